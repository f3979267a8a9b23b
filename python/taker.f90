!> The visitor that gives each variable of an analysis the value that a Python call has passed by its name, and says what is wrong
!> with it.
module geartrain_python_taker
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   use geartrain, only: dp
   use geartrain_base_checker, only: checker_type
   use geartrain_base_field, only: group_type
   use geartrain_base_variable, only: variable_type
   implicit none (type, external)
   private
   public :: taker_type

   type, extends(checker_type) :: taker_type
      !> The values passed, of the kinds of their variables.
      type(group_type) :: given
   contains
      procedure :: on_real => take_real
      procedure :: on_integer => take_integer
      procedure :: on_logical => take_logical
      procedure :: on_text => take_text
      procedure :: on_list => take_list
      procedure, private :: find
   end type taker_type

contains

   subroutine take_real(self, variable, value, in_force)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), intent(inout) :: value
      logical, intent(inout), optional :: in_force
      character(4) :: word
      integer :: place

      call self%find(variable, place)
      if (place == 0) return
      if (present(in_force)) in_force = .true.
      if (.not. ieee_is_finite(self%given%fields(place)%reals(1))) then
         ! As Python writes it.
         word = 'inf'
         if (self%given%fields(place)%reals(1) < 0) word = '-inf'
         if (ieee_is_nan(self%given%fields(place)%reals(1))) word = 'nan'
         call self%complain(variable%name, trim(word), 'must be a finite number')
         return
      end if
      value = self%given%fields(place)%reals(1)
      call self%checker_type%on_real(variable, value)
   end subroutine take_real

   subroutine take_integer(self, variable, value)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(inout) :: value
      integer :: place

      call self%find(variable, place)
      if (place == 0) return
      value = self%given%fields(place)%integers(1)
      call self%checker_type%on_integer(variable, value)
   end subroutine take_integer

   subroutine take_logical(self, variable, value)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      logical, intent(inout) :: value
      integer :: place

      call self%find(variable, place)
      if (place > 0) value = self%given%fields(place)%integers(1) == 1
   end subroutine take_logical

   subroutine take_text(self, variable, value)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      character(:), allocatable, intent(inout) :: value
      integer :: place

      call self%find(variable, place)
      if (place == 0) return
      value = self%given%fields(place)%texts(1)%text
      call self%checker_type%on_text(variable, value)
   end subroutine take_text

   subroutine take_list(self, variable, value)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      real(dp), allocatable, intent(inout) :: value(:)
      integer :: place

      call self%find(variable, place)
      if (place == 0) return
      value = self%given%fields(place)%reals
      call self%checker_type%on_list(variable, value)
   end subroutine take_list

   !> Where the value of a variable is, 0: none was passed, which is told of one that is required.
   subroutine find(self, variable, place)
      class(taker_type), intent(inout) :: self
      type(variable_type), intent(in) :: variable
      integer, intent(out) :: place

      do place = 1, self%given%count
         if (self%given%fields(place)%about%name == variable%name) return
      end do
      place = 0
      if (variable%required) call self%lacks(variable%name, trim(variable%range())//' '//variable%unit)
   end subroutine find

end module geartrain_python_taker
