!> The exact branch, for whoever checks a branch of the balance: orbits by shooting as a curve in state and Lambda, through folds.
module geartrain_continuation_orbit_path
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: divide_orders, take_one
   use geartrain_base_kinds, only: dp
   use geartrain_continuation_units, only: units_of, units_type
   use geartrain_floquet_multipliers, only: eigenvalues, power
   use geartrain_flow_multiple_shooting, only: find_orbit_in_sections, most_parts, section_states
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: orbit_type, orbit_corrector_type, orbit_test_type, resolution

   !> Cosine of the largest turn of the tangent within a step.
   real(dp), parameter :: least_cosine = 0.8_dp
   !> Places on the path that are closer than this, in units of the train's own, are one: a tenth of it is what shooting leaves.
   real(dp), parameter :: resolution = 1e-10_dp
   integer, parameter :: max_steps = 60
   !> Least Lambda that one step goes to, relative.
   real(dp), parameter :: slowest = 0.5_dp

   !> A point of the exact branch.
   type :: orbit_type
      !> Lambda and the states where the sections of the period begin, (2*coordinates, section).
      real(dp) :: frequency_ratio = 0
      real(dp), allocatable :: states(:, :)
      !> The unit tangent there.
      real(dp) :: tangent_frequency = 0
      real(dp), allocatable :: tangent(:, :)
      !> All of them over the whole period, largest magnitude first, (2*coordinates).
      complex(dp), allocatable :: multipliers(:)
   end type orbit_type

   type :: orbit_corrector_type
      type(system_type) :: system
      !> In mesh periods.
      integer :: period = 1
      !> How often a motion repeats itself within that: orbits are those of one repetition, at so many times the branch's Lambda.
      integer :: times = 1
      type(units_type) :: units
      !> At constant Lambda, and along the branch.
      type(sections_type), private :: fixed, moving
      !> Metric of the states, (2*coordinates, section).
      real(dp), allocatable, private :: weight(:, :)
   contains
      procedure :: setup
      procedure :: solution
      procedure :: distance
      procedure :: point_at
      procedure :: solve_at
      procedure :: correct
      procedure :: advance
      procedure :: find_zero
      procedure, private :: find_multipliers
   end type orbit_corrector_type

   !> A number that an orbit has and that changes sign at what is sought.
   type, abstract :: orbit_test_type
   contains
      procedure(value_interface), deferred :: value
   end type orbit_test_type

   abstract interface
      pure real(dp) function value_interface(self, orbit)
         import :: dp, orbit_test_type, orbit_type
         implicit none (type, external)
         class(orbit_test_type), intent(in) :: self
         type(orbit_type), intent(in) :: orbit
      end function value_interface
   end interface

contains

   !> Prepares for orbits of `period` mesh periods.
   subroutine setup(self, system, period)
      class(orbit_corrector_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: period
      integer :: parts

      self%system = system
      self%period = period
      self%times = 1
      if (period == 1) self%times = system%excitation_order
      call divide_orders(self%times, self%system)
      self%units = units_of(system)
      parts = most_parts(system, period)
      call self%fixed%setup(self%system, period, parts, moves=.false.)
      call self%moving%setup(self%system, period, parts, moves=.true.)
      associate (n => system%coordinates, m => self%fixed%sections)
         allocate (self%weight(2*n, m))
         self%weight(:n, :) = 1/(m*self%units%length**2)
         self%weight(n + 1:, :) = 1/(m*(self%units%length*self%units%frequency_ratio)**2)
      end associate
   end subroutine setup

   !> A motion as a first guess of an orbit.
   subroutine solution(self, motion, orbit)
      class(orbit_corrector_type), intent(inout) :: self
      type(motion_type), intent(in) :: motion
      type(orbit_type), intent(out) :: orbit
      type(motion_type) :: one

      one = motion
      if (self%times > 1) call take_one(self%times, one)
      orbit%frequency_ratio = one%frequency_ratio
      call section_states(self%system, one, self%fixed, orbit%states)
   end subroutine solution

   !> Of two orbits, in units of the train's own.
   pure real(dp) function distance(self, a, b)
      class(orbit_corrector_type), intent(in) :: self
      type(orbit_type), intent(in) :: a, b

      distance = sqrt(sum(self%weight*(a%states - b%states)**2) &
                      + ((a%frequency_ratio - b%frequency_ratio)/self%units%frequency_ratio)**2)
   end function distance

   !> Makes the tangent of `orbit` the unit vector from `before` to `after`; their distance is 0 where there is none.
   subroutine point_at(self, before, after, orbit, way)
      class(orbit_corrector_type), intent(in) :: self
      type(orbit_type), intent(in) :: before, after
      type(orbit_type), intent(inout) :: orbit
      real(dp), intent(out) :: way

      way = self%distance(before, after)
      if (.not. way > 0) return
      orbit%tangent = (after%states - before%states)/way
      orbit%tangent_frequency = (after%frequency_ratio - before%frequency_ratio)/way
   end subroutine point_at

   !> The orbit at exactly the Lambda of `orbit`, from its states; its multipliers.
   subroutine solve_at(self, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      type(orbit_type), intent(inout) :: orbit
      logical, intent(out) :: success
      real(dp) :: last

      call find_orbit_in_sections(self%fixed, orbit%frequency_ratio, orbit%states, last, success)
      if (success) call self%find_multipliers(self%fixed, orbit)
   end subroutine solve_at

   !> The orbit near `orbit`, across its tangent; its multipliers and its own tangent, in the same sense.
   subroutine correct(self, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      type(orbit_type), intent(inout) :: orbit
      logical, intent(out) :: success
      real(dp) :: tangent(size(orbit%states, 1), size(orbit%states, 2)), tangent_frequency, length, last

      call find_orbit_in_sections(self%moving, orbit%frequency_ratio, orbit%states, last, success, self%weight*orbit%tangent, &
                      orbit%tangent_frequency/self%units%frequency_ratio**2, tangent, tangent_frequency)
      if (.not. success) return
      length = sqrt(sum(self%weight*tangent**2) + (tangent_frequency/self%units%frequency_ratio)**2)
      orbit%tangent = tangent/length
      orbit%tangent_frequency = tangent_frequency/length
      call self%find_multipliers(self%moving, orbit)
   end subroutine correct

   subroutine find_multipliers(self, sections, orbit)
      class(orbit_corrector_type), intent(in) :: self
      type(sections_type), intent(inout) :: sections
      type(orbit_type), intent(inout) :: orbit

      if (.not. allocated(orbit%multipliers)) allocate (orbit%multipliers(size(orbit%states, 1)))
      call eigenvalues(sections%monodromy, orbit%multipliers)
      if (self%times > 1) orbit%multipliers = power(orbit%multipliers, self%times)
   end subroutine find_multipliers

   !> From `from` a distance h along its tangent to `to`. No success where the tangent turns by too much, which may be a jump to
   !> another branch.
   subroutine advance(self, from, h, to, success)
      class(orbit_corrector_type), intent(inout) :: self
      type(orbit_type), intent(in) :: from
      real(dp), intent(in) :: h
      type(orbit_type), intent(inout) :: to
      logical, intent(out) :: success

      to = from
      to%states = from%states + h*from%tangent
      to%frequency_ratio = from%frequency_ratio + h*from%tangent_frequency
      ! A flight at Lambda near 0 would have no end.
      success = to%frequency_ratio > slowest*from%frequency_ratio
      if (success) call self%correct(to, success)
      if (success) success = sum(self%weight*from%tangent*to%tangent) &
                             + from%tangent_frequency*to%tangent_frequency/self%units%frequency_ratio**2 > least_cosine
   end subroutine advance

   !> The orbit between `here` and the one a distance h further where the test is 0, which has other signs there.
   subroutine find_zero(self, test, here, h, last, orbit, success)
      class(orbit_corrector_type), intent(inout) :: self
      class(orbit_test_type), intent(in) :: test
      type(orbit_type), intent(in) :: here
      real(dp), intent(in) :: h
      !> The orbit at h.
      type(orbit_type), intent(in) :: last
      type(orbit_type), intent(inout) :: orbit
      logical, intent(out) :: success
      real(dp) :: a, b, fa, fb, f, s
      integer :: i, kept

      a = 0
      b = h
      fa = test%value(here)
      fb = test%value(last)
      kept = 0
      do i = 1, max_steps
         s = between(a, b, fa, fb)
         call self%advance(here, s, orbit, success)
         if (.not. success) return
         f = test%value(orbit)
         if (abs(f) <= tiny(f)) return
         call shrink(a, b, fa, fb, s, f, kept)
         if (b - a < resolution) return
      end do
   end subroutine find_zero

end module geartrain_continuation_orbit_path
