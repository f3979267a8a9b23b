!> What a Python call does with a box: work on its branch and motions, derivatives; and the watch on long work.
module geartrain_python_work
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
   use, intrinsic :: iso_fortran_env, only: int64, real64
   use geartrain, only: audit_branch, branch_type, case_type, error_type, find_exact_point, frequency_gradient, integrate, &
                        interrupt_by, locate_contact_edges, motion_gradient, motion_type, name_parameter, observer_type, &
                        onsets_of, period_doubled, refine, refine_branch, refine_motions, refine_special_points, results_type, &
                        solutions_at, special_gradient, special_point_type
   use geartrain_analyses_forecast, only: forecast_type
   use geartrain_base_error, only: fatal, status_input
   use geartrain_curves_locus_trace, only: refusal_of
   use geartrain_exact_exact_point, only: branch_with_multipliers
   use geartrain_network_gradient, only: check_parameters
   use geartrain_network_long_period, only: describe_period, refuse_long_period
   use geartrain_python_box, only: box_type
   use geartrain_run_room, only: room_type
   implicit none (type, external)
   private
   public :: begin_watch, differentiate, watch_type, work

   !> Writes the progress where Python's waiting thread reads it, and stops when that thread asks for it.
   type, extends(observer_type) :: watch_type
      !> 1: Python sets it to stop the work; 2: points done; 3: Lambda of the latest point; 4: length of the latest forecast, whose
      !> characters follow as their codes.
      real(real64), pointer :: progress(:) => null()
      !> The case and the results under way; null: work that makes few.
      type(case_type), pointer :: case => null()
      type(results_type), pointer :: results => null()
      !> Whether there is memory for more results.
      type(room_type) :: room
      !> Whether it is this observer that ends the work where there is none.
      logical :: measures = .false.
      !> How long each analysis takes.
      type(forecast_type) :: forecast
   contains
      procedure :: on_step
   end type watch_type

contains

   !> Lets Python's waiting thread see the progress of work on the box's train, and end it: between two steps, and in their midst,
   !> since the first number, zero until then, is the flag of the train's interrupt.
   subroutine begin_watch(watch, box, progress)
      type(watch_type), intent(out) :: watch
      type(box_type), intent(inout) :: box
      real(real64), intent(in), target :: progress(:)
      integer(int64), pointer :: flag

      watch%progress => progress
      watch%forecast%in_python = .true.
      call c_f_pointer(c_loc(progress), flag)
      box%case%train%interrupt = interrupt_by(flag)
   end subroutine begin_watch

   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(watch_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(real64), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going

      real(real64), pointer, volatile :: progress(:)
      character(:), allocatable :: sentence
      integer :: i

      progress => self%progress
      if (associated(self%results)) then
         call self%forecast%look(analysis, done, frequency_ratio, self%case, self%results, sentence)
         do i = 1, min(len(sentence), size(progress) - 4)
            progress(4 + i) = iachar(sentence(i:i))
         end do
         if (sentence /= '') progress(4) = min(len(sentence), size(progress) - 4)
      end if
      if (analysis == 'modes') return
      ! The periods of the fundamental of a motion that settles are no points of the analysis.
      ! The random starts of basins are none of its rows.
      if (analysis /= 'settling' .and. analysis /= 'settling by time' .and. analysis /= 'random starts') progress(2) = done
      progress(3) = frequency_ratio
      if (progress(1) > 0) keep_going = .false.
      if (self%measures .and. keep_going) call self%room%look(analysis, self%case, self%results, keep_going)
   end subroutine on_step

   !> Work on the box's branch: 'at' (its solutions at exactly the Lambda values(1) become the box's motions), 'refine', 'double'
   !> (the branch of twice the period at special point values(1) takes its place), 'audit' (values(1) of its points, which values(2)
   !> draws, and all special points), 'exact' (its special point values(1), or with values(2) = 1 its contact onset of this number,
   !> becomes the box's exact point, and the motion of the exact point the box's motion); 'motions' and
   !> 'locus' (only an error where a search for all motions, or a curve, is refused); on the box's first motion, which the
   !> result takes the place of: 'integrate' (at the Lambda values(1), from the motion if there is one) and 'shoot' (refine it).
   subroutine work(box, what, values, watch, error)
      type(box_type), intent(inout), target :: box
      character(*), intent(in) :: what
      real(real64), intent(in) :: values(:)
      type(watch_type), intent(inout) :: watch
      type(error_type), allocatable, intent(out) :: error
      type(branch_type), allocatable :: doubled
      type(motion_type), pointer :: start
      type(motion_type) :: motion
      character(:), allocatable :: period, refusal
      integer :: cycles

      select case (what)
      case ('at')
         call solutions_at(box%case%train, box%case%response, box%results%response, values(1), box%motions, error)
         ! What there is then may not be solutions.
         if (box%case%train%interrupt%raised()) deallocate (box%motions)
         if (allocated(error) .or. .not. (allocated(box%results%response%correction) .and. allocated(box%motions))) return
         call refine_motions(box%case%train, box%results%response, values(1), box%motions, error)
      case ('motions')
         call refuse_long_period(box%case%train, 'motions: shoots over whole periods', 'use integrate', .false., error)
      case ('locus')
         call describe_period(box%case%train, 1, cycles, period)
         call refusal_of(cycles, period, 'special point', refusal)
         if (refusal /= '') call fatal(error, 'locus: '//refusal, status_input)
      case ('refine')
         call refuse_long_period(box%case%train, 'refine: shoots over whole periods', 'take '//branch_with_multipliers, &
                                 box%results%response%states > 0, error)
         if (allocated(error)) return
         call refine_branch(box%case%train, box%results%response, error, watch)
         if (allocated(error) .or. box%results%response%cancelled) return
         call refine_special_points(box%case%train, box%results%response, watch)
      case ('double')
         allocate (doubled)
         call period_doubled(box%case%train, box%case%response, box%results%response, nint(values(1)), doubled, error, watch)
         call name_parameter(box%case%train, doubled)
         call move_alloc(doubled, box%results%response)
      case ('audit')
         allocate (box%audit)
         call audit_branch(box%case%train, box%results%response, nint(values(1)), nint(values(2)), box%audit, error, watch)
      case ('exact')
         call make_exact(box, nint(values(1)), values(2) > 0, error)
      case ('integrate')
         nullify (start)
         if (allocated(box%motions)) start => box%motions(1)
         call integrate(box%case%train, values(1), box%case%integration, motion, error, start, watch)
         if (.not. allocated(error)) box%motions = [motion]
      case ('shoot')
         call refuse_long_period(box%case%train, 'refine: shoots over a whole period', &
                                 'take a motion of '//branch_with_multipliers, allocated(box%motions(1)%multipliers), error)
         if (allocated(error)) return
         call refine(box%case%train, box%motions(1), error)
      end select
   end subroutine work

   !> Finds special point or contact onset `number` of the box's branch on the exact branch.
   subroutine make_exact(box, number, onset, error)
      type(box_type), intent(inout) :: box
      integer, intent(in) :: number
      logical, intent(in) :: onset
      type(error_type), allocatable, intent(out) :: error
      type(special_point_type), allocatable :: onsets(:)

      associate (branch => box%results%response)
         if (onset) then
            if (.not. allocated(branch%contact_edges)) call locate_contact_edges(box%case%train, box%case%response, branch)
            call onsets_of(branch, onsets)
            call find_exact_point(box%case%train, branch, 0, onsets(number), box%exact, error)
         else
            call find_exact_point(box%case%train, branch, number, branch%special_points(number), box%exact, error)
         end if
      end associate
      if (.not. allocated(error)) box%motions = [box%exact%motion]
   end subroutine make_exact

   !> Differentiates with respect to parameters, whose names are parted by line feeds: '/parameters', nothing, the names are checked
   !> alone; '/frequency', the natural frequencies; '/special', Lambda of special point `number` of the box's branch; else a figure
   !> of the motion of period `number` at Lambda = `frequency` that has the coefficients.
   subroutine differentiate(box, what, text, number, frequency, coefficients, error)
      type(box_type), intent(inout) :: box
      character(*), intent(in) :: what, text
      integer, intent(in) :: number
      real(real64), intent(in) :: frequency, coefficients(:, :)
      type(error_type), allocatable, intent(out) :: error
      type(motion_type) :: motion
      character(len(text)), allocatable :: names(:)
      integer :: at, first

      allocate (names(0))
      first = 1
      do while (first <= len(text))
         at = index(text(first:)//new_line('a'), new_line('a'))
         names = [character(len(text)) :: names, text(first:first + at - 2)]
         first = first + at
      end do
      select case (what)
      case ('/parameters')
         call check_parameters(box%case%train, names, error)
      case ('/frequency')
         call frequency_gradient(box%case%train, names, box%gradient, error)
      case ('/special')
         call special_gradient(box%case%train, box%results%response, number, names, box%gradient, error)
      case default
         motion%period = number
         motion%frequency_ratio = frequency
         motion%coefficients = coefficients
         call motion_gradient(box%case%train, motion, what, names, box%gradient, error)
      end select
   end subroutine differentiate

end module geartrain_python_work
