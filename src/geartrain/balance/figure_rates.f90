!> Derivatives of the figures of a motion with respect to a parameter, by differences of motions beside it. To first order an
!> extreme changes as the function does at its instant. Where two extremes are equal and their derivatives differ, there is none.
module geartrain_balance_figure_rates
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balanced_torque, only: element_forces, shaft_coefficients
   use geartrain_balance_extreme_places, only: agreed, find_places, most_places, place_type, rate_at
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, fine_samples, least_height, next_maximum, sample
   implicit none (type, external)
   private
   public :: figures_type, figure_names

   !> The figures of meshes and of shafts.
   character(*), parameter :: figure_names(9) = [character(20) :: 'rms', 'mean', 'minimum', 'maximum', 'mesh_force_maximum', &
      'dynamic_factor', 'shaft_torque_mean', 'shaft_torque_minimum', 'shaft_torque_maximum']
   !> In place of a region of a law: the region in which the displacement is.
   integer, parameter :: by_place = huge(1)

   type :: figures_type
      !> Name of the figure; it is a figure of shafts, or of the forces of meshes.
      character(20), private :: figure = ''
      logical :: of_shafts = .false.
      logical, private :: of_forces = .false.
      !> Coefficients of all meshes [1], (block, mesh), or of the torques of all shafts [N m], (block, shaft), and the derivatives.
      real(dp), allocatable, private :: coefficients(:, :), d(:, :)
      !> Where the figure is an extreme, (mesh or shaft); +1 or -1: direction of the largest force, (mesh).
      type(place_type), allocatable, private :: places(:)
      integer, allocatable, private :: side(:)
      !> Whether there is the figure of each mesh or shaft, (mesh or shaft).
      logical, allocatable, private :: told(:)
      !> Derivative of the figure at each place, (place, mesh).
      real(dp), allocatable, private :: d_force(:, :)
   contains
      procedure :: setup
      procedure :: begin
      procedure :: add
      procedure :: rates
      procedure :: is_told
      procedure, private :: coefficients_of
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
      integer :: items, j, side

      self%figure = figure
      self%of_shafts = index(figure, 'shaft') == 1
      self%of_forces = figure == 'mesh_force_maximum' .or. figure == 'dynamic_factor'
      side = merge(-1, 1, index(figure, 'minimum') > 0)
      items = merge(balance%system%torque_paths%shafts, balance%system%meshes, self%of_shafts)
      allocate (self%coefficients(balance%block, items), self%d(balance%block, items), self%places(items), self%side(items))
      allocate (self%d_force(most_places, items))
      self%told = [(self%is_told(balance, j), j=1, items)]
      call self%coefficients_of(balance, u, self%coefficients)
      if (.not. (index(figure, 'imum') > 0 .or. self%of_forces)) return
      call transform%plan(fine_samples(maxval([1, balance%harmonic])))
      do j = 1, items
         if (self%of_forces) then
            call find_force(self, balance, transform, j)
         else if (self%is_told(balance, j)) then
            call find_places(self%coefficients(:, j), balance%harmonic, transform, side, self%places(j))
         end if
      end do
   end subroutine setup

   !> Coefficients of all meshes, or of the torques of all shafts.
   subroutine coefficients_of(self, balance, u, coefficients)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      real(dp), intent(out) :: coefficients(:, :)
      real(dp), allocatable :: force(:, :)

      if (self%of_shafts) then
         allocate (force(balance%block, balance%system%elements))
         call element_forces(balance, force)
         call shaft_coefficients(balance, balance%harmonic, force, coefficients)
      else
         call balance%full_coefficients(u, coefficients)
      end if
   end subroutine coefficients_of

   !> Begins the derivative with respect to another parameter.
   subroutine begin(self)
      class(figures_type), intent(inout) :: self

      self%d = 0
      self%d_force = 0
   end subroutine begin

   !> Adds a motion beside the motion of `setup`: the derivatives are the sums of the motions times their weights.
   subroutine add(self, balance, u, weight)
      class(figures_type), intent(inout) :: self
      !> The balance of the train with another value of the parameter, evaluated at its motion, to first order, with the contact
      !> events of the motion of `setup`.
      type(balance_type), intent(in) :: balance
      !> Coefficients of its unknown meshes [1], (block, unknown); its weight [1/unit of the parameter].
      real(dp), intent(in) :: u(:, :), weight
      real(dp) :: coefficients(size(self%d, 1), size(self%d, 2)), theta, phi(0:2), unit
      integer :: e, i, j, s

      call self%coefficients_of(balance, u, coefficients)
      self%d = self%d + weight*coefficients
      if (.not. self%of_forces) return
      do j = 1, balance%system%meshes
         if (.not. self%told(j)) cycle
         associate (system => balance%system, n => balance%system%mesh_element(j), places => self%places(j))
            unit = system%load_unit(j)
            if (self%figure == 'dynamic_factor') unit = 1/abs(system%static_force(n))
            do i = 1, places%count
               theta = places%theta(i)
               e = places%event(i)
               ! The instant of a contact event is no extreme.
               if (e > 0) theta = balance%contact(findloc(balance%mesh, j, 1))%moved_instant(e, coefficients(:, j))
               call force_at(balance, coefficients(:, j), j, theta, places%region(i), s, phi)
               self%d_force(i, j) = self%d_force(i, j) + weight*unit*self%side(j)*phi(0)
            end do
         end associate
      end do
   end subroutine add

   !> The derivatives [unit of the figure/unit of the parameter], (mesh or shaft); NaN where there is none.
   subroutine rates(self, balance, values)
      class(figures_type), intent(in) :: self
      !> The balance of `setup`.
      type(balance_type), intent(in) :: balance
      !> The derivatives.
      real(dp), intent(out) :: values(:)
      real(dp) :: unit
      integer :: j

      do j = 1, size(values)
         values(j) = ieee_value(values(j), ieee_quiet_nan)
         if (.not. self%is_told(balance, j)) cycle
         associate (c => self%coefficients(2:, j), d => self%d(:, j), places => self%places(j))
            if (self%of_forces) then
               associate (system => balance%system, n => balance%system%mesh_element(j))
                  unit = system%load_unit(j)
                  if (self%figure == 'dynamic_factor') unit = 1/abs(system%static_force(n))
               end associate
               ! A mesh that never bears and is not damped has no force.
               values(j) = 0
               if (places%count > 0) values(j) = agreed(self%d_force(:places%count, j), unit*norm2(d))
            else if (self%figure == 'rms') then
               if (norm2(c) > 0) values(j) = sum(c*d(2:))/norm2(c)
               if (.not. (norm2(c) > 0 .or. norm2(d(2:)) > 0)) values(j) = 0
            else if (index(self%figure, 'mean') > 0) then
               values(j) = d(1)
            else
               values(j) = rate_at(places, balance%harmonic, d)
            end if
         end associate
      end do
   end subroutine rates

   !> Whether the figure is told of each mesh or shaft: a dynamic factor needs a static force, a torque of rigid shafts side by side
   !> is not determined.
   pure logical function is_told(self, balance, item)
      class(figures_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      !> Number of the mesh or shaft.
      integer, intent(in) :: item

      is_told = .true.
      associate (system => balance%system)
         if (self%figure == 'dynamic_factor') is_told = abs(system%static_force(system%mesh_element(item))) > 0
         if (self%of_shafts) is_told = system%torque_paths%known(item)
      end associate
   end function is_told

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
               call force_at(balance, self%coefficients(:, mesh), mesh, theta, by_place, s, phi)
               if (.not. side*phi(2) < 0) exit
               correction = -phi(1)/phi(2)
               theta = theta + max(-2*pi/size(force), min(2*pi/size(force), correction))
               if (abs(correction) < 1e-9_dp) exit
            end do
            call force_at(balance, self%coefficients(:, mesh), mesh, theta, by_place, s, phi)
            call places%add(side*phi(0), theta, s, 0)
         end do
         if (places%count == 0) places%value = side*force(1)
         if (.not. balance%system%law(mesh)%peaks) return
         associate (contact => balance%contact(findloc(balance%mesh, mesh, 1)))
            do i = 1, contact%events
               call force_at(balance, self%coefficients(:, mesh), mesh, contact%instant(i), contact%contact(i), s, phi)
               call places%add(side*phi(0), contact%instant(i), s, i)
               call force_at(balance, self%coefficients(:, mesh), mesh, contact%instant(i), &
                             contact%contact(merge(i, contact%events + 1, i > 1) - 1), s, phi)
               call places%add(side*phi(0), contact%instant(i), s, i)
            end do
         end associate
      end subroutine find_side

   end subroutine find_force

   !> phi of a mesh and its first two derivatives at theta, by the row of a region.
   subroutine force_at(balance, coefficients, mesh, theta, wanted, region, phi)
      type(balance_type), intent(in) :: balance
      !> Coefficients of the mesh.
      real(dp), intent(in) :: coefficients(:)
      integer, intent(in) :: mesh, wanted
      real(dp), intent(in) :: theta
      integer, intent(out) :: region
      real(dp), intent(out) :: phi(0:2)
      real(dp) :: p(0:3)

      call evaluate(coefficients, balance%harmonic, theta, p(0), p(1), p(2), p(3))
      region = wanted
      if (wanted == by_place) region = balance%system%law(mesh)%region_at(p(0))
      call balance%system%law(mesh)%along(region, balance%eta, theta, balance%frequency_ratio, p, phi)
   end subroutine force_at

end module geartrain_balance_figure_rates
