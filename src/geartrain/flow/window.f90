!> The window over which the figures of a motion are taken where the common period of all meshes is too long.
!>
!> Two stages with 71 and 19 cycles in their common period are integrated over whole periods. A third stage makes thousands of
!> cycles of a period, and every figure of one costs them all, though all that happens is a few frequencies beating. Some hundred
!> cycles of the slowest mesh tell the beats; their number is chosen such that all meshes go through nearly whole cycles. An idle
!> mesh rattles, as a rule without any period: looking for one takes thousands of cycles in vain, and its figures are those of a
!> window as well.
module geartrain_flow_window
   use geartrain_base_kinds, only: dp, pi
   use geartrain_network_excitation, only: excited_harmonics, lowest_harmonic
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: cycle_time, goes_by_windows, window_of

   !> Most cycles of the slowest mesh in a period of the fundamental that is flown over as a whole.
   integer, parameter :: longest_period = 200
   !> Cycles of the slowest mesh in a period from which on a train with an idle mesh goes by windows.
   integer, parameter :: longest_idle = 10
   !> Largest static force of an idle mesh over the largest of all meshes [1]: forces in loops are found to rounding.
   real(dp), parameter :: idle = 1e-9_dp
   !> Fewest cycles of the slowest mesh in a window, and of the slowest excitation.
   integer, parameter :: fewest_cycles = 100, fewest_slowest = 10
   !> Longest window over the shortest window that would do [1].
   real(dp), parameter :: longer = 3

contains

   !> Whether the figures of the motions are those of a window.
   pure logical function goes_by_windows(system, wanted)
      type(system_type), intent(in) :: system
      !> Window that was asked for [cycles of the slowest mesh]; 0: none, it depends on the length of the period.
      integer, intent(in) :: wanted

      associate (order => slowest_order(system))
         goes_by_windows = wanted > 0 .or. order > longest_period .or. (order >= longest_idle .and. has_idle_mesh(system))
      end associate
   end function goes_by_windows

   !> Whether some mesh with backlash bears no mean force, and others do.
   pure logical function has_idle_mesh(system)
      type(system_type), intent(in) :: system
      real(dp) :: force(system%meshes)

      force = abs(system%static_force(system%mesh_element)*system%stiffness(system%mesh_element))
      has_idle_mesh = any(system%half_backlash > 0 .and. force <= idle*maxval(force)) .and. maxval(force) > 0
   end function has_idle_mesh

   !> Frequency of the slowest mesh over Lambda [1].
   pure real(dp) function slowest_order(system)
      type(system_type), intent(in) :: system

      slowest_order = minval(system%law%order)
   end function slowest_order

   !> Time of a cycle of the slowest mesh [1].
   pure real(dp) function cycle_time(system, frequency_ratio)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio

      cycle_time = 2*pi/(frequency_ratio*slowest_order(system))
   end function cycle_time

   !> Length of the window [periods of the fundamental].
   pure real(dp) function window_of(system, wanted) result(window)
      type(system_type), intent(in) :: system
      !> Cycles of the slowest mesh that were asked for; 0: chosen here.
      integer, intent(in) :: wanted
      real(dp) :: order(system%meshes + size(system%torque)), slowest, misfit, best, cycles
      integer :: j, n, first

      slowest = slowest_order(system)
      cycles = wanted
      if (wanted == 0) then
         first = max(fewest_cycles, ceiling(fewest_slowest*slowest/max(1, minval([nint(slowest), excited_harmonics(system)]))))
         ! Whole periods where they are short.
         cycles = slowest*max(1, ceiling(first/slowest))
         order = [system%law%order, (real(lowest_harmonic(system%torque(j)), dp), j=1, size(system%torque))]
         best = huge(best)
         do n = first, merge(min(int(longer*first), int(slowest)), 0, first < slowest)
            misfit = maxval(abs(n*order/slowest - anint(n*order/slowest)))
            if (misfit >= best) cycle
            best = misfit
            cycles = n
         end do
      end if
      window = cycles/slowest
   end function window_of

end module geartrain_flow_window
