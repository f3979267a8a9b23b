! Figure 3's train for AUTO-07p. Displacements of the five elastic elements (shaft, mesh, shaft, mesh, shaft) over b_c, time times
! omega_c: u = p(5), p'(5), cos, sin; the last two are the oscillator that makes the system autonomous.
! par(1) = Lambda, par(2) = amplitude of the mesh stiffness, par(3:4) = rms of the meshes as the paper counts it,
! par(5) = width over which the corners of the backlash are rounded, 0: not at all.
module train
   implicit none
   double precision, parameter :: wc = 9870, gap = 30e-6, torque = 150
   double precision, parameter :: inertia(6) = [2.3d-7, 2.3d-3, 3.7d-2, 4.6d-3, 7.4d-2, 2.3d-7]   ! kg m^2
   double precision, parameter :: stiffness(5) = [1d3, 2.5d8, 1d8, 5d8, 1d3], ratio(5) = [1d-2, 5d-2, 1d-2, 5d-2, 1d-2]
   ! p(n) = left(n) theta(n) - right(n) theta(n+1)
   double precision, parameter :: left(5) = [1d0, 5d-2, 1d0, 5d-2, 1d0], right(5) = [1d0, 1d-1, 1d0, 1d-1, 1d0]
   ! Static force in each element; the torques at the ends are those that balance it.
   double precision, parameter :: load(5) = torque*[1d0, 2d1, 2d0, 4d1, 4d0]
   double precision, parameter :: damping(5) = 2*ratio*sqrt(stiffness/(left**2/inertia(:5) + right**2/inertia(2:)))
contains
   pure logical function is_mesh(n)
      integer, intent(in) :: n
      is_mesh = mod(n, 2) == 0
   end function

   ! Elastic force over b_c at displacement p, and its slope.
   pure subroutine spring(n, p, kappa, width, force, slope)
      integer, intent(in) :: n
      double precision, intent(in) :: p, kappa, width
      double precision, intent(out) :: force, slope
      double precision :: root(2)
      force = p
      slope = 1
      if (is_mesh(n)) then
         if (width > 0) then
            root = sqrt((p + [-1, 1])**2 + width**2)
            force = p + (root(1) - root(2))/2
            slope = 1 + ((p - 1)/root(1) - (p + 1)/root(2))/2
         else
            force = max(p - 1, 0d0) + min(p + 1, 0d0)
            slope = merge(1d0, 0d0, abs(p) > 1)
         end if
      end if
      force = stiffness(n)*force
      slope = stiffness(n)*slope
      if (is_mesh(n)) then
         force = force*kappa
         slope = slope*kappa
      end if
   end subroutine

   ! Element displacements of angles theta; what forces in the elements do to the angles.
   pure function gradient(theta) result(p)
      double precision, intent(in) :: theta(6)
      double precision :: p(5)
      p = left*theta(:5) - right*theta(2:)
   end function

   pure function angular_acceleration(force) result(a)
      double precision, intent(in) :: force(5)
      double precision :: a(6)
      a = [0d0, right*force]
      a(:5) = a(:5) - left*force
      a = a/(inertia*wc**2)
   end function
end module

subroutine func(ndim, u, icp, par, ijac, f, dfdu, dfdp)
   use train
   implicit none
   integer, intent(in) :: ndim, icp(*), ijac
   double precision, intent(in) :: u(ndim), par(*)
   double precision, intent(out) :: f(ndim)
   double precision, intent(inout) :: dfdu(ndim, ndim), dfdp(ndim, *)
   double precision :: force(5), slope(5), unit(5), circle
   integer :: n

   do n = 1, 5
      call spring(n, u(n), 1 + par(2)*u(11), par(5), force(n), slope(n))
   end do
   circle = 1 - u(11)**2 - u(12)**2
   f(1:5) = u(6:10)
   f(6:10) = gradient(angular_acceleration(force + damping*wc*u(6:10) - load/gap))
   f(11) = u(11)*circle - par(1)*u(12)
   f(12) = u(12)*circle + par(1)*u(11)
   if (ijac == 0) return

   dfdu = 0
   do n = 1, 5
      unit = 0
      unit(n) = 1
      dfdu(n, n + 5) = 1
      dfdu(6:10, n) = gradient(angular_acceleration(slope(n)*unit))
      dfdu(6:10, n + 5) = gradient(angular_acceleration(damping(n)*wc*unit))
   end do
   unit = 0
   do n = 2, 4, 2
      unit(n) = force(n)/(1 + par(2)*u(11))
   end do
   dfdu(6:10, 11) = par(2)*gradient(angular_acceleration(unit))
   dfdu(11, 11:12) = [circle - 2*u(11)**2, -par(1) - 2*u(11)*u(12)]
   dfdu(12, 11:12) = [par(1) - 2*u(11)*u(12), circle - 2*u(12)**2]
   if (ijac == 1) return

   dfdp(:, 1) = 0
   dfdp(11:12, 1) = [-u(12), u(11)]
   dfdp(:, 2) = 0
   dfdp(6:10, 2) = u(11)*gradient(angular_acceleration(unit))
end subroutine

! Starting motion: at rest under the load, constant mesh stiffness, Lambda = 2.6.
subroutine stpnt(ndim, u, par, t)
   use train
   implicit none
   integer, intent(in) :: ndim
   double precision, intent(inout) :: u(ndim), par(*)
   double precision, intent(in) :: t
   double precision, parameter :: turn = 8*atan(1d0)
   integer :: n

   par(1) = 2.6d0
   par(2) = 0
   par(5) = 0
   par(11) = turn/par(1)
   u = 0
   u(1:5) = load/(stiffness*gap)
   do n = 2, 4, 2
      u(n) = u(n) + 1
   end do
   u(11) = cos(turn*t)
   u(12) = sin(turn*t)
end subroutine

! What a point reports: rms of both meshes, the root of the sum of squared harmonic amplitudes.
subroutine pvls(ndim, u, par)
   implicit none
   integer, intent(in) :: ndim
   double precision, intent(in) :: u(ndim)
   double precision, intent(inout) :: par(*)
   double precision, external :: getp

   par(3) = sqrt(2*max(0d0, getp('NRM', 2, u)**2 - getp('INT', 2, u)**2))
   par(4) = sqrt(2*max(0d0, getp('NRM', 4, u)**2 - getp('INT', 4, u)**2))
end subroutine

subroutine bcnd
end subroutine
subroutine icnd
end subroutine
subroutine fopt
end subroutine
