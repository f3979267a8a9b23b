!> Taylor series in time of the excitation, and of the solution of the equations of motion with constant contacts.
module geartrain_flow_taylor
   use geartrain_base_kinds, only: dp
   use geartrain_flow_dry_friction, only: friction_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: accelerate, add_waves, last_term, recur, series_value, series_values, sum_series

contains

   !> Computes the Taylor coefficients of displacements and velocities by the recurrence p(k+1) = v(k)/(k+1), v(k+1) = (-W phi(k) +
   !> s(k))/(k+1) with phi = kappa (p - origin) + damping v. The columns of element n are the numbers (n-1)*columns + 1 ..
   !> n*columns, so that most lines are long loops over all elements.
   pure subroutine recur(columns, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, &
                         loop, friction, work, p, v)
      !> Number of columns (state and tangents), elements and meshes; order of the series.
      integer, intent(in) :: columns, elements, meshes, order
      !> Last Taylor coefficient of kappa that counts, (mesh); negative: kappa is constant and part of `spring`.
      integer, intent(in) :: terms(meshes)
      !> Constant stiffness over mean stiffness, 0 where kappa varies, and damping gamma in the present contact [1].
      real(dp), intent(in) :: spring(elements), damping(elements)
      !> Taylor coefficients of kappa in the present contact; displacement at which the elastic force of the mesh is 0 [1].
      real(dp), intent(in) :: kappa(0:order, meshes), origin(meshes)
      !> Taylor coefficients of the accelerations by excitation, and of the displacements of the elements that close loops where the
      !> coordinates are 0, (0:order + 1, loop) [1].
      real(dp), intent(in) :: excitation(0:order, elements), loop(0:, :)
      type(system_type), intent(in) :: system
      !> Dry friction of couplings, prepared; gets its forces.
      type(friction_type), intent(inout) :: friction
      !> Work space; Taylor coefficients of displacement and velocity [1], of which coefficient 0 of the coordinates is given.
      real(dp), intent(inout) :: work(columns*elements, 4), p(columns*elements, 0:order), v(columns*elements, 0:order)

      ! Each constant makes the compiler a procedure of its own, whose loops over the columns of an element are no loops.
      select case (columns)
      case (1)
         call recur_columns(1, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, loop, friction, &
                            work, p, v)
      case (2)
         call recur_columns(2, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, loop, friction, &
                            work, p, v)
      case default
         call recur_columns(columns, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, loop, &
                            friction, work, p, v)
      end select
   end subroutine recur

   !> The recurrence of `recur`, whose arguments it has.
   pure subroutine recur_columns(columns, elements, meshes, order, spring, damping, terms, kappa, system, origin, excitation, &
                                 loop, friction, work, p, v)
      integer, intent(in) :: columns, elements, meshes, order
      integer, intent(in) :: terms(meshes)
      real(dp), intent(in) :: spring(elements), damping(elements)
      real(dp), intent(in) :: kappa(0:order, meshes), origin(meshes)
      real(dp), intent(in) :: excitation(0:order, elements), loop(0:, :)
      type(system_type), intent(in) :: system
      type(friction_type), intent(inout) :: friction
      real(dp), intent(inout) :: work(columns*elements, 4), p(columns*elements, 0:order), v(columns*elements, 0:order)
      real(dp) :: inverse
      integer :: first, last, n, i, j, k, l, count, all_

      associate (phi => work(:, 1), own => work(:, 2), gamma => work(:, 3), k_spring => work(:, 4))
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
               count = min(k, terms(j)) + 1
               ! Four terms at a time: each passes over phi once.
               do l = 0, count - 4, 4
                  phi(first:last) = phi(first:last) + (kappa(l, j)*p(first:last, k - l) &
                                                       + kappa(l + 1, j)*p(first:last, k - l - 1) &
                                                       + kappa(l + 2, j)*p(first:last, k - l - 2) &
                                                       + kappa(l + 3, j)*p(first:last, k - l - 3))
               end do
               do l = count - mod(max(count, 0), 4), count - 1
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
            if (friction%count > 0) call friction%act(system, columns, k, loop, v(:all_, k + 1))
            v(:all_, k + 1) = inverse*v(:all_, k + 1)
            call close_loops(columns, system, loop, k + 1, p(:, k + 1), v(:, k + 1))
         end do
      end associate
   end subroutine recur_columns

   !> Adds the accelerations of the coordinates by a force in an element.
   pure subroutine accelerate(system, element, force, acceleration)
      !> The train.
      type(system_type), intent(in) :: system
      !> Number of the element.
      integer, intent(in) :: element
      !> Taylor coefficients of the force over k b_c [1], (0:order).
      real(dp), intent(in) :: force(0:)
      !> Taylor coefficients of the accelerations [1], (0:order, element).
      real(dp), intent(inout) :: acceleration(0:, :)
      integer :: i, n

      do n = 1, system%coordinates
         if (n == element) acceleration(:, n) = acceleration(:, n) - system%own(n)*force
         do i = system%first(n), system%first(n + 1) - 1
            if (system%neighbour(i) == element) acceleration(:, n) = acceleration(:, n) - system%coupling(i)*force
         end do
      end do
   end subroutine accelerate

   !> Sets coefficient k of the elements that close loops from coefficient k of the coordinates.
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

   !> Value of a Taylor series with vector coefficients by Horner's rule.
   pure subroutine sum_series(length, stride, order, series, h, value)
      !> Elements of the vector that are wanted; elements of each coefficient; order of the series.
      integer, intent(in) :: length, stride, order
      !> Taylor coefficients; time [1].
      real(dp), intent(in) :: series(stride, 0:order), h
      !> Value of the series.
      real(dp), intent(out) :: value(length)
      integer :: k

      value = series(:length, order)
      do k = order - 1, 0, -1
         value = value*h + series(:length, k)
      end do
   end subroutine sum_series

   !> Adds the Taylor coefficients at `time` of the sum over the harmonics h of Re(amplitude exp(i h phi)) with the phase
   !> phi = phase + frequency_ratio t + acceleration t**2/2. The recurrence follows from
   !> y' = i h (frequency_ratio + acceleration t) y.
   pure subroutine add_waves(harmonic, amplitude, phase, frequency_ratio, acceleration, time, coefficient)
      !> Harmonics of Lambda, (harmonic).
      integer, intent(in) :: harmonic(:)
      !> Their complex amplitudes, (harmonic).
      complex(dp), intent(in) :: amplitude(:)
      !> Phase [1] and Lambda [1] at time 0, and its rate of change [1]; time of the expansion [1].
      real(dp), intent(in) :: phase, frequency_ratio, acceleration, time
      !> Taylor coefficients, (0:order).
      real(dp), intent(inout) :: coefficient(0:)
      complex(dp) :: term, before, next
      real(dp) :: rate
      integer :: h, i, k

      do i = 1, size(harmonic)
         h = harmonic(i)
         term = amplitude(i)*exp(cmplx(0, h*(phase + (frequency_ratio + acceleration/2*time)*time), dp))
         rate = h*(frequency_ratio + acceleration*time)
         coefficient(0) = coefficient(0) + term%re
         if (abs(acceleration) > 0) then
            before = 0
            do k = 1, ubound(coefficient, 1)
               next = rate*term + h*acceleration*before
               before = term
               term = cmplx(-next%im, next%re, dp)/k
               coefficient(k) = coefficient(k) + term%re
            end do
         else
            do k = 1, ubound(coefficient, 1)
               term = cmplx(-term%im, term%re, dp)*(rate/k)
               coefficient(k) = coefficient(k) + term%re
            end do
         end if
      end do
   end subroutine add_waves

   !> Value of a Taylor series by Horner's rule.
   pure real(dp) function series_value(coefficient, time)
      !> Taylor coefficients, (0:order); time since the expansion [1].
      real(dp), intent(in) :: coefficient(0:), time
      integer :: k

      series_value = coefficient(ubound(coefficient, 1))
      do k = ubound(coefficient, 1) - 1, 0, -1
         series_value = series_value*time + coefficient(k)
      end do
   end function series_value

   !> Values of a Taylor series at several times.
   pure function series_values(coefficient, time) result(values)
      !> Taylor coefficients, (0:order); times since the expansion [1].
      real(dp), intent(in) :: coefficient(0:), time(:)
      real(dp) :: values(size(time))
      integer :: k

      values = coefficient(ubound(coefficient, 1))
      do k = ubound(coefficient, 1) - 1, 0, -1
         values = values*time + coefficient(k)
      end do
   end function series_values

   !> Index of the last coefficient that counts within a time `reach`: the last two terms are larger than the tolerance.
   pure integer function last_term(coefficient, reach, tolerance)
      !> Taylor coefficients, (0:order); time [1], from 1e10 on all coefficients count; largest sum of two terms to neglect.
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
