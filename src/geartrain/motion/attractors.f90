!> The steady motions that random starts settle on at one frequency, and the share of each.
module geartrain_motion_attractors
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_error, only: error_type, fatal
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_numbers, only: text
   use geartrain_model_check, only: check_train
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   use geartrain_motion_integration, only: check_single, settle
   use geartrain_motion_integration_settings, only: integration_settings_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_motion_start_state, only: resting_state
   implicit none (type, external)
   private
   public :: attractors

   !> Motions whose rms, mean and extremes agree to this, relative to the largest displacement, are one.
   real(dp), parameter :: same = 1e-5_dp
   !> Starts between two reports to the observer: they run in parallel.
   integer, parameter :: batch = 32

contains

   !> Settles `starts` random states, in parallel and with results that do not depend on the number of threads. Largest
   !> share first; starts that found no period are not among the motions (the shares then sum to less than 1).
   subroutine attractors(train, frequency, starts, random_seed, settings, motions, error, observer)
      type(train_type), intent(in) :: train
      !> Lambda [1].
      real(dp), intent(in) :: frequency
      integer, intent(in) :: starts, random_seed
      type(integration_settings_type), intent(in) :: settings
      type(motion_type), allocatable, intent(out) :: motions(:)
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout), optional :: observer
      type(system_type) :: system
      type(motion_type) :: settled(batch)
      real(dp), allocatable :: state(:)
      integer :: first, last, i, done
      logical :: keep_going

      allocate (motions(0))
      call check_train(train, error)
      if (allocated(error)) return
      call check_single(settings, frequency, error)
      if (starts < 1) call fatal(error, 'attractors: starts = '//text(starts)//': must be >= 1')
      if (allocated(error)) return
      call build_system(train, system)
      done = 0
      do first = 1, starts, batch
         last = min(first + batch - 1, starts)
         !$omp parallel do private(state) schedule(dynamic)
         do i = first, last
            state = random_state(system, random_seed, i)
            call settle(system, frequency, settings, state, settled(i - first + 1))
         end do
         !$omp end parallel do
         done = last
         do i = 1, last - first + 1
            call collect(settled(i), motions)
         end do
         if (.not. present(observer)) cycle
         keep_going = .true.
         call observer%on_step('attractors', done, frequency, keep_going)
         if (.not. keep_going) exit
      end do
      motions%share = motions%share/done
      call sort_by_share(motions)
   end subroutine attractors

   !> Mesh displacements and velocities uniform within three times the resting displacement; shafts untwisted.
   function random_state(system, seed, start) result(state)
      type(system_type), intent(in) :: system
      integer, intent(in) :: seed, start
      real(dp), allocatable :: state(:)
      real(dp) :: reach
      integer(int64) :: generator
      integer :: j

      generator = 1 + abs(mod(int(seed, int64)*1000003_int64 + int(start, int64)*7919_int64, 2147483646_int64))
      do j = 1, 10
         reach = uniform(generator)
      end do
      allocate (state(2*system%elements))
      state = resting_state(system)
      do j = 1, system%meshes
         associate (n => system%mesh_element(j))
            reach = 3*abs(state(n))
            state(n) = reach*(2*uniform(generator) - 1)
            state(system%elements + n) = reach*(2*uniform(generator) - 1)
         end associate
      end do
   end function random_state

   !> Park and Miller's minimal standard generator, in (0, 1).
   real(dp) function uniform(generator)
      integer(int64), intent(inout) :: generator

      generator = mod(48271_int64*generator, 2147483647_int64)
      uniform = real(generator, dp)/2147483647.0_dp
   end function uniform

   !> Counts a settled motion among those found, or adds it.
   subroutine collect(motion, motions)
      type(motion_type), intent(in) :: motion
      type(motion_type), allocatable, intent(inout) :: motions(:)
      integer :: i
      real(dp) :: scale

      if (motion%period == 0) return
      do i = 1, size(motions)
         if (motions(i)%period /= motion%period) cycle
         scale = max(maxval(abs(motion%maximum)), maxval(abs(motion%minimum)))
         if (any(abs(motions(i)%rms - motion%rms) > same*scale)) cycle
         if (any(abs(motions(i)%mean - motion%mean) > same*scale)) cycle
         if (any(abs(motions(i)%maximum - motion%maximum) > same*scale)) cycle
         motions(i)%share = motions(i)%share + 1
         return
      end do
      motions = [motions, motion]
      motions(size(motions))%share = 1
   end subroutine collect

   pure subroutine sort_by_share(motions)
      type(motion_type), intent(inout) :: motions(:)
      type(motion_type) :: held
      integer :: i, j

      do i = 2, size(motions)
         held = motions(i)
         do j = i - 1, 1, -1
            if (motions(j)%share >= held%share) exit
            motions(j + 1) = motions(j)
         end do
         motions(j + 1) = held
      end do
   end subroutine sort_by_share

end module geartrain_motion_attractors
