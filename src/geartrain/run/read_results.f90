!> Reads results from their file, with their case.
module geartrain_run_read_results
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_fields, only: fields_type
   use geartrain_input_reader, only: read_case_text
   use geartrain_run_results, only: open_results, take_results
   implicit none (type, external)
   private
   public :: read_results

contains

   !> Reads a results file, or the checkpoint of a run under way. A file that was changed, or written in another format, is refused.
   subroutine read_results(path, case, results, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The case of the results.
      type(case_type), intent(out) :: case
      type(results_type), intent(out) :: results
      type(error_type), allocatable, intent(out) :: error
      type(fields_type) :: fields
      character(:), allocatable :: input, written_by, wrong
      integer :: status

      call open_results(path, fields, input, written_by, wrong, status)
      if (wrong == '') then
         call read_case_text(input, '', case, error)
         if (allocated(error)) wrong = 'its case is none: '//error%message
      end if
      if (wrong == '') call take_results(fields, case, results, wrong)
      if (allocated(error)) deallocate (error)
      if (wrong /= '') call fatal(error, path//': error: cannot be read as results: '//wrong, status, lines=.true.)
   end subroutine read_results

end module geartrain_run_read_results
