!> What a run gives, and the HDF5 file of it: self-describing, one group an analysis, only what was computed.
module geartrain_results_results
   use, intrinsic :: iso_fortran_env, only: int8
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: version
   use geartrain_base_numbers, only: text
   use geartrain_branch_branch, only: branch_type
   use geartrain_branch_stability_map_settings, only: stability_map_type
   use geartrain_case_case, only: case_type
   use geartrain_case_text, only: case_text
   use geartrain_model_modes, only: modes_type
   use geartrain_motion_attractors_settings, only: attractors_type
   use geartrain_motion_integration_settings, only: sweep_type
   use geartrain_results_attractors, only: write_attractors
   use geartrain_results_file, only: replace_file
   use geartrain_results_integration, only: write_integration
   use geartrain_results_modes, only: write_modes
   use geartrain_results_reading, only: state_path
   use geartrain_results_response, only: write_response
   use geartrain_results_seal, only: add_seal, seal_bytes
   use geartrain_results_stability_map, only: write_stability_map
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: results_type, write_results

   !> Raised when a name or a shape in the file changes its meaning.
   integer, parameter :: format_version = 1

   !> Allocated where it was computed.
   type :: results_type
      type(modes_type), allocatable :: modes
      type(branch_type), allocatable :: response
      type(sweep_type), allocatable :: integration
      type(attractors_type), allocatable :: attractors
      type(stability_map_type), allocatable :: stability_map
      !> Further branches, each with its origin: those from period doublings of the response, then those through attractors.
      type(branch_type), allocatable :: branches(:)
   end type results_type

contains

   !> Writes an HDF5 file; a file of that name is replaced once the new one is whole, and kept where writing fails.
   subroutine write_results(path, case, results, error, state, seal)
      character(*), intent(in) :: path
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      type(error_type), allocatable, intent(out) :: error
      !> What another run needs to go on from here; the file is then sealed, see read_state.
      integer(int8), intent(in), contiguous, optional :: state(:)
      !> The seal of what was written; allocated where that was done.
      integer(int8), allocatable, intent(inout), optional :: seal(:)
      integer(int8), allocatable :: content(:)
      type(store_type) :: store
      integer :: i

      !$omp critical (geartrain_hdf5)
      call store%open()
      call write_root(store, case)
      if (allocated(results%modes)) call write_modes(store, results%modes)
      if (allocated(results%response)) call write_response(store, '/response', results%response)
      if (allocated(results%integration)) call write_integration(store, results%integration)
      if (allocated(results%attractors)) call write_attractors(store, results%attractors)
      if (allocated(results%stability_map)) call write_stability_map(store, results%stability_map)
      if (allocated(results%branches)) then
         do i = 1, size(results%branches)
            call write_response(store, '/branch_'//text(i), results%branches(i))
         end do
      end if
      if (present(state)) call store%put_bytes(state_path, state, 'what geartrain --resume goes on from')
      call store%close(content, error)
      !$omp end critical (geartrain_hdf5)
      if (present(state)) call add_seal(content)
      if (allocated(error)) then
         error%message = path//': error: '//error%message
      else
         call replace_file(path, content, error)
         if (present(seal) .and. .not. allocated(error)) seal = content(size(content) - seal_bytes + 1:)
      end if
   end subroutine write_results

   subroutine write_root(store, case)
      type(store_type), intent(inout) :: store
      type(case_type), intent(in) :: case
      character(:), allocatable :: input

      call store%attribute('/', 'format_version', format_version)
      call store%attribute('/', 'program_version', version)
      if (allocated(case%train%title)) then
         call store%attribute('/', 'title', case%train%title)
      else
         call store%attribute('/', 'title', '')
      end if
      call case_text(case, input)
      call store%attribute('/', 'input', input)
      call store%attribute('/', 'characteristic_length', case%train%characteristic_length)
      call store%attribute('/', 'characteristic_frequency', case%train%characteristic_frequency)
   end subroutine write_root

end module geartrain_results_results
