!> Where a branch begins: a tracer for a train, and solution points to start it from.
module geartrain_trace_start
   use geartrain_balance_chosen_harmonics, only: first_harmonics
   use geartrain_balance_tail_harmonics, only: resonance_ratio
   use geartrain_balance_harmonic_set, only: first_set, has_sparse_motions
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_points, only: repeats_of
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_trace_response_variables, only: settings_for
   use geartrain_network_units, only: largest_unit, length_unit_of, units_of
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_network_equal_branches, only: equal_branches_type, find_equal_branches, same_branches
   use geartrain_network_natural_modes, only: natural_frequency_ranges
   use geartrain_network_planet_symmetry, only: find_symmetries
   use geartrain_network_system, only: build_system, put_speed, system_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: add_harmonics, begin_trace, doubled_settings, motion_at, resting, solution_of

   !> Amplitude limits where the settings give none, rms in the unit of motions that cross the gap [1]: with backlash; and of a
   !> linear train, whose branch is merely not recorded near a multiplier +1, where its amplitude is infinite.
   real(dp), parameter :: default_amplitude_limit = 12, linear_amplitude_limit = 1e4_dp
   !> Least amplitude of a harmonic that `add_harmonics` carries, over the tolerance and the amplitude of the motion [1].
   real(dp), parameter :: least_share = 0.01_dp
   !> Most harmonics that it adds, times the number of unknown meshes: a chaotic motion has thousands, and is no start.
   integer, parameter :: most_added = 1500

contains

   !> Prepares a tracer: system, units, amplitude limit, first number of harmonics.
   subroutine begin_trace(train, settings, systems, tracer, branch, motion)
      !> A checked train.
      type(train_type), intent(in) :: train
      !> Settings to trace with.
      type(response_settings_type), intent(in) :: settings
      !> Room for the systems of the tracer: of the train, amid the path on a branch over a parameter, and the one that moves there.
      type(system_type), pointer, intent(in) :: systems(:)
      !> Becomes ready to solve, its settings in Lambda; its recorder is set up separately.
      type(tracer_type), intent(inout) :: tracer
      !> A branch that the tracer is to work on: its motions repeat themselves as often.
      type(branch_type), intent(in), optional :: branch
      !> Likewise a motion.
      type(motion_type), intent(in), optional :: motion
      type(error_type), allocatable :: checked
      type(system_type) :: at_end
      integer, allocatable :: set(:)
      real(dp) :: largest
      logical :: gaps
      integer :: i

      tracer%system => systems(1)
      tracer%moving => systems(2)
      tracer%settings = settings
      tracer%settings%unit = 'Lambda'
      associate (factor => lambda_per(train, settings%unit), own => tracer%settings, units => tracer%corrector%units, &
                 system => tracer%system, balance => tracer%corrector%balance)
         if (settings%parameter == '') then
            own%start = settings%start*factor
            own%stop = settings%stop*factor
            call build_system(train, system)
            units = units_of(system)
            largest = largest_unit(system)
            gaps = any(system%half_backlash > 0)
         else
            own%frequency = settings%frequency*factor
            allocate (balance%path)
            ! Errors were told by check_response.
            call balance%path%setup(train, settings%parameter, own%frequency, own%start, own%stop, checked)
            ! Amid the path no excitation is 0, unlike at its ends: this system tells which harmonics to carry.
            call balance%path%system_at(balance%path%amid, system)
            units = units_of(system)
            largest = largest_unit(system)
            gaps = any(system%half_backlash > 0)
            do i = 1, 2
               call balance%path%system_at(merge(own%start, own%stop, i == 1), at_end)
               units%length = max(units%length, length_unit_of(at_end))
               largest = max(largest, largest_unit(at_end))
            end do
            units%frequency_ratio = balance%path%length
         end if
      end associate
      call find_sets()
      call choose_repeats()
      if (settings%amplitude_limit > 0) then
         tracer%amplitude_limit = settings%amplitude_limit
      else if (gaps) then
         tracer%amplitude_limit = default_amplitude_limit*largest
      else
         tracer%amplitude_limit = linear_amplitude_limit*largest
      end if
      tracer%estimate%resonance = natural_frequency_ranges(tracer%system, resonance_ratio)
      tracer%chooses_sets = settings%harmonics == 0 .and. has_sparse_motions(tracer%system, settings%subharmonic, &
                                                                          tracer%settings%repeats)
      if (tracer%chooses_sets) then
         set = first_set(tracer%system)
         call tracer%prepare(set(size(set)), set)
      else
         call tracer%prepare(merge(settings%harmonics, first_harmonics(tracer%system, settings%subharmonic, &
                                                                       tracer%settings%repeats), settings%harmonics > 0))
      end if

   contains

      !> Finds the equal branches. Along a path they are those that are equal at both ends and amid the path.
      subroutine find_sets()
         type(equal_branches_type), allocatable :: other(:)
         integer :: k

         associate (balance => tracer%corrector%balance)
            call find_equal_branches(tracer%system, tracer%corrector%sets)
            if (.not. allocated(balance%path)) then
               call find_symmetries(train, tracer%system, tracer%corrector%symmetries)
               return
            end if
            do k = 1, 2
               if (size(tracer%corrector%sets) == 0) return
               call balance%path%system_at(merge(balance%path%low, balance%path%high, k == 1), at_end)
               call find_equal_branches(at_end, other)
               if (.not. same_branches(tracer%corrector%sets, other)) deallocate (tracer%corrector%sets)
               if (.not. allocated(tracer%corrector%sets)) allocate (tracer%corrector%sets(0))
            end do
         end associate
      end subroutine find_sets

      subroutine choose_repeats()
         associate (repeats => tracer%settings%repeats, system => tracer%system)
            if (repeats > 0) return
            repeats = merge(system%excitation_order, 1, settings%subharmonic == 1)
            if (present(motion) .and. repeats > 1) repeats = repetitions_of(system, motion)
            if (present(branch)) repeats = repeats_of(branch, system)
         end associate
      end subroutine choose_repeats
   end subroutine begin_trace

   !> Settings for the branch that leaves a branch at a period doubling: of motions that go half as often through their waveform
   !> within the period or, where this is no whole number, of twice the period.
   function doubled_settings(train, settings, branch) result(doubled)
      !> A checked train.
      type(train_type), intent(in) :: train
      !> Settings of the branch.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(in) :: branch
      type(response_settings_type) :: doubled
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer

      if (branch%subharmonic == 1 .and. branch%points > 0) then
         call begin_trace(train, settings, systems, tracer, branch)
         doubled = settings
         doubled%repeats = tracer%settings%repeats/2
         if (2*doubled%repeats == tracer%settings%repeats) return
      end if
      doubled = settings_for(settings, 2*branch%subharmonic)
   end function doubled_settings

   !> A solution point as a motion, with the coefficients of all meshes.
   function motion_at(tracer, solution) result(motion)
      !> Tracer whose balance was evaluated last at `solution`.
      type(tracer_type), intent(in) :: tracer
      !> The solution point.
      type(solution_point_type), intent(in) :: solution
      type(motion_type) :: motion
      real(dp) :: coefficients(tracer%corrector%balance%block, tracer%system%meshes)
      integer :: k

      associate (balance => tracer%corrector%balance)
         call balance%full_coefficients(solution%u, coefficients)
         motion%frequency_ratio = solution%frequency_ratio
         motion%period = tracer%settings%subharmonic
         allocate (motion%coefficients(1 + 2*balance%highest, tracer%system%meshes), source=0.0_dp)
         motion%coefficients(1, :) = coefficients(1, :)
         do k = 1, size(balance%harmonic)
            associate (r => balance%harmonic(k))
               motion%coefficients(2*r:2*r + 1, :) = coefficients(2*k:2*k + 1, :)
            end associate
         end do
      end associate
   end function motion_at

   !> The train at rest under its mean load as a first guess of a solution point: every mesh on the flank that bears its load.
   function resting(tracer, frequency_ratio) result(solution)
      !> Tracer after `begin_trace`.
      type(tracer_type), intent(in) :: tracer
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      type(solution_point_type) :: solution
      integer :: i

      associate (balance => tracer%corrector%balance, system => tracer%system)
         if (.not. allocated(balance%path)) call put_speed(system, frequency_ratio)
         allocate (solution%u(balance%block, balance%unknowns), source=0.0_dp)
         solution%frequency_ratio = frequency_ratio
         do i = 1, balance%unknowns
            associate (j => balance%mesh(i))
               solution%u(1, i) = system%law(j)%rest(system%static_force(system%mesh_element(j)))
            end associate
         end do
      end associate
   end function resting

   !> A motion as a first guess of a solution point, on the carried harmonics of the balance.
   function solution_of(tracer, motion) result(solution)
      !> Tracer after `begin_trace`.
      type(tracer_type), intent(in) :: tracer
      !> Motion with coefficients, whose period divides the sub-harmonic index.
      type(motion_type), intent(in) :: motion
      type(solution_point_type) :: solution
      integer :: i, k, r, ratio

      associate (balance => tracer%corrector%balance)
         allocate (solution%u(balance%block, balance%unknowns), source=0.0_dp)
         solution%frequency_ratio = motion%frequency_ratio
         ratio = tracer%settings%subharmonic/motion%period
         do i = 1, balance%unknowns
            solution%u(1, i) = motion%coefficients(1, balance%mesh(i))
            do k = 1, size(balance%harmonic)
               r = balance%harmonic(k)/ratio
               if (r*ratio /= balance%harmonic(k) .or. 2*r + 1 > size(motion%coefficients, 1)) cycle
               solution%u(2*k:2*k + 1, i) = motion%coefficients(2*r:2*r + 1, balance%mesh(i))
            end do
         end do
      end associate
   end function solution_of

   !> Makes the balance carry, besides its set of harmonics, those that matter in a motion to begin from.
   subroutine add_harmonics(tracer, motion)
      !> Tracer after `begin_trace` that chooses sets.
      type(tracer_type), intent(inout) :: tracer
      !> Motion with coefficients, whose period divides the sub-harmonic index.
      type(motion_type), intent(in) :: motion
      logical, allocatable :: carried(:)
      real(dp), allocatable :: amplitude(:)
      real(dp) :: least
      integer :: k, highest, ratio

      highest = (size(motion%coefficients, 1) - 1)/2
      ratio = tracer%settings%subharmonic/motion%period
      least = least_share*tracer%settings%tolerance*sqrt(sum(motion%coefficients(2:, :)**2))
      associate (set => tracer%corrector%balance%harmonic)
         allocate (carried(max(ratio*highest, set(size(set)))), source=.false.)
         carried(set) = .true.
      end associate
      amplitude = [(norm2(motion%coefficients(2*k:2*k + 1, :)), k=1, highest)]
      do while (count(amplitude > least)*tracer%corrector%balance%unknowns > most_added)
         least = 2*least
      end do
      where (amplitude > least) carried(ratio:ratio*highest:ratio) = .true.
      call tracer%prepare(findloc(carried, .true., 1, back=.true.), pack([(k, k=1, size(carried))], carried))
   end subroutine add_harmonics

end module geartrain_trace_start
