!> The motions of a branch of a train with dry friction at exactly one Lambda, or value of a parameter: by shooting from motions
!> between two points of the branch.
module geartrain_readings_friction_solutions
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_shooting, only: refine
   use geartrain_flow_start_state, only: state_of
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_trace_branch, only: branch_type, coefficients_of
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: friction_solutions_at

   !> Distance from the motion between two points, over the distance of the points, up to which a motion counts as that of the
   !> branch; and over the motion itself, of points very near to each other [1].
   real(dp), parameter :: as_far = 1, as_near = 1e-6_dp

contains

   !> Finds the motion of every crossing of a branch with a frequency.
   subroutine friction_solutions_at(train, branch, frequency_ratio, motions, error)
      !> A checked train.
      type(train_type), intent(in) :: train
      !> Its branch.
      type(branch_type), intent(in) :: branch
      !> Lambda [1], or value of the parameter.
      real(dp), intent(in) :: frequency_ratio
      !> The motions in the order along the branch.
      type(motion_type), allocatable, intent(out) :: motions(:)
      !> Shooting finds no motion between two points.
      type(error_type), allocatable, intent(inout) :: error
      type(train_type) :: own
      type(parameter_path_type) :: path
      type(motion_type) :: guess, motion
      real(dp) :: at, share, apart
      integer :: i
      logical :: found, last

      allocate (motions(0))
      own = train
      at = frequency_ratio
      if (allocated(branch%parameter)) then
         call path%setup(train, branch%parameter, branch%constant_frequency, frequency_ratio, frequency_ratio, error)
         if (allocated(error)) return
         call path%train_at(frequency_ratio, own)
         at = branch%constant_frequency
      end if
      do i = 1, branch%points - 1
         if (branch%segment(i) /= branch%segment(i + 1)) cycle
         last = i + 1 == branch%points
         if (.not. last) last = branch%segment(i + 2) /= branch%segment(i + 1)
         associate (a => branch%frequency_ratio(i), b => branch%frequency_ratio(i + 1))
            ! The end of a piece is the beginning of the next one.
            if ((a - frequency_ratio)*(b - frequency_ratio) > 0 .or. abs(b - a) <= 0) cycle
            if (abs(b - frequency_ratio) <= 0 .and. .not. last) cycle
            share = (frequency_ratio - a)/(b - a)
         end associate
         guess = motion_type(frequency_ratio=at, period=branch%subharmonic)
         guess%coefficients = (1 - share)*coefficients_of(branch, i) + share*coefficients_of(branch, i + 1)
         guess%state = (1 - share)*branch%state(:, i) + share*branch%state(:, i + 1)
         apart = max(as_far*norm2(coefficients_of(branch, i + 1) - coefficients_of(branch, i)), as_near*norm2(guess%coefficients))
         motion = guess
         call solve_near(own, guess, motion, apart, found)
         if (.not. found) then
            call fatal(error, 'at: shooting finds no motion of the branch near '//trim(text(frequency_ratio))//'; begin a &
                              &response with a motion that &integration finds there', status_ended_early)
            return
         end if
         if (.not. allocated(branch%stable) .and. allocated(motion%multipliers)) deallocate (motion%multipliers)
         motions = [motions, motion]
      end do
   end subroutine friction_solutions_at

   !> Shoots from a guess, then from the motion that the flow from the guess settles on.
   subroutine solve_near(train, guess, motion, apart, found)
      type(train_type), intent(in) :: train
      type(motion_type), intent(in) :: guess
      type(motion_type), intent(inout) :: motion
      !> How far from the guess the motion may be [1].
      real(dp), intent(in) :: apart
      logical, intent(out) :: found
      type(error_type), allocatable :: error
      type(system_type), target :: system
      type(integration_settings_type) :: settings
      real(dp), allocatable :: state(:)
      integer :: attempt

      found = .false.
      call build_system(train, system)
      do attempt = 1, 2
         if (attempt == 2) then
            allocate (state(system%states))
            call state_of(system, guess, state)
            call settle(system, guess%frequency_ratio, settings, state, motion)
            if (motion%period < 1 .or. mod(guess%period, max(1, motion%period)) /= 0) return
            motion%period = guess%period
         end if
         call refine(train, motion, error, harmonics=(size(guess%coefficients, 1) - 1)/2/guess%period)
         if (allocated(error)) then
            motion = guess
            cycle
         end if
         found = norm2(motion%coefficients - guess%coefficients) <= apart
         if (found) return
         motion = guess
      end do
   end subroutine solve_near

end module geartrain_readings_friction_solutions
