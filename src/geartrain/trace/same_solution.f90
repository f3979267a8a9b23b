!> Whether two bifurcation points are equal, up to a shift by some periods of the fundamental, and the order of equal branches in
!> which points and motions are compared.
module geartrain_trace_same_solution
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_base_sorting, only: ascending
   use geartrain_network_equal_branches, only: equal_branches_type
   use geartrain_network_units, only: units_type
   implicit none (type, external)
   private
   public :: put_figures_in_order, put_in_order, same_solution

   !> Solution points closer than this in the metric of the branch are equal [units_type]. Two searches that end at one point agree
   !> to some 1e-6 only, so the tolerance of geartrain_balance_same_motion would be too small.
   real(dp), parameter :: same = 1e-3_dp
   !> Distances in Lambda up to which they may be: as a share of Lambda, and what searches agree to with ample room [units_type].
   real(dp), parameter :: as_share = 0.01_dp, agreement = 1e-5_dp
   !> Directions whose angle has a larger cosine than this are equal.
   real(dp), parameter :: parallel = 0.7_dp

contains

   !> Renumbers equal branches by the sizes of their harmonics, which a shift in time leaves as they are: bifurcation points that
   !> are equal but for the numbers of equal branches become equal.
   subroutine put_in_order(sets, solution)
      !> Equal branches of the train, those of a branch after the set of this branch.
      type(equal_branches_type), intent(in) :: sets(:)
      !> Bifurcation point with the critical vector as tangent.
      type(solution_point_type), intent(inout) :: solution
      integer, allocatable :: order(:)
      real(dp), allocatable :: key(:)
      integer :: i, j

      do i = size(sets), 1, -1
         associate (unknown => sets(i)%unknown)
            key = [(key_of(unknown(:, j)), j=1, size(unknown, 2))]
            order = ascending(key)
            solution%u(:, reshape(unknown, [size(unknown)])) = solution%u(:, reshape(unknown(:, order), [size(unknown)]))
            solution%tangent(:, reshape(unknown, [size(unknown)])) = &
               solution%tangent(:, reshape(unknown(:, order), [size(unknown)]))
         end associate
      end do

   contains

      !> A number of a branch that grows with the sizes of its harmonics.
      real(dp) function key_of(unknown)
         integer, intent(in) :: unknown(:)
         integer :: k, l

         key_of = 0
         do l = 1, size(unknown)
            associate (u => solution%u(:, unknown(l)), t => solution%tangent(:, unknown(l)))
               key_of = key_of + (u(1) + 0.1_dp*abs(t(1)))/l
               do k = 2, size(u) - 1, 2
                  key_of = key_of + (hypot(u(k), u(k + 1)) + 0.1_dp*hypot(t(k), t(k + 1)))/(k*l)
               end do
            end associate
         end do
      end function key_of

   end subroutine put_in_order

   !> Renumbers equal branches by their figures: motions that are equal but for the numbers of equal branches get equal figures.
   subroutine put_figures_in_order(sets, mesh, motion)
      !> Equal branches of the train, those of a branch after the set of this branch.
      type(equal_branches_type), intent(in) :: sets(:)
      !> Mesh that each unknown is, (unknown).
      integer, intent(in) :: mesh(:)
      !> Motion whose rms, mean, minimum and maximum become those of the unknown meshes, in the new order.
      type(motion_type), intent(inout) :: motion
      integer, allocatable :: place(:), branches(:, :)
      integer :: i, j, l
      real(dp), allocatable :: key(:)

      if (size(sets) == 0) return
      place = mesh
      do i = size(sets), 1, -1
         branches = reshape(place(reshape(sets(i)%unknown, [size(sets(i)%unknown)])), shape(sets(i)%unknown))
         allocate (key(size(branches, 2)), source=0.0_dp)
         do j = 1, size(key)
            do l = 1, size(branches, 1)
               associate (m => branches(l, j))
                  key(j) = key(j) + (motion%rms(m) + motion%mean(m) + motion%maximum(m))/l
               end associate
            end do
         end do
         place(reshape(sets(i)%unknown, [size(branches)])) = reshape(branches(:, ascending(key)), [size(branches)])
         deallocate (key)
      end do
      motion%rms = motion%rms(place)
      motion%mean = motion%mean(place)
      motion%minimum = motion%minimum(place)
      motion%maximum = motion%maximum(place)
   end subroutine put_figures_in_order

   !> Whether `one`, shifted by some number of periods of the fundamental, is `other`. Their harmonics may differ.
   pure logical function same_solution(one, other, period, units, by_direction)
      !> Solution points to compare.
      type(solution_point_type), intent(in) :: one, other
      !> Period of whose frequency the harmonics of both points are multiples [periods of the excitation].
      integer, intent(in) :: period
      !> Units of the branch.
      type(units_type), intent(in) :: units
      !> The tangents must be parallel as well: two branches may leave next to one another.
      logical, intent(in) :: by_direction
      real(dp) :: apart, along, length(2)
      complex(dp) :: turn, a, b
      integer :: i, k, shift

      same_solution = .false.
      associate (apart_by => abs(one%frequency_ratio - other%frequency_ratio))
         if (apart_by >= same*units%frequency_ratio) return
         ! Of a train with soft shafts that is far in relation to Lambda.
         if (apart_by >= max(as_share*abs(one%frequency_ratio), agreement*units%frequency_ratio)) return
      end associate
      do shift = 0, period - 1
         apart = ((one%frequency_ratio - other%frequency_ratio)/units%frequency_ratio)**2
         along = one%tangent_frequency*other%tangent_frequency/units%frequency_ratio**2
         length = [one%tangent_frequency, other%tangent_frequency]**2/units%frequency_ratio**2
         do i = 1, size(one%u, 2)
            do k = 0, max(highest_of(one), highest_of(other))
               turn = exp(cmplx(0, 2*pi*k*shift/period, dp))
               a = harmonic_of(one, one%u(:, i), k)
               b = harmonic_of(other, other%u(:, i), k)*turn
               apart = apart + merge(1.0_dp, 0.5_dp, k == 0)*(abs(a - b)/units%length)**2
               if (.not. by_direction) cycle
               a = harmonic_of(one, one%tangent(:, i), k)/units%length
               b = harmonic_of(other, other%tangent(:, i), k)*turn/units%length
               along = along + real(conjg(a)*b)
               length = length + [abs(a), abs(b)]**2
            end do
         end do
         same_solution = apart < same**2
         if (by_direction) same_solution = same_solution .and. abs(along) > parallel*sqrt(product(length))
         if (same_solution) return
      end do
   end function same_solution

   pure integer function highest_of(solution)
      type(solution_point_type), intent(in) :: solution

      highest_of = (size(solution%u, 1) - 1)/2
      if (allocated(solution%harmonic)) highest_of = maxval([0, solution%harmonic])
   end function highest_of

   !> Complex amplitude of harmonic k in the coefficients `u` of a mesh of `solution`; 0 where harmonic k is not carried.
   pure complex(dp) function harmonic_of(solution, u, k)
      type(solution_point_type), intent(in) :: solution
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: k
      integer :: i

      i = k
      if (allocated(solution%harmonic) .and. k > 0) then
         i = findloc(solution%harmonic, k, 1)
         if (i == 0) i = size(u)
      end if
      harmonic_of = 0
      if (i == 0) harmonic_of = u(1)
      if (i > 0 .and. 2*i + 1 <= size(u)) harmonic_of = cmplx(u(2*i), -u(2*i + 1), dp)
   end function harmonic_of

end module geartrain_trace_same_solution
