!> What a Python call carries over the border: a case and motions in, results out, and the watch on long work.
module geartrain_python_box
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_null_ptr
   use, intrinsic :: iso_fortran_env, only: int64, real64
   use geartrain, only: audit_text, audit_type, band_type, back_collision_ranges, bands_without_stability, branch_type, &
                        case_text, case_type, error_type, interrupt_by, jump_type, jumps, locate_contact_edges, &
                        mesh_load_type, motion_type, observer_type, &
                        peak_type, peaks, results_type, separation_ranges, version
   implicit none (type, external)
   private
   public :: box_type, watch_type, begin_watch, handle_of, box_of, box_text, branch_at, close_with, motion_list
   public :: loose, of_integration, of_attractors, summarize, as_values, as_loads

   !> Which motions of a box: those on their own, of the sweep, of the search for attractors.
   integer, parameter :: loose = 0, of_integration = 1, of_attractors = 2

   !> One call's data; Python knows it by a handle and frees it before the call returns.
   type :: box_type
      type(case_type) :: case
      !> What was computed, or what is to be written; `results%response` is also the branch of `solve_at`.
      type(results_type) :: results
      !> Motions in (seed, start, the motion to refine) or out (solutions at a frequency).
      type(motion_type), allocatable :: motions(:)
      !> The audit of the branch.
      type(audit_type), allocatable :: audit
      !> What was last read off the branch, see `summarize`, (column, row).
      real(real64), allocatable :: table(:, :)
      !> Message of the last error.
      character(:), allocatable :: message
   end type box_type

   !> Writes the progress where Python's waiting thread reads it, and stops when that thread asks for it.
   type, extends(observer_type) :: watch_type
      !> 1: Python sets it to stop the work; 2: points done; 3: Lambda of the latest point.
      real(real64), pointer :: progress(:) => null()
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
      call c_f_pointer(c_loc(progress), flag)
      box%case%train%interrupt = interrupt_by(flag)
   end subroutine begin_watch

   subroutine on_step(self, analysis, done, frequency, keep_going)
      class(watch_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(real64), intent(in) :: frequency
      logical, intent(inout) :: keep_going

      real(real64), pointer, volatile :: progress(:)

      progress => self%progress
      ! The mesh periods of a motion that settles are no points of the analysis.
      if (analysis /= 'settling') progress(2) = done
      progress(3) = frequency
      if (progress(1) > 0) keep_going = .false.
   end subroutine on_step

   !> The box as a number that Python can hold.
   integer(int64) function handle_of(box) result(handle)
      type(box_type), pointer, intent(in) :: box

      handle = transfer(c_loc(box), handle)
   end function handle_of

   !> The box of a handle.
   function box_of(handle) result(box)
      integer(int64), intent(in) :: handle
      type(box_type), pointer :: box

      call c_f_pointer(transfer(handle, c_null_ptr), box)
   end function box_of

   !> Exit status of `error`, 0 where there is none; its message stays in the box.
   integer function close_with(box, error) result(status)
      type(box_type), intent(inout) :: box
      type(error_type), allocatable, intent(in) :: error

      status = 0
      if (.not. allocated(error)) return
      status = error%status
      box%message = error%message
   end function close_with

   !> The motions of one kind that the box holds; null where none were computed.
   function motion_list(box, kind) result(motions)
      type(box_type), target, intent(in) :: box
      integer, intent(in) :: kind
      type(motion_type), pointer :: motions(:)

      nullify (motions)
      select case (kind)
      case (loose)
         if (allocated(box%motions)) motions => box%motions
      case (of_integration)
         if (.not. allocated(box%results%integration)) return
         if (allocated(box%results%integration%motions)) motions => box%results%integration%motions
      case (of_attractors)
         if (.not. allocated(box%results%attractors)) return
         if (allocated(box%results%attractors%motions)) motions => box%results%attractors%motions
      end select
   end function motion_list

   !> The response (place 0) or a further branch; null where there is none.
   function branch_at(box, place) result(branch)
      type(box_type), target, intent(in) :: box
      integer, intent(in) :: place
      type(branch_type), pointer :: branch

      nullify (branch)
      if (place == 0) then
         if (allocated(box%results%response)) branch => box%results%response
      else if (allocated(box%results%branches)) then
         if (place <= size(box%results%branches)) branch => box%results%branches(place)
      end if
   end function branch_at

   !> A text of the box by its name, see `text_size`; lists have one item a line.
   subroutine box_text(box, name, place, text)
      type(box_type), intent(in) :: box
      character(*), intent(in) :: name
      !> Which branch, see `branch_at`.
      integer, intent(in) :: place
      character(:), allocatable, intent(out) :: text
      type(branch_type), pointer :: branch
      type(motion_type), pointer :: motions(:)
      type(jump_type), allocatable :: found(:)
      integer :: i

      text = ''
      branch => branch_at(box, place)
      select case (name)
      case ('version')
         text = version
      case ('message')
         if (allocated(box%message)) text = box%message
      case ('case')
         call case_text(box%case, text)
      case ('elements')
         text = lines(box%results%modes%element)
      case ('kinds')
         motions => motion_list(box, place)
         text = lines(motions%kind)
      case ('directions')
         text = lines(box%results%integration%direction)
      case ('integration')
         if (allocated(box%results%integration%ended)) text = box%results%integration%ended
      case ('attractors')
         if (allocated(box%results%attractors%ended)) text = box%results%attractors%ended
      case ('map')
         if (allocated(box%results%stability_map%ended)) text = box%results%stability_map%ended
      case ('map name')
         text = box%results%stability_map%name
      case ('map unit')
         text = box%results%stability_map%unit
      case ('branch')
         if (allocated(branch%ended)) text = branch%ended
      case ('origin')
         if (allocated(branch%origin)) text = branch%origin
      case ('audit')
         call audit_text(box%audit, text)
      case ('audit kinds')
         text = lines(box%audit%rows%kind)
      case ('audit verdicts')
         text = lines(box%audit%rows%verdict)
      case ('exact verdicts')
         text = lines(box%audit%rows%exact_verdict)
      case ('findings')
         text = lines(box%audit%rows%finding)
      case ('jump kinds')
         found = jumps(branch)
         text = lines(found%kind)
      case ('jump causes')
         found = jumps(branch)
         text = lines(found%cause)
      case ('special points')
         text = lines([(branch%special_points(i)%kind, i=1, size(branch%special_points))])
      end select
   end subroutine box_text

   !> Reads a list off the box's branch into its table; the columns are
   !> 'peaks' (of a mesh): Lambda, rms, point, stable;
   !> 'jumps': Lambda, rising, then the rms before and after, mesh by mesh (after is negative where the jump leaves the
   !> branch), candidates;
   !> 'bands', 'separation', 'back collision' (the last two of a mesh, at any or at stable motions): from, to.
   subroutine summarize(box, what, mesh, stable_only)
      type(box_type), intent(inout) :: box
      character(*), intent(in) :: what
      integer, intent(in) :: mesh
      logical, intent(in) :: stable_only
      type(peak_type), allocatable :: at_peak(:)
      type(jump_type), allocatable :: at_jump(:)
      type(band_type), allocatable :: ranges(:)
      integer :: i, n

      if (allocated(box%table)) deallocate (box%table)
      associate (branch => box%results%response)
         select case (what)
         case ('peaks')
            at_peak = peaks(branch, mesh)
            n = size(at_peak)
            allocate (box%table(5, n))
            do i = 1, n
               box%table(:, i) = [at_peak(i)%frequency, at_peak(i)%rms, real(at_peak(i)%point, real64), &
                                  merge(1.0_real64, 0.0_real64, [at_peak(i)%stable, at_peak(i)%undecided])]
            end do
            return
         case ('jumps')
            at_jump = jumps(branch)
            n = size(at_jump)
            allocate (box%table(4 + 2*branch%meshes, n))
            do i = 1, n
               box%table(:, i) = [at_jump(i)%frequency, merge(1.0_real64, 0.0_real64, at_jump(i)%rising), &
                                  at_jump(i)%before, at_jump(i)%after, real(at_jump(i)%candidates, real64), &
                                  merge(1.0_real64, 0.0_real64, at_jump(i)%undecided)]
            end do
            return
         case ('bands')
            ranges = bands_without_stability(branch)
         case ('separation')
            call locate_contact_edges(box%case%train, box%case%response, branch)
            ranges = separation_ranges(branch, mesh, stable_only)
         case default
            call locate_contact_edges(box%case%train, box%case%response, branch)
            ranges = back_collision_ranges(branch, mesh, stable_only)
         end select
      end associate
      n = size(ranges)
      allocate (box%table(3, n))
      box%table(1, :) = ranges%from
      box%table(2, :) = ranges%to
      box%table(3, :) = merge(1.0_real64, 0.0_real64, ranges%undecided)
   end subroutine summarize

   !> Largest force, dynamic factor, shares of separation and of back contact, (mesh, 4).
   pure function as_values(loads) result(values)
      type(mesh_load_type), intent(in) :: loads(:)
      real(real64) :: values(size(loads), 4)

      values(:, 1) = loads%force_maximum
      values(:, 2) = loads%dynamic_factor
      values(:, 3) = loads%separation
      values(:, 4) = loads%back_contact
   end function as_values

   !> The inverse of `as_values`.
   pure function as_loads(values) result(loads)
      real(real64), intent(in) :: values(:, :)
      type(mesh_load_type) :: loads(size(values, 1))

      loads%force_maximum = values(:, 1)
      loads%dynamic_factor = values(:, 2)
      loads%separation = values(:, 3)
      loads%back_contact = values(:, 4)
   end function as_loads

   !> The items, one a line.
   pure function lines(items) result(text)
      character(*), intent(in) :: items(:)
      character(sum(len_trim(items)) + size(items)) :: text
      integer :: i, at

      at = 0
      do i = 1, size(items)
         text(at + 1:) = trim(items(i))//new_line('a')
         at = at + len_trim(items(i)) + 1
      end do
   end function lines

end module geartrain_python_box
