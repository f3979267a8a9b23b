!> The results of a case to and from their file. All results are read back: a file of work under way serves as a checkpoint.
module geartrain_run_results
   use, intrinsic :: iso_fortran_env, only: int8
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_analyses_response, only: visit_whole_branch
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_error, only: error_type, fatal, status_file
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: version
   use geartrain_base_numbers, only: text
   use geartrain_input_text, only: case_text
   use geartrain_model_labels, only: mesh_labels, shaft_labels
   use geartrain_model_network, only: state_count
   use geartrain_results_file, only: replace_file
   use geartrain_results_hdf5_reader, only: read_groups
   use geartrain_results_hdf5_writer, only: hdf5_content
   use geartrain_results_seal, only: add_seal, seal_bytes
   implicit none (type, external)
   private
   public :: open_results, take_results, visit_results, visit_root, write_results

   !> Raised when a name or a shape in the file changes its meaning. 2: a file is sealed and holds all that reading needs.
   integer, parameter :: format_version = 2

contains

   !> Writes an HDF5 file. A file at `path` is replaced once the new file is complete, and kept if writing fails.
   subroutine write_results(path, case, results, error, seal)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The case.
      type(case_type), intent(in) :: case
      !> The results, which may be under way; unchanged.
      type(results_type), intent(inout) :: results
      type(error_type), allocatable, intent(out) :: error
      !> The seal of the file; set if the file was written.
      integer(int8), allocatable, intent(inout), optional :: seal(:)
      integer(int8), allocatable :: content(:)
      type(fields_type) :: fields

      call visit_root(case, fields)
      call visit_results(results, case, fields, summary=.true.)
      call hdf5_content(fields, content, error)
      if (allocated(error)) then
         error%message = path//': error: '//error%message
         return
      end if
      call add_seal(content)
      call replace_file(path, content, error)
      if (present(seal) .and. .not. allocated(error)) seal = content(size(content) - seal_bytes + 1:)
   end subroutine write_results

   !> Visits the attributes of the file itself, which are not read back here but by open_results.
   subroutine visit_root(case, fields)
      !> The case.
      type(case_type), intent(in) :: case
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: title, input
      real(kind(case%train%characteristic_length)) :: value
      integer :: number

      if (.not. fields%enter('/', '', .true.)) return
      number = format_version
      call carry(fields, row('format_version', '', '', 'it rises when a name or a shape changes its meaning'), number)
      title = version
      call carry_text(fields, row('program_version', '', '', 'version of geartrain that wrote the file'), title)
      title = ''
      if (allocated(case%train%title)) title = case%train%title
      call carry_text(fields, row('title', '', '', 'as in `&train`'), title)
      if (fields%way /= listing) call case_text(case, input)
      call carry_text(fields, row('input', '', '', 'the case, all defaults included: written to a file it runs again'), input)
      value = case%train%characteristic_length
      call carry(fields, row('characteristic_length', '', '', 'm'), value)
      value = case%train%characteristic_frequency
      call carry(fields, row('characteristic_frequency', '', '', 'rad/s'), value)
   end subroutine visit_root

   !> Reads the groups of a results file.
   subroutine open_results(path, fields, input, written_by, wrong)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The fields; without groups if the file has no valid seal.
      type(fields_type), intent(inout) :: fields
      !> Text of the case; version of geartrain that wrote the file; why the file cannot be used, '': it can.
      character(:), allocatable, intent(out) :: input, written_by, wrong
      integer :: number

      call read_groups(path, fields)
      fields%way = reading
      wrong = 'its checksum does not fit: damaged, cut short or something else'
      input = ''
      written_by = ''
      if (.not. fields%enter('/', '', .true.)) return
      number = 0
      call carry(fields, row('format_version'), number)
      call carry_text(fields, row('program_version'), written_by)
      call carry_text(fields, row('input'), input)
      wrong = ''
      if (allocated(fields%wrong) .or. number /= format_version) wrong = 'it was written by another version of geartrain'
   end subroutine open_results

   !> Takes the results of a case from the groups read.
   subroutine take_results(fields, case, results, wrong)
      !> The fields, as open_results gives them.
      type(fields_type), intent(inout) :: fields
      !> The case of the results.
      type(case_type), intent(in) :: case
      !> The results.
      type(results_type), intent(out) :: results
      !> Path of the first field that does not agree with other fields or with the case; '': all fields agree.
      character(:), allocatable, intent(out) :: wrong

      fields%way = reading
      fields%here = 0
      wrong = ''
      call visit_results(results, case, fields, summary=.false.)
      if (allocated(fields%wrong)) wrong = fields%wrong
   end subroutine take_results

   !> Visits the groups of all results, in the order of the file.
   subroutine visit_results(results, case, fields, summary)
      !> The results; set by reading.
      type(results_type), intent(inout), target :: results
      !> The case of the results.
      type(case_type), intent(in), target :: case
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields
      !> Whether the figures of branches (peaks, jumps, ...) are computed and visited as well.
      logical, intent(in) :: summary
      class(analysis_type), allocatable :: analysis
      integer :: i, n

      call fields%expect('mesh', size(case%train%meshes), mesh_labels(case%train))
      call fields%expect('shaft', size(case%train%shafts), shaft_labels(case%train))
      call fields%expect('coordinate', state_count(case%train))
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

   end subroutine visit_results

end module geartrain_run_results
