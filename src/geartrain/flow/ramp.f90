!> A linear ramp of Lambda in time, window by window: a window is a period of the slowest mesh. Times count from the beginning of
!> the period of the fundamental, where the phase is 0. So phases stay small, and the phase after any number of windows is exact to
!> rounding.
module geartrain_flow_ramp
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: ramp_type, make_ramp

   type :: ramp_type
      !> Lambda at time 0 and at the end [1]; time from end to end [1]; rate of change of Lambda [1].
      real(dp) :: start = 1, stop = 1, duration = 0, acceleration = 0
      !> Number of windows of a period of the fundamental; number of all windows, the last of which may be cut short by the end of
      !> the ramp.
      integer :: parts = 1, windows = 0
   contains
      procedure :: speed_of
      procedure :: begin_of
      procedure :: place
   end type ramp_type

contains

   !> Makes a ramp.
   pure type(ramp_type) function make_ramp(start, stop, duration, parts) result(ramp)
      !> Lambda at time 0 and at the end [1].
      real(dp), intent(in) :: start, stop
      !> Time from end to end times characteristic frequency [1].
      real(dp), intent(in) :: duration
      !> Number of windows of a period of the fundamental.
      integer, intent(in) :: parts

      ramp%start = start
      ramp%stop = stop
      ramp%duration = duration
      ramp%acceleration = (stop - start)/duration
      ramp%parts = parts
      ramp%windows = ceiling((start + stop)/2*duration/(2*pi)*parts*(1 - 1e-12_dp))
   end function make_ramp

   !> Lambda at the beginning of a window [1].
   pure real(dp) function speed_of(self, window) result(speed)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window

      speed = sqrt(self%start**2 + 4*pi*((window - 1)/real(self%parts, dp))*self%acceleration)
   end function speed_of

   !> Time at which a window begins [1].
   pure real(dp) function begin_of(self, window) result(time)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window

      time = 4*pi*((window - 1)/real(self%parts, dp))/(self%start + self%speed_of(window))
   end function begin_of

   !> Beginning and end of a window, counted from the beginning of the period of the fundamental in which it lies. The end of a
   !> window is the beginning of the next to the last bit.
   pure subroutine place(self, window, origin, speed, begin, end)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window
      !> Time at which the period of the fundamental begins [1]; Lambda there [1].
      real(dp), intent(out) :: origin, speed
      !> Times since then at which the window begins and ends [1].
      real(dp), intent(out) :: begin, end
      integer :: part

      part = mod(window - 1, self%parts)
      origin = self%begin_of(window - part)
      speed = self%speed_of(window - part)
      begin = 4*pi*(part/real(self%parts, dp))/(speed + self%speed_of(window))
      if (window < self%windows) then
         end = 4*pi*((part + 1)/real(self%parts, dp))/(speed + self%speed_of(window + 1))
      else
         end = self%duration - origin
      end if
   end subroutine place

end module geartrain_flow_ramp
