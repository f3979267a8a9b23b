!> The linear part of the harmonic balance: displacement of each unknown mesh under harmonic mesh forces,
!>    p_j + sum over i = j-1, j, j+1 of H_ji phi_i = a_j,
!> with linear meshes of constant stiffness eliminated and recovered afterwards.
module geartrain_model_receptance
   use geartrain_base_kinds, only: dp
   use geartrain_model_body, only: body_type
   use geartrain_model_system, only: series_type, system_type
   implicit none (type, external)
   private
   public :: receptance_type, find_receptance, is_unknown, recover_meshes

   type :: receptance_type
      !> H(j, i = j-1, j, j+1) between neighbouring meshes that remain and the excitation a(j), with their derivatives with
      !> respect to Lambda, (3, mesh) and (mesh). Rows of eliminated meshes hold their state at elimination.
      complex(dp), allocatable :: h(:, :), dh(:, :), a(:), da(:)
   end type receptance_type

contains

   !> Whether a mesh is an unknown of the balance: it has backlash or a varying stiffness.
   pure function is_unknown(system)
      type(system_type), intent(in) :: system
      logical, allocatable :: is_unknown(:)
      integer :: j

      is_unknown = [(system%backlash(j) > 0 .or. size(system%mesh_stiffness(j)%amplitude) > 0, j=1, system%meshes)]
   end function is_unknown

   !> Receptance at `harmonic` of Lambda/eta (`harmonic` >= 1).
   pure subroutine find_receptance(system, unknown, frequency, harmonic, eta, r)
      type(system_type), intent(in) :: system
      logical, intent(in) :: unknown(:)
      real(dp), intent(in) :: frequency
      integer, intent(in) :: harmonic, eta
      type(receptance_type), intent(inout) :: r
      complex(dp) :: alpha(3), d_alpha(3), next(3), d_next(3), torque
      real(dp) :: omega, d_omega
      integer :: j, m, n, before, after, last_unknown

      m = system%meshes
      if (.not. allocated(r%h)) allocate (r%h(3, m), r%dh(3, m), r%a(m), r%da(m))
      d_omega = system%characteristic_frequency*harmonic/eta
      omega = d_omega*frequency
      torque = amplitude_at(system%torque, harmonic, eta)
      call system%bodies(1)%receptance(omega, alpha, d_alpha)
      do j = 1, m
         call system%bodies(j + 1)%receptance(omega, next, d_next)
         n = system%mesh_element(j)
         associate (left => system%left_radius(n), right => system%right_radius(n))
            r%h(2, j) = (left**2*alpha(3) + right**2*next(1))*system%stiffness(n)
            r%dh(2, j) = (left**2*d_alpha(3) + right**2*d_next(1))*system%stiffness(n)*d_omega
            r%a(j) = amplitude_at(system%transmission_error(j), harmonic, eta)
            r%da(j) = 0
            r%h([1, 3], j) = 0
            r%dh([1, 3], j) = 0
            if (j > 1) then
               before = system%mesh_element(j - 1)
               r%h(1, j) = -left*system%right_radius(before)*system%stiffness(before)*alpha(2)
               r%dh(1, j) = -left*system%right_radius(before)*system%stiffness(before)*d_alpha(2)*d_omega
            else
               r%a(j) = r%a(j) + left*alpha(2)*torque
               r%da(j) = left*d_alpha(2)*torque*d_omega
            end if
            if (j < m) then
               after = system%mesh_element(j + 1)
               r%h(3, j) = -right*system%left_radius(after)*system%stiffness(after)*next(2)
               r%dh(3, j) = -right*system%left_radius(after)*system%stiffness(after)*d_next(2)*d_omega
            end if
         end associate
         alpha = next
         d_alpha = d_next
      end do
      last_unknown = 0
      do j = 1, m
         if (unknown(j)) then
            last_unknown = j
         else
            call eliminate(system, j, last_unknown, frequency*harmonic/eta, real(harmonic, dp)/eta, r)
         end if
      end do
   end subroutine find_receptance

   !> Eliminates linear mesh j: (1/z + H_jj) phi_j + H_j,j-1 phi_j-1 + H_j,j+1 phi_j+1 = a_j with z = 1 + i omega gamma.
   !> Its neighbours then couple to each other. Meshes before j that are linear have been eliminated already: `before` is the last
   !> one that has not, or 0.
   pure subroutine eliminate(system, j, before, omega, d_omega, r)
      type(system_type), intent(in) :: system
      integer, intent(in) :: j, before
      real(dp), intent(in) :: omega, d_omega
      type(receptance_type), intent(inout) :: r
      complex(dp) :: pivot, d_pivot, z

      z = cmplx(1, omega*system%damping(system%mesh_element(j)), dp)
      pivot = 1/z + r%h(2, j)
      d_pivot = r%dh(2, j) - cmplx(0, d_omega*system%damping(system%mesh_element(j)), dp)/z**2
      if (before >= 1) call eliminate_from(r, before, 3, j, pivot, d_pivot)
      if (j < system%meshes) call eliminate_from(r, j + 1, 1, j, pivot, d_pivot)
   end subroutine eliminate

   !> Eliminates mesh j from `row`, where its receptance stands in `column`; the far neighbour of j takes its place.
   pure subroutine eliminate_from(r, row, column, j, pivot, d_pivot)
      type(receptance_type), intent(inout) :: r
      integer, intent(in) :: row, column, j
      complex(dp), intent(in) :: pivot, d_pivot
      complex(dp) :: ratio, d_ratio

      ratio = r%h(column, row)/pivot
      d_ratio = (r%dh(column, row) - ratio*d_pivot)/pivot
      r%a(row) = r%a(row) - ratio*r%a(j)
      r%da(row) = r%da(row) - d_ratio*r%a(j) - ratio*r%da(j)
      r%h(column, row) = -ratio*r%h(column, j)
      r%dh(column, row) = -d_ratio*r%h(column, j) - ratio*r%dh(column, j)
      r%h(2, row) = r%h(2, row) - ratio*r%h(4 - column, j)
      r%dh(2, row) = r%dh(2, row) - d_ratio*r%h(4 - column, j) - ratio*r%dh(4 - column, j)
   end subroutine eliminate_from

   !> Given the forces phi (mesh) of the unknown meshes at one harmonic, fills in those of the eliminated ones and their
   !> displacements p = phi/z. Back substitution: the last eliminated first.
   pure subroutine recover_meshes(system, unknown, omega, r, phi, p)
      type(system_type), intent(in) :: system
      logical, intent(in) :: unknown(:)
      !> harmonic Lambda/eta [1].
      real(dp), intent(in) :: omega
      type(receptance_type), intent(in) :: r
      complex(dp), intent(inout) :: phi(:), p(:)
      complex(dp) :: z
      integer :: j, before

      before = system%meshes
      do j = system%meshes, 1, -1
         if (unknown(j)) cycle
         do before = min(before, j - 1), 1, -1
            if (unknown(before)) exit
         end do
         z = cmplx(1, omega*system%damping(system%mesh_element(j)), dp)
         phi(j) = r%a(j)
         if (j < system%meshes) phi(j) = phi(j) - r%h(3, j)*phi(j + 1)
         if (before >= 1) phi(j) = phi(j) - r%h(1, j)*phi(before)
         phi(j) = phi(j)/(1/z + r%h(2, j))
         p(j) = phi(j)/z
      end do
   end subroutine recover_meshes

   !> Amplitude of a series at a harmonic of Lambda/eta.
   pure complex(dp) function amplitude_at(series, harmonic, eta)
      type(series_type), intent(in) :: series
      integer, intent(in) :: harmonic, eta
      integer :: h

      amplitude_at = 0
      h = harmonic/(eta*series%order)
      if (h*eta*series%order == harmonic .and. h <= size(series%amplitude)) amplitude_at = series%amplitude(h)
   end function amplitude_at

end module geartrain_model_receptance
