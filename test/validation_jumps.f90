!> Jumps and ranges of contact of the paper's train: what the branch says against what integration does.
module validation_jumps
   use fixtures, only: paper_train, settings_of
   use geartrain, only: back_collision_ranges, band_type, branch_type, dp, error_type, integrate, integration_settings_type, &
                        jump_type, jumps, locate_contact_edges, motion_type, response, response_settings_type, separation_ranges, &
                        solutions_at
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: jumps_tests

contains

   subroutine jumps_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('against_integration')) call against_integration(tests)
      if (tests%runs('independent_of_step')) call independent_of_step(tests)
   end subroutine jumps_tests

   !> A short way before each jump integration stays on the stable motion that ends; as far beyond it goes where the branch says.
   subroutine against_integration(tests)
      class(tests_type), intent(inout) :: tests
      real(dp), parameter :: way = 0.002_dp
      !> Folds of figure 3 (claim 41: 0.4621, 0.7923 and 1.6645 jump up, 0.4586 and 1.5473 down) and the ends of stability.
      character(9), parameter :: kind(*) = [character(9) :: 'jump down', 'jump up', 'jump down', 'jump up', 'jump down', &
                                            'jump up', 'jump down', 'jump up', 'leaves', 'leaves']
      logical, parameter :: rising(*) = [.false., .true., .false., .false., .true., .true., .false., .true., .true., .false.]
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(jump_type), allocatable :: found(:)
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: here, beyond
      type(integration_settings_type) :: integration
      type(error_type), allocatable :: error
      character(32) :: name
      integer :: i, nearest
      real(dp) :: side

      settings = settings_of(0.2_dp, 2.6_dp, 12)
      call response(paper_train(), settings, branch, error)
      found = jumps(branch)
      call tests%is_true(size(found) == size(kind), 'ten ends of stable motions')
      if (size(found) /= size(kind)) return
      integration%max_periods = 20000
      do i = 1, size(found)
         write (name, '(a, f7.4)') 'at Lambda ', found(i)%frequency_ratio
         call tests%is_text(trim(found(i)%kind), trim(kind(i)), 'kind '//name)
         call tests%is_true(found(i)%rising .eqv. rising(i), 'direction of the sweep '//name)
         side = merge(1, -1, found(i)%rising)
         call solutions_at(paper_train(), settings, branch, found(i)%frequency_ratio - side*way, motions, error)
         nearest = stable_nearest(motions, found(i)%before)
         call tests%is_true(nearest > 0, 'a stable motion before the jump '//name)
         if (nearest == 0) cycle
         call integrate(paper_train(), motions(nearest)%frequency_ratio, integration, here, error, start=motions(nearest))
         call tests%is_close(norm2(here%rms - motions(nearest)%rms)/norm2(here%rms), 0.0_dp, 1e-2_dp, 'before the jump '//name)
         call integrate(paper_train(), found(i)%frequency_ratio + side*way, integration, beyond, error, start=here)
         if (kind(i) == 'leaves') then
            call tests%is_true(beyond%period /= 1, 'no motion of the branch beyond '//name)
         else
            call solutions_at(paper_train(), settings, branch, beyond%frequency_ratio, motions, error)
            nearest = stable_nearest(motions, found(i)%after)
            call tests%is_true(nearest > 0, 'a stable motion after the jump '//name)
            if (nearest == 0) cycle
            call tests%is_close(norm2(beyond%rms - motions(nearest)%rms)/norm2(beyond%rms), 0.0_dp, 1e-2_dp, &
                                'after the jump '//name)
         end if
      end do
   end subroutine against_integration

   !> Index of the stable motion whose rms is nearest; 0 where none is stable.
   pure integer function stable_nearest(motions, rms) result(nearest)
      type(motion_type), intent(in) :: motions(:)
      real(dp), intent(in) :: rms(:)
      integer :: k

      nearest = 0
      do k = 1, size(motions)
         if (.not. motions(k)%stable) cycle
         if (nearest == 0) nearest = k
         if (norm2(motions(k)%rms - rms) < norm2(motions(nearest)%rms - rms)) nearest = k
      end do
   end function stable_nearest

   !> The edges of the ranges do not depend on the step: a twentieth of it is the reference.
   subroutine independent_of_step(tests)
      class(tests_type), intent(inout) :: tests
      type(response_settings_type) :: settings
      type(branch_type) :: coarse, fine
      type(error_type), allocatable :: error
      integer :: mesh

      settings = settings_of(0.2_dp, 2.6_dp, 6)
      settings%stability = .false.
      settings%step = 0.025_dp
      call response(paper_train(), settings, coarse, error)
      settings%step = 0.0025_dp
      call response(paper_train(), settings, fine, error)
      call compare_all(3e-4_dp, 'interpolated')
      ! Located to 1e-7 of the backlash, of points at whatever distance.
      settings%step = 0.05_dp
      call response(paper_train(), settings, coarse, error)
      call locate_contact_edges(paper_train(), settings, coarse)
      call locate_contact_edges(paper_train(), settings, fine)
      call compare_all(1e-7_dp, 'located')
      call tests%is_true(size(separation_ranges(fine, 1, .true.)) == 0, 'no stability asked for: no stable ranges')

   contains

      subroutine compare_all(tolerance, how)
         real(dp), intent(in) :: tolerance
         character(*), intent(in) :: how

         do mesh = 1, 2
            call compare(separation_ranges(coarse, mesh, .false.), separation_ranges(fine, mesh, .false.), 4 - mesh, tolerance, &
                         'separation, '//how)
            call compare(back_collision_ranges(coarse, mesh, .false.), back_collision_ranges(fine, mesh, .false.), mesh - 1, &
                         tolerance, 'back collision, '//how)
         end do
      end subroutine compare_all

      subroutine compare(a, b, expected, tolerance, name)
         type(band_type), intent(in) :: a(:), b(:)
         integer, intent(in) :: expected
         real(dp), intent(in) :: tolerance
         character(*), intent(in) :: name

         call tests%is_true(size(a) == expected .and. size(b) == expected, name//': number of ranges')
         if (size(a) /= expected .or. size(b) /= expected) return
         call tests%is_close(maxval([0.0_dp, abs(a%from - b%from), abs(a%to - b%to)]), 0.0_dp, tolerance, name//': edges')
      end subroutine compare

   end subroutine independent_of_step

end module validation_jumps
