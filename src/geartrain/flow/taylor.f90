!> Taylor series in time: of the excitation, and of the solution of the equations of motion along constant contacts.
module geartrain_flow_taylor
   use geartrain_base_kinds, only: dp
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: add_waves, last_term, recur, sum_series

contains

   !> The recurrence: p(k+1) = v(k)/(k+1), v(k+1) = (-W phi(k) + s(k))/(k+1) with phi = kappa (p - origin) + damping v, kappa of a
   !> mesh a series where it has terms (`terms` >= 0), else `spring`. The columns of element n are the numbers
   !> (n-1)*columns + 1 .. n*columns, so that most lines are long loops over all elements.
   pure subroutine recur(columns, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, &
                         loop, phi, p, v)
      integer, intent(in) :: columns, elements, meshes, order, terms(meshes)
      real(dp), intent(in) :: spring(elements), damping(elements), kappa(0:order, meshes), origin(meshes), &
                              excitation(0:order, elements), loop(0:, :)
      type(system_type), intent(in) :: system
      real(dp), intent(inout) :: phi(columns*elements), p(columns*elements, 0:order), v(columns*elements, 0:order)
      real(dp), dimension(columns*elements) :: own, gamma, k_spring
      real(dp) :: inverse
      integer :: first, last, n, i, j, k, l, all_

      do n = 1, elements
         first = (n - 1)*columns + 1
         last = n*columns
         own(first:last) = -system%own(n)
         gamma(first:last) = damping(n)
         k_spring(first:last) = spring(n)
      end do
      all_ = columns*system%coordinates
      call close_loops(columns, system, loop, 0, p(:, 0), v(:, 0))
      do k = 0, order - 1
         phi = gamma*v(:, k) + k_spring*p(:, k)
         do j = 1, meshes
            n = system%mesh_element(j)
            first = (n - 1)*columns + 1
            last = n*columns
            do l = 0, min(k, terms(j))
               phi(first:last) = phi(first:last) + kappa(l, j)*p(first:last, k - l)
            end do
            if (terms(j) >= 0) then
               phi(first) = phi(first) - origin(j)*kappa(k, j)
            else if (k == 0) then
               phi(first) = phi(first) - origin(j)*spring(n)
            end if
            if (k == 0) phi(first) = phi(first) - system%static_force(n)
         end do
         inverse = 1.0_dp/(k + 1)
         p(:all_, k + 1) = inverse*v(:all_, k)
         v(:all_, k + 1) = own(:all_)*phi(:all_)
         do n = 1, system%coordinates
            do i = system%first(n), system%first(n + 1) - 1
               associate (other => (system%neighbour(i) - 1)*columns, here => (n - 1)*columns)
                  do l = 1, columns
                     v(here + l, k + 1) = v(here + l, k + 1) - system%coupling(i)*phi(other + l)
                  end do
               end associate
            end do
            first = (n - 1)*columns + 1
            v(first, k + 1) = v(first, k + 1) + excitation(k, n)
         end do
         v(:all_, k + 1) = inverse*v(:all_, k + 1)
         call close_loops(columns, system, loop, k + 1, p(:, k + 1), v(:, k + 1))
      end do
   end subroutine recur

   !> Coefficient k of the elements that close loops, from those of the coordinates.
   pure subroutine close_loops(columns, system, loop, k, p, v)
      integer, intent(in) :: columns, k
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: loop(0:, :)
      real(dp), intent(inout) :: p(:), v(:)
      integer :: all_, i, l, place

      all_ = columns*system%coordinates
      do i = 1, size(loop, 2)
         place = all_ + (i - 1)*columns
         do l = 1, columns
            p(place + l) = dot_product(system%network%loop(i, :), p(l:all_:columns))
            v(place + l) = dot_product(system%network%loop(i, :), v(l:all_:columns))
         end do
         p(place + 1) = p(place + 1) + loop(k, i)
         v(place + 1) = v(place + 1) + (k + 1)*loop(k + 1, i)
      end do
   end subroutine close_loops

   !> Value at h of a series with vector coefficients, the first `length` of `stride` numbers each, by Horner's rule.
   pure subroutine sum_series(length, stride, order, series, h, value)
      integer, intent(in) :: length, stride, order
      real(dp), intent(in) :: series(stride, 0:order), h
      real(dp), intent(out) :: value(length)
      integer :: k

      value = series(:length, order)
      do k = order - 1, 0, -1
         value = value*h + series(:length, k)
      end do
   end subroutine sum_series

   !> Adds the Taylor coefficients in time of the sum over h of Re(amplitude(h) exp(i h frequency t)).
   pure subroutine add_waves(amplitude, frequency_ratio, time, coefficient)
      complex(dp), intent(in) :: amplitude(:)
      real(dp), intent(in) :: frequency_ratio, time
      real(dp), intent(inout) :: coefficient(0:)
      complex(dp) :: term
      real(dp) :: rate
      integer :: h, k

      do h = 1, size(amplitude)
         rate = h*frequency_ratio
         term = amplitude(h)*exp(cmplx(0, rate*time, dp))
         coefficient(0) = coefficient(0) + term%re
         do k = 1, ubound(coefficient, 1)
            term = cmplx(-term%im, term%re, dp)*(rate/k)
            coefficient(k) = coefficient(k) + term%re
         end do
      end do
   end subroutine add_waves

   !> Index of the last coefficient that matters within `reach`.
   pure integer function last_term(coefficient, reach, tolerance)
      real(dp), intent(in) :: coefficient(0:), reach, tolerance
      real(dp) :: power

      last_term = ubound(coefficient, 1)
      if (.not. reach < 1e10_dp) return
      power = reach**last_term
      do while (last_term > 1)
         if (abs(coefficient(last_term))*power + abs(coefficient(last_term - 1))*power/reach > tolerance) exit
         last_term = last_term - 1
         power = power/reach
      end do
   end function last_term

end module geartrain_flow_taylor
