!> A single gear pair integrated until it is steady, then refined: fpm run --profile release --example time_integration
program time_integration
   use geartrain, only: dp, error_type, integrate, integration_settings_type, motion_type, refine, shaft_type, train_type
   implicit none (type, external)
   type(train_type) :: train
   type(integration_settings_type) :: settings
   type(motion_type) :: motion
   type(error_type), allocatable :: error

   train%input_torque = 100                                   ! N m
   train%characteristic_length = 20e-6_dp                     ! m
   train%characteristic_frequency = 20000                     ! rad/s
   train%shafts = [shaft_type(rigid=.true.), shaft_type(rigid=.true.)]
   allocate (train%meshes(1))
   train%meshes(1)%driving_radius = 0.05_dp                   ! m
   train%meshes(1)%driven_radius = 0.05_dp
   train%meshes(1)%driving_inertia = 0.002_dp                 ! kg m^2
   train%meshes(1)%driven_inertia = 0.002_dp
   train%meshes(1)%stiffness = 2e8_dp                         ! N/m
   train%meshes(1)%damping_ratio = 0.05_dp
   train%meshes(1)%half_backlash = 20e-6_dp                   ! m
   train%meshes(1)%stiffness_cos = [0.3_dp]

   call integrate(train, 0.9_dp, settings, motion, error)
   if (.not. allocated(error)) call refine(train, motion, error)
   if (allocated(error)) then
      print '(a)', error%message
      error stop
   end if
   print '(a, i0, a, l1)', 'period ', motion%period, ', stable ', motion%stable
   print '(3(a, f9.6))', 'rms', motion%rms(1), ', from', motion%minimum(1), ' to', motion%maximum(1)
end program time_integration

! It prints:
! period 1, stable T
! rms 0.454936, from 1.071172 to 1.980928
