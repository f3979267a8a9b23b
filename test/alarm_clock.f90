!> A flag that a signal raises, for the interrupt of a train.
module alarm_clock
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none (type, external)
   private
   public :: alarm_flag, alarm_rang, on_alarm

   integer(int64), target, volatile :: alarm_flag = 0

contains

   logical function alarm_rang()
      alarm_rang = alarm_flag /= 0
   end function alarm_rang

   !> The handler of the signal.
   subroutine on_alarm(number) bind(c)
      integer(c_int), value :: number

      if (number > 0) alarm_flag = 1
   end subroutine on_alarm

end module alarm_clock
