!> A linear ramp of Lambda in time, window by window: a window is a period of the fundamental mesh frequency, its phase from 2 pi k
!> to 2 pi (k + 1). So phases stay small, and the phase after any number of windows is exact to rounding.
module geartrain_flow_ramp
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: ramp_type, make_ramp

   type :: ramp_type
      !> Lambda at time 0 and at the end [1]; time from end to end [1]; rate of change of Lambda [1].
      real(dp) :: start = 1, stop = 1, duration = 0, acceleration = 0
      !> Number of windows; the last window may be cut short by the end of the ramp.
      integer :: windows = 0
   contains
      procedure :: speed_of
      procedure :: begin_of
      procedure :: length_of
   end type ramp_type

contains

   !> Makes a ramp.
   pure type(ramp_type) function make_ramp(start, stop, duration) result(ramp)
      !> Lambda at time 0 and at the end [1].
      real(dp), intent(in) :: start, stop
      !> Time from end to end times characteristic frequency [1].
      real(dp), intent(in) :: duration

      ramp%start = start
      ramp%stop = stop
      ramp%duration = duration
      ramp%acceleration = (stop - start)/duration
      ramp%windows = ceiling((start + stop)/2*duration/(2*pi)*(1 - 1e-12_dp))
   end function make_ramp

   !> Lambda at the beginning of a window [1].
   pure real(dp) function speed_of(self, window) result(speed)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window

      speed = sqrt(self%start**2 + 4*pi*(window - 1)*self%acceleration)
   end function speed_of

   !> Time at which a window begins [1].
   pure real(dp) function begin_of(self, window) result(time)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window

      time = 4*pi*(window - 1)/(self%start + self%speed_of(window))
   end function begin_of

   !> Time that a window takes [1].
   pure real(dp) function length_of(self, window) result(time)
      class(ramp_type), intent(in) :: self
      !> Number of the window, from 1.
      integer, intent(in) :: window

      if (window < self%windows) then
         time = 4*pi/(self%speed_of(window) + self%speed_of(window + 1))
      else
         time = self%duration - self%begin_of(window)
      end if
   end function length_of

end module geartrain_flow_ramp
