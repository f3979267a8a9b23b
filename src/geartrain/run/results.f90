!> The results of a case, their file, and back: what is written is what is read, by a run that goes on as by whoever asks for it.
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
   use geartrain_model_labels, only: mesh_labels
   use geartrain_model_network, only: state_count
   use geartrain_results_file, only: replace_file
   use geartrain_results_hdf5_reader, only: read_groups
   use geartrain_results_hdf5_writer, only: hdf5_content
   use geartrain_results_seal, only: add_seal, seal_bytes
   implicit none (type, external)
   private
   public :: open_results, take_results, visit_results, visit_root, write_results

   !> Raised when a name or a shape in the file changes its meaning. 2: a file is sealed and holds all that is to be read back.
   integer, parameter :: format_version = 2

contains

   !> Writes an HDF5 file; a file of that name is replaced once the new one is whole, and kept where writing fails. Of work under
   !> way it holds what another run needs to go on.
   subroutine write_results(path, case, results, error, seal)
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      !> They stay as they are.
      type(results_type), intent(inout) :: results
      type(error_type), allocatable, intent(out) :: error
      !> The seal of what was written; allocated where that was done.
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

   !> The attributes of the file itself.
   subroutine visit_root(case, fields)
      type(case_type), intent(in) :: case
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

   !> The groups of a results file, the text of the case that they are results of, and the version of geartrain that wrote them;
   !> `wrong` says why they cannot be used, '' where all is well so far.
   subroutine open_results(path, fields, input, written_by, wrong)
      character(*), intent(in) :: path
      type(fields_type), intent(inout) :: fields
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

   !> The results of the case among the groups read; `wrong` says what does not agree with the rest or with the case, '' where all
   !> does.
   subroutine take_results(fields, case, results, wrong)
      type(fields_type), intent(inout) :: fields
      type(case_type), intent(in) :: case
      type(results_type), intent(out) :: results
      character(:), allocatable, intent(out) :: wrong

      fields%way = reading
      wrong = ''
      call visit_results(results, case, fields, summary=.false.)
      if (allocated(fields%wrong)) wrong = fields%wrong
   end subroutine take_results

   !> All that a case can give, in the order of the file.
   subroutine visit_results(results, case, fields, summary)
      type(results_type), intent(inout), target :: results
      type(case_type), intent(in), target :: case
      class(fields_type), intent(inout) :: fields
      !> Whether what one reads off a branch is computed as well.
      logical, intent(in) :: summary
      class(analysis_type), allocatable :: analysis
      integer :: i, n

      call fields%expect('mesh', size(case%train%meshes), mesh_labels(case%train))
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
