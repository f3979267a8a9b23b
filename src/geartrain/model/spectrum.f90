!> Eigenvalues of W diag(factor), which the roots of stiffness and factor transform to a symmetric matrix, banded since the elements
!> are numbered along the train. Each element that closes a loop or has factor 0 adds an eigenvalue 0.
module geartrain_model_spectrum
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dsbev
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: eigenvalues_of

contains

   !> Finds the largest eigenvalues.
   pure subroutine eigenvalues_of(system, factor, values, info, vectors)
      !> The train.
      type(system_type), intent(in) :: system
      !> Factors >= 0 of the elements, (element).
      real(dp), intent(in) :: factor(:)
      !> The largest eigenvalues [1], ascending, as many as there is room for, (value).
      real(dp), intent(out) :: values(:)
      !> 0: LAPACK converged.
      integer, intent(out) :: info
      !> Eigenvectors of the symmetric matrix [1], (element, value).
      real(dp), intent(out), optional :: vectors(:, :)
      real(dp), allocatable :: band(:, :), work(:), vector(:, :)
      real(dp) :: value(system%elements)
      real(dp) :: none(1, 1)
      integer :: below, i, n, width

      width = 0
      do n = 1, system%elements
         do i = system%first(n), system%first(n + 1) - 1
            width = max(width, n - system%neighbour(i))
         end do
      end do
      allocate (band(width + 1, system%elements), source=0.0_dp)
      allocate (work(max(1, 3*system%elements - 2)))
      do n = 1, system%elements
         band(width + 1, n) = system%own(n)*factor(n)
         do i = system%first(n), system%first(n + 1) - 1
            associate (m => system%neighbour(i))
               if (m < n) band(width + 1 - n + m, n) = system%coupling(i)*sqrt(system%stiffness(n)/system%stiffness(m)) &
                                                       *sqrt(factor(n)*factor(m))
            end associate
         end do
      end do
      below = system%elements - size(values)
      if (present(vectors)) then
         allocate (vector(system%elements, system%elements))
         call dsbev('V', 'U', system%elements, width, band, width + 1, value, vector, system%elements, work, info)
         vectors = vector(:, below + 1:)
      else
         call dsbev('N', 'U', system%elements, width, band, width + 1, value, none, 1, work, info)
      end if
      values = value(below + 1:)
   end subroutine eigenvalues_of

end module geartrain_model_spectrum
