!> The fields of a branch: the groups /response, /branch_1, ..., with the special points and, while the response is under way, with
!> the state of the trace.
module geartrain_continuation_fields
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_continuation_branch, only: branch_type, special_point_type, visit_points
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_decided, only: rests_on_undecided
   use geartrain_continuation_free_fields, only: carry_free, free_name
   use geartrain_flow_fields, only: about_rms, on_stability
   implicit none (type, external)
   private
   public :: visit_branch

contains

   !> Visits the group of a branch and the groups in it.
   subroutine visit_branch(branch, home, fields)
      !> The branch, which may be under way; set by reading.
      type(branch_type), intent(inout) :: branch
      !> Path of the group.
      character(*), intent(in) :: home
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields

      if (.not. fields%enter(home, 'frequency response: periodic motions along one branch, through its folds', .true.)) return
      if (allocated(branch%frequency_ratio)) call fields%describe('coordinates', trim(free_name(branch)))
      call carry_text(fields, row('origin', '', '', 'where it comes from, in words', 'further branches', optional=.true.), &
                      branch%origin)
      call carry_text(fields, row('ended', '', '', 'why the branch ended, in words'), branch%ended, &
                      'not yet: these are the points so far')
      call carry_text(fields, row('parameter_name', '', '', 'name of the parameter of the train that it goes over', &
                                  'with `parameter`', optional=.true.), branch%parameter)
      call carry_text(fields, row('parameter_unit', '', '', 'unit of the parameter; 1 of a dimensionless one', &
                                  'with `parameter`', optional=.true.), branch%parameter_unit)
      call carry(fields, row('complete', '', '', '1: it got to the other end of the range; or, traced from both ends, it left the &
                             &range each time'), branch%complete)
      call carry(fields, row('closed', '', '', '1: followed back to where it began, as an island: the last point is the first &
                             &one'), branch%closed)
      call carry(fields, row('harmonics', '', '', 'harmonics in use; where the program chose them, the most that any point has', &
                             least=0), branch%harmonics)
      call carry(fields, row('subharmonic', '', '', 'period in periods of the fundamental', least=1), branch%subharmonic)
      call visit_points(branch, fields)
      call visit_special_points(branch, home//'/special_points', fields)
      call visit_trace(branch, home//'/trace', fields)
   end subroutine visit_branch

   subroutine visit_special_points(branch, home, fields)
      type(branch_type), intent(inout) :: branch
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields
      type(special_point_type), allocatable :: list(:)
      logical :: undecided
      integer :: i, n

      n = 0
      if (allocated(branch%special_points)) n = size(branch%special_points)
      if (fields%way == reading) allocate (list(0))
      if (fields%enter(home, 'places on the branch that a reader looks for', n > 0)) then
         call fields%describe('coordinates', trim(free_name(branch))//' kind')
         call fields%index_axis('special_point', n, 'special point, in the order found')
         if (allocated(list)) deallocate (list)
         allocate (list(merge(1, n, fields%way == listing)))
         if (n > 0 .and. fields%way /= reading) list = branch%special_points
         call fields%begin_list('special_point')
         do i = 1, size(list)
            call fields%visit_item(i)
            call visit_special_point(list(i), branch, fields)
            call visit_correction(list(i), any(list%correction > -2), any(list%correction <= -2), fields)
            if (fields%way == reading) cycle
            undecided = .false.
            if (allocated(branch%undecided) .and. fields%way /= listing) undecided = rests_on_undecided(branch, i)
            if (fields%has('undecided', allocated(branch%undecided))) &
               call carry(fields, row('undecided', '', '1', '1 = it rests on undecided points: on one side of it the next points &
                                      &(five at most, none beyond another special point) are all undecided, in the number of &
                                      &multipliers outside the unit circle where it is no fold', on_stability), undecided)
         end do
         call fields%end_list()
      end if
      if (fields%way == reading) call move_alloc(list, branch%special_points)
   end subroutine visit_special_points

   !> Visits what refinement has done to a special point.
   subroutine visit_correction(special, begun, in_part, fields)
      type(special_point_type), intent(inout) :: special
      !> Whether refinement has tried any special point of the branch, and whether it has not tried all.
      logical, intent(in) :: begun, in_part
      class(fields_type), intent(inout) :: fields
      logical :: untried

      if (.not. fields%has('correction', begun)) return
      call carry(fields, row('correction', '', '1', 'change of Lambda by refinement, which is the error that it had; NaN: shooting &
                             &finds no special point of this kind near it, it is that of the balance', 'with `refine`', &
                             none_is_negative=.true.), special%correction)
      untried = special%correction < -1
      if (.not. fields%has('untried', in_part)) return
      call carry(fields, row('untried', '', '1', '1 = refinement has not come to it', 'of a branch refined in part'), untried)
      if (fields%way == reading .and. untried) special%correction = -2
   end subroutine visit_correction

   subroutine visit_special_point(special, branch, fields)
      type(special_point_type), intent(inout) :: special
      type(branch_type), intent(in) :: branch
      class(fields_type), intent(inout) :: fields

      call carry(fields, row('kind', '', '', 'fold; period doubling; neimark-sacker: a pair of multipliers leaves the unit circle; &
                             &branch point: another branch of the same period crosses, a multiplier passes +1 without a fold; &
                             &stability change: of a motion of long period, whose multipliers are not computed, the growth rate &
                             &passes 0'), &
                 special%kind)
      if (special%kind == 'torus') special%kind = 'neimark-sacker'
      call carry_free(branch, fields, special%frequency_ratio)
      call carry(fields, row('after_point', '', '1', 'the point of the branch before it', least=0, &
                             most=branch%points), special%point)
      call carry(fields, row('rms', 'mesh', '1', about_rms), special%rms)
      call carry(fields, row('multiplicity', '', '1', 'multipliers, or pairs, that pass the unit circle together: N - 1 where &
                             &N equal branches begin to move differently', optional=.true., least=1), special%multiplicity)
   end subroutine visit_special_point

   !> Visits the state of a trace, see trace_state_type.
   subroutine visit_trace(branch, home, fields)
      type(branch_type), intent(inout) :: branch
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields

      if (fields%way == listing) return
      if (.not. fields%enter(home, 'what the next step of a trace under way depends on', allocated(branch%trace))) return
      if (.not. allocated(branch%trace)) allocate (branch%trace)
      associate (trace => branch%trace)
         call carry(fields, row('from_stop'), trace%from_stop)
         call carry(fields, row('whole'), trace%whole)
         call carry(fields, row('first_points', least=0, most=branch%points), trace%first_points)
         call carry(fields, row('steps', least=0), trace%steps)
         call carry(fields, row('harmonics', least=merge(1, 0, trace%steps > 0)), trace%harmonics)
         call carry(fields, row('step'), trace%step)
         call carry(fields, row('curvature'), trace%curvature)
         call carry(fields, row('missed', least=0), trace%missed)
         call carry(fields, row('sense'), trace%sense)
         call carry_text(fields, row('before', optional=.true.), trace%before)
         if (trace%steps == 0) return
         call fields%check(trace%step > 0, 'step')
         call visit_solution(trace%here, home//'/here', trace%harmonics, branch, fields)
         call visit_solution(trace%earlier, home//'/earlier', branch%harmonics, branch, fields)
         call visit_solution(trace%origin, home//'/origin', trace%harmonics, branch, fields)
      end associate
   end subroutine visit_trace

   !> Visits a solution point of a branch under way, with harmonics up to `highest`.
   subroutine visit_solution(solution, home, highest, branch, fields)
      type(solution_point_type), intent(inout) :: solution
      character(*), intent(in) :: home
      integer, intent(in) :: highest
      type(branch_type), intent(in) :: branch
      class(fields_type), intent(inout) :: fields
      integer :: harmonics, terms, unknowns

      if (.not. fields%enter(home, 'a place on the branch', .true.)) then
         call fields%check(.false., home)
         return
      end if
      harmonics = 0
      terms = 0
      unknowns = 0
      if (allocated(solution%harmonic)) harmonics = size(solution%harmonic)
      if (allocated(solution%u)) terms = size(solution%u, 1)
      if (allocated(solution%u)) unknowns = size(solution%u, 2)
      call fields%index_axis('unknown', unknowns, 'mesh whose displacement is an unknown')
      call fields%index_axis('term', terms, 'mean, cosines and sines')
      call fields%index_axis('number', harmonics, 'harmonic that is carried')
      call carry(fields, row('harmonic', 'number', least=1, most=highest), solution%harmonic)
      call carry(fields, row('displacement', 'unknown term'), solution%u)
      call carry(fields, row('tangent', 'unknown term'), solution%tangent)
      call carry(fields, row('frequency'), solution%frequency_ratio)
      call carry(fields, row('tangent_frequency'), solution%tangent_frequency)
      call carry(fields, row('orientation'), solution%orientation)
      call carry(fields, row('differences'), solution%differences)
      call fields%check((allocated(branch%parameter) .or. solution%frequency_ratio > 0) .and. terms == 1 + 2*harmonics .and. &
                        unknowns <= branch%meshes, 'term')
   end subroutine visit_solution

end module geartrain_continuation_fields
