!> The state of a run under way as bytes, bit by bit, and back: what a checkpoint keeps for another run to go on from.
module geartrain_results_state
   use, intrinsic :: iso_fortran_env, only: int8
   use geartrain_base_kinds, only: dp, version
   use geartrain_branch_branch, only: branch_type, special_point_type, trace_state_type
   use geartrain_branch_path, only: place_type
   use geartrain_branch_stability_map_settings, only: map_row_type, stability_map_type
   use geartrain_motion_attractors_settings, only: attractors_type
   use geartrain_motion_integration_settings, only: sweep_type
   use geartrain_motion_mesh_load, only: mesh_load_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_results_archive, only: archive_type
   use geartrain_results_results, only: results_type
   implicit none (type, external)
   private
   public :: pack_state, unpack_state

   !> A component added to a type that is carried here must be carried, too.
   character(*), parameter :: mark = 'geartrain state 5, version '//version

contains

   !> The bytes of a case and of its results so far, which stay as they are.
   subroutine pack_state(input, results, bytes)
      !> The resolved case.
      character(*), intent(in) :: input
      type(results_type), intent(inout) :: results
      integer(int8), allocatable, intent(out) :: bytes(:)
      type(archive_type) :: archive
      character(:), allocatable :: first, text

      first = mark
      text = input
      call archive%carry(first)
      call archive%carry(text)
      call carry_results(archive, results)
      call archive%finish()
      call move_alloc(archive%bytes, bytes)
   end subroutine pack_state

   !> `wrong` says why the bytes cannot be used; '' where all is well.
   subroutine unpack_state(bytes, input, results, wrong)
      integer(int8), allocatable, intent(inout) :: bytes(:)
      character(:), allocatable, intent(out) :: input, wrong
      type(results_type), intent(inout) :: results
      type(archive_type) :: archive
      character(:), allocatable :: first

      archive%reading = .true.
      call move_alloc(bytes, archive%bytes)
      call archive%carry(first)
      call archive%carry(input)
      if (.not. allocated(first)) first = ''
      if (.not. allocated(input)) input = ''
      wrong = 'it was written by another version of geartrain'
      if (first /= mark) return
      call carry_results(archive, results)
      wrong = ''
      if (archive%broken .or. .not. archive%at_end()) wrong = 'it is damaged'
   end subroutine unpack_state

   !> Modes are not kept: they are found again at once.
   subroutine carry_results(archive, results)
      type(archive_type), intent(inout) :: archive
      type(results_type), intent(inout) :: results
      integer :: i, n

      if (archive%has(allocated(results%response))) then
         if (archive%reading) allocate (results%response)
         call carry_branch(archive, results%response)
      end if
      if (archive%has(allocated(results%integration))) then
         if (archive%reading) allocate (results%integration)
         call carry_sweep(archive, results%integration)
      end if
      if (archive%has(allocated(results%attractors))) then
         if (archive%reading) allocate (results%attractors)
         call carry_attractors(archive, results%attractors)
      end if
      if (archive%has(allocated(results%stability_map))) then
         if (archive%reading) allocate (results%stability_map)
         call carry_map(archive, results%stability_map)
      end if
      if (.not. archive%has(allocated(results%branches))) return
      n = 0
      if (allocated(results%branches)) n = size(results%branches)
      call carry_count(archive, n)
      if (archive%reading) allocate (results%branches(n))
      do i = 1, n
         call carry_branch(archive, results%branches(i))
      end do
   end subroutine carry_results

   !> How many there are of something that takes a byte at least.
   subroutine carry_count(archive, n)
      type(archive_type), intent(inout) :: archive
      integer, intent(inout) :: n

      call archive%carry(n)
      if (.not. archive%reading) return
      if (n < 0 .or. n > size(archive%bytes)) archive%broken = .true.
      if (archive%broken) n = 0
   end subroutine carry_count

   subroutine carry_sweep(archive, sweep)
      type(archive_type), intent(inout) :: archive
      type(sweep_type), intent(inout) :: sweep
      character(:), allocatable :: words
      integer :: i

      call carry_motions(archive, sweep%motions)
      if (.not. archive%reading .and. allocated(sweep%direction)) &
         words = transfer(sweep%direction, repeat(' ', 4*size(sweep%direction)))
      call archive%carry(words)
      if (archive%reading .and. allocated(words)) sweep%direction = [(words(4*i - 3:4*i), i=1, len(words)/4)]
      call archive%carry(sweep%ended)
      call archive%carry(sweep%complete)
   end subroutine carry_sweep

   subroutine carry_attractors(archive, found)
      type(archive_type), intent(inout) :: archive
      type(attractors_type), intent(inout) :: found

      call carry_motions(archive, found%motions)
      call archive%carry(found%frequency)
      call archive%carry(found%starts)
      call archive%carry(found%random_seed)
      call archive%carry(found%unsettled)
      call archive%carry(found%ended)
      call archive%carry(found%complete)
   end subroutine carry_attractors

   subroutine carry_map(archive, map)
      type(archive_type), intent(inout) :: archive
      type(stability_map_type), intent(inout) :: map
      integer :: i, n

      call archive%carry(map%name)
      call archive%carry(map%unit)
      call archive%carry(map%linear)
      call archive%carry(map%frequency)
      call archive%carry(map%parameter)
      call archive%carry(map%motions)
      call archive%carry(map%stable_motions)
      if (allocated(map%parameter)) call carry_multipliers(archive, map%multiplier, size(map%parameter))
      call archive%carry(map%rms)
      call archive%carry(map%done)
      call archive%carry(map%whole)
      if (archive%has(allocated(map%rows))) then
         n = 0
         if (allocated(map%rows)) n = size(map%rows)
         call carry_count(archive, n)
         if (archive%reading) allocate (map%rows(n))
         do i = 1, n
            call carry_row(archive, map%rows(i))
         end do
      end if
      call archive%carry(map%ended)
      call archive%carry(map%complete)
   end subroutine carry_map

   subroutine carry_row(archive, row)
      type(archive_type), intent(inout) :: archive
      type(map_row_type), intent(inout) :: row
      complex(dp), allocatable :: multiplier(:, :)

      call archive%carry(row%motions)
      call archive%carry(row%stable_motions)
      if (allocated(row%multiplier)) multiplier = reshape(row%multiplier, [size(row%multiplier), 1])
      call carry_multipliers(archive, multiplier, 1)
      if (archive%reading .and. allocated(multiplier)) row%multiplier = multiplier(:, 1)
      call archive%carry(row%rms)
      call archive%carry(row%whole)
   end subroutine carry_row

   subroutine carry_branch(archive, branch)
      type(archive_type), intent(inout) :: archive
      type(branch_type), intent(inout) :: branch
      integer :: i, n

      call archive%carry(branch%points)
      call archive%carry(branch%meshes)
      call archive%carry(branch%states)
      call archive%carry(branch%harmonics)
      call archive%carry(branch%subharmonic)
      call archive%carry(branch%frequency, branch%points)
      call archive%carry(branch%coefficients, branch%points)
      call archive%carry(branch%rms, branch%points)
      call archive%carry(branch%mean, branch%points)
      call archive%carry(branch%minimum, branch%points)
      call archive%carry(branch%maximum, branch%points)
      call archive%carry(branch%backlash)
      call carry_loads(archive, branch%mesh_load, branch%points)
      call carry_multipliers(archive, branch%multipliers, branch%points)
      call archive%carry(branch%stable, branch%points)
      call archive%carry(branch%undecided, branch%points)
      call archive%carry(branch%second_estimate, branch%points)
      call archive%carry(branch%count_undecided, branch%points)
      call archive%carry(branch%error_estimate, branch%points)
      call archive%carry(branch%correction, branch%points)
      call archive%carry(branch%estimate_doubtful, branch%points)
      call archive%carry(branch%point_harmonics, branch%points)
      call archive%carry(branch%part, branch%points)
      call archive%carry(branch%ended)
      call archive%carry(branch%complete)
      call archive%carry(branch%closed)
      call archive%carry(branch%origin)
      if (archive%has(allocated(branch%special_points))) then
         n = 0
         if (allocated(branch%special_points)) n = size(branch%special_points)
         call carry_count(archive, n)
         if (archive%reading) allocate (branch%special_points(n))
         do i = 1, size(branch%special_points)
            call carry_special_point(archive, branch%special_points(i))
         end do
      end if
      if (.not. archive%has(allocated(branch%trace))) return
      if (archive%reading) allocate (branch%trace)
      call carry_trace(archive, branch%trace)
   end subroutine carry_branch

   subroutine carry_special_point(archive, special)
      type(archive_type), intent(inout) :: archive
      type(special_point_type), intent(inout) :: special
      character(:), allocatable :: kind

      if (.not. archive%reading) kind = special%kind
      call archive%carry(kind)
      if (allocated(kind)) special%kind = kind
      call archive%carry(special%frequency)
      call archive%carry(special%point)
      call archive%carry(special%rms)
   end subroutine carry_special_point

   subroutine carry_trace(archive, trace)
      type(archive_type), intent(inout) :: archive
      type(trace_state_type), intent(inout) :: trace

      call archive%carry(trace%from_stop)
      call archive%carry(trace%whole)
      call archive%carry(trace%first_points)
      call archive%carry(trace%steps)
      call archive%carry(trace%harmonics)
      call archive%carry(trace%step)
      call archive%carry(trace%bend)
      call archive%carry(trace%missed)
      call archive%carry(trace%sense)
      call archive%carry(trace%before)
      call carry_place(archive, trace%here)
      call carry_place(archive, trace%origin)
   end subroutine carry_trace

   subroutine carry_place(archive, place)
      type(archive_type), intent(inout) :: archive
      type(place_type), intent(inout) :: place

      call archive%carry(place%u)
      call archive%carry(place%tangent)
      call archive%carry(place%harmonic)
      call archive%carry(place%frequency)
      call archive%carry(place%tangent_frequency)
      call archive%carry(place%orientation)
   end subroutine carry_place

   !> Those at the end that are still to come (without a frequency) are counted alone.
   subroutine carry_motions(archive, motions)
      type(archive_type), intent(inout) :: archive
      type(motion_type), allocatable, intent(inout) :: motions(:)
      integer :: i, n, done, status

      if (.not. archive%has(allocated(motions))) return
      n = 0
      done = 0
      if (allocated(motions)) then
         n = size(motions)
         done = count(motions%frequency > 0)
      end if
      call archive%carry(n)
      call carry_count(archive, done)
      status = merge(1, 0, n < done)
      if (archive%reading .and. status == 0) allocate (motions(n), stat=status)
      if (status /= 0) archive%broken = .true.
      if (archive%broken) return
      do i = 1, done
         call carry_motion(archive, motions(i))
      end do
   end subroutine carry_motions

   subroutine carry_motion(archive, motion)
      type(archive_type), intent(inout) :: archive
      type(motion_type), intent(inout) :: motion
      type(mesh_load_type), allocatable :: loads(:, :)
      complex(dp), allocatable :: multipliers(:, :)
      character(:), allocatable :: kind

      call archive%carry(motion%frequency)
      call archive%carry(motion%period)
      call archive%carry(motion%coefficients)
      call archive%carry(motion%rms)
      call archive%carry(motion%mean)
      call archive%carry(motion%minimum)
      call archive%carry(motion%maximum)
      call archive%carry(motion%state)
      call archive%carry(motion%stable)
      call archive%carry(motion%undecided)
      call archive%carry(motion%floating)
      if (archive%has(allocated(motion%lyapunov_exponent))) then
         if (archive%reading) allocate (motion%lyapunov_exponent)
         call archive%carry(motion%lyapunov_exponent)
      end if
      call archive%carry(motion%lyapunov_error)
      kind = motion%kind
      call archive%carry(kind)
      if (archive%reading .and. allocated(kind)) motion%kind = kind
      call archive%carry(motion%error_estimate)
      call archive%carry(motion%share)
      if (allocated(motion%mesh_load)) loads = reshape(motion%mesh_load, [size(motion%mesh_load), 1])
      call carry_loads(archive, loads, 1)
      if (archive%reading .and. allocated(loads)) motion%mesh_load = loads(:, 1)
      if (allocated(motion%multipliers)) multipliers = reshape(motion%multipliers, [size(motion%multipliers), 1])
      call carry_multipliers(archive, multipliers, 1)
      if (archive%reading .and. allocated(multipliers)) motion%multipliers = multipliers(:, 1)
   end subroutine carry_motion

   subroutine carry_loads(archive, loads, used)
      type(archive_type), intent(inout) :: archive
      type(mesh_load_type), allocatable, intent(inout) :: loads(:, :)
      integer, intent(in) :: used
      real(dp), allocatable :: values(:, :, :)

      if (.not. archive%reading .and. allocated(loads)) then
         allocate (values(4, size(loads, 1), used))
         values(1, :, :) = loads(:, :used)%force_maximum
         values(2, :, :) = loads(:, :used)%dynamic_factor
         values(3, :, :) = loads(:, :used)%separation
         values(4, :, :) = loads(:, :used)%back_contact
      end if
      call archive%carry(values)
      if (.not. archive%reading .or. .not. allocated(values)) return
      allocate (loads(size(values, 2), size(values, 3)))
      loads%force_maximum = values(1, :, :)
      loads%dynamic_factor = values(2, :, :)
      loads%separation = values(3, :, :)
      loads%back_contact = values(4, :, :)
   end subroutine carry_loads

   subroutine carry_multipliers(archive, multipliers, used)
      type(archive_type), intent(inout) :: archive
      complex(dp), allocatable, intent(inout) :: multipliers(:, :)
      integer, intent(in) :: used
      real(dp), allocatable :: values(:, :, :)

      if (.not. archive%reading .and. allocated(multipliers)) then
         allocate (values(2, size(multipliers, 1), used))
         values(1, :, :) = multipliers(:, :used)%re
         values(2, :, :) = multipliers(:, :used)%im
      end if
      call archive%carry(values)
      if (archive%reading .and. allocated(values)) multipliers = cmplx(values(1, :, :), values(2, :, :), dp)
   end subroutine carry_multipliers

end module geartrain_results_state
