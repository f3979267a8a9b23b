!> The fields of a branch: the groups /response, /branch_1, ..., with the special points and, while the response is under way, with
!> the state of the trace.
module geartrain_trace_branch_fields
   use geartrain_base_carry, only: carry, carry_text, carry_words
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_flow_motion_fields, only: on_stability
   use geartrain_trace_branch, only: branch_type, special_point_type, visit_points
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_decided, only: rests_on_undecided
   use geartrain_trace_free_fields, only: carry_free, free_name
   implicit none (type, external)
   private
   public :: visit_branch

   !> Largest number of harmonics, and period, that is read: arrays have its size before it is known whether a file has as many
   !> values. No branch comes near it.
   integer, parameter :: highest = 10000000

contains

   !> Visits the group of a branch and the groups in it.
   subroutine visit_branch(branch, home, fields)
      !> The branch, which may be under way; set by reading.
      type(branch_type), intent(inout) :: branch
      !> Path of the group.
      character(*), intent(in) :: home
      class(fields_type), intent(inout) :: fields

      if (.not. fields%enter(home, 'periodic motions along a branch, through its folds', .true.)) return
      if (allocated(branch%frequency_ratio)) call fields%describe('coordinates', trim(free_name(branch)))
      call carry_words(fields, row('origin', '', '', 'where the branch begins, in words', 'further branches', optional=.true.), &
                       branch%origin)
      call carry_words(fields, row('ended', '', '', 'why the branch ended, in words'), branch%ended, &
                       'not yet: these are the points so far')
      call carry_text(fields, row('parameter_name', '', '', 'name of the parameter that varies along the branch', &
                                  'with `parameter`', optional=.true.), branch%parameter)
      call carry_text(fields, row('parameter_unit', '', '', 'unit of the parameter; 1: dimensionless', &
                                  'with `parameter`', optional=.true.), branch%parameter_unit)
      call carry(fields, row('complete', '', '', '1 = the branch reached the other end of the range, or both branches traced from &
                             &the ends left the range'), branch%complete)
      call carry(fields, row('closed', '', '', '1 = the branch closes, as an island; its last point is its first'), branch%closed)
      call carry(fields, row('harmonics', '', '', 'number of harmonics; where the program chose them, the largest of all points', &
                             least=0, most=highest), branch%harmonics)
      call carry(fields, row('subharmonic', '', '', 'period of the motions in periods of the fundamental', least=1, &
                             most=highest), &
                             branch%subharmonic)
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
      if (fields%enter(home, 'folds and changes of stability on the branch', n > 0)) then
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
               call carry(fields, row('undecided', '', '1', '1 = the special point is a guess: on one side all of the next points, &
                                      &at most five, are undecided', on_stability), undecided)
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
      call carry(fields, row('correction', '', '1', 'change of Lambda by refinement, the error before it; NaN: shooting finds no &
                             &such point nearby', 'with `refine`', &
                             none_is_negative=.true.), special%correction)
      untried = special%correction < -1
      if (.not. fields%has('untried', in_part)) return
      call carry(fields, row('untried', '', '1', '1 = refinement has not reached the special point yet', &
                             'where refinement is not finished'), untried)
      if (fields%way == reading .and. untried) special%correction = -2
   end subroutine visit_correction

   subroutine visit_special_point(special, branch, fields)
      type(special_point_type), intent(inout) :: special
      type(branch_type), intent(in) :: branch
      class(fields_type), intent(inout) :: fields

      call carry(fields, row('kind', '', '', 'fold; period doubling; neimark-sacker: a complex pair of multipliers crosses the &
                             &unit circle; branch point: a multiplier passes +1 without a fold, another branch crosses; stability &
                             &change: the growth rate passes 0 (long periods, without multipliers)'), &
                 special%kind)
      if (special%kind == 'torus') special%kind = 'neimark-sacker'
      call carry_free(branch, fields, special%frequency_ratio)
      call carry(fields, row('after_point', '', '1', 'point of the branch before the special point', least=0, &
                             most=branch%points), special%point)
      call carry(fields, row('rms', 'mesh', '1', '`rms` of the branch at the special point'), special%rms)
      call carry(fields, row('multiplicity', '', '1', 'number of multipliers, or pairs, that cross the unit circle together; N - 1 &
                             &where N equal branches of the train begin to move differently', optional=.true., least=1), &
                             special%multiplicity)
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
         call carry(fields, row('harmonics', least=merge(1, 0, trace%steps > 0), most=highest), &
                    trace%harmonics)
         call carry(fields, row('step'), trace%step)
         call carry(fields, row('longest_step'), trace%longest)
         call carry(fields, row('curvature'), trace%curvature)
         call carry(fields, row('missed', least=0), trace%missed)
         call carry(fields, row('sense'), trace%sense)
         call carry(fields, row('refusals', least=0), trace%refusals)
         call carry_words(fields, row('before', optional=.true.), trace%before)
         if (trace%steps == 0) return
         call fields%check(min(trace%step, trace%longest) > 0, 'step')
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

end module geartrain_trace_branch_fields
