!> Ends work within a step. The caller of long work keeps a flag in memory and passes its address down with the train. Each
!> procedure that may take a tenth of a second looks at the flag and, where it is raised, returns as if it had failed; its caller
!> drops the step.
module geartrain_base_interrupt
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_loc, c_null_ptr, c_ptr
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none (type, external)
   private
   public :: interrupt_type, interrupt_by

   !> Address of the flag, eight bytes that are 0 until the work is to end; a null address never interrupts.
   type :: interrupt_type
      private
      type(c_ptr) :: flag = c_null_ptr
   contains
      procedure :: raised
   end type interrupt_type

contains

   !> Interrupt that is raised by a flag.
   type(interrupt_type) function interrupt_by(flag)
      !> 0 until the work is to end; must exist until the work has ended.
      integer(int64), intent(in), target :: flag

      interrupt_by%flag = c_loc(flag)
   end function interrupt_by

   !> Whether the work is to end; takes some nanoseconds and may be called from any thread.
   logical function raised(self)
      class(interrupt_type), intent(in) :: self
      integer(int64), pointer, volatile :: flag

      raised = .false.
      if (.not. c_associated(self%flag)) return
      call c_f_pointer(self%flag, flag)
      raised = flag /= 0
   end function raised

end module geartrain_base_interrupt
