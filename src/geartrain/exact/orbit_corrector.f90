!> The exact branch, to check a branch of the balance against: orbits by shooting as a curve in state and Lambda, through folds.
module geartrain_exact_orbit_corrector
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: take_one
   use geartrain_base_kinds, only: dp
   use geartrain_exact_chord, only: tangents_meet
   use geartrain_exact_orbit_depth, only: depth_of
   use geartrain_trace_stages, only: depth_of_stage, no_stage
   use geartrain_network_divide_orders, only: divide_orders
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_units, only: units_of, units_type
   use geartrain_floquet_multipliers, only: eigenvalues, is_neutral, is_stable, multipliers_of
   use geartrain_flow_held_twists, only: centre_twists
   use geartrain_flow_kept_states, only: keeps
   use geartrain_flow_multiple_shooting, only: find_orbit_in_sections, most_parts, section_states
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: orbit_type, orbit_corrector_type, orbit_test_type, resolution

   !> Least cosine of the angle between the tangents at the ends of a step [1], and where there may be a corner; largest distance of
   !> an orbit from its guess over the length of the step, where there may be a corner [1].
   real(dp), parameter :: least_cosine = 0.8_dp, cosine_at_corner = 0.02_dp, farthest_aside = 4
   !> Orbits closer than this in the metric are equal: about ten times the error of shooting [units_type].
   real(dp), parameter :: resolution = 1e-10_dp
   integer, parameter :: max_steps = 60
   !> Most changes of twists that dry friction holds.
   integer, parameter :: most_centred = 4
   !> Half of the distance of the orbits around a blurred zero [units_type].
   real(dp), parameter :: around = 1e-4_dp
   !> Least Lambda at the end of a step, over Lambda at its beginning [1].
   real(dp), parameter :: slowest = 0.5_dp

   !> A point of the exact branch.
   type :: orbit_type
      !> Lambda [1], of one repetition (see orbit_corrector_type).
      real(dp) :: frequency_ratio = 0
      !> Dimensionless states at the beginnings of the sections of the period, (state, section).
      real(dp), allocatable :: states(:, :)
      !> Unit tangent: its parts of Lambda and of the states, (state, section).
      real(dp) :: tangent_frequency = 0
      real(dp), allocatable :: tangent(:, :)
      !> Multipliers over one repetition, largest magnitude first, (state). Those of twists that a period leaves as they are count
      !> as 0.
      complex(dp), allocatable :: multipliers(:)
      !> Verdict by the multipliers; number of twists that a period leaves as they are.
      logical :: stable = .false., undecided = .false.
      integer :: kept = 0
      !> Last step of Newton's method, relative [1].
      real(dp) :: accuracy = 0
      !> Distance from the guess of the step that led there, over the length of the step [1].
      real(dp) :: correction = 0
      !> Distance of the displacement of the watched mesh from the contact that is watched, negative with this contact [1].
      real(dp) :: depth = 0
   end type orbit_type

   type :: orbit_corrector_type
      !> The train, its orders divided by `times`.
      type(system_type), pointer :: system => null()
      !> Period of the branch [periods of the fundamental].
      integer :: period = 1
      !> Number of repetitions of a motion within the period: an orbit is one repetition, at `times` the Lambda of the branch.
      integer :: times = 1
      !> Number of the mesh whose contact is watched, 0: none; whether its back flanks are, else its separation.
      integer :: watched_mesh = 0
      logical :: watches_back = .false.
      !> Number of the stage that is watched in place of both, `no_stage`: none.
      integer :: watched_stage = no_stage
      !> Whether the branch may have corners, as dry friction makes them.
      logical :: corners = .false.
      !> Units of the metric.
      type(units_type) :: units
      !> Sections for shooting at constant Lambda, and for shooting along the branch.
      type(sections_type), private :: fixed, moving
      !> Metric of the states, (state, section).
      real(dp), allocatable, private :: weight(:, :)
   contains
      procedure :: setup
      procedure :: first_guess
      procedure :: distance
      procedure :: along
      procedure :: cosine
      procedure :: take_train
      procedure :: point_at
      procedure :: solve_at
      procedure :: correct
      procedure :: advance
      procedure :: find_zero
      procedure, private :: find_multipliers
   end type orbit_corrector_type

   !> A test function: it changes sign at the orbit that is sought.
   type, abstract :: orbit_test_type
      !> Two branches cross at its zero, next to which shooting fails: the chord of the step leads there.
      logical :: singular = .false.
      !> Several branches cross at its zero, next to which shooting is blurred by rounding: the orbit is taken from those around it.
      logical :: blurred = .false.
   contains
      procedure(value_interface), deferred :: value
   end type orbit_test_type

   abstract interface
      pure real(dp) function value_interface(self, orbit)
         import :: dp, orbit_test_type, orbit_type
         implicit none (type, external)
         class(orbit_test_type), intent(in) :: self
         !> An orbit with tangent and multipliers.
         type(orbit_type), intent(in) :: orbit
      end function value_interface
   end interface

contains

   !> Prepares for the orbits of a branch.
   subroutine setup(self, system, period, times, path, origin, beside, corners)
      ! A thread's private variable has garbage where its type has default values (gfortran 12): intent(out) sets them.
      class(orbit_corrector_type), intent(out) :: self
      !> The train, a copy for this corrector alone: its orders are divided by `times`.
      type(system_type), pointer, intent(in) :: system
      !> Period of the branch [periods of the fundamental]; how often its motions go through their waveform within it.
      integer, intent(in) :: period, times
      !> The train over a parameter in place of Lambda, see sections_type.
      type(parameter_path_type), pointer, intent(in), optional :: path
      !> Value at which what stands for Lambda is 1 [unit of the parameter].
      real(dp), intent(in), optional :: origin
      !> Room for the train with another value of the parameter.
      type(system_type), pointer, intent(in), optional :: beside
      !> Whether the branch may have corners; default: it has none.
      logical, intent(in), optional :: corners
      integer :: parts

      self%system => system
      self%period = period
      self%times = times
      if (present(corners)) self%corners = corners
      call divide_orders(self%times, self%system)
      self%units = units_of(system)
      parts = most_parts(system, period)
      if (present(path)) then
         self%units%frequency_ratio = 1
         call self%fixed%vary_along(path, origin, beside)
         call self%moving%vary_along(path, origin, beside)
      end if
      call self%fixed%setup(self%system, period, parts, moves=.false.)
      call self%moving%setup(self%system, period, parts, moves=.true.)
      associate (n => system%displacements, m => self%fixed%sections, rate => units_of(system))
         allocate (self%weight(system%states, m))
         self%weight(:n, :) = 1/(m*self%units%length**2)
         self%weight(n + 1:, :) = 1/(m*(self%units%length*rate%frequency_ratio)**2)
         ! Where an event passes the end of a section, velocities have a corner along a smooth branch; displacements have none.
         if (self%corners) self%weight(n + 1:, :) = 0
      end associate
   end subroutine setup

   !> First guess of an orbit from a motion.
   subroutine first_guess(self, motion, orbit)
      class(orbit_corrector_type), intent(inout) :: self
      !> A motion of period `period`, with coefficients or state.
      type(motion_type), intent(in) :: motion
      !> Lambda and states, without tangent and multipliers.
      type(orbit_type), intent(out) :: orbit
      type(motion_type) :: one

      one = motion
      if (self%times > 1) call take_one(self%times, one)
      orbit%frequency_ratio = one%frequency_ratio
      call section_states(self%system, one, self%fixed, orbit%states)
   end subroutine first_guess

   !> Distance of two orbits in the metric: mean square over the sections plus the square of Lambda, in their units [units_type].
   pure real(dp) function distance(self, a, b)
      class(orbit_corrector_type), intent(in) :: self
      !> The two orbits.
      type(orbit_type), intent(in) :: a, b

      distance = sqrt(sum(self%weight*(a%states - b%states)**2) &
                      + ((a%frequency_ratio - b%frequency_ratio)/self%units%frequency_ratio)**2)
   end function distance

   !> Distance of an orbit from another along its tangent [units_type].
   pure real(dp) function along(self, from, to)
      class(orbit_corrector_type), intent(in) :: self
      !> The orbit with the tangent; the other one.
      type(orbit_type), intent(in) :: from, to

      along = sum(self%weight*from%tangent*(to%states - from%states)) &
              + from%tangent_frequency*(to%frequency_ratio - from%frequency_ratio)/self%units%frequency_ratio**2
   end function along

   !> Cosine of the angle between the tangents of two orbits [1].
   pure real(dp) function cosine(self, a, b)
      class(orbit_corrector_type), intent(in) :: self
      !> The two orbits.
      type(orbit_type), intent(in) :: a, b

      cosine = sum(self%weight*a%tangent*b%tangent) + a%tangent_frequency*b%tangent_frequency/self%units%frequency_ratio**2
   end function cosine

   !> Gives `system` the value of the parameter that an orbit has, and finds Lambda.
   subroutine take_train(self, orbit, frequency_ratio)
      class(orbit_corrector_type), intent(inout) :: self
      !> The orbit.
      type(orbit_type), intent(in) :: orbit
      !> Lambda [1].
      real(dp), intent(out) :: frequency_ratio

      call self%fixed%stand_at(orbit%frequency_ratio, frequency_ratio)
   end subroutine take_train

   !> Makes the tangent of an orbit the unit vector along a chord.
   subroutine point_at(self, before, after, orbit, way)
      class(orbit_corrector_type), intent(in) :: self
      !> The two ends of the chord.
      type(orbit_type), intent(in) :: before, after
      !> Gets the tangent; unchanged where `way` is 0.
      type(orbit_type), intent(inout) :: orbit
      !> Length of the chord [units_type].
      real(dp), intent(out) :: way

      way = self%distance(before, after)
      if (.not. way > 0) return
      orbit%tangent = (after%states - before%states)/way
      orbit%tangent_frequency = (after%frequency_ratio - before%frequency_ratio)/way
   end subroutine point_at

   !> Shooting at constant Lambda.
   subroutine solve_at(self, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      !> A guess; then the orbit with its multipliers, the tangent unchanged.
      type(orbit_type), intent(inout) :: orbit
      !> Newton's method has converged.
      logical, intent(out) :: success
      integer :: i
      logical :: moved

      do i = 1, most_centred
         call find_orbit_in_sections(self%fixed, orbit%frequency_ratio, orbit%states, orbit%accuracy, success)
         if (.not. success) return
         if (.not. self%corners) exit
         call centre_twists(self%system, self%fixed, orbit%frequency_ratio, self%units%length, orbit%states, moved)
         if (.not. moved) exit
      end do
      call self%find_multipliers(self%fixed, orbit)
   end subroutine solve_at

   !> Shooting in the hyperplane through `orbit` normal to its tangent.
   subroutine correct(self, orbit, success, farthest)
      class(orbit_corrector_type), intent(inout) :: self
      !> A guess with tangent; then the orbit with its multipliers, and its tangent in the direction of the former tangent.
      type(orbit_type), intent(inout) :: orbit
      !> Newton's method has converged.
      logical, intent(out) :: success
      !> Distance from the guess beyond which Newton's method ends [units_type]; default: none.
      real(dp), intent(in), optional :: farthest
      real(dp) :: tangent(size(orbit%states, 1), size(orbit%states, 2)), tangent_frequency, length
      real(dp) :: smallest, largest
      real(dp), allocatable :: metric(:, :)
      integer :: i
      logical :: moved

      if (present(farthest)) metric = self%weight
      do i = 1, most_centred
         call find_orbit_in_sections(self%moving, orbit%frequency_ratio, orbit%states, orbit%accuracy, success, &
            self%weight*orbit%tangent, orbit%tangent_frequency/self%units%frequency_ratio**2, tangent, tangent_frequency, &
            metric, farthest)
         if (.not. success) return
         if (.not. self%corners) exit
         call centre_twists(self%system, self%moving, orbit%frequency_ratio, self%units%length, orbit%states, moved)
         if (.not. moved) exit
      end do
      length = sqrt(sum(self%weight*tangent**2) + (tangent_frequency/self%units%frequency_ratio)**2)
      orbit%tangent = tangent/length
      orbit%tangent_frequency = tangent_frequency/length
      call self%find_multipliers(self%moving, orbit)
      if (self%watched_mesh == 0) return
      if (self%watched_stage /= no_stage) then
         call self%moving%extremes(orbit%frequency_ratio, orbit%states, self%watched_mesh, smallest, largest)
         orbit%depth = depth_of_stage(self%system, self%watched_mesh, self%watched_stage, smallest, largest)
         return
      end if
      orbit%depth = depth_of(self%moving, orbit%frequency_ratio, orbit%states, self%watched_mesh, &
                             self%system%half_backlash(self%watched_mesh), self%watches_back)
   end subroutine correct

   subroutine find_multipliers(self, sections, orbit)
      class(orbit_corrector_type), intent(in) :: self
      type(sections_type), intent(inout) :: sections
      type(orbit_type), intent(inout) :: orbit
      integer, allocatable :: moving(:)
      integer :: k

      if (.not. allocated(orbit%multipliers)) allocate (orbit%multipliers(size(orbit%states, 1)))
      orbit%kept = 0
      if (self%corners) orbit%kept = count(keeps(sections%monodromy))
      if (orbit%kept > 0) then
         moving = pack([(k, k=1, size(orbit%multipliers))], .not. keeps(sections%monodromy))
         orbit%multipliers = 0
         orbit%multipliers(:size(moving)) = multipliers_of(sections%monodromy(moving, moving))
      else
         call eigenvalues(sections%monodromy, orbit%multipliers)
      end if
      orbit%stable = is_stable(orbit%multipliers)
      orbit%undecided = is_neutral(orbit%multipliers)
   end subroutine find_multipliers

   !> One step along the branch: predictor and corrector.
   subroutine advance(self, from, h, to, success)
      class(orbit_corrector_type), intent(inout) :: self
      !> An orbit with tangent.
      type(orbit_type), intent(in) :: from
      !> Length of the predictor step [units_type].
      real(dp), intent(in) :: h
      !> The next orbit, with tangent and multipliers; no orbit unless `success`.
      type(orbit_type), intent(inout) :: to
      !> Shooting has converged, and the tangent turns by less than `least_cosine`, or, where there may be a corner, meets the
      !> tangent at the beginning: else it may be another branch.
      logical, intent(out) :: success
      real(dp), allocatable :: farthest

      to = from
      to%states = from%states + h*from%tangent
      to%frequency_ratio = from%frequency_ratio + h*from%tangent_frequency
      ! Near Lambda = 0 the period is too long to be integrated.
      success = to%frequency_ratio > slowest*from%frequency_ratio .and. self%moving%reaches(to%frequency_ratio)
      if (self%corners) farthest = farthest_aside*abs(h)
      if (success) call self%correct(to, success, farthest)
      if (success) success = self%cosine(from, to) > merge(cosine_at_corner, least_cosine, self%corners)
      if (.not. (success .and. self%corners)) return
      associate (chord => to%states - from%states, moves => abs(from%tangent) > 0, way => to%frequency_ratio - from%frequency_ratio)
         ! The states that the tangent leaves as they are may be twists that are moved to their middle.
         to%correction = sqrt(sum(self%weight*(chord - h*from%tangent)**2, moves))/abs(h)
         success = tangents_meet(merge(self%weight, 0.0_dp, moves .and. abs(to%tangent) > 0), self%units%frequency_ratio, &
            chord, way, from%tangent, from%tangent_frequency, to%tangent, to%tangent_frequency)
      end associate
   end subroutine advance

   !> Finds the orbit between two orbits of a step at which a test function is zero.
   subroutine find_zero(self, test, here, h, last, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      !> The test function, of different signs at `here` and `last`.
      class(orbit_test_type), intent(in) :: test
      !> The orbit at the beginning of the step.
      type(orbit_type), intent(in) :: here
      !> Length of the step [units_type].
      real(dp), intent(in) :: h
      !> The orbit at the end of the step.
      type(orbit_type), intent(in) :: last
      !> The orbit at which the test function is zero, to `resolution`; of a singular test a guess of it.
      type(orbit_type), intent(inout) :: orbit
      !> Shooting has converged.
      logical, intent(out) :: success
      real(dp) :: a, b, fa, fb, f, s
      integer :: i, kept

      a = 0
      b = h
      fa = test%value(here)
      fb = test%value(last)
      kept = 0
      if (test%singular) then
         s = fa/(fa - fb)
         orbit = here
         orbit%states = (1 - s)*here%states + s*last%states
         orbit%frequency_ratio = (1 - s)*here%frequency_ratio + s*last%frequency_ratio
         success = .true.
         return
      end if
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call self%advance(here, s, orbit, success)
         ! Next to a blurred zero shooting may fail.
         if (test%blurred .and. .not. success) exit
         if (.not. success) return
         f = test%value(orbit)
         if (abs(f) <= tiny(f)) return
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < merge(around, resolution, test%blurred)) exit
      end do
      if (test%blurred) call interpolate_zero(self, test, here, s, orbit, success)
   end subroutine find_zero

   !> The zero of a test function near the distance `s` from an orbit, by a cubic through four orbits around it.
   subroutine interpolate_zero(self, test, here, s, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      class(orbit_test_type), intent(in) :: test
      type(orbit_type), intent(in) :: here
      real(dp), intent(in) :: s
      type(orbit_type), intent(inout) :: orbit
      logical, intent(out) :: success
      real(dp), parameter :: place(4) = [-3, -1, 1, 3]
      type(orbit_type) :: near(4)
      real(dp) :: f(4), share(4), x, x_before, y, y_before, step
      integer :: i

      do i = 1, size(place)
         call self%advance(here, s + around*place(i), near(i), success)
         if (.not. success) return
         f(i) = test%value(near(i))
      end do
      ! The secant method on the cubic.
      x_before = place(1)
      y_before = f(1)
      x = 0
      do i = 1, max_steps
         share = shares(x)
         y = sum(share*f)
         if (.not. abs(y - y_before) > 0) exit
         step = y*(x - x_before)/(y - y_before)
         x_before = x
         y_before = y
         x = x - step
         if (abs(step) < 1e-10_dp) exit
      end do
      success = abs(x) < maxval(place)
      if (.not. success) return
      share = shares(x)
      orbit = here
      orbit%states = 0
      orbit%tangent = 0
      do i = 1, size(place)
         orbit%states = orbit%states + share(i)*near(i)%states
         orbit%tangent = orbit%tangent + share(i)*near(i)%tangent
      end do
      orbit%frequency_ratio = sum(share*near%frequency_ratio)
      orbit%tangent_frequency = sum(share*near%tangent_frequency)
      call self%moving%fly(orbit%frequency_ratio, orbit%states)
      success = .not. self%moving%interrupted()
      if (success) call self%find_multipliers(self%moving, orbit)

   contains

      !> Share of each orbit in the cubic at x.
      pure function shares(x)
         real(dp), intent(in) :: x
         real(dp) :: shares(size(place))
         integer :: j, k

         shares = 1
         do j = 1, size(place)
            do k = 1, size(place)
               if (k /= j) shares(j) = shares(j)*(x - place(k))/(place(j) - place(k))
            end do
         end do
      end function shares

   end subroutine interpolate_zero

end module geartrain_exact_orbit_corrector
