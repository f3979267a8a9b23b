!> Hunting orders, 71 and 19 of a two-stage reducer: the harmonics that a balance carries where the program chooses them, against
!> time integration and shooting.
module validation_hunting
   use fixtures, only: reducer
   use geartrain, only: branch_type, dp, error_type, motion_type, refine, response, response_settings_type, solutions_at, &
      train_type
   use testing, only: full, nightly, tests_type
   implicit none (type, external)
   private
   public :: hunting_tests

contains

   subroutine hunting_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('in_contact')) call in_contact(tests)
      if (tests%runs('apart', nightly)) call apart(tests)
      if (tests%runs('both_apart', full)) call both_apart(tests)
   end subroutine hunting_tests

   !> The reducer with mesh stiffness by ISO 6336-1 and three harmonics of the rectangular wave averaged over the face. Lambda is
   !> the speed of the motor over 1000 rpm.
   function iso_reducer() result(train)
      type(train_type) :: train

      train = reducer()
      train%meshes%stiffness = [778.62671e6_dp, 1330.72142e6_dp]
      train%meshes(1)%stiffness_cos = [0.0743511_dp, 0.0146892_dp, -0.00065245_dp]
      train%meshes(2)%stiffness_cos = [0.0815484_dp, 0.00478257_dp, 0.0045966_dp]
   end function iso_reducer

   !> 1500 rpm, in contact: a few harmonics do. Integration of another conversion of the drawing gives rms 0.610949 and 0.589583 um
   !> and largest forces of 3495.3 and 8144.3 N, which these figures meet to the accuracy of the conversion.
   subroutine in_contact(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type) :: motion

      call compare(tests, '1500 rpm', 1.49_dp, 1.51_dp, 1.5_dp, branch, motion)
      call tests%is_true(carried(motion) <= 40, '1500 rpm: at most 40 harmonics')
      call tests%is_close(maxval(abs(motion%rms/[0.610949_dp, 0.589583_dp] - 1)), 0.0_dp, 0.02_dp, '1500 rpm: rms of the drawing')
      call tests%is_close(maxval(abs(motion%mesh_load%force_maximum/[3495.3_dp, 8144.3_dp] - 1)), 0.0_dp, 0.01_dp, &
                          '1500 rpm: forces of the drawing')
      call tests%is_true(size(branch%orders) < branch%harmonics, '1500 rpm: the branch lists the carried harmonics only')
   end subroutine in_contact

   !> 1680 rpm: mesh 1 is apart for 29 % of the time.
   subroutine apart(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type) :: motion

      call compare(tests, '1680 rpm', 1.72_dp, 1.679_dp, 1.68_dp, branch, motion)
      call tests%is_close(motion%mesh_load(1)%separation, 0.29_dp, 0.01_dp, '1680 rpm: mesh 1 is apart')
      call tests%is_true(carried(motion) < 300, '1680 rpm: fewer than 300 of the harmonics')
   end subroutine apart

   !> 3060 rpm: both meshes are apart for a fifth of the time.
   subroutine both_apart(tests)
      class(tests_type), intent(inout) :: tests
      type(branch_type) :: branch
      type(motion_type) :: motion

      call compare(tests, '3060 rpm', 3.16_dp, 3.059_dp, 3.06_dp, branch, motion)
      call tests%is_true(minval(motion%mesh_load%separation) > 0.15_dp, '3060 rpm: both meshes are apart')
   end subroutine both_apart

   !> Traces a response, and compares its first motion at one speed with the orbit that shooting finds next to it.
   subroutine compare(tests, name, start, stop, at, branch, motion)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: name
      real(dp), intent(in) :: start, stop, at
      type(branch_type), intent(out) :: branch
      type(motion_type), intent(out) :: motion
      type(train_type) :: train
      type(response_settings_type) :: settings
      type(motion_type), allocatable :: motions(:)
      type(motion_type) :: exact
      type(error_type), allocatable :: error
      real(dp) :: off
      integer :: n

      train = iso_reducer()
      settings%start = start
      settings%stop = stop
      settings%harmonics = 0
      settings%tolerance = 1e-3_dp
      call response(train, settings, branch, error)
      call tests%is_true(branch%complete, name//': '//branch%ended%text)
      call solutions_at(train, settings, branch, at, motions, error)
      call tests%is_true(size(motions) > 0, name//': a motion')
      if (size(motions) == 0) return
      motion = motions(1)
      exact = motion
      call refine(train, exact, error)
      call tests%is_true(.not. allocated(error), name//': shooting converges')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(motion%rms/exact%rms - 1)), 0.0_dp, 1e-3_dp, name//': rms by shooting')
      n = min(size(motion%coefficients, 1), size(exact%coefficients, 1))
      off = sqrt((2*sum((motion%coefficients(1, :) - exact%coefficients(1, :))**2) &
                  + sum((motion%coefficients(2:n, :) - exact%coefficients(2:n, :))**2) + sum(exact%coefficients(n + 1:, :)**2)) &
                 /sum(exact%coefficients(2:, :)**2))
      call tests%is_true(off < 3*motion%error_estimate .and. off > motion%error_estimate/3, name//': the estimate holds')
      call tests%is_close(abs(abs(motion%multipliers(1)) - abs(exact%multipliers(1))), 0.0_dp, 0.02_dp, &
                          name//': largest multiplier')
   end subroutine compare

   !> Number of harmonics of a motion that are not 0.
   pure integer function carried(motion)
      type(motion_type), intent(in) :: motion
      integer :: k

      carried = count([(any(abs(motion%coefficients(2*k:2*k + 1, :)) > 0), k=1, size(motion%coefficients, 1)/2)])
   end function carried

end module validation_hunting
