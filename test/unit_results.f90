!> The results file: what is in it, read back with HDF5, and what is left behind when it cannot be written.
module unit_results
   use hdf5, only: h5aclose_f, h5aopen_by_name_f, h5aread_f, h5dclose_f, h5dget_space_f, h5dopen_f, h5dread_f, h5fclose_f, &
      h5fget_obj_count_f, h5fopen_f, h5lexists_f, h5sclose_f, h5sget_simple_extent_dims_f, h5f_acc_rdonly_f, &
      h5f_obj_all_f, h5t_native_double, h5t_native_integer, hid_t, hsize_t, size_t
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_error, only: error_type, status_file
   use geartrain_base_field, only: lengths_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text
   use geartrain_base_words, only: lambda, operator(//)
   use geartrain_results_file, only: check_place
   use geartrain_run_reference, only: output_reference
   use geartrain_run_results, only: write_results
   use testing, only: scratch, tests_type
   implicit none (type, external)
   private
   public :: results_tests

   character(*), parameter :: path = scratch//'results.h5'

contains

   subroutine results_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('only_what_was_computed')) call only_what_was_computed(tests)
      if (tests%runs('response_as_written')) call response_as_written(tests)
      if (tests%runs('integration_as_written')) call integration_as_written(tests)
      if (tests%runs('attractors_and_branches_as_written')) call attractors_and_branches_as_written(tests)
      if (tests%runs('failures')) call failures(tests)
      if (tests%runs('reference_page')) call reference_page(tests)
      if (tests%runs('many_dimensions')) call many_dimensions(tests)
      call clean()
   end subroutine results_tests

   subroutine many_dimensions(tests)
      class(tests_type), intent(inout) :: tests
      type(lengths_type) :: lengths
      integer :: i

      do i = 1, 40
         call lengths%set('d'//integer_text(i), 0)
         call lengths%set('d'//integer_text(i), i)
      end do
      call tests%is_true(all([(lengths%of('d'//integer_text(i)) == i, i=1, 40)]) .and. lengths%of('d') == -1, &
                         'the lengths of forty dimensions')
   end subroutine many_dimensions

   subroutine only_what_was_computed(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      integer :: status

      call make_case(case)
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'is written')
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call tests%is_true(status == 0, 'opens')
      call tests%is_true(integer_attribute(file, '/', 'format_version') == 3, 'format_version is 3')
      call tests%is_true(.not. exists(file, '/modes'), 'no modes asked for, no /modes')
      call tests%is_true(.not. exists(file, '/response'), 'no response asked for, no /response')
      call tests%is_true(.not. exists(file, '/integration'), 'no integration asked for, no /integration')
      call h5fclose_f(file, status)
   end subroutine only_what_was_computed

   subroutine response_as_written(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      integer(size_t) :: handles
      integer :: status
      real(dp) :: rms(2, 3), multipliers(2, 4, 3)

      call make_case(case)
      call make_response(results)
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'is written')
      call h5fget_obj_count_f(int(h5f_obj_all_f, hid_t), h5f_obj_all_f, handles, status)
      call tests%is_true(status == 0 .and. handles == 0, 'HDF5 has nothing left open')

      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call tests%is_true(all(extents(file, '/response/frequency', 1) == [3]), 'frequency (point), the points in use only')
      call tests%is_true(all(extents(file, '/response/rms', 2) == [2, 3]), 'rms (point, mesh)')
      call tests%is_true(all(extents(file, '/response/coefficients', 3) == [5, 2, 3]), 'coefficients (point, mesh, coefficient)')
      call tests%is_true(all(extents(file, '/response/multipliers', 3) == [2, 4, 3]), 'multipliers (point, state, complex)')
      call read_real(file, '/response/rms', size(rms), rms)
      call tests%is_close(rms(2, 3), 0.23_dp, 0.0_dp, 'rms of mesh 2 at point 3')
      call read_real(file, '/response/multipliers', size(multipliers), multipliers)
      call tests%is_close(multipliers(1, 4, 2), 4.0_dp, 0.0_dp, 'real part of multiplier 4 at point 2')
      call tests%is_close(multipliers(2, 4, 2), -2.0_dp, 0.0_dp, 'its imaginary part')
      call tests%is_true(integer_attribute(file, '/response', 'complete') == 0, 'a branch that ended early says so')
      call tests%is_true(exists(file, '/response/special_points/kind'), 'special points')
      call h5fclose_f(file, status)

      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call tests%is_true(.not. exists(file, '/response/dynamic_factor'), 'no mesh loads, no datasets of them')
      call h5fclose_f(file, status)
      allocate (results%response%mesh_load(2, 3))
      results%response%mesh_load%force_maximum = 10
      results%response%mesh_load%dynamic_factor = reshape([2, 3, 4, 5, -1, 7], [2, 3])
      results%response%half_backlash = [5.0_dp, 5.0_dp]
      call write_results(path, case, results, error)
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call read_real(file, '/response/dynamic_factor', size(rms), rms)
      call tests%is_close(rms(2, 2), 5.0_dp, 0.0_dp, 'dynamic factor (point, mesh)')
      call tests%is_true(rms(1, 3) /= rms(1, 3), 'without a static force it is NaN')
      call read_real(file, '/response/mesh_force_maximum', size(rms), rms)
      call tests%is_close(rms(1, 3), 10.0_dp, 0.0_dp, 'the largest force is there all the same')
      call tests%is_true(exists(file, '/response/separation_ranges/from'), 'ranges of separation')
      call h5fclose_f(file, status)

      deallocate (results%response%stable, results%response%multipliers, results%response%special_points)
      call write_results(path, case, results, error)
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call tests%is_true(.not. exists(file, '/response/stable'), 'no stability asked for, no stable')
      call tests%is_true(.not. exists(file, '/response/multipliers'), 'no stability asked for, no multipliers')
      call tests%is_true(.not. exists(file, '/response/special_points'), 'no special points, no group of them')
      call h5fclose_f(file, status)

      results%response%points = 0
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'a branch without points is written')
   end subroutine response_as_written

   subroutine integration_as_written(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      integer :: status
      real(dp) :: rms(1, 2)

      call make_case(case)
      allocate (results%integration)
      associate (sweep => results%integration)
         allocate (sweep%motions(4), sweep%direction(4))
         sweep%direction = 'up'
         sweep%motions(1)%frequency_ratio = 0.5_dp
         sweep%motions(1)%coefficients = reshape([1.0_dp, 0.3_dp, 0.4_dp], [3, 1])
         sweep%motions(1)%rms = [0.5_dp]
         sweep%motions(1)%mean = [1.0_dp]
         sweep%motions(1)%minimum = [0.5_dp]
         sweep%motions(1)%maximum = [1.5_dp]
         ! One that ran away; two are still to come.
         sweep%motions(2)%frequency_ratio = 0.6_dp
         sweep%motions(2)%period = 0
      end associate
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'half a sweep is written')
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call tests%is_true(all(extents(file, '/integration/rms', 2) == [1, 2]), 'rms (point, mesh) of the motions done')
      call read_real(file, '/integration/rms', size(rms), rms)
      call tests%is_close(rms(1, 1), 0.5_dp, 0.0_dp, 'rms of the first motion')
      call tests%is_true(rms(1, 2) /= rms(1, 2), 'a motion that ran away has no rms')
      call tests%is_true(.not. exists(file, '/integration/stable'), 'no stability asked for, no stable')
      call h5fclose_f(file, status)
   end subroutine integration_as_written

   subroutine attractors_and_branches_as_written(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error
      integer(hid_t) :: file
      integer :: status
      real(dp) :: share(2), rms(2, 3)

      call make_case(case)
      call make_response(results)
      allocate (results%branches(2), results%attractors)
      results%branches(2) = results%response
      results%branches(2)%origin = 'attractor 1 at '//lambda(0.5_dp)
      associate (found => results%attractors)
         allocate (found%motions(2))
         found%motions%frequency_ratio = 0.5_dp
         found%motions%share = [0.5_dp, 0.25_dp]
         found%motions(1)%coefficients = reshape([1.0_dp, 0.3_dp, 0.4_dp], [3, 1])
         found%motions(1)%rms = [0.5_dp]
         found%motions(1)%mean = [1.0_dp]
         found%motions(1)%minimum = [0.5_dp]
         found%motions(1)%maximum = [1.5_dp]
         allocate (found%motions(1)%mesh_load(1))
         found%motions(1)%mesh_load%dynamic_factor = 2.5_dp
         found%motions(2) = found%motions(1)
         found%motions(2)%share = 0.25_dp
         found%starts = 4
         found%unsettled = 0.25_dp
      end associate
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'is written')
      call h5fopen_f(path, h5f_acc_rdonly_f, file, status)
      call read_real(file, '/attractors/share', 2, share)
      call tests%is_close(share(2), 0.25_dp, 0.0_dp, 'share of the second motion')
      call tests%is_true(all(extents(file, '/attractors/rms', 2) == [1, 2]), 'rms (motion, mesh)')
      call read_real(file, '/attractors/dynamic_factor', 2, share)
      call tests%is_close(share(1), 2.5_dp, 0.0_dp, 'dynamic factor (motion, mesh)')
      call tests%is_true(integer_attribute(file, '/attractors', 'starts') == 4, 'number of starts')
      call tests%is_true(exists(file, '/branch_1') .and. .not. exists(file, '/branch_1/rms'), 'a branch without points')
      call read_real(file, '/branch_2/rms', 6, rms)
      call tests%is_close(rms(2, 3), 0.23_dp, 0.0_dp, 'a further branch is written as the response is')
      call h5fclose_f(file, status)
   end subroutine attractors_and_branches_as_written

   subroutine failures(tests)
      class(tests_type), intent(inout) :: tests
      type(case_type) :: case
      type(results_type) :: results
      type(error_type), allocatable :: error

      call make_case(case)
      call write_results('build/no-such-folder/a.h5', case, results, error)
      call expect(tests, error, 'build/no-such-folder/a.h5: error: cannot be written: there is no folder build/no-such-folder/', &
                  'missing folder')
      call write_results('build', case, results, error)
      call expect(tests, error, 'build: error: cannot be written: it is a folder; give the name of a file', 'a folder')
      call write_results('/dev/null', case, results, error)
      call tests%is_true(allocated(error), 'a device is not replaced')
      if (allocated(error)) deallocate (error)
      call check_place('build/no-such-folder/a.h5', error)
      call tests%is_true(allocated(error), 'a missing folder is known before anything is computed')

      ! A name that leaves no room for that of a temporary file.
      call write_results('build/'//repeat('a', 250), case, results, error)
      call tests%is_true(allocated(error), 'a temporary file that cannot be made is an error')
      call write_results(path, case, results, error)
      call tests%is_true(.not. allocated(error), 'after a failure writing works again')
      call tests%is_true(no_temporary(path), 'no temporary file is left')
      call check_place(path, error)
      call tests%is_true(there(path) .and. no_temporary(path), 'asking whether it can be written leaves all as it was')
   end subroutine failures

   subroutine reference_page(tests)
      class(tests_type), intent(inout) :: tests
      character(:), allocatable :: page, text
      integer :: unit, bytes, status

      open (newunit=unit, file='docs/output.md', access='stream', form='unformatted', status='old', action='read')
      inquire (unit=unit, size=bytes)
      allocate (character(bytes) :: page)
      read (unit, iostat=status) page
      close (unit)
      call output_reference(text)
      call tests%is_true(index(page, text) > 0, 'docs/output.md holds what geartrain --output-reference prints')
   end subroutine reference_page

   subroutine expect(tests, error, message, name)
      class(tests_type), intent(inout) :: tests
      type(error_type), allocatable, intent(in) :: error
      character(*), intent(in) :: message, name

      call tests%is_true(allocated(error), name//' is an error')
      if (.not. allocated(error)) return
      call tests%is_text(error%message, message, name)
      call tests%is_true(error%status == status_file, name//' has the status of the file system')
   end subroutine expect

   !> Whether no temporary file stands beside the file.
   logical function no_temporary(path)
      character(*), intent(in) :: path
      integer :: status

      status = 0
      call execute_command_line('ls '//path//'.*.tmp >/dev/null 2>&1', exitstat=status)
      no_temporary = status /= 0
   end function no_temporary

   subroutine clean()
      integer :: unit

      open (newunit=unit, file=path)
      close (unit, status='delete')
   end subroutine clean

   subroutine make_case(case)
      type(case_type), intent(out) :: case

      case%train%title = 'Zahnräder'
      allocate (case%train%shafts(2), case%train%meshes(1))
      case%output_file = ''
   end subroutine make_case

   !> Three points in arrays with room for four.
   subroutine make_response(results)
      type(results_type), intent(inout) :: results
      integer :: i, j

      allocate (results%response)
      associate (branch => results%response)
         branch%points = 3
         branch%meshes = 2
         branch%states = 4
         branch%harmonics = 2
         branch%frequency_ratio = [0.1_dp, 0.2_dp, 0.3_dp, -1.0_dp]
         allocate (branch%coefficients(5, 2, 4), source=1.0_dp)
         branch%rms = reshape([((0.1_dp*i + 0.01_dp*j, i=1, 2), j=1, 4)], [2, 4])
         branch%mean = branch%rms
         branch%minimum = branch%rms
         branch%maximum = branch%rms
         branch%multipliers = reshape([((cmplx(i, -j, dp), i=1, 4), j=1, 4)], [4, 4])
         branch%stable = [.true., .false., .true., .false.]
         branch%undecided = [.false., .true., .false., .false.]
         branch%second_estimate = [-1.0_dp, 0.99_dp, -1.0_dp, -1.0_dp]
         branch%count_undecided = [.false., .true., .false., .false.]
         branch%error_estimate = [1e-3_dp, 1e-3_dp, 1e-3_dp, 0.0_dp]
         branch%estimate_doubtful = [.false., .true., .false., .false.]
         branch%point_harmonics = [2, 2, 1, 0]
         branch%segment = [1, 1, 2, 0]
         branch%ended = 'step below 1e-9 at '//lambda(0.3_dp)
         allocate (branch%special_points(1))
         branch%special_points(1)%kind = 'fold'
         branch%special_points(1)%frequency_ratio = 0.25_dp
         branch%special_points(1)%point = 2
         branch%special_points(1)%rms = [0.1_dp, 0.2_dp]
      end associate
   end subroutine make_response

   integer function integer_attribute(file, object, name) result(value)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: object, name
      integer(hid_t) :: id
      integer(hsize_t) :: one(1)
      integer :: status

      one = 1
      value = -1
      call h5aopen_by_name_f(file, object, name, id, status)
      call h5aread_f(id, h5t_native_integer, value, one, status)
      call h5aclose_f(id, status)
   end function integer_attribute

   logical function exists(file, name)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: name
      integer :: status

      call h5lexists_f(file, name, exists, status)
      exists = exists .and. status == 0
   end function exists

   !> In Fortran's order, the reverse of the file's.
   function extents(file, name, rank) result(values)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: name
      integer, intent(in) :: rank
      integer :: values(rank)
      integer(hsize_t) :: now(rank), most(rank)
      integer(hid_t) :: id, space
      integer :: status

      call h5dopen_f(file, name, id, status)
      call h5dget_space_f(id, space, status)
      call h5sget_simple_extent_dims_f(space, now, most, status)
      values = int(now)
      call h5sclose_f(space, status)
      call h5dclose_f(id, status)
   end function extents

   subroutine read_real(file, name, n, values)
      integer(hid_t), intent(in) :: file
      character(*), intent(in) :: name
      integer, intent(in) :: n
      real(dp), intent(out) :: values(n)
      integer(hsize_t) :: extent(1)
      integer(hid_t) :: id
      integer :: status

      extent = n
      call h5dopen_f(file, name, id, status)
      call h5dread_f(id, h5t_native_double, values, extent, status)
      call h5dclose_f(id, status)
   end subroutine read_real

   logical function there(name)
      character(*), intent(in) :: name

      inquire (file=name, exist=there)
   end function there

end module unit_results
