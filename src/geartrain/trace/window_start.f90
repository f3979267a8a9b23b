!> A start for motions of long period: the motion that time integration settles on, read over a window.
!>
!> A window is some hundred cycles of a period of thousands, and a line of its spectrum covers many harmonics of the period. A
!> motion has mainly harmonics that are sums and differences of few harmonics of the excitation. So each line is taken for the
!> harmonic with the shortest sum. That is near enough for Newton's method to begin.
module geartrain_trace_window_start
   use geartrain_balance_harmonic_set, only: first_set
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_tail_harmonics, only: busiest
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_observer, only: observer_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_time_constants, only: find_in_window
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_system, only: system_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_start, only: add_harmonics, motion_at, solution_of
   use geartrain_trace_tracer, only: tracer_type
   implicit none (type, external)
   private
   public :: solve_in_window

   !> Share of the spectrum that the start leaves out, by root sum squares [1].
   real(dp), parameter :: negligible = 0.01_dp
   !> Most cycles of the slowest mesh in a window that is a whole period. Cycles of settling; one period where that is longer.
   real(dp), parameter :: longest_period = 500, most_cycles = 300
   !> Most harmonics of the start.
   integer, parameter :: most = 400

contains

   !> Solves the balance next to the motion that the flow from rest settles on.
   subroutine solve_in_window(tracer, frequency_ratio, solution, success, stopped, observer)
      !> Tracer after `begin_trace` that chooses sets.
      type(tracer_type), intent(inout) :: tracer
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The solution, where `success`.
      type(solution_point_type), intent(inout) :: solution
      !> A motion was found; the observer or an interrupt ended the flow before.
      logical, intent(out) :: success, stopped
      !> Told of 'settling by time'; may end it.
      class(observer_type), intent(inout), optional :: observer
      type(motion_type) :: window, motion
      type(integration_settings_type) :: settings
      real(dp) :: state(tracer%system%states)
      integer, allocatable :: set(:)

      success = .false.
      state = resting_state(tracer%system)
      associate (cycles => minval(tracer%system%law%order))
         ! A whole period has no other lines than its harmonics.
         if (cycles <= longest_period) settings%window = nint(cycles)
         settings%max_periods = max(1, nint(most_cycles/cycles))
      end associate
      call find_in_window(tracer%system, frequency_ratio, settings, state, window, observer, stopped)
      if (stopped .or. .not. allocated(window%coefficients)) return
      call take_lines(tracer%system, window, motion)
      call add_harmonics(tracer, motion)
      solution = solution_of(tracer, motion)
      call tracer%corrector%solve_at(solution, success)
      if (.not. success) return
      ! Most harmonics that the window showed have no amplitude of their own.
      motion = motion_at(tracer, solution)
      set = first_set(tracer%system)
      call tracer%prepare(set(size(set)), set)
      call add_harmonics(tracer, motion)
      solution = solution_of(tracer, motion)
      call tracer%corrector%solve_at(solution, success)
   end subroutine solve_in_window

   !> A motion of the fundamental from the spectrum of a window.
   pure subroutine take_lines(system, window, motion)
      type(system_type), intent(in) :: system
      !> Motion over a window, with coefficients.
      type(motion_type), intent(in) :: window
      !> Motion of period 1 with coefficients.
      type(motion_type), intent(out) :: motion
      integer, allocatable :: owner(:)
      logical, allocatable :: taken(:)
      real(dp), allocatable :: square(:)
      complex(dp) :: amplitude, share
      real(dp) :: off
      integer :: j, l

      associate (lines => (size(window%coefficients, 1) - 1)/2)
         owner = owners(excited_harmonics(system), window%window, lines)
         square = [(merge(sum(window%coefficients(2*l:2*l + 1, :)**2), 0.0_dp, owner(l) > 0), l=1, lines)]
      end associate
      taken = busiest(square, negligible**2*sum(square), most)
      motion%frequency_ratio = window%frequency_ratio
      motion%period = 1
      allocate (motion%coefficients(1 + 2*maxval(pack(owner, taken)), system%meshes), source=0.0_dp)
      motion%coefficients(1, :) = window%coefficients(1, :)
      do l = 1, size(taken)
         if (.not. taken(l)) cycle
         ! What the line shows of a wave that does not go through whole periods within the window.
         off = pi*(window%window*owner(l) - l)
         share = exp(cmplx(0, off, dp))
         if (abs(off) > 0) share = share*sin(off)/off
         do j = 1, system%meshes
            amplitude = cmplx(window%coefficients(2*l, j), -window%coefficients(2*l + 1, j), dp)/share
            motion%coefficients(2*owner(l):2*owner(l) + 1, j) = [amplitude%re, -amplitude%im]
         end do
      end do
   end subroutine take_lines

   !> The harmonic of the fundamental that each line of a window is taken for; 0: none.
   pure function owners(excited, window, lines) result(owner)
      !> Harmonics of the excitation; periods of the fundamental in the window; number of lines.
      integer, intent(in) :: excited(:), lines
      real(dp), intent(in) :: window
      integer :: owner(lines)
      integer :: found(0:lines), i, j, line, n, r, way

      owner = 0
      found(0) = 0
      n = 0
      ! Sums of one more harmonic than those found before.
      i = 0
      do while (i <= n)
         do j = 1, size(excited)
            do way = 1, -1, -2
               r = abs(found(i) + way*excited(j))
               line = nint(window*r)
               if (line < 1 .or. line > lines) cycle
               if (owner(line) > 0) cycle
               owner(line) = r
               n = n + 1
               found(n) = r
            end do
         end do
         i = i + 1
      end do
   end function owners

end module geartrain_trace_window_start
