!> Random trees and loops of gears.
module networks
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: body, uniform
   use geartrain, only: dp, mesh_type, shaft_type, train_type
   implicit none (type, external)
   private
   public :: draw_laws, random_network

contains

   !> A tree of bodies with shafts and meshes as the dice fall, and as many meshes more as there are loops; some idle, some linear.
   subroutine random_network(bodies, loops, seed, train)
      integer, intent(in) :: bodies, loops, seed
      type(train_type), intent(out) :: train
      character(8) :: name(bodies)
      real(dp) :: radius(bodies), dice
      integer :: i, parent, sense(bodies)
      integer(int64) :: generator
      type(mesh_type) :: mesh
      type(shaft_type) :: shaft

      generator = 7919*seed
      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 1e4_dp
      allocate (train%bodies(bodies), train%shafts(0), train%meshes(0))
      do i = 1, bodies
         write (name(i), '(a, i0)') 'b', i
         train%bodies(i) = body(name(i), 1e-3_dp*(1 + 4*share()), balances=i == bodies)
         radius(i) = 0.03_dp + 0.05_dp*share()
      end do
      train%bodies(1)%torque = 60 + 60*share()
      train%bodies(1)%torque_cos = [5*share()]
      train%bodies(2)%torque = -10*share()
      sense(1) = 1
      do i = 2, bodies
         parent = 1 + int((i - 1)*share()*0.999_dp)
         dice = share()
         if (i > 2 .and. dice < 0.3_dp) then
            radius(i) = radius(parent)
            sense(i) = sense(parent)
            shaft = shaft_type(between=[character(64) :: name(parent), name(i)], stiffness=1e5_dp*(1 + 9*share()), &
                               damping_ratio=0.05_dp)
            train%shafts = [train%shafts, shaft]
         else
            sense(i) = -sense(parent)
            call add_mesh(parent, i)
         end if
      end do
      do i = 1, loops
         call add_mesh(1 + i, bodies + 1 - i)
      end do

   contains

      real(dp) function share()
         share = uniform(generator, 0.0_dp, 1.0_dp)
      end function share

      subroutine add_mesh(a, b)
         integer, intent(in) :: a, b
         real(dp) :: size_

         size_ = 0.5_dp + share()
         mesh = mesh_type(between=[character(64) :: name(a), name(b)], driving_radius=size_*radius(a), &
                          driven_radius=size_*radius(b), stiffness=1e8_dp*(1 + 2*share()), damping_ratio=0.1_dp)
         mesh%internal = sense(a) == sense(b)
         if (share() < 0.85_dp) then
            mesh%half_backlash = 1e-5_dp*(1 + share())
            mesh%stiffness_cos = [0.3_dp*share(), 0.1_dp*share()]
            mesh%stiffness_sin = [0.2_dp*share()]
         end if
         if (share() < 0.5_dp) mesh%error_cos = [2e-6_dp*share()]
         train%meshes = [train%meshes, mesh]
      end subroutine add_mesh

   end subroutine random_network

   !> Damping in contact only, in every second mesh on average, and back flanks of their own.
   subroutine draw_laws(seed, train)
      integer, intent(in) :: seed
      type(train_type), intent(inout) :: train
      integer(int64) :: generator
      integer :: i

      generator = 1000 + seed
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i))
            if (.not. mesh%half_backlash > 0) cycle
            if (uniform(generator, 0.0_dp, 1.0_dp) < 0.6_dp) mesh%damping_acts = 'contact'
            mesh%back_stiffness = mesh%stiffness*uniform(generator, 0.4_dp, 2.0_dp)
            mesh%back_phase = uniform(generator, -3.0_dp, 3.0_dp)
         end associate
      end do
   end subroutine draw_laws

end module networks
