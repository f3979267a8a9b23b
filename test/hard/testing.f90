!> Checks that count themselves; the runner prints the failures and the closing line.
module testing
   use, intrinsic :: iso_fortran_env, only: output_unit
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: tests_type

   type :: tests_type
      integer :: passed = 0, failed = 0
      character(:), allocatable, private :: group
   contains
      procedure :: begin
      procedure :: is_true
      procedure :: is_close
      procedure :: is_text
      procedure :: finish
   end type tests_type

contains

   !> Names the group that the next checks belong to.
   subroutine begin(self, group)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: group

      self%group = group
   end subroutine begin

   subroutine is_true(self, claim, name)
      class(tests_type), intent(inout) :: self
      logical, intent(in) :: claim
      character(*), intent(in) :: name

      if (claim) then
         self%passed = self%passed + 1
      else
         self%failed = self%failed + 1
         write (output_unit, '(4a)') 'FAILED ', self%group, ': ', name
      end if
   end subroutine is_true

   !> |value - expected| <= tolerance; NaN fails.
   subroutine is_close(self, value, expected, tolerance, name)
      class(tests_type), intent(inout) :: self
      real(dp), intent(in) :: value, expected, tolerance
      character(*), intent(in) :: name
      character(160) :: text

      write (text, '(a, es23.15, a, es23.15, a, es9.2, a, es9.2)') ': got', value, ', expected', expected, ', off by', &
         abs(value - expected), ', allowed', tolerance
      call self%is_true(abs(value - expected) <= tolerance, name//trim(text))
   end subroutine is_close

   subroutine is_text(self, value, expected, name)
      class(tests_type), intent(inout) :: self
      character(*), intent(in) :: value, expected, name

      call self%is_true(value == expected, name//': got "'//value//'", expected "'//expected//'"')
   end subroutine is_text

   !> Prints the closing line; fails the program when a check failed or none ran.
   subroutine finish(self)
      class(tests_type), intent(inout) :: self

      write (output_unit, '(i0, a, i0, a)') self%passed, ' passed, ', self%failed, ' failed'
      if (self%failed > 0 .or. self%passed == 0) stop 1, quiet=.true.
   end subroutine finish

end module testing
