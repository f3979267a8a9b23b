! A gear pair for AUTO-07p: p'' + 0.1 p' + (1 + kappa cos Lambda t) g(p) = 0.4 with half the backlash 1; u = p, p', cos, sin, the
! last two the oscillator that makes the equation autonomous. Parameters as in auto_train.f90.
subroutine func(ndim, u, icp, par, ijac, f, dfdu, dfdp)
   implicit none
   integer, intent(in) :: ndim, icp(*), ijac
   double precision, intent(in) :: u(ndim), par(*)
   double precision, intent(out) :: f(ndim)
   double precision, intent(inout) :: dfdu(ndim, ndim), dfdp(ndim, *)
   double precision :: force, slope, root(2), circle

   if (par(5) > 0) then
      root = sqrt((u(1) + [-1, 1])**2 + par(5)**2)
      force = u(1) + (root(1) - root(2))/2
      slope = 1 + ((u(1) - 1)/root(1) - (u(1) + 1)/root(2))/2
   else
      force = max(u(1) - 1, 0d0) + min(u(1) + 1, 0d0)
      slope = merge(1d0, 0d0, abs(u(1)) > 1)
   end if
   circle = 1 - u(3)**2 - u(4)**2
   f(1) = u(2)
   f(2) = 0.4d0 - 0.1d0*u(2) - (1 + par(2)*u(3))*force
   f(3) = u(3)*circle - par(1)*u(4)
   f(4) = u(4)*circle + par(1)*u(3)
   if (ijac == 0) return
   dfdu = 0
   dfdu(1, 2) = 1
   dfdu(2, :3) = [-(1 + par(2)*u(3))*slope, -0.1d0, -par(2)*force]
   dfdu(3, 3:4) = [circle - 2*u(3)**2, -par(1) - 2*u(3)*u(4)]
   dfdu(4, 3:4) = [par(1) - 2*u(3)*u(4), circle - 2*u(4)**2]
   if (ijac == 1) return
   dfdp(:, 1) = [0d0, 0d0, -u(4), u(3)]
   dfdp(:, 2) = [0d0, -u(3)*force, 0d0, 0d0]
end subroutine

subroutine stpnt(ndim, u, par, t)
   implicit none
   integer, intent(in) :: ndim
   double precision, intent(inout) :: u(ndim), par(*)
   double precision, intent(in) :: t
   double precision, parameter :: turn = 8*atan(1d0)

   par(1) = 2.6d0
   par(2) = 0
   par(5) = 0
   par(11) = turn/par(1)
   u = [1.4d0, 0d0, cos(turn*t), sin(turn*t)]
end subroutine

subroutine pvls
end subroutine
subroutine bcnd
end subroutine
subroutine icnd
end subroutine
subroutine fopt
end subroutine
