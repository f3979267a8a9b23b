!> Eigenvalues of symmetric band matrices by LAPACK, with eigenvectors by divide and conquer: of some hundred rows they take a
!> quarter of the time that rotations take.
module geartrain_linalg_band_eigenvalues
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_lapack, only: dsbevd
   implicit none (type, external)
   private
   public :: band_eigenvalues

contains

   !> Finds all eigenvalues, and eigenvectors where they are wanted.
   pure subroutine band_eigenvalues(band, value, info, vector)
      !> Upper triangle by diagonals, the main diagonal in the last row, destroyed, (1 + diagonals beside it, n).
      real(dp), intent(inout), contiguous :: band(:, :)
      !> Eigenvalues, ascending, (n).
      real(dp), intent(out) :: value(:)
      !> 0: LAPACK converged.
      integer, intent(out) :: info
      !> Eigenvectors of length 1, (n, n).
      real(dp), intent(out), contiguous, optional :: vector(:, :)
      real(dp), allocatable :: work(:)
      integer, allocatable :: places(:)
      real(dp) :: none(1, 1)
      integer :: n, width

      n = size(value)
      width = size(band, 1) - 1
      if (present(vector)) then
         allocate (work(1 + 5*n + 2*n**2), places(3 + 5*n))
         call dsbevd('V', 'U', n, width, band, width + 1, value, vector, n, work, size(work), places, size(places), info)
      else
         allocate (work(max(1, 2*n)), places(1))
         call dsbevd('N', 'U', n, width, band, width + 1, value, none, 1, work, size(work), places, size(places), info)
      end if
   end subroutine band_eigenvalues

end module geartrain_linalg_band_eigenvalues
