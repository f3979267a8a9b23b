!> Ends work in the midst of a step. Whoever starts long work keeps a flag in memory and hands its address down with the train;
!> every piece of work that may take a tenth of a second looks at it, ends as if it had failed where it is raised, and whoever
!> called that piece drops the step it belongs to.
module geartrain_base_interrupt
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_loc, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none (type, external)
   private
   public :: interrupt_type, interrupt_by

   !> Where the flag is: eight bytes, all zero until the work is to end; nowhere, and the work is not ended so.
   type :: interrupt_type
      private
      type(c_ptr) :: flag = c_null_ptr
   contains
      procedure :: raised
   end type interrupt_type

contains

   !> The interrupt of a flag that outlives the work.
   type(interrupt_type) function interrupt_by(flag)
      integer(int64), intent(in), target :: flag

      interrupt_by%flag = c_loc(flag)
   end function interrupt_by

   !> Whether the work is to end: some nanoseconds, from any thread.
   logical function raised(self)
      class(interrupt_type), intent(in) :: self
      integer(int64), pointer, volatile :: flag

      raised = .false.
      if (.not. c_associated(self%flag)) return
      call c_f_pointer(self%flag, flag)
      raised = flag /= 0
   end function raised

end module geartrain_base_interrupt
