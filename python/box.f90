!> What a Python call carries over the border: a case and fields in, fields out.
module geartrain_python_box
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_null_ptr
   use, intrinsic :: iso_fortran_env, only: int64, real64
   use geartrain, only: audit_text, audit_type, case_text, case_type, error_type, exact_point_type, gradient_type, &
      locate_contact_edges, motion_type, onsets_of, results_type, special_point_type, status_input, version
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_exact_audit_fields, only: visit_audit
   use geartrain_analyses_dependencies, only: locate_edges
   use geartrain_analyses_list, only: find_analysis, number_of
   use geartrain_balance_planet_orbits, only: number_orbits
   use geartrain_base_error, only: fatal, status_memory
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: field_type, values_type
   use geartrain_base_fields, only: fields_type, reading
   use geartrain_base_kinds, only: dp
   use geartrain_base_memory, only: can_begin, need
   use geartrain_exact_exact_fields, only: visit_exact_point, visit_onsets
   use geartrain_readings_summary_fields, only: visit_bands, visit_jumps, visit_peaks, visit_ranges
   use geartrain_flow_motion_fields, only: visit_motions
   use geartrain_flow_simulator, only: simulator_type
   use geartrain_input_check_case, only: check_analyses
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_report_drawing_warnings, only: warnings_text
   use geartrain_report_explain, only: explain_train, explanation_text
   use geartrain_network_frequency_unit, only: hertz_per_lambda, speed_per_lambda
   use geartrain_network_load_sharing, only: planet_labels
   use geartrain_network_planet_symmetry, only: find_symmetries, symmetry_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_labels, only: body_labels, mesh_labels, shaft_labels
   use geartrain_network_parameter_path, only: give_variation
   use geartrain_train_train, only: train_type
   use geartrain_python_field_text, only: list_fields
   use geartrain_python_taker, only: taker_type
   use geartrain_run_reference, only: list_results
   use geartrain_report_case_report, only: report_text
   use geartrain_run_results, only: results_bytes, take_results, visit_results
   implicit none (type, external)
   private
   public :: ask, box_of, box_type, check_memory, close_with, field_at, get_text, handle_of, new_field, show, take

   !> One call's data; Python knows it by a handle.
   type :: box_type
      type(case_type) :: case
      !> What was computed, or what is to be written; `results%response` is also the branch of `solve_at`.
      type(results_type) :: results
      !> Motions in (seed, start, the motion to refine) or out (solutions at a frequency).
      type(motion_type), allocatable :: motions(:)
      !> The audit of the branch.
      type(audit_type), allocatable :: audit
      !> The special point that was made exact last.
      type(exact_point_type) :: exact
      !> The train under torques from outside.
      type(simulator_type), allocatable :: simulator
      !> What was differentiated last.
      type(gradient_type) :: gradient
      !> Fields on their way: shown by the box, or put into it.
      type(fields_type) :: fields
      !> A field put into the box found no memory.
      logical :: lacks_memory = .false.
      !> Message of the last error.
      character(:), allocatable :: message
      !> A text on its way out, see `text_size`.
      character(:), allocatable :: text
   end type box_type

contains

   !> Makes the case ask for the analyses whose variables were put into groups of their names. The response may have a seed.
   subroutine ask(box, error)
      type(box_type), intent(inout), target :: box
      type(error_type), allocatable, intent(out) :: error
      class(analysis_type), allocatable :: analysis
      type(fields_type) :: none
      type(taker_type) :: taker
      integer :: i

      do i = 1, box%fields%count
         taker%given = box%fields%groups(i)
         call find_analysis(number_of(taker%given%path), box%case, box%results, analysis, ask=.true.)
         call analysis%visit_variables(taker)
      end do
      box%fields = none
      call check_analyses(box%case, .true., taker)
      call taker%problems%raise('', error)
   end subroutine ask

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

   !> Makes it an error if there is no memory to begin work with: OpenBLAS would ask for ever for its buffers. To be called by the
   !> thread that works, since a new thread takes memory of its own.
   subroutine check_memory(error)
      type(error_type), allocatable, intent(out) :: error

      if (.not. can_begin()) call fatal(error, 'there is not enough memory to begin with, 160 MB: is there a limit (ulimit -v)?', &
                                        status_memory)
   end subroutine check_memory

   !> Exit status of `error`, 0 where there is none; its message stays in the box.
   integer function close_with(box, error) result(status)
      type(box_type), intent(inout) :: box
      type(error_type), allocatable, intent(in) :: error

      status = 0
      if (.not. allocated(error)) return
      status = error%status
      box%message = error%message
   end function close_with

   !> A text of the box by its name, see `text_size`.
   subroutine get_text(box, name, text)
      type(box_type), intent(inout), target :: box
      character(*), intent(in) :: name
      character(:), allocatable, intent(out) :: text
      type(case_type) :: case

      text = ''
      select case (name)
      case ('version')
         text = version
      case ('message')
         if (allocated(box%message)) text = box%message
      case ('case')
         call case_text(box%case, text)
      case ('case with variation')
         case = box%case
         call give_variation(case%train)
         call case_text(case, text)
      case ('explanation')
         call explanation_text(box%case%train, text)
      case ('warnings')
         call warnings_text(box%case%train, text)
      case ('audit')
         call audit_text(box%audit, box%case%train, box%case%response%unit, text)
      case ('report', 'verbose report')
         call locate_edges(box%case, box%results)
         call report_text(box%case, box%results, name == 'verbose report', text)
      case ('fields')
         call list_fields(box%fields, text)
      end select
   end subroutine get_text

   !> Makes fields of what the box holds, see `show_fields`.
   subroutine show(box, what, error)
      type(box_type), intent(inout) :: box
      character(*), intent(in) :: what
      type(error_type), allocatable, intent(out) :: error
      type(fields_type) :: none
      type(special_point_type), allocatable :: onsets(:)
      logical, allocatable :: assessed(:)
      integer, allocatable :: orbit(:)
      integer :: n

      box%fields = none
      associate (fields => box%fields, branch => box%results%response)
         select case (what)
         case ('results')
            ! The fields, Python's arrays of them, and one on its way.
            if (.not. is_small(box%results)) &
               call need(3.0_real64*results_bytes(box%results, box%case), 'no memory for the results', 'compute fewer', error)
            if (allocated(error)) return
            call visit_results(box%results, box%case, fields, summary=.false.)
         case ('listing')
            call list_results(fields)
         case ('explanation')
            call explain_train(box%case%train, fields)
         case ('train')
            call show_train(box%case%train, fields)
         case ('motions')
            if (.not. allocated(box%motions)) return
            if (.not. fields%enter('/motions', '', .true.)) return
            n = size(box%motions)
            call fields%expect('mesh', size(box%case%train%meshes))
            call fields%index_axis('motion', n, '')
            call visit_motions(box%motions, 'motion', fields)
            assessed = box%motions%assessed
            call carry(fields, field_type('assessed', 'motion'), assessed)
            assessed = box%motions%assessed .and. box%motions%stable
            call carry(fields, field_type('assessed_stable', 'motion'), assessed)
            assessed = box%motions%assessed .and. box%motions%undecided
            call carry(fields, field_type('assessed_undecided', 'motion'), assessed)
         case ('orbits')
            if (.not. allocated(box%motions)) return
            if (.not. fields%enter('/orbits', '', .true.)) return
            n = size(box%motions)
            allocate (orbit(n))
            call number_orbits(box%case%train, box%motions, orbit)
            call fields%index_axis('motion', n, '')
            call carry(fields, field_type('orbit', 'motion'), orbit)
         case ('symmetries')
            call show_symmetries(box%case%train, fields)
         case ('audit')
            call visit_audit(box%audit, fields)
         case ('gradient')
            if (.not. fields%enter('/gradient', '', .true.)) return
            n = size(box%gradient%values, 1)
            call fields%index_axis('item', n, '')
            n = size(box%gradient%reason)
            call fields%index_axis('parameter', n, '')
            call carry(fields, field_type('value', 'parameter item'), box%gradient%values)
            call carry(fields, field_type('reason', 'parameter'), box%gradient%reason)
         case ('exact')
            call visit_exact_point(box%exact, fields)
         case ('onsets')
            call locate_contact_edges(box%case%train, box%case%response, branch)
            call onsets_of(branch, onsets)
            call visit_onsets(branch, onsets, fields)
         case ('peaks')
            call visit_peaks(branch, '', fields)
         case ('jumps')
            call visit_jumps(branch, '', fields)
         case ('bands')
            call visit_bands(branch, '', fields)
         case default
            call locate_contact_edges(box%case%train, box%case%response, branch)
            call visit_ranges(branch, '', what == 'back collision', fields)
         end select
      end associate
   end subroutine show

   !> Whether the results are one branch that is small beside the memory that is kept free: to measure it would take as long as to
   !> show it.
   pure logical function is_small(results)
      type(results_type), intent(in) :: results
      integer, parameter :: few = 100000

      associate (r => results)
         is_small = allocated(r%response) .and. .not. &
                    (allocated(r%branches) .or. allocated(r%modes) .or. allocated(r%integration) .or. allocated(r%attractors) .or. &
                     allocated(r%basins) .or. allocated(r%bifurcation_diagram) .or. allocated(r%stability_map) .or. &
                     allocated(r%run_up) .or. allocated(r%locus))
      end associate
      if (is_small) is_small = allocated(results%response%coefficients)
      if (is_small) is_small = size(results%response%coefficients) < few
   end function is_small

   !> Shows the symmetric planetary sets: of each mesh its planet and whether it is the first or second mesh of the planet, 0 for
   !> other meshes, and the shift in time that goes with a turn by one planet [rad of Lambda].
   subroutine show_symmetries(train, fields)
      type(train_type), intent(in) :: train
      type(fields_type), intent(inout) :: fields
      type(system_type) :: system
      type(symmetry_type), allocatable :: symmetries(:)
      integer, allocatable :: planet(:, :), kind(:, :)
      real(dp), allocatable :: shift(:)
      integer :: i, n, sets

      call build_system(train, system)
      call find_symmetries(train, system, symmetries)
      sets = size(symmetries)
      allocate (planet(system%meshes, sets), kind(system%meshes, sets), source=0)
      shift = symmetries%shift
      do i = 1, sets
         associate (mesh => symmetries(i)%mesh)
            do n = 1, size(mesh, 2)
               planet(mesh(:, n), i) = n
            end do
            do n = 1, size(mesh, 1)
               kind(mesh(n, :), i) = n
            end do
         end associate
      end do
      if (.not. fields%enter('/symmetries', '', .true.)) return
      call fields%index_axis('set', sets, '')
      call fields%index_axis('mesh', system%meshes, '')
      call carry(fields, field_type('planet', 'set mesh'), planet)
      call carry(fields, field_type('kind', 'set mesh'), kind)
      call carry(fields, field_type('shift', 'set'), shift)
   end subroutine show_symmetries

   !> Shows the names of bodies, meshes and shafts, the orders of the meshes, the characteristic length, and speed and frequency of
   !> the fundamental at Lambda = 1, 0 where not known.
   subroutine show_train(train, fields)
      type(train_type), intent(in) :: train
      type(fields_type), intent(inout) :: fields
      type(train_type) :: plain
      integer, allocatable :: order(:)
      real(real64) :: value

      if (.not. fields%enter('/train', '', .true.)) return
      call plain_train(train, plain)
      call fields%text_axis('body', body_labels(train), '')
      call fields%text_axis('mesh', mesh_labels(train), '')
      call fields%text_axis('shaft', shaft_labels(train), '')
      call fields%text_axis('planet', planet_labels(train), '')
      order = plain%meshes%order
      call carry(fields, field_type('order', 'mesh'), order)
      call carry(fields, field_type('characteristic_length'), plain%characteristic_length)
      value = speed_per_lambda(plain)
      call carry(fields, field_type('speed'), value)
      value = hertz_per_lambda(plain)
      call carry(fields, field_type('fundamental_frequency'), value)
   end subroutine show_train

   !> Makes of the fields put what they are of, see `take_fields`.
   subroutine take(box, what, error)
      type(box_type), intent(inout) :: box
      character(*), intent(in) :: what
      type(error_type), allocatable, intent(out) :: error
      type(fields_type) :: none
      character(:), allocatable :: wrong
      integer :: n

      wrong = ''
      if (box%lacks_memory) then
         call fatal(error, 'no memory for what is put in', status_memory)
         return
      end if
      if (what == 'results') then
         call take_results(box%fields, box%case, box%results, wrong)
      else
         associate (fields => box%fields)
            fields%way = reading
            call fields%expect('mesh', size(box%case%train%meshes))
            call fields%expect('shaft', size(box%case%train%shafts))
            call fields%expect('coupling', count(box%case%train%meshes%is_coupling))
            call fields%expect('bearing', count(box%case%train%meshes%axis == 1))
            n = 0
            if (fields%enter('/motions', '', .true.)) call fields%index_axis('motion', n, '')
            allocate (box%motions(n))
            if (n > 0) call visit_motions(box%motions, 'motion', fields)
            if (allocated(fields%wrong)) wrong = fields%wrong//': does not agree with the rest, or with the train'
         end associate
      end if
      box%fields = none
      if (wrong /= '') call fatal(error, wrong, status_input)
   end subroutine take

   !> The field shown by its number through all groups; null where there is none.
   function field_at(box, number) result(field)
      type(box_type), target, intent(in) :: box
      integer, intent(in) :: number
      type(values_type), pointer :: field
      integer :: i, before

      nullify (field)
      before = 0
      do i = 1, box%fields%count
         if (number <= before + box%fields%groups(i)%count) then
            field => box%fields%groups(i)%fields(number - before)
            return
         end if
         before = before + box%fields%groups(i)%count
      end do
   end function field_at

   !> A field more, in a group that may be new; null where there is no memory for it.
   function new_field(box, path, name, kind, extents) result(field)
      type(box_type), target, intent(inout) :: box
      character(*), intent(in) :: path, name
      character, intent(in) :: kind
      integer, intent(in) :: extents(:)
      type(values_type), pointer :: field
      integer :: i, status

      nullify (field)
      i = box%fields%find_group(path)
      if (i == 0) then
         call box%fields%add_group(path, '')
         i = box%fields%count
      end if
      ! What the dimensions are called, the reader of the fields knows.
      call box%fields%groups(i)%add(field_type(name, merge('of Python', '         ', size(extents) > 0)), kind, extents, &
                                     status)
      box%lacks_memory = box%lacks_memory .or. status /= 0
      if (status /= 0) return
      field => box%fields%groups(i)%fields(box%fields%groups(i)%count)
   end function new_field

end module geartrain_python_box
