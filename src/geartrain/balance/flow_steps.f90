!> The steps of the linearised train in time (linear_flow.f90), which flow_steps.c takes, and the masses that they need.
module geartrain_balance_flow_steps
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_base_kinds, only: dp
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: add_influence, mass_of_steps, take_steps, take_steps_back, transpose_steps

   ! flow_steps.c has the shapes.
   interface
      !> Transposes numbers at the steps of a period to numbers of all segments side by side, or back.
      pure subroutine transpose_steps(rows, columns, from, to) bind(c, name='geartrain_transpose')
         import :: c_double, c_int
         implicit none (type, external)
         !> Numbers of rows and columns, of which one is that of the segments.
         integer(c_int), value :: rows, columns
         !> (row, column).
         real(c_double), intent(in) :: from(*)
         !> (column, row).
         real(c_double), intent(inout) :: to(*)
      end subroutine transpose_steps

      !> Takes the steps of all segments.
      pure subroutine take_steps(elements, unknowns, steps, element, h, mass, spring, damper, stiffness, drive, p, v, y) &
         bind(c, name='geartrain_flow_steps')
         import :: c_double, c_int
         implicit none (type, external)
         !> Numbers of elements, of unknown meshes and of steps of a segment.
         integer(c_int), value :: elements, unknowns, steps
         !> Length of a step.
         real(c_double), value :: h
         !> Element of each unknown mesh.
         integer(c_int), intent(in) :: element(*)
         !> See `mass_of_steps`; stiffness of the linear elements and damping of all; stiffness of the unknown meshes along the
         !> motion, and their force besides.
         real(c_double), intent(in), dimension(*) :: mass, spring, damper, stiffness, drive
         !> Displacements and velocities at the beginning, then at the end; displacements of the unknown meshes.
         real(c_double), intent(inout), dimension(*) :: p, v, y
      end subroutine take_steps

      !> Adds what forces at the steps add to the end states of the segments.
      pure subroutine add_influence(states, steps, influence, force, added) bind(c, name='geartrain_add_influence')
         import :: c_double, c_int
         implicit none (type, external)
         !> Numbers of values of a state and of steps.
         integer(c_int), value :: states, steps
         !> As of `take_steps_back`; force at each step.
         real(c_double), intent(in), dimension(*) :: influence, force
         !> The end states.
         real(c_double), intent(inout), dimension(*) :: added
      end subroutine add_influence

      !> Carries functionals of the end states back over the steps, to the states at the beginnings.
      pure subroutine take_steps_back(elements, unknowns, steps, functionals, element, h, mass, spring, damper, stiffness, row, p, &
                                      v, force, influence) bind(c, name='geartrain_carry_back')
         import :: c_double, c_int
         implicit none (type, external)
         !> As of `take_steps`; number of functionals.
         integer(c_int), value :: elements, unknowns, steps, functionals
         !> Length of a step.
         real(c_double), value :: h
         !> Element of each unknown mesh.
         integer(c_int), intent(in) :: element(*)
         !> As of `take_steps`; weights of the last functional, a sum over the steps.
         real(c_double), intent(in), dimension(*) :: mass, spring, damper, stiffness, row
         !> Factors of displacements and velocities; work space; what a force at a step adds to the functionals.
         real(c_double), intent(inout), dimension(*) :: p, v, force, influence
      end subroutine take_steps_back
   end interface

contains

   !> Velocity that forces take in a step: h W for infinitely small steps, and such that the modes of the train in contact keep
   !> their frequencies: 2 - 2 cos(h omega) in place of (h omega)**2, by its power series.
   pure function mass_of_steps(system, h) result(mass)
      type(system_type), intent(in) :: system
      !> Length of a step [1].
      real(dp), intent(in) :: h
      !> (element, element).
      real(dp), dimension(system%elements, system%elements) :: mass
      real(dp), dimension(system%elements, system%elements) :: w, stiff, drag, term
      integer, parameter :: terms = 12
      integer :: j, k, n

      w = 0
      do n = 1, system%elements
         w(n, n) = system%own(n)
         do k = system%first(n), system%first(n + 1) - 1
            w(n, system%neighbour(k)) = w(n, system%neighbour(k)) + system%coupling(k)
         end do
      end do
      do n = 1, system%elements
         stiff(n, :) = h**2*system%spring(n)*w(n, :)
         drag(:, n) = h/2*w(:, n)*system%damping(n)
      end do
      term = h*w
      mass = term
      do j = 0, terms
         term = -matmul(term, stiff)/((2*j + 3)*(2*j + 4))
         mass = mass + term
      end do
      ! Damping acts by the velocity half a step before.
      mass = mass - matmul(drag, mass - matmul(drag, mass)/2)
   end function mass_of_steps

end module geartrain_balance_flow_steps
