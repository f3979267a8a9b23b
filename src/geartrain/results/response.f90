!> The groups /response, /branch_1, ... of a results file: a branch, point by point.
module geartrain_results_response
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: branch_type
   use geartrain_branch_decided, only: rests_on_undecided
   use geartrain_results_labels, only: about_coefficients, about_doubtful, about_multipliers, about_rms, about_stable, &
      about_true_ac_rms, about_undecided, as_parts, coefficient_labels, frequency_description
   use geartrain_results_mesh_load, only: write_mesh_loads
   use geartrain_results_store, only: store_type
   use geartrain_results_summary, only: write_summary
   implicit none (type, external)
   private
   public :: write_response

   character(5), parameter :: by_mesh(2) = ['point', 'mesh ']

contains

   !> Writes the points 1:branch%points; the arrays may be longer, and `ended` may still be unknown.
   subroutine write_response(store, home, branch)
      type(store_type), intent(inout) :: store
      !> Path of the group.
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch

      call store%group(home)
      call write_attributes(store, home, branch)
      call store%axis(home//'/point', branch%points, 'point, in the order along the branch')
      call store%axis(home//'/mesh', branch%meshes, 'mesh, in the order of the train')
      if (branch%points > 0) then
         call write_points(store, home, branch, branch%points)
         if (allocated(branch%stable)) call write_stability(store, home, branch, branch%points)
         call write_summary(store, home, branch)
      end if
      if (.not. allocated(branch%special_points)) return
      if (size(branch%special_points) > 0) call write_special_points(store, home, branch)
   end subroutine write_response

   subroutine write_attributes(store, home, branch)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch

      call store%attribute(home, 'description', 'frequency response: periodic motions along one branch, through its folds')
      if (allocated(branch%origin)) call store%attribute(home, 'origin', branch%origin)
      if (branch%points > 0) call store%attribute(home, 'coordinates', 'frequency')
      if (allocated(branch%ended)) then
         call store%attribute(home, 'ended', branch%ended)
      else
         call store%attribute(home, 'ended', 'not yet: these are the points so far')
      end if
      call store%attribute(home, 'complete', merge(1, 0, branch%complete))
      call store%attribute(home, 'closed', merge(1, 0, branch%closed))
      call store%attribute(home, 'harmonics', branch%harmonics)
      call store%attribute(home, 'subharmonic', branch%subharmonic)
   end subroutine write_attributes

   subroutine write_points(store, home, branch, n)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: n

      call store%put(home//'/frequency', branch%frequency(:n), ['point'], '1', frequency_description)
      call store%put(home//'/rms', branch%rms(:, :n), by_mesh, '1', about_rms)
      call store%put(home//'/true_ac_rms', branch%rms(:, :n)/sqrt(2.0_dp), by_mesh, '1', about_true_ac_rms)
      call store%put(home//'/mean', branch%mean(:, :n), by_mesh, '1', 'mean mesh displacement / characteristic_length')
      call store%put(home//'/minimum', branch%minimum(:, :n), by_mesh, '1', &
                     'smallest mesh displacement over the period / characteristic_length')
      call store%put(home//'/maximum', branch%maximum(:, :n), by_mesh, '1', &
                     'largest mesh displacement over the period / characteristic_length')
      if (allocated(branch%mesh_load)) &
         call write_mesh_loads(store, home, 'point', branch%mesh_load(:, :n), spread(.true., 1, n))
      call store%axis(home//'/coefficient', coefficient_labels(size(branch%coefficients, 1)), &
                      'order of the coefficient in multiples of Lambda/subharmonic')
      call store%put(home//'/coefficients', branch%coefficients(:, :, :n), ['point      ', 'mesh       ', 'coefficient'], '1', &
                     about_coefficients)
      call store%put(home//'/error_estimate', branch%error_estimate(:n), ['point'], '1', &
                     'estimated relative error of the waveform')
      if (allocated(branch%correction)) &
         call store%put(home//'/correction', merge(ieee_value(0.0_dp, ieee_quiet_nan), branch%correction(:n), &
                                                   branch%correction(:n) < 0), ['point'], '1', 'relative change of the &
                        &waveform by refinement: the error that the point had; NaN: not refined, shooting finds no orbit near it')
      call store%put(home//'/estimate_doubtful', branch%estimate_doubtful(:n), ['point'], about_doubtful)
      call store%put(home//'/harmonics', branch%point_harmonics(:n), ['point'], '1', 'harmonics that the point was solved with')
      call store%put(home//'/part', branch%part(:n), ['point'], '1', &
                     'number of the part: a new one begins where the branch comes back from beyond the amplitude limit, or with &
                     &the points traced from the other end (to)')
   end subroutine write_points

   subroutine write_stability(store, home, branch, n)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: n

      call store%put(home//'/stable', branch%stable(:n), ['point'], about_stable)
      call store%put(home//'/undecided', branch%undecided(:n), ['point'], about_undecided)
      call store%put(home//'/count_undecided', branch%count_undecided(:n), ['point'], '1 = how many multipliers are outside the &
                     &unit circle is a guess: one is as near to it as it is uncertain')
      call store%put(home//'/second_estimate', merge(branch%second_estimate(:n), ieee_value(1.0_dp, ieee_quiet_nan), &
                                                     branch%second_estimate(:n) >= 0), ['point'], '1', &
                     'second estimate of the largest magnitude of a multiplier: of the motion corrected by its estimated error; &
                     &NaN where none was needed')
      call store%axis(home//'/state', branch%states, 'number of the multiplier, in no order that holds between points')
      call store%axis(home//'/complex', ['real     ', 'imaginary'], 'part of a complex number')
      call store%put(home//'/multipliers', as_parts(branch%multipliers(:, :n)), ['point  ', 'state  ', 'complex'], '1', &
                     about_multipliers)
   end subroutine write_stability

   subroutine write_special_points(store, home, branch)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home
      type(branch_type), intent(in) :: branch
      character(:), allocatable :: room
      real(dp) :: rms(branch%meshes, size(branch%special_points))
      integer :: i

      room = home//'/special_points'
      associate (special => branch%special_points)
         do i = 1, size(special)
            rms(:, i) = special(i)%rms
         end do
         call store%group(room)
         call store%attribute(room, 'description', 'places on the branch that a reader looks for')
         call store%attribute(room, 'coordinates', 'frequency kind')
         call store%axis(room//'/special_point', size(special), 'special point, in the order found')
         ! The parentheses make the copy that gathers a component explicit.
         call store%put(room//'/kind', (special%kind), ['special_point'], '', &
                        'fold; period doubling; torus: a pair of multipliers leaves the unit circle; branch point: &
                        &another branch of the same period crosses, a multiplier passes +1 without a fold')
         call store%put(room//'/frequency', (special%frequency), ['special_point'], '1', frequency_description)
         call store%put(room//'/after_point', (special%point), ['special_point'], '1', 'the point of the branch before it')
         call store%put(room//'/rms', rms, ['special_point', 'mesh         '], '1', about_rms)
         if (allocated(branch%undecided)) &
            call store%put(room//'/undecided', [(rests_on_undecided(branch, i), i=1, size(special))], ['special_point'], &
                           '1 = it rests on undecided points: on one side of it the next points are all undecided')
      end associate
   end subroutine write_special_points

end module geartrain_results_response
