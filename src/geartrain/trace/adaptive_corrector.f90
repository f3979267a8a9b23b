!> A corrector that chooses its number of harmonics by the tolerance, from solution point to solution point, where the settings
!> leave it to the program (harmonics = 0).
module geartrain_trace_adaptive_corrector
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_chosen_harmonics, only: fewest_harmonics, most_harmonics
   use geartrain_balance_error_estimate, only: error_estimate_type, find_error_estimate, harmonics_for
   use geartrain_balance_harmonic_set, only: next_set
   use geartrain_balance_tail_harmonics, only: resonance_ratio
   use geartrain_balance_winding, only: find_winding, winding_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_floquet_monodromy, only: has_all_multipliers
   use geartrain_trace_branch, only: response_settings_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_readings_at, only: weigh_readings
   use geartrain_trace_step_geometry, only: sense_of
   use geartrain_network_units, only: largest_drive
   use geartrain_linalg_trigonometric, only: transform_length
   use geartrain_network_excitation, only: highest_order
   use geartrain_network_long_period, only: long_period
   use geartrain_network_natural_modes, only: natural_frequency_ranges
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: adaptive_corrector_type

   !> Share of the tolerance aimed at, so that the next points keep within the tolerance too.
   real(dp), parameter :: tolerance_share = 0.3_dp, set_share = 0.6_dp
   !> Ratio of new to present number of harmonics above which the number is not lowered: each change plans the balance anew.
   real(dp), parameter :: worth_lowering = 0.75_dp
   !> Distance of the motion of fewer harmonics over the next step above which the number is not lowered.
   real(dp), parameter :: farthest = 0.3_dp
   !> Largest drive of a train that is as good as none, over the displacements of the branch.
   real(dp), parameter :: vanishing = 1e-6_dp
   !> Most harmonics of a set.
   integer, parameter :: largest_set = 2000
   !> Share of such a set that must stay, where harmonics of its tail that are larger than some of its own do not matter enough.
   real(dp), parameter :: least_change = 0.8_dp
   !> Most harmonics of a set where teeth part in a long period: the motion has thousands of nearly equal amplitudes there, and a
   !> point would take a minute with them.
   integer, parameter :: largest_set_parting = 160
   !> Weight of the first winding that is tried; weight of a longer one over it.
   integer, parameter :: least_weight = 12
   real(dp), parameter :: longer = 1.25_dp
   !> Error by the shorter winding over the tolerance above which it is too short; accuracy of this error [1].
   real(dp), parameter :: winding_share = 0.2_dp, rough = 0.1_dp

   type :: adaptive_corrector_type
      !> Settings that the branch is traced with.
      type(response_settings_type) :: settings
      !> Dimensionless system of the train; on a branch over a parameter that amid the path, where no excitation is 0, by which
      !> harmonics are planned, and the one that the balance moves along the path.
      type(system_type), pointer :: system => null(), moving => null()
      type(corrector_type) :: corrector
      !> Error estimate of the solution point of the latest `estimate_error`.
      type(error_estimate_type) :: estimate
      !> Change of the tangent's Lambda part per length of the branch at the latest step [1], in the metric of the branch.
      real(dp) :: curvature = 0
      !> The branch is shown: its points must have what is read off it, and their errors. Else it only leads to its end.
      logical :: shows = .true.
      !> Carried are sets of harmonics, see geartrain_balance_harmonic_set.
      logical :: chooses_sets = .false.
      !> The balance with exact coefficients, for the error of sampled ones, or on a longer winding, for that of a shorter one; not
      !> set up where they are exact anyway.
      type(balance_type), private :: exact
      !> The shorter and the longer winding, and the weight of the shorter.
      type(winding_type), private :: winding(2)
      integer, private :: weight = least_weight
      !> The weight that is enough for the places of the harmonics where no teeth part.
      integer, private :: weight_in_contact = least_weight
      !> Error of the latest solution point by the shorter winding, relative to the motion [1].
      real(dp), private :: off_winding = 0
      !> Evaluations of the balance at the latest error estimate; -1: none yet.
      integer, private :: estimated = -1
   contains
      procedure :: prepare, estimate_error, adapt, relax, tell_trouble, vanishes
      procedure, private :: solve_again, winds, take_windings
      procedure, private :: largest
   end type adaptive_corrector_type

contains

   !> Plans balance and corrector for a number of harmonics.
   subroutine prepare(self, harmonics, set)
      class(adaptive_corrector_type), intent(inout) :: self
      !> Highest harmonic of Lambda/subharmonic to carry.
      integer, intent(in) :: harmonics
      !> Harmonics to carry, ascending up to `harmonics`, where sets are chosen; else those that the excitation reaches.
      integer, intent(in), optional :: set(:)
      type(system_type), pointer :: system
      integer :: samples
      logical :: chosen, parts, winds

      system => self%system
      if (allocated(self%corrector%balance%path)) then
         self%moving = self%system
         system => self%moving
      end if
      samples = 0
      if (self%settings%coefficients == 'sampled') then
         samples = self%settings%samples
         if (samples == 0) samples = max(1024, transform_length(16*harmonics))
      end if
      chosen = self%chooses_sets .and. present(set)
      associate (own => self%settings)
         if (chosen) then
            ! A short winding is enough again where no teeth part.
            parts = .false.
            if (allocated(self%corrector%balance%contact)) parts = self%corrector%balance%parts()
            if (.not. parts) self%weight = self%weight_in_contact
            winds = self%winds(set)
            if (.not. parts) self%weight_in_contact = self%weight
            if (winds) then
               call self%corrector%balance%setup(system, harmonics, own%subharmonic, samples, set, own%repeats, self%winding(1))
               call self%exact%setup(system, harmonics, own%subharmonic, samples, set, own%repeats, self%winding(2))
            else
               call self%corrector%balance%setup(system, harmonics, own%subharmonic, samples, set, own%repeats)
            end if
         else
            call self%corrector%balance%setup(system, harmonics, own%subharmonic, samples, repeats=own%repeats)
         end if
      end associate
      if (allocated(self%corrector%balance%path)) self%exact%path = self%corrector%balance%path
      if (samples > 0) call self%exact%setup(system, harmonics, self%settings%subharmonic, 0, &
                                               repeats=self%settings%repeats)
      call self%corrector%setup()
      self%corrector%local_control = self%settings%control == 'local'
   end subroutine prepare

   !> Whether the contacts of a set of harmonics are found on a winding: of a long period where only motions that are recorded need
   !> the contacts over the period, and where all harmonics have places.
   logical function winds(self, set)
      class(adaptive_corrector_type), intent(inout) :: self
      integer, intent(in) :: set(:)
      integer :: i

      winds = .false.
      associate (own => self%settings, system => self%system)
         if (own%coefficients == 'sampled' .or. allocated(self%corrector%balance%path) .or. own%subharmonic > 1) return
         if (own%multipliers .or. .not. has_all_multipliers(system)) return
         if (.not. highest_order(system) > long_period*system%excitation_order) return
      end associate
      do
         call self%take_windings()
         winds = all([(self%winding(i)%cycles > 0, i=1, 2)])
         if (.not. winds) return
         winds = all(self%winding(1)%place_of(set) > 0) .and. all(self%winding(2)%place_of(set) > 0)
         if (winds) return
         self%weight = nint(longer*self%weight)
      end do
   end function winds

   !> Finds the windings of the present weight and of a higher one, unless they are known.
   subroutine take_windings(self)
      class(adaptive_corrector_type), intent(inout) :: self
      integer :: i

      do i = 1, 2
         associate (weight => nint(self%weight*longer**(i - 1)))
            if (self%winding(i)%weight /= weight) call find_winding(self%system, weight, self%winding(i))
            self%winding(i)%weight = weight
         end associate
      end do
   end subroutine take_windings

   !> Estimates the error of the solution point that `corrector` worked on last, unless it is known already.
   subroutine estimate_error(self, solution)
      class(adaptive_corrector_type), intent(inout) :: self
      !> Solution point with its tangent.
      type(solution_point_type), intent(in) :: solution
      real(dp), allocatable :: off(:, :)
      real(dp) :: y

      if (self%estimated == self%corrector%evaluations) return
      self%estimated = self%corrector%evaluations
      associate (c => self%corrector, s => solution)
         if (c%balance%varies) self%estimate%resonance = natural_frequency_ranges(c%balance%system, resonance_ratio)
         if (self%settings%coefficients == 'sampled') then
            call self%exact%evaluate(s%u, s%frequency_ratio)
            call find_error_estimate(self%exact, s%u, self%exact%frequency_ratio, s%tangent, s%tangent_frequency, self%curvature, &
                                     c%units%frequency_ratio, c%matrix, self%estimate, self%exact%residual)
            if (self%shows) call weigh_readings(self%exact, s%u, self%settings%shaft_torque, self%estimate)
         else
            self%off_winding = 0
            if (c%balance%is_wound() .and. .not. c%balance%keeps_distance()) then
               call self%exact%evaluate(s%u, s%frequency_ratio)
               off = -self%exact%residual
               y = 0
               call c%matrix%solve(c%balance, off, y, rough)
               self%off_winding = norm2(off(2:, :))/max(norm2(s%u(2:, :)), tiny(1.0_dp))
               call find_error_estimate(c%balance, s%u, c%balance%frequency_ratio, s%tangent, s%tangent_frequency, self%curvature, &
                                        c%units%frequency_ratio, c%matrix, self%estimate, self%exact%residual)
            else
               call find_error_estimate(c%balance, s%u, c%balance%frequency_ratio, s%tangent, s%tangent_frequency, self%curvature, &
                                        c%units%frequency_ratio, c%matrix, self%estimate)
            end if
            if (self%shows) call weigh_readings(c%balance, s%u, self%settings%shaft_torque, self%estimate)
         end if
      end associate
   end subroutine estimate_error

   !> With harmonics = 0: raises the number of harmonics until `solution` is within the tolerance.
   subroutine adapt(self, solution, success, here, origin, fixed, kept, step_end)
      class(adaptive_corrector_type), intent(inout) :: self
      !> Solution point that was solved last.
      type(solution_point_type), intent(inout) :: solution
      !> False where a balance of more harmonics finds no solution: then nothing is changed.
      logical, intent(out) :: success
      !> Further solution points to put onto the new harmonics.
      type(solution_point_type), intent(inout), optional :: here, origin
      !> Keeps Lambda of `solution` as it is; false unless it is given.
      logical, intent(in), optional :: fixed
      !> Where `success` is false: whether `solution` is solved, as it was.
      logical, intent(out), optional :: kept
      !> The solution point ends a step from `here`: where Lambda turns within it, the step has a fold also with more harmonics.
      logical, intent(in), optional :: step_end
      type(solution_point_type) :: before(3)
      integer, allocatable :: first_set(:), larger(:)
      integer :: highest, most, first
      real(dp) :: share
      logical :: ends_step

      success = .true.
      if (present(kept)) kept = .true.
      if (self%settings%harmonics > 0) return
      ends_step = .false.
      if (present(step_end)) ends_step = step_end
      first = self%corrector%balance%highest
      first_set = self%corrector%balance%harmonic
      most = most_harmonics(self%system, self%settings%subharmonic, self%settings%repeats)
      before(1) = solution
      if (present(here)) before(2) = here
      if (present(origin)) before(3) = origin
      do
         call self%estimate_error(solution)
         highest = self%corrector%balance%highest
         if (self%estimate%limited <= self%settings%tolerance) return
         if (self%corrector%balance%is_wound() .and. self%off_winding > winding_share*self%settings%tolerance) then
            self%weight = nint(longer*self%weight)
            larger = self%corrector%balance%harmonic
            call self%prepare(highest, larger)
         else if (self%chooses_sets) then
            share = set_share*self%settings%tolerance/self%estimate%limited
            associate (now => size(self%corrector%balance%harmonic), most => self%largest())
               ! A set made where no teeth part may be larger.
               if (now > 2*most) share = 1 + epsilon(share)
               if (now >= most .and. now <= 2*most .and. most < largest_set) return
               larger = next_set(self%corrector%balance, solution%u, self%estimate, share, most)
               if (now >= most .and. now <= 2*most .and. kept_of(larger) > least_change*now) return
            end associate
            call self%prepare(larger(size(larger)), larger)
         else
            if (highest >= most) return
            call self%prepare(min(most, max(highest + self%settings%repeats, harmonics_for(self%estimate, &
                                            tolerance_share*self%settings%tolerance/self%estimate%limited))))
         end if
         call self%corrector%refit(solution)
         if (present(here)) call self%corrector%refit(here)
         if (present(origin)) call self%corrector%refit(origin)
         call self%solve_again(solution, success, fixed)
         if (success .and. ends_step) call find_turn(success)
         if (.not. success) exit
      end do
      call self%prepare(first, first_set)
      solution = before(1)
      if (present(here)) here = before(2)
      if (present(origin)) origin = before(3)
      call self%solve_again(solution, success, fixed)
      if (present(kept)) kept = success
      success = .false.

   contains

      !> Refuses a motion of more harmonics past a fold where the motion of fewer is before it, and a turn between which and `here`
      !> more harmonics have no fold.
      subroutine find_turn(success)
         logical, intent(out) :: success
         integer :: sense

         sense = sense_of(solution, self%corrector%units)
         success = sense_of(before(1), self%corrector%units)*sense >= 0
         if (.not. success .or. sense_of(here, self%corrector%units)*sense >= 0) return
         call self%corrector%correct(here, success)
         if (success) call self%solve_again(solution, success, fixed)
      end subroutine find_turn

      !> How many of the carried harmonics a set has.
      pure integer function kept_of(set)
         integer, intent(in) :: set(:)
         logical :: has(max(highest, maxval(set)))

         has = .false.
         has(set) = .true.
         kept_of = count(has(self%corrector%balance%harmonic))
      end function kept_of

   end subroutine adapt

   !> Most harmonics of a set at the latest solution point.
   pure integer function largest(self)
      class(adaptive_corrector_type), intent(in) :: self

      largest = largest_set
      if (self%corrector%balance%has_long_period() .and. self%corrector%balance%parts()) largest = largest_set_parting
   end function largest

   !> Solves a solution point that has a tangent after its number of harmonics changed: at the same Lambda if `fixed`.
   subroutine solve_again(self, solution, success, fixed)
      class(adaptive_corrector_type), intent(inout) :: self
      type(solution_point_type), intent(inout) :: solution
      logical, intent(out) :: success
      logical, intent(in), optional :: fixed
      integer :: direction

      if (present(fixed)) then
         if (fixed) then
            direction = merge(1, -1, solution%tangent_frequency > 0)
            call self%corrector%solve_at(solution, success)
            if (success) call self%corrector%orient(solution, direction)
            return
         end if
      end if
      call self%corrector%correct(solution, success, damped=.true.)
   end subroutine solve_again

   !> With harmonics = 0: lowers the number of harmonics for the next points where the error estimate leaves room, to half at least,
   !> unless the motion of fewer lies too far away: where a branch is steep each change of harmonics may lead back by a step.
   subroutine relax(self, here, origin, step)
      class(adaptive_corrector_type), intent(inout) :: self
      !> Latest point, to which `estimate` belongs; where the branch began. Both are put onto the new harmonics.
      type(solution_point_type), intent(inout) :: here, origin
      !> Length of the next step [1].
      real(dp), intent(in) :: step
      type(solution_point_type) :: before(2), guess
      integer, allocatable :: set(:), smaller(:)
      real(dp) :: share
      integer :: highest, fewer
      logical :: success

      if (self%settings%harmonics > 0) return
      highest = self%corrector%balance%highest
      share = tolerance_share*self%settings%tolerance/max(self%estimate%limited, tiny(1.0_dp))
      set = self%corrector%balance%harmonic
      fewer = max(fewest_harmonics(self%system, self%settings%subharmonic, self%settings%repeats), highest/2, &
                  harmonics_for(self%estimate, share))
      if (self%chooses_sets) then
         share = set_share*self%settings%tolerance/max(self%estimate%limited, tiny(1.0_dp))
         if (share < 1) return
         smaller = next_set(self%corrector%balance, here%u, self%estimate, share)
         if (size(smaller) > worth_lowering*size(set)) return
      else
         if (fewer > worth_lowering*highest) return
      end if
      before = [here, origin]
      if (self%chooses_sets) then
         call self%prepare(smaller(size(smaller)), smaller)
      else
         call self%prepare(fewer)
      end if
      call self%corrector%refit(here)
      call self%corrector%refit(origin)
      guess = here
      call self%corrector%correct(here, success)
      if (success) success = self%corrector%length_of(here%u - guess%u, here%frequency_ratio - guess%frequency_ratio) &
                             < farthest*step
      if (success) then
         ! Where the branch is steep, a motion of fewer harmonics may lie far away; where it gives a smaller error than it has, the
         ! next step would lead back to the same point with all of them.
         call self%estimate_error(here)
         success = self%estimate%limited <= self%settings%tolerance
      end if
      if (success) return
      call self%prepare(highest, set)
      here = before(1)
      origin = before(2)
   end subroutine relax

   !> Tells what keeps the next point of the branch from being found.
   subroutine tell_trouble(self, words)
      class(adaptive_corrector_type), intent(in) :: self
      !> The words.
      character(:), allocatable, intent(out) :: words

      if (self%vanishes()) then
         words = 'the motion vanishes there with all that excites it'
         return
      end if
      words = 'the motion is not smooth there or needs more than '//text(self%corrector%balance%highest)//' harmonics: '
      if (self%settings%harmonics == 0) words = words//'lower tolerance, or see &integration'
      if (self%settings%harmonics > 0) words = words//'raise harmonics, or see &integration'
   end subroutine tell_trouble

   !> Whether on a branch over a parameter hardly anything excites the train of the latest solution, which has gaps: it is at
   !> rest at a wall, or floats.
   pure logical function vanishes(self)
      class(adaptive_corrector_type), intent(in) :: self

      vanishes = .false.
      if (.not. allocated(self%corrector%balance%path)) return
      associate (system => self%corrector%balance%system)
         vanishes = any(system%half_backlash > 0) .and. largest_drive(system) < vanishing*self%corrector%units%length
      end associate
   end function vanishes

end module geartrain_trace_adaptive_corrector
