!> The linear parts in the harmonic balance: displacement of each unknown mesh i under harmonic mesh forces,
!>    p_i + sum over j of H_ij phi_j = a_i,
!> j over the unknown meshes at the linear parts of mesh i; and the displacements of the other elements.
module geartrain_network_receptance
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_network_part, only: part_state_type, part_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: receptance_type, amplitude_at, find_receptance, linear_displacements

   type :: receptance_type
      !> H [1] and dH/dLambda [1], (entry of the graph of the unknowns); excitation a [1] and da/dLambda [1], (unknown).
      complex(dp), allocatable :: h(:), dh(:), a(:), da(:)
   end type receptance_type

contains

   !> Computes receptance and excitation at one harmonic.
   pure subroutine find_receptance(system, frequency_ratio, harmonic, eta, r, derivatives)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Harmonic >= 1 of Lambda/eta; sub-harmonic index.
      integer, intent(in) :: harmonic, eta
      !> Gets H, a and their derivatives; allocated where it has not the size.
      type(receptance_type), intent(inout) :: r
      !> .false.: the derivatives are not wanted, and may be anything.
      logical, intent(in), optional :: derivatives
      complex(dp) :: alpha(3), d_alpha(3)
      real(dp) :: omega, d_omega
      integer :: i, p
      logical :: wanted

      wanted = .true.
      if (present(derivatives)) wanted = derivatives
      associate (cut => system%cut)
         ! A train with another value of a parameter may couple meshes that are not coupled in this one, as damping that is 0.
         if (allocated(r%h)) then
            if (size(r%h) /= cut%graph%entries) deallocate (r%h, r%dh, r%a, r%da)
         end if
         if (.not. allocated(r%h)) allocate (r%h(cut%graph%entries), r%dh(cut%graph%entries), r%a(cut%unknowns), r%da(cut%unknowns))
         d_omega = system%characteristic_frequency*harmonic/eta
         omega = d_omega*frequency_ratio
         r%h = 0
         r%dh = 0
         do i = 1, cut%unknowns
            r%a(i) = amplitude_at(system%transmission_error(cut%mesh(i)), harmonic, eta)
         end do
         r%da = 0
         do p = 1, size(cut%part)
            associate (part => cut%part(p))
               if (size(part%at) == 0) cycle
               if (.not. part%has_closed_form()) then
                  call add_part(part, omega, d_omega, wanted, r)
               else
                  if (wanted) then
                     call part%receptance_of_two(omega, alpha, d_alpha)
                  else
                     call part%receptance_of_two(omega, alpha)
                  end if
                  call add_two(size(part%at), part%at, part%entry, part%gain, 1.0_dp, alpha, r%h)
                  if (wanted) call add_two(size(part%at), part%at, part%entry, part%gain, d_omega, d_alpha, r%dh)
               end if
               if (part%excited) call add_sources(system, p, omega, d_omega, harmonic, eta, r)
            end associate
         end do
      end associate
   end subroutine find_receptance

   !> Adds gain times factor times receptance of a part of one or two masses, real and imaginary part by themselves: gfortran makes
   !> a complex number of a real factor.
   pure subroutine add_two(ports, at, entry, gain, factor, alpha, h)
      integer, intent(in) :: ports, at(ports), entry(ports, ports)
      real(dp), intent(in) :: gain(ports, ports), factor
      complex(dp), intent(in) :: alpha(3)
      complex(dp), intent(inout) :: h(*)
      integer :: i, j

      do j = 1, ports
         do i = 1, ports
            associate (n => entry(i, j), a => alpha(at(i) + at(j) - 1))
               h(n) = cmplx(h(n)%re + gain(i, j)*factor*a%re, h(n)%im + gain(i, j)*factor*a%im, dp)
            end associate
         end do
      end do
   end subroutine add_two

   !> Adds the receptance of a part without closed form.
   pure subroutine add_part(part, omega, d_omega, wanted, r)
      type(part_type), intent(in) :: part
      real(dp), intent(in) :: omega, d_omega
      logical, intent(in) :: wanted
      type(receptance_type), intent(inout) :: r
      !> The receptance and its derivative.
      complex(dp) :: alpha(size(part%at), size(part%at), 2)
      integer :: i, j

      if (wanted) then
         call part%receptance(omega, alpha(:, :, 1), alpha(:, :, 2))
      else
         call part%receptance(omega, alpha(:, :, 1))
      end if
      do j = 1, size(part%at)
         do i = 1, size(part%at)
            associate (entry => part%entry(i, j))
               r%h(entry) = r%h(entry) + part%gain(i, j)*alpha(i, j, 1)
               if (wanted) r%dh(entry) = r%dh(entry) + (part%gain(i, j)*d_omega)*alpha(i, j, 2)
            end associate
         end do
      end do
   end subroutine add_part

   !> Adds to the excitation a the torques on part p and the transmission errors of linear meshes in part p.
   pure subroutine add_sources(system, p, omega, d_omega, harmonic, eta, r)
      type(system_type), intent(in) :: system
      integer, intent(in) :: p, harmonic, eta
      real(dp), intent(in) :: omega, d_omega
      type(receptance_type), intent(inout) :: r
      type(part_state_type) :: state
      complex(dp) :: x(size(system%cut%part(p)%mass)), dx(size(system%cut%part(p)%mass)), &
                     difference(system%cut%part(p)%graph%slots)
      integer :: i

      associate (part => system%cut%part(p))
         call find_sources(system, p, omega, harmonic, eta, x, dx)
         if (.not. any(abs(x) > 0)) return
         call part%factor(omega, state)
         call part%solve(state, x, difference)
         dx = dx - part%derivative(omega, x)
         call part%solve(state, dx, difference)
         do i = 1, size(part%at)
            associate (unknown => part%unknown(i))
               r%a(unknown) = r%a(unknown) + part%weight(i)*x(part%at(i))
               r%da(unknown) = r%da(unknown) + part%weight(i)*dx(part%at(i))*d_omega
            end associate
         end do
      end associate
   end subroutine add_sources

   !> Forces of the sources in part p on its masses over b_c [N/m], and their derivatives with respect to omega, (mass).
   pure subroutine find_sources(system, p, omega, harmonic, eta, force, d_force)
      type(system_type), intent(in) :: system
      !> Number of the part; harmonic >= 1 of Lambda/eta; sub-harmonic index.
      integer, intent(in) :: p, harmonic, eta
      !> Frequency of the harmonic [rad/s].
      real(dp), intent(in) :: omega
      !> Forces and derivatives, see above.
      complex(dp), intent(out) :: force(:), d_force(:)
      integer :: i, j

      force = 0
      d_force = 0
      associate (cut => system%cut, network => system%network)
         do j = 1, size(system%torque)
            associate (node => network%node(system%torque_body(j)))
               if (node == 0) cycle
               if (cut%home(node) == p) force(cut%mass(node)) = force(cut%mass(node)) + amplitude_at(system%torque(j), harmonic, &
                                                                                                  eta)/network%radius(node)
            end associate
         end do
         do i = 1, size(cut%part(p)%element)
            call push(system, cut%part(p)%element(i), omega, harmonic, eta, force, d_force)
         end do
         do i = 1, size(cut%part(p)%ground_element)
            call push(system, cut%part(p)%ground_element(i), omega, harmonic, eta, force, d_force)
         end do
      end associate
   end subroutine find_sources

   !> Adds the forces by the transmission error of an element: a mesh pushes its bodies along the line of action.
   pure subroutine push(system, n, omega, harmonic, eta, force, d_force)
      type(system_type), intent(in) :: system
      !> Number of the element; see `find_sources`.
      integer, intent(in) :: n, harmonic, eta
      real(dp), intent(in) :: omega
      complex(dp), intent(inout) :: force(:), d_force(:)
      complex(dp) :: amplitude
      real(dp) :: share
      integer :: i

      if (system%element_mesh(n) == 0) return
      amplitude = amplitude_at(system%transmission_error(system%element_mesh(n)), harmonic, eta)
      if (.not. abs(amplitude) > 0) return
      associate (element => system%network%elements(n))
         do i = 1, size(element%node)
            share = element%entry(i)/system%network%radius(element%node(i))
            associate (mass => system%cut%mass(element%node(i)))
               force(mass) = force(mass) - share*cmplx(element%stiffness, omega*element%damping, dp)*amplitude
               d_force(mass) = d_force(mass) - share*cmplx(0, element%damping, dp)*amplitude
            end associate
         end do
      end associate
   end subroutine push

   !> Computes the displacements of linear elements at one harmonic from the forces of the unknown meshes.
   pure subroutine linear_displacements(system, frequency_ratio, harmonic, eta, phi, p)
      type(system_type), intent(in) :: system
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Harmonic >= 1 of Lambda/eta; sub-harmonic index.
      integer, intent(in) :: harmonic, eta
      !> Complex amplitudes of the forces of the unknown meshes over k b_c [1], (unknown).
      complex(dp), intent(in) :: phi(:)
      !> Complex amplitudes of the displacements over b_c [1], (element); left unchanged for unknown meshes.
      complex(dp), intent(inout) :: p(:)
      type(part_state_type) :: state
      complex(dp), allocatable :: x(:), dx(:), difference(:)
      real(dp) :: omega
      integer :: i, n, k

      omega = system%characteristic_frequency*harmonic/eta*frequency_ratio
      associate (cut => system%cut)
         do k = 1, size(cut%part)
            associate (part => cut%part(k))
               if (size(part%mass) == 1 .and. .not. part%grounded) cycle
               if (part%has_closed_form()) then
                  call displace_few(system, k, omega, harmonic, eta, phi, p)
                  cycle
               end if
               allocate (x(size(part%mass)), dx(size(part%mass)), difference(part%graph%slots))
               call find_sources(system, k, omega, harmonic, eta, x, dx)
               do i = 1, size(part%at)
                  associate (mass => part%at(i), unknown => part%unknown(i))
                     x(mass) = x(mass) - part%weight(i)*system%stiffness(cut%element(unknown))*phi(unknown)
                  end associate
               end do
               call part%factor(omega, state)
               call part%solve(state, x, difference)
               do i = 1, size(part%element)
                  n = part%element(i)
                  p(n) = cut%scale(n)*difference(cut%slot(n))
                  if (system%element_mesh(n) > 0) &
                     p(n) = p(n) + amplitude_at(system%transmission_error(system%element_mesh(n)), harmonic, eta)
               end do
               do i = 1, size(part%ground_element)
                  n = part%ground_element(i)
                  p(n) = cut%scale(n)*x(cut%mass(system%network%elements(n)%node(1)))
                  if (system%element_mesh(n) > 0) &
                     p(n) = p(n) + amplitude_at(system%transmission_error(system%element_mesh(n)), harmonic, eta)
               end do
               deallocate (x, dx, difference)
            end associate
         end do
      end associate
   end subroutine linear_displacements

   !> Sets the displacements of the elements of a part of one mass, to ground, or of two masses on a spring, in closed form.
   pure subroutine displace_few(system, k, omega, harmonic, eta, phi, p)
      type(system_type), intent(in) :: system
      !> Number of the part; harmonic of Lambda/eta; sub-harmonic index.
      integer, intent(in) :: k, harmonic, eta
      real(dp), intent(in) :: omega
      complex(dp), intent(in) :: phi(:)
      complex(dp), intent(inout) :: p(:)
      complex(dp) :: force(2), d_force(2), difference
      integer :: first, i

      associate (cut => system%cut, part => system%cut%part(k))
         force = 0
         if (part%excited) call find_sources(system, k, omega, harmonic, eta, force, d_force)
         do i = 1, size(part%at)
            associate (mass => part%at(i), unknown => part%unknown(i))
               force(mass) = force(mass) - part%weight(i)*system%stiffness(cut%element(unknown))*phi(unknown)
            end associate
         end do
         if (size(part%mass) == 1) then
            difference = force(1)/cmplx(part%support(1) - omega**2*part%mass(1), omega*part%drag(1), dp)
         else
            ! The masses obey -omega**2 m x = force -+ spring (x_1 - x_2). The sign of the difference is as in part%solve.
            first = part%graph%order(1)
            difference = (force(first)/part%mass(first) - force(3 - first)/part%mass(3 - first)) &
                         /(cmplx(part%stiffness(1), omega*part%damping(1), dp)*sum(1/part%mass) - omega**2)
         end if
         do i = 1, size(part%element)
            call put(part%element(i), p)
         end do
         do i = 1, size(part%ground_element)
            call put(part%ground_element(i), p)
         end do
      end associate

   contains

      pure subroutine put(n, p)
         integer, intent(in) :: n
         complex(dp), intent(inout) :: p(:)

         p(n) = system%cut%scale(n)*difference
         if (system%element_mesh(n) > 0) &
            p(n) = p(n) + amplitude_at(system%transmission_error(system%element_mesh(n)), harmonic, eta)
      end subroutine put

   end subroutine displace_few

   !> Complex amplitude of a series at a harmonic of Lambda/eta; 0 where the series does not have the harmonic.
   pure complex(dp) function amplitude_at(series, harmonic, eta)
      !> The series.
      type(series_type), intent(in) :: series
      !> Harmonic of Lambda/eta; sub-harmonic index.
      integer, intent(in) :: harmonic, eta
      integer :: low, middle, high

      amplitude_at = 0
      low = 1
      high = size(series%harmonic)
      do while (low <= high)
         middle = (low + high)/2
         associate (difference => eta*series%harmonic(middle) - harmonic)
            if (difference == 0) then
               amplitude_at = series%amplitude(middle)
               return
            end if
            if (difference < 0) low = middle + 1
            if (difference > 0) high = middle - 1
         end associate
      end do
   end function amplitude_at

end module geartrain_network_receptance
