!> Derivatives of the figures of a motion from those of its coefficients. The instant of an extreme does not count, to first order:
!> its derivative is that of the function there. Where two extremes are equal and their derivatives are not, there is none.
module geartrain_balance_figure_rates
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balance_rate, only: balance_rate_type
   use geartrain_balance_extreme_places, only: agreed, find_places, most_places, place_type, rate_at
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_series, only: series_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, fine_samples, least_height, next_maximum, sample
   use geartrain_model_receptance, only: amplitude_at, linear_displacements
   use geartrain_model_system_rate, only: system_rate_type
   implicit none (type, external)
   private
   public :: figures_type, figure_names

   !> The figures of meshes and of shafts.
   character(*), parameter :: figure_names(9) = [character(20) :: 'rms', 'mean', 'minimum', 'maximum', 'mesh_force_maximum', &
      'dynamic_factor', 'shaft_torque_mean', 'shaft_torque_minimum', 'shaft_torque_maximum']
   !> In place of a region of a law: the region in which the displacement is.
   integer, parameter :: by_place = huge(1)

   type :: figures_type
      !> Name of the figure; it is one of shafts.
      character(20), private :: figure = ''
      logical :: of_shafts = .false.
      !> Coefficients of all meshes [1], (block, mesh), and of the torques of all shafts [N m], (block, shaft).
      real(dp), allocatable, private :: coefficients(:, :), torque(:, :)
      !> Amplitudes of displacement [1], (element, harmonic), and of phi [1] with its mean, (element, 0:harmonics).
      complex(dp), allocatable, private :: p(:, :), phi(:, :)
      !> Where the figure is an extreme, (mesh or shaft); +1 or -1: direction of the largest force, (mesh).
      type(place_type), allocatable, private :: places(:)
      integer, allocatable, private :: side(:)
   contains
      procedure :: setup
      procedure :: rates
      procedure :: is_told
      procedure, private :: mesh_rates
      procedure, private :: shaft_rates
   end type figures_type

contains

   !> Prepares the derivatives of a figure: finds the extremes.
   subroutine setup(self, balance, u, figure)
      class(figures_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> One of `figure_names`.
      character(*), intent(in) :: figure
      type(transform_type) :: transform
      integer :: j, side

      self%figure = figure
      self%of_shafts = index(figure, 'shaft') == 1
      side = merge(-1, 1, index(figure, 'minimum') > 0)
      associate (system => balance%system, paths => balance%system%torque_paths)
         allocate (self%coefficients(balance%block, system%meshes), self%torque(balance%block, paths%shafts))
         call balance%full_coefficients(u, self%coefficients)
         if (self%of_shafts) call find_torques(self, balance, u)
         allocate (self%places(merge(paths%shafts, system%meshes, self%of_shafts)), self%side(system%meshes))
         if (.not. (index(figure, 'imum') > 0 .or. figure == 'dynamic_factor')) return
         call transform%plan(fine_samples(maxval([1, balance%harmonic])))
         do j = 1, size(self%places)
            if (self%of_shafts) then
               if (paths%known(j)) call find_places(self%torque(:, j), balance%harmonic, transform, side, self%places(j))
            else if (figure == 'minimum' .or. figure == 'maximum') then
               call find_places(self%coefficients(:, j), balance%harmonic, transform, side, self%places(j))
            else
               call find_force(self, balance, transform, j)
            end if
         end do
      end associate
   end subroutine setup

   !> Finds the torques of the shafts and what they are made of.
   subroutine find_torques(self, balance, u)
      class(figures_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      integer :: i, k, harmonics

      harmonics = size(balance%harmonic)
      associate (system => balance%system, paths => balance%system%torque_paths)
         allocate (self%p(system%elements, harmonics), self%phi(system%elements, 0:harmonics), source=(0.0_dp, 0.0_dp))
         do k = 1, harmonics
            do i = 1, balance%unknowns
               self%p(system%cut%element(i), k) = cmplx(u(2*k, i), -u(2*k + 1, i), dp)
            end do
            call linear_displacements(system, balance%frequency_ratio, balance%harmonic(k), balance%eta, &
                                      cmplx(balance%force(2*k, :), -balance%force(2*k + 1, :), dp), self%p(:, k))
            self%phi(:, k) = cmplx(system%spring, omega_of(balance, k)*system%damping, dp)*self%p(:, k)
         end do
         do i = 1, system%elements
            self%phi(i, 0) = system%static_force(i) + system%spring(i)*system%mean%linear_displacement(system%cut, i, &
               balance%force(1, :), system%static_force)
         end do
         call put_unknown(balance, balance%force, self%phi)
         self%torque = 0
         call add_torques(balance, paths%gain, system%stiffness, self%phi, self%torque)
         call add_sources(balance, paths%constant, paths%torque_gain, system%torque, self%torque)
      end associate
   end subroutine find_torques

   !> Derivatives of the figure.
   subroutine rates(self, balance, parts, rate, d_u, d_force, values)
      class(figures_type), intent(in) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Motion of its linear parts.
      type(balance_rate_type), intent(in) :: parts
      !> Derivatives of the system.
      type(system_rate_type), intent(in) :: rate
      !> Whole derivatives of the coefficients and of phi of the unknown meshes, (block, unknown).
      real(dp), intent(in) :: d_u(:, :), d_force(:, :)
      !> Derivatives [unit of the figure/unit of the parameter], (mesh or shaft); NaN where there is none.
      real(dp), intent(out) :: values(:)
      complex(dp) :: d_p(balance%system%elements, size(balance%harmonic))
      real(dp) :: d_mean(balance%system%elements)
      integer :: i, n

      associate (system => balance%system)
         d_p = 0
         if (self%of_shafts .or. balance%unknowns < system%meshes) &
            call parts%displacements(balance, rate, d_u, d_force, d_p)
         ! Of the mean phi of linear elements, which is their displacement.
         d_mean = rate%static_force
         do i = 1, size(system%mean%closing)
            associate (c => system%mean%closing(i))
               n = system%cut%element(c)
               d_mean = d_mean + system%spring*(system%mean%follow(:, i)*(d_force(1, c) - rate%static_force(n)) &
                                                + rate%mean%follow(:, i)*(balance%force(1, c) - system%static_force(n)))
            end associate
         end do
      end associate
      if (self%of_shafts) then
         call self%shaft_rates(balance, rate, d_force, d_p, d_mean, values)
      else
         call self%mesh_rates(balance, rate, d_u, d_p, d_mean, values)
      end if
   end subroutine rates

   subroutine mesh_rates(self, balance, rate, d_u, d_p, d_mean, values)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      type(system_rate_type), intent(in) :: rate
      real(dp), intent(in) :: d_u(:, :), d_mean(:)
      complex(dp), intent(in) :: d_p(:, :)
      real(dp), intent(out) :: values(:)
      real(dp) :: d(balance%block), load
      integer :: i, j, k

      do j = 1, balance%system%meshes
         associate (system => balance%system, n => balance%system%mesh_element(j), c => self%coefficients(2:, j), &
                    value => values(j), places => self%places(j))
            i = findloc(balance%mesh, j, 1)
            if (i > 0) then
               d = d_u(:, i)
            else
               d(1) = d_mean(n)
               do k = 1, size(balance%harmonic)
                  d(2*k:2*k + 1) = [real(d_p(n, k), dp), -aimag(d_p(n, k))]
               end do
            end if
            value = ieee_value(load, ieee_quiet_nan)
            load = abs(system%static_force(n))
            select case (self%figure)
            case ('rms')
               if (norm2(c) > 0) value = sum(c*d(2:))/norm2(c)
               if (.not. (norm2(c) > 0 .or. norm2(d(2:)) > 0)) value = 0
            case ('mean')
               value = d(1)
            case ('minimum', 'maximum')
               value = rate_at(places, balance%harmonic, d)
            case ('mesh_force_maximum')
               value = (self%side(j)*force_rate(self, balance, rate, j, d)*system%stiffness(n) &
                        + places%value*rate%network%stiffness(n))*system%characteristic_length
            case ('dynamic_factor')
               if (load > 0) value = self%side(j)*(force_rate(self, balance, rate, j, d) - places%value*rate%static_force(n)/load) &
                                     /load
            end select
         end associate
      end do
   end subroutine mesh_rates

   subroutine shaft_rates(self, balance, rate, d_force, d_p, d_mean, values)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      type(system_rate_type), intent(in) :: rate
      real(dp), intent(in) :: d_force(:, :), d_mean(:)
      complex(dp), intent(in) :: d_p(:, :)
      real(dp), intent(out) :: values(:)
      complex(dp) :: d_phi(balance%system%elements, 0:size(balance%harmonic))
      real(dp) :: d_torque(balance%block, size(self%torque, 2))
      integer :: j, k

      associate (system => balance%system, paths => balance%system%torque_paths)
         d_phi(:, 0) = d_mean
         do k = 1, size(balance%harmonic)
            d_phi(:, k) = cmplx(system%spring, omega_of(balance, k)*system%damping, dp)*d_p(:, k) &
                          + cmplx(0, omega_of(balance, k)*rate%damping, dp)*self%p(:, k)
         end do
         call put_unknown(balance, d_force, d_phi)
         d_torque = 0
         call add_torques(balance, paths%gain, system%stiffness, d_phi, d_torque)
         call add_torques(balance, paths%gain, rate%network%stiffness, self%phi, d_torque)
         call add_torques(balance, rate%paths%gain, system%stiffness, self%phi, d_torque)
         call add_sources(balance, rate%paths%constant, rate%paths%torque_gain, system%torque, d_torque)
         call add_sources(balance, 0*paths%constant, paths%torque_gain, rate%torque, d_torque)
         do j = 1, paths%shafts
            values(j) = ieee_value(values(j), ieee_quiet_nan)
            if (.not. (paths%known(j) .and. rate%paths%known(j))) cycle
            values(j) = d_torque(1, j)
            if (self%figure /= 'shaft_torque_mean') values(j) = rate_at(self%places(j), balance%harmonic, d_torque(:, j))
         end do
      end associate
   end subroutine shaft_rates

   !> Whether the figure is told of each mesh or shaft: a dynamic factor needs a static force, a torque of rigid shafts side by side
   !> is not determined.
   pure logical function is_told(self, balance, item)
      class(figures_type), intent(in) :: self
      !> The balance.
      type(balance_type), intent(in) :: balance
      !> Number of the mesh or shaft.
      integer, intent(in) :: item

      is_told = .true.
      associate (system => balance%system)
         if (self%figure == 'dynamic_factor') is_told = abs(system%static_force(system%mesh_element(item))) > 0
         if (self%of_shafts) is_told = system%torque_paths%known(item)
      end associate
   end function is_told

   !> Frequency of a harmonic over omega_c.
   pure real(dp) function omega_of(balance, k)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: k

      omega_of = balance%harmonic(k)*balance%frequency_ratio/balance%eta
   end function omega_of

   !> Puts coefficients of the unknown meshes among the amplitudes of all elements.
   pure subroutine put_unknown(balance, force, phi)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: force(:, :)
      complex(dp), intent(inout) :: phi(:, 0:)
      integer :: k

      phi(balance%system%cut%element, 0) = force(1, :)
      do k = 1, size(balance%harmonic)
         phi(balance%system%cut%element, k) = cmplx(force(2*k, :), -force(2*k + 1, :), dp)
      end do
   end subroutine put_unknown

   !> Adds to the torques of the shafts what the elements give: gain times stiffness times phi.
   pure subroutine add_torques(balance, gain, stiffness, phi, torque)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: gain(:), stiffness(:)
      complex(dp), intent(in) :: phi(:, 0:)
      real(dp), intent(inout) :: torque(:, :)
      complex(dp) :: part
      integer :: i, k, s

      associate (paths => balance%system%torque_paths)
         do s = 1, paths%shafts
            do i = paths%first(s), paths%first(s + 1) - 1
               associate (n => paths%element(i))
                  part = gain(i)*stiffness(n)*balance%system%characteristic_length
                  torque(1, s) = torque(1, s) + real(part*phi(n, 0), dp)
                  do k = 1, size(balance%harmonic)
                     torque(2*k, s) = torque(2*k, s) + real(part*phi(n, k), dp)
                     torque(2*k + 1, s) = torque(2*k + 1, s) - aimag(part*phi(n, k))
                  end do
               end associate
            end do
         end do
      end associate
   end subroutine add_torques

   !> Adds to the torques of the shafts those on the bodies of rigid ones.
   pure subroutine add_sources(balance, constant, gain, series, torque)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: constant(:), gain(:)
      type(series_type), intent(in) :: series(:)
      real(dp), intent(inout) :: torque(:, :)
      complex(dp) :: part
      integer :: i, k, s

      torque(1, :) = torque(1, :) + constant
      associate (paths => balance%system%torque_paths)
         do s = 1, paths%shafts
            do i = paths%torque_first(s), paths%torque_first(s + 1) - 1
               do k = 1, size(balance%harmonic)
                  part = gain(i)*balance%system%characteristic_length*amplitude_at(series(paths%torque(i)), balance%harmonic(k), &
                                                                                   balance%eta)
                  torque(2*k:2*k + 1, s) = torque(2*k:2*k + 1, s) + [part%re, -part%im]
               end do
            end do
         end do
      end associate
   end subroutine add_sources

   !> Finds the places of the largest force of a mesh, in the direction of its static force or, without it, in either direction.
   subroutine find_force(self, balance, transform, mesh)
      class(figures_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      type(transform_type), intent(inout) :: transform
      integer, intent(in) :: mesh
      type(place_type) :: reversed
      real(dp) :: force(transform%samples)
      integer :: q

      associate (static => balance%system%static_force(balance%system%mesh_element(mesh)), law => balance%system%law(mesh))
         call sample(self%coefficients(:, mesh), balance%harmonic, transform)
         force = [(law%force(2*pi*balance%eta*(q - 1)/real(size(force), dp), transform%sample(q), 0.0_dp), q=1, size(force))]
         block
            real(dp) :: damping(size(force))
            damping = [(law%damping(law%region_at(transform%sample(q))), q=1, size(force))]
            call sample(self%coefficients(:, mesh), balance%harmonic, transform, derivative=.true.)
            force = force + balance%frequency_ratio/balance%eta*damping*transform%sample
         end block
         self%side(mesh) = 1
         if (.not. static < 0) call find_side(1, self%places(mesh))
         if (static > 0) return
         call find_side(-1, reversed)
         if (reversed%value <= self%places(mesh)%value) return
         self%places(mesh) = reversed
         self%side(mesh) = -1
      end associate

   contains

      subroutine find_side(side, places)
         integer, intent(in) :: side
         type(place_type), intent(out) :: places
         real(dp) :: least, theta, phi(0:2), correction
         integer :: i, s

         least = least_height(force, side)
         q = 0
         do
            call next_maximum(force, side, least, q, theta)
            if (q == 0) exit
            do i = 1, 12
               call force_at(self, balance, mesh, theta, by_place, s, phi)
               if (.not. side*phi(2) < 0) exit
               correction = -phi(1)/phi(2)
               theta = theta + max(-2*pi/size(force), min(2*pi/size(force), correction))
               if (abs(correction) < 1e-9_dp) exit
            end do
            call force_at(self, balance, mesh, theta, by_place, s, phi)
            call places%add(side*phi(0), theta, s, 0)
         end do
         if (places%count == 0) places%value = side*force(1)
         if (.not. balance%system%law(mesh)%jumps) return
         associate (contact => balance%contact(findloc(balance%mesh, mesh, 1)))
            do i = 1, contact%events
               call force_at(self, balance, mesh, contact%instant(i), contact%contact(i), s, phi)
               call places%add(side*phi(0), contact%instant(i), s, i)
               call force_at(self, balance, mesh, contact%instant(i), contact%contact(merge(i, contact%events + 1, i > 1) - 1), s, &
                             phi)
               call places%add(side*phi(0), contact%instant(i), s, i)
            end do
         end associate
      end subroutine find_side

   end subroutine find_force

   !> phi of a mesh and its first two derivatives at theta, by the row of a region.
   subroutine force_at(self, balance, mesh, theta, wanted, region, phi)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: mesh, wanted
      real(dp), intent(in) :: theta
      integer, intent(out) :: region
      real(dp), intent(out) :: phi(0:2)
      real(dp) :: p(0:3)

      call evaluate(self%coefficients(:, mesh), balance%harmonic, theta, p(0), p(1), p(2), p(3))
      region = wanted
      if (wanted == by_place) region = balance%system%law(mesh)%region_at(p(0))
      call balance%system%law(mesh)%along(region, balance%eta, theta, balance%frequency_ratio, p, phi)
   end subroutine force_at

   !> Derivative of the largest phi of a mesh, with the sign of phi.
   real(dp) function force_rate(self, balance, rate, mesh, d)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      type(system_rate_type), intent(in) :: rate
      integer, intent(in) :: mesh
      !> Whole derivative of the coefficients of the mesh.
      real(dp), intent(in) :: d(:)
      real(dp) :: value(most_places), phi(0:2), p(0:2), dp_(0:2), phase, omega
      integer :: i, s, before

      omega = balance%frequency_ratio/balance%eta
      associate (places => self%places(mesh), law => balance%system%law(mesh))
         do i = 1, places%count
            phase = places%theta(i)*balance%eta
            call force_at(self, balance, mesh, places%theta(i), places%region(i), s, phi)
            call evaluate(self%coefficients(:, mesh), balance%harmonic, places%theta(i), p(0), p(1), p(2))
            call evaluate(d, balance%harmonic, places%theta(i), dp_(0), dp_(1), dp_(2))
            value(i) = law%stiffness_at(s, phase)*dp_(0) + omega*law%damping(s)*dp_(1)
            if (rate%law_changes(mesh)) then
               associate (change => rate%law(mesh))
                  value(i) = value(i) + change%stiffness_at(s, phase)*(p(0) - law%origin(s)) &
                             - law%stiffness_at(s, phase)*change%origin(s)
                  if (law%jumps) value(i) = value(i) + omega*change%damping(s)*p(1)
                  if (places%event(i) > 0) then
                     ! The instant of a contact event is no extreme.
                     associate (contact => balance%contact(findloc(balance%mesh, mesh, 1)), e => places%event(i))
                        before = contact%contact(merge(e, contact%events + 1, e > 1) - 1)
                        value(i) = value(i) + phi(1)*change%wall(min(before, contact%contact(e)))/p(1)
                     end associate
                  end if
               end associate
            end if
            if (.not. law%jumps) value(i) = value(i) + omega*rate%damping(balance%system%mesh_element(mesh))*p(1)
            if (places%event(i) > 0) value(i) = value(i) - phi(1)*dp_(0)/p(1)
         end do
         ! A mesh that never bears and is not damped has no force.
         force_rate = 0
         if (places%count > 0) force_rate = agreed(value(:places%count), norm2(d))
      end associate
   end function force_rate

end module geartrain_balance_figure_rates
