!> The results of a case to and from their file. All results are read back: a file of work under way serves as a checkpoint.
module geartrain_run_results
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_analyses_response, only: visit_whole_branch
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_error, only: error_type, status_file
   use geartrain_base_field, only: kind_real, row => field_type
   use geartrain_base_fields, only: fields_type, listing, measuring, reading
   use geartrain_base_kinds, only: dp, version
   use geartrain_base_memory, only: need
   use geartrain_base_numbers, only: text
   use geartrain_base_plain_text, only: escaped
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_input_text, only: case_text
   use geartrain_network_frequency_unit, only: hertz_per_lambda, speed_per_lambda
   use geartrain_network_network, only: state_count
   use geartrain_report_drawing_warnings, only: warnings_text
   use geartrain_results_file, only: replace_file
   use geartrain_results_hdf5_reader, only: read_groups
   use geartrain_results_hdf5_writer, only: hdf5_content
   use geartrain_results_seal, only: add_seal, check_replaceable, seal_bytes
   use geartrain_network_load_sharing, only: planet_labels
   use geartrain_train_labels, only: bearing_labels, coupling_labels, held_labels, label_length, mesh_labels, shaft_labels
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: open_results, results_bytes, take_results, visit_results, visit_root, write_results

   !> Raised when a name or a shape in the file changes its meaning. 2: a file is sealed and holds all that reading needs. 3:
   !> `speed` is in rpm, where format 2 had the way of a sweep in /jumps, which is not read.
   integer, parameter :: format_version = 3
   character(*), parameter :: about_speed = 'speed of the first body, or of `speed_of`'

contains

   !> Writes an HDF5 file. A results file at `path` is replaced once the new file is complete, and kept if writing fails; any other
   !> file is not replaced.
   subroutine write_results(path, case, results, error, seal)
      !> Path of the file.
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      !> The results, which may be under way; unchanged.
      type(results_type), intent(inout) :: results
      type(error_type), allocatable, intent(out) :: error
      !> The seal of the file; set if the file was written.
      integer(int8), allocatable, intent(inout), optional :: seal(:)
      integer(int8), allocatable :: content(:)
      type(fields_type) :: fields

      call check_replaceable(path, error)
      if (allocated(error)) return
      ! The fields, the file that HDF5 makes of them in memory, and its bytes.
      call need(3.0_dp*results_bytes(results, case), path//': error: cannot be written: there is no memory for the results', &
                'compute fewer, or allow more memory', error)
      if (allocated(error)) return
      call visit_root(case, fields)
      call visit_results(results, case, fields, summary=.true.)
      call hdf5_content(fields, content, error)
      if (allocated(error)) then
         error%message = escaped(path)//': error: '//error%message
         return
      end if
      call add_seal(content)
      call replace_file(path, content, error)
      if (present(seal) .and. .not. allocated(error)) seal = content(size(content) - seal_bytes + 1:)
   end subroutine write_results

   !> Bytes of the values of all fields of the results. What follows from other values is not counted: it is a small part.
   integer(int64) function results_bytes(results, case)
      !> The results, which may be under way; unchanged.
      type(results_type), intent(inout) :: results
      !> The case of the results.
      type(case_type), intent(in) :: case
      type(fields_type) :: fields

      fields%way = measuring
      call visit_whole_results(results, case, fields, summary=.false.)
      results_bytes = fields%bytes
   end function results_bytes

   !> Visits the attributes of the file itself, which are not read back here but by open_results.
   subroutine visit_root(case, fields)
      type(case_type), intent(in) :: case
      class(fields_type), intent(inout) :: fields
      type(train_type) :: plain
      character(:), allocatable :: title, input, warnings
      real(kind(case%train%characteristic_length)) :: value
      integer :: number

      if (.not. fields%enter('/', '', .true.)) return
      number = format_version
      call carry(fields, row('format_version', '', '', 'version of the format of the file'), number)
      title = version
      call carry_text(fields, row('program_version', '', '', 'version of geartrain that wrote the file'), title)
      title = ''
      if (allocated(case%train%title)) title = case%train%title
      call carry_text(fields, row('title', '', '', 'as in `&train`'), title)
      if (fields%way /= listing) call case_text(case, input)
      call carry_text(fields, row('input', '', '', 'text of the case with all defaults; it runs again as a case file'), input)
      call plain_train(case%train, plain)
      warnings = ''
      ! A list of all fields has no train.
      if (fields%way /= listing) call warnings_text(case%train, warnings)
      if (fields%has('warnings', warnings /= '')) call carry_text(fields, row('warnings', '', '', 'formulas of the drawing used &
         &outside their range, and modes of little damping, a line each', only='where there are any', optional=.true.), warnings)
      value = plain%characteristic_length
      call carry(fields, row('characteristic_length', '', '', 'unit of displacements [m]'), value)
      value = plain%characteristic_frequency
      call carry(fields, row('characteristic_frequency', '', '', 'unit of frequencies [rad/s]'), value)
   end subroutine visit_root

   !> Reads the groups of a results file.
   subroutine open_results(path, fields, input, written_by, wrong, status)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The fields; without groups if the file has no valid seal.
      type(fields_type), intent(inout) :: fields
      !> Text of the case; version of geartrain that wrote the file; why the file cannot be used, '': it can.
      character(:), allocatable, intent(out) :: input, written_by, wrong
      !> Status of the error that `wrong` tells: status_file, or status_memory.
      integer, intent(out) :: status
      type(error_type), allocatable :: error
      integer :: number
      logical :: there

      status = status_file

      input = ''
      written_by = ''
      inquire (file=path, exist=there)
      wrong = 'there is no such file'
      if (.not. there) return
      wrong = 'it is a case: run it first, geartrain '//path
      if (index(path, '.nml', back=.true.) > max(0, len(path) - 4)) return
      call read_groups(path, fields, error)
      fields%way = reading
      if (allocated(error)) then
         wrong = error%message
         status = error%status
         return
      end if
      wrong = 'its checksum does not fit: it is damaged, cut short, of an earlier version (format 1: run its case again) or &
              &something else'
      if (.not. fields%enter('/', '', .true.)) return
      number = 0
      call carry(fields, row('format_version'), number)
      call carry_text(fields, row('program_version'), written_by)
      call carry_text(fields, row('input'), input)
      wrong = ''
      if (allocated(fields%wrong) .or. number < 2 .or. number > format_version) wrong = 'it was written by version '//written_by// &
         ' of geartrain in format '//text(number)//'; this is version '//version//', which reads &
         &formats 2 to '//text(format_version)
   end subroutine open_results

   !> Takes the results of a case from the groups read.
   subroutine take_results(fields, case, results, wrong)
      !> The fields, as open_results gives them.
      type(fields_type), intent(inout) :: fields
      !> The case of the results.
      type(case_type), intent(in) :: case
      !> The results; none where something is wrong.
      type(results_type), intent(out) :: results
      !> Which field lacks, or does not agree with other fields or with the case, in words; '': all is as it should be.
      character(:), allocatable, intent(out) :: wrong
      type(results_type) :: none

      fields%way = reading
      fields%here = 0
      wrong = ''
      call visit_results(results, case, fields, summary=.false.)
      if (allocated(fields%wrong)) wrong = fields%wrong//' in it does not agree with the rest'
      if (fields%no_room) wrong = fields%wrong//' in it has more places than there is memory for'
      if (fields%lacks) wrong = fields%wrong//' is not in it, which this version of geartrain needs: run its case again'
      ! Half of the results would mislead a caller who reports what there is.
      if (wrong /= '') results = none
   end subroutine take_results

   subroutine visit_whole_results(results, case, fields, summary)
      type(results_type), intent(inout), target :: results
      type(case_type), intent(in), target :: case
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      class(analysis_type), allocatable :: analysis
      character(label_length), allocatable :: planets(:)
      integer :: i, n

      if (fields%way /= measuring) then
         call fields%expect('mesh', size(case%train%meshes), mesh_labels(case%train))
         call fields%expect('shaft', size(case%train%shafts), shaft_labels(case%train))
         call fields%expect('held', size(held_labels(case%train)), held_labels(case%train))
         planets = planet_labels(case%train)
         call fields%expect('planet', size(planets), planets)
         call fields%expect('coupling', size(coupling_labels(case%train)), coupling_labels(case%train))
         call fields%expect('bearing', size(bearing_labels(case%train)), bearing_labels(case%train))
      end if
      if (fields%way == reading) call fields%expect('coordinate', state_count(case%train))
      do i = 1, size(analyses)
         call find_analysis(i, case, results, analysis)
         call fields%check(analysis%asked .or. .not. is_found(i), trim(analyses(i)%name))
      end do
      do i = 1, size(analyses)
         call find_analysis(i, case, results, analysis, begin=is_found(i) .or. fields%way == listing)
         if (analysis%begun) call analysis%visit_fields(case%train, fields, summary)
      end do
      if (fields%way == reading) then
         n = 0
         do while (fields%find_group('/branch_'//text(n + 1)) > 0)
            n = n + 1
         end do
         if (n > 0) allocate (results%branches(n))
      end if
      if (.not. allocated(results%branches)) return
      do i = 1, size(results%branches)
         call visit_whole_branch(results%branches(i), '/branch_'//text(i), case%train, fields, summary)
      end do

   contains

      !> Whether an analysis is among the fields to be read.
      logical function is_found(number)
         integer, intent(in) :: number

         is_found = .false.
         if (fields%way == reading) is_found = fields%find_group('/'//trim(analyses(number)%name)) > 0
      end function is_found

   end subroutine visit_whole_results

   !> Adds the speed [rpm], of a train whose meshes all have teeth, and the frequency of the fundamental [Hz] to every dataset and
   !> attribute of Lambda. They are not read.
   subroutine add_speeds(train, fields)
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      type(train_type) :: plain
      integer :: i, j, count

      call plain_train(train, plain)
      do i = 1, fields%count
         ! Fields are added behind.
         count = fields%groups(i)%count
         do j = 1, count
            select case (fields%groups(i)%fields(j)%about%name)
            case ('frequency')
               call add_field(i, j, 'speed', 'rpm', about_speed, speed_per_lambda(plain))
               call add_field(i, j, 'fundamental_frequency', 'Hz', 'frequency of the fundamental', hertz_per_lambda(plain))
            case ('from', 'to')
               call add_field(i, j, 'speed_'//trim(fields%groups(i)%fields(j)%about%name), 'rpm', about_speed, &
                              speed_per_lambda(plain))
            case ('natural_frequency')
               call add_field(i, j, 'natural_frequency_hertz', 'Hz', 'undamped natural frequency', hertz_per_lambda(plain))
            end select
         end do
      end do

   contains

      subroutine add_field(group, source, name, unit, description, factor)
         !> Numbers of the group and of the field with Lambda.
         integer, intent(in) :: group, source
         character(*), intent(in) :: name, unit, description
         !> Value at Lambda = 1; 0: not known.
         real(dp), intent(in) :: factor
         character(40) :: only
         type(row) :: about
         real(dp), allocatable :: values(:)
         integer, allocatable :: extents(:)
         integer :: place

         if (.not. allocated(fields%groups(group)%fields(source)%reals)) return
         if (.not. factor > 0 .and. fields%way /= listing) return
         only = ''
         if (unit == 'rpm') only = 'where every mesh has teeth'
         about = row(name, fields%groups(group)%fields(source)%about%dimensions, unit, description, only=only)
         values = factor*fields%groups(group)%fields(source)%reals
         extents = fields%groups(group)%fields(source)%extents
         associate (here => fields%groups(group))
            call here%add(about, kind_real, extents)
            call move_alloc(values, here%fields(here%count)%reals)
            if (fields%way == listing .or. about%dimensions == '' .or. about%dimensions == 'frequency') return
            place = here%place('coordinates', .true., 0)
            if (place > 0) here%fields(place)%texts(1)%text = here%fields(place)%texts(1)%text//' '//name
         end associate
      end subroutine add_field

   end subroutine add_speeds

   !> Visits the groups of all results, in the order of the file, and adds speeds where the fields are to be shown.
   subroutine visit_results(results, case, fields, summary)
      !> The results; set by reading.
      type(results_type), intent(inout), target :: results
      !> The case of the results.
      type(case_type), intent(in), target :: case
      class(fields_type), intent(inout) :: fields
      !> Whether the figures of branches (peaks, jumps, ...) are computed and visited as well.
      logical, intent(in) :: summary

      call visit_whole_results(results, case, fields, summary)
      if (fields%derives()) call add_speeds(case%train, fields)
   end subroutine visit_results

end module geartrain_run_results
