!> The steady motions that random starts settle on at one frequency, and the share of each.
module geartrain_flow_attractors
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_observer, only: observer_type
   use geartrain_base_random, only: begin_random, generator_type
   use geartrain_flow_attractors_settings, only: attractors_settings_type, attractors_type
   use geartrain_flow_floating, only: note_of
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_settling, only: settle
   use geartrain_flow_start_state, only: resting_state
   use geartrain_flow_variables, only: check_attractors
   use geartrain_model_check, only: check_train
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: attractors

   !> Motions whose rms, mean and extremes agree to this, relative to the largest displacement, are one.
   real(dp), parameter :: same = 1e-5_dp
   !> Starts between two reports to the observer: they run in parallel.
   integer, parameter :: batch = 32

contains

   !> Settles settings%starts random states, in parallel and with results that do not depend on the number of threads. A
   !> search under way (its motions are there, why it ended is not, as in a checkpoint of the same case) is taken up.
   subroutine attractors(train, settings, found, error, observer)
      type(train_type), intent(in) :: train
      type(attractors_settings_type), intent(in) :: settings
      !> A target: an observer may read the motions so far through a pointer.
      type(attractors_type), intent(inout), target :: found
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), optional :: observer
      type(attractors_type) :: empty
      type(integration_settings_type) :: integration
      type(system_type) :: system
      type(motion_type) :: settled(batch)
      real(dp), allocatable :: state(:)
      integer, allocatable :: hits(:)
      integer :: first, last, i
      logical :: keep_going

      if (allocated(found%ended) .or. .not. allocated(found%motions)) found = empty
      call check_train(train, error)
      if (.not. allocated(error)) call check_attractors(train, settings, error)
      if (allocated(error)) return
      call build_system(train, system)
      integration%harmonics = settings%harmonics
      integration%max_periods = settings%max_periods
      integration%tolerance = settings%tolerance
      integration%stability = settings%stability
      found%frequency_ratio = settings%frequency_ratio
      found%random_seed = settings%random_seed
      if (.not. allocated(found%motions)) allocate (found%motions(0))
      hits = nint(found%motions%share*found%starts)
      keep_going = .true.
      do first = found%starts + 1, settings%starts, batch
         last = first + min(batch - 1, settings%starts - first)
         !$omp parallel do private(state) schedule(dynamic)
         do i = first, last
            state = random_state(system, settings%random_seed, i)
            call settle(system, settings%frequency_ratio, integration, state, settled(i - first + 1))
         end do
         !$omp end parallel do
         if (train%interrupt%raised()) exit
         do i = 1, last - first + 1
            call collect(settled(i), found%motions, hits)
         end do
         call sort_by_hits(found%motions, hits)
         found%starts = last
         found%motions%share = hits/real(last, dp)
         found%unsettled = (last - sum(hits))/real(last, dp)
         if (present(observer)) call observer%on_step('attractors', last, settings%frequency_ratio, keep_going)
         if (.not. keep_going) exit
      end do
      found%complete = found%starts == settings%starts
      found%ended = 'all starts done'
      if (.not. found%complete) found%ended = 'cancelled after '//text(found%starts)//' of '//text(settings%starts)//' starts'
      found%ended = found%ended//note_of(any(found%motions%floating))
   end subroutine attractors

   !> Mesh displacements and velocities uniform within three times the resting displacement; shafts untwisted.
   function random_state(system, seed, start) result(state)
      type(system_type), intent(in) :: system
      integer, intent(in) :: seed, start
      real(dp), allocatable :: state(:)
      real(dp) :: reach
      type(generator_type) :: generator
      integer :: j

      generator = begin_random(seed, start)
      allocate (state(system%states))
      state = resting_state(system)
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            ! A mesh that closes a loop moves as the others say.
            if (n > system%coordinates) cycle
            reach = 3*abs(state(n))
            state(n) = reach*(2*generator%uniform() - 1)
            state(system%displacements + n) = reach*(2*generator%uniform() - 1)
         end associate
      end do
   end function random_state

   !> Counts a settled motion among those found, or adds it.
   subroutine collect(motion, motions, hits)
      type(motion_type), intent(in) :: motion
      type(motion_type), allocatable, intent(inout) :: motions(:)
      !> Starts that settled on each motion.
      integer, allocatable, intent(inout) :: hits(:)
      integer :: i
      real(dp) :: scale

      if (motion%period == 0) return
      do i = 1, size(motions)
         if (motions(i)%period /= motion%period) cycle
         scale = max(maxval(abs(motion%maximum)), maxval(abs(motion%minimum)))
         if (any(abs(motions(i)%rms - motion%rms) > same*scale)) cycle
         if (any(abs(motions(i)%mean - motion%mean) > same*scale)) cycle
         if (any(abs(motions(i)%maximum - motion%maximum) > same*scale)) cycle
         hits(i) = hits(i) + 1
         return
      end do
      motions = [motions, motion]
      hits = [hits, 1]
   end subroutine collect

   pure subroutine sort_by_hits(motions, hits)
      type(motion_type), intent(inout) :: motions(:)
      integer, intent(inout) :: hits(:)
      type(motion_type) :: held
      integer :: i, j, count

      do i = 2, size(motions)
         held = motions(i)
         count = hits(i)
         do j = i - 1, 1, -1
            if (hits(j) >= count) exit
            motions(j + 1) = motions(j)
            hits(j + 1) = hits(j)
         end do
         motions(j + 1) = held
         hits(j + 1) = count
      end do
   end subroutine sort_by_hits

end module geartrain_flow_attractors
