!> Random trains whose slow modes take thousands of mesh periods to settle, the same on every machine; and one that rattles.
module slow_trains
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain, only: dp, motion_type, shaft_type, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_model_system, only: system_type
   use geartrain_motion_flow, only: flow_type
   implicit none (type, external)
   private
   public :: nearest_approach, rattling_pair, slow_train, uniform

contains

   !> The next train of a list, and Lambda, in the natural frequency of the first mesh alone: 2 to 5 flexible shafts of damping
   !> ratio .005 to .04, meshes with backlash, of damping ratio .01 to .06.
   subroutine slow_train(generator, train, frequency)
      !> State of the generator; 1 begins the list.
      integer(int64), intent(inout) :: generator
      type(train_type), intent(out) :: train
      real(dp), intent(out) :: frequency
      real(dp) :: inverse
      integer :: i, m

      m = min(4, 1 + int(uniform(generator, 0.0_dp, 4.0_dp)))
      train%title = 'random'
      train%input_torque = uniform(generator, 40.0_dp, 250.0_dp)
      train%prime_mover_inertia = logarithmic(generator, 1e-3_dp, 0.03_dp)
      train%load_inertia = logarithmic(generator, 1e-3_dp, 0.03_dp)
      train%characteristic_length = 30e-6_dp
      allocate (train%shafts(m + 1), train%meshes(m))
      do i = 1, m + 1
         train%shafts(i)%stiffness = logarithmic(generator, 3e4_dp, 3e6_dp)
         train%shafts(i)%damping_ratio = uniform(generator, 0.005_dp, 0.04_dp)
      end do
      do i = 1, m
         associate (mesh => train%meshes(i))
            mesh%driving_radius = uniform(generator, 0.03_dp, 0.08_dp)
            mesh%driven_radius = mesh%driving_radius*uniform(generator, 1.0_dp, 2.5_dp)
            mesh%driving_inertia = 0.002_dp*(mesh%driving_radius/0.05_dp)**4*uniform(generator, 0.5_dp, 2.0_dp)
            mesh%driven_inertia = 0.002_dp*(mesh%driven_radius/0.05_dp)**4*uniform(generator, 0.5_dp, 2.0_dp)
            mesh%stiffness = uniform(generator, 1e8_dp, 6e8_dp)
            mesh%damping_ratio = uniform(generator, 0.01_dp, 0.06_dp)
            mesh%half_backlash = uniform(generator, 10e-6_dp, 50e-6_dp)
            mesh%stiffness_cos = [uniform(generator, 0.1_dp, 0.4_dp)]
            mesh%stiffness_sin = [uniform(generator, -0.2_dp, 0.2_dp)]
            mesh%order = 1 + int(uniform(generator, 0.0_dp, 2.5_dp))
         end associate
      end do
      associate (mesh => train%meshes(1))
         inverse = mesh%driving_radius**2/mesh%driving_inertia + mesh%driven_radius**2/mesh%driven_inertia
         train%characteristic_frequency = sqrt(mesh%stiffness*inverse)
      end associate
      frequency = uniform(generator, 0.3_dp, 2.0_dp)
   end subroutine slow_train

   !> The first pair of the paper's train alone, under a torque that swings by 10 N m.
   function rattling_pair(torque) result(train)
      !> Mean torque [N m].
      real(dp), intent(in) :: torque
      type(train_type) :: train

      train%title = 'rattling pair'
      train%input_torque = torque
      train%torque_cos = [10.0_dp]
      train%characteristic_length = 30e-6_dp
      train%characteristic_frequency = 9870
      train%shafts = [shaft_type(rigid=.true.), shaft_type(rigid=.true.)]
      allocate (train%meshes(1))
      train%meshes%driving_radius = 0.05_dp
      train%meshes%driven_radius = 0.1_dp
      train%meshes%driving_inertia = 0.0023_dp
      train%meshes%driven_inertia = 0.037_dp
      train%meshes%stiffness = 2.5e8_dp
      train%meshes%damping_ratio = 0.05_dp
      train%meshes%half_backlash = 30e-6_dp
      train%meshes(1)%stiffness_cos = [0.3_dp]
   end function rattling_pair

   !> How near the flow from a state comes to a motion within some mesh periods, over how far it was: by nothing but integration.
   !> Ends where it is near enough.
   real(dp) function nearest_approach(system, start, motion, enough, periods) result(nearest)
      type(system_type), intent(in) :: system
      !> (2*elements) at phase 0.
      real(dp), intent(in) :: start(:)
      type(motion_type), intent(in) :: motion
      real(dp), intent(in) :: enough
      integer, intent(in) :: periods
      type(flow_type) :: flow
      integer :: k

      call flow%setup(system, 1, 20, 1e-15_dp)
      flow%x(1, :) = start
      nearest = 1
      do k = 1, periods
         call flow%start(motion%frequency, 0.0_dp)
         call flow%advance(2*pi/motion%frequency)
         nearest = min(nearest, maxval(abs(flow%x(1, :) - motion%state))/maxval(abs(start - motion%state)))
         if (nearest <= enough) return
      end do
   end function nearest_approach

   !> Park and Miller's minimal standard generator, from `least` to `most`.
   real(dp) function uniform(generator, least, most)
      integer(int64), intent(inout) :: generator
      real(dp), intent(in) :: least, most

      generator = mod(48271_int64*generator, 2147483647_int64)
      uniform = least + (most - least)*real(generator, dp)/2147483647.0_dp
   end function uniform

   real(dp) function logarithmic(generator, least, most)
      integer(int64), intent(inout) :: generator
      real(dp), intent(in) :: least, most

      logarithmic = least*exp(uniform(generator, 0.0_dp, log(most/least)))
   end function logarithmic

end module slow_trains
