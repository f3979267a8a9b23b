!> Loads on the teeth of a mesh over a period: largest mesh force, dynamic factor (largest over static force), and shares of the
!> period in separation and in back contact.
!>
!> The mesh force over k b_c is phi (geartrain_mesh_law_law), damping included.
module geartrain_balance_mesh_load
   use geartrain_balance_torus_extremes, only: torus_force_top
   use geartrain_balance_winding, only: winding_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, least_height, next_maximum, resolution, sample
   use geartrain_mesh_law_contact, only: contact_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: mesh_load_type, force_reader_type, load_resolution, put_force

   type :: mesh_load_type
      !> Largest mesh force over the period in the direction of the static force [N], of a coupling the torque [N m]; without a
      !> static force, in either direction.
      real(dp) :: force_maximum = 0
      !> `force_maximum` over the static (mean) mesh force [1]; negative where there is no static force.
      real(dp) :: dynamic_factor = -1
      !> Shares of the period with |p| < b and with p < -b [1]; 0 without backlash.
      real(dp) :: separation = 0, back_contact = 0
   end type mesh_load_type

   !> kappa and, where the law has them, offsets of a mesh at the samples of a period [1], (sample, region).
   type :: stiffness_samples_type
      real(dp), allocatable :: kappa(:, :), offset(:, :)
   end type stiffness_samples_type

   !> Finds the largest mesh force of Fourier coefficients, with work space and samples of the stiffness that are made once.
   type :: force_reader_type
      integer, private :: eta = 0
      !> In place of the period, where it has cycles.
      type(winding_type), private :: winding
      !> Of each mesh, as many as its waveform needed last, (mesh).
      type(stiffness_samples_type), allocatable, private :: samples(:)
      !> Mesh force over k b_c [1], (sample).
      real(dp), allocatable, private :: force(:)
   contains
      procedure :: setup
      procedure :: read => read_force
   end type force_reader_type

contains

   !> Makes the work space for a mesh, unless it has one with this eta, winding and number of samples.
   subroutine setup(self, system, mesh, eta, winding, transform)
      class(force_reader_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Period of the motions [periods of the fundamental].
      integer, intent(in) :: eta
      !> Winding to sample; without cycles the period is sampled.
      type(winding_type), intent(in) :: winding
      !> Planned for as many samples as a period has; overwritten.
      type(transform_type), intent(inout) :: transform
      integer :: s

      if (allocated(self%samples) .and. (self%eta /= eta .or. self%winding%cycles /= winding%cycles .or. &
                                         self%winding%weight /= winding%weight)) deallocate (self%samples)
      if (.not. allocated(self%samples)) then
         allocate (self%samples(system%meshes))
         self%eta = eta
         self%winding = winding
      end if
      if (allocated(self%force)) then
         if (size(self%force) /= transform%samples) deallocate (self%force)
      end if
      if (.not. allocated(self%force)) allocate (self%force(transform%samples))
      associate (law => system%law(mesh), samples => self%samples(mesh))
         if (allocated(samples%kappa)) then
            if (size(samples%kappa, 1) == transform%samples) return
            deallocate (samples%kappa)
         end if
         if (allocated(samples%offset)) deallocate (samples%offset)
         allocate (samples%kappa(transform%samples, law%lowest:law%highest))
         if (allocated(law%offset)) allocate (samples%offset(transform%samples, law%lowest:law%highest))
         do s = law%lowest, law%highest
            call take_waves(law%stiffness(s), law%amplitude(:, s), samples%kappa(:, s))
            if (allocated(law%offset)) call take_waves(0.0_dp, law%offset(:, s), samples%offset(:, s))
         end do
      end associate

   contains

      !> Samples of a mean and waves of the law.
      subroutine take_waves(mean, amplitude, values)
         real(dp), intent(in) :: mean
         complex(dp), intent(in) :: amplitude(:)
         real(dp), intent(out) :: values(:)
         integer :: i

         call sample([mean, (amplitude(i)%re, -amplitude(i)%im, i=1, size(amplitude))], &
                     winding%place_of(eta*system%law(mesh)%harmonic), transform)
         values = transform%sample
      end subroutine take_waves

   end subroutine setup

   !> The harmonic whose `fine_samples` show the extremes of the displacement of a mesh and of its force: of hunting teeth much
   !> lower than the highest.
   pure integer function load_resolution(law, eta, frequency_ratio, u, harmonic, force)
      type(law_type), intent(in) :: law
      !> Period of the motion [periods of the fundamental].
      integer, intent(in) :: eta
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Coefficients of the mesh displacement over b_c [1], (coefficient): mean, cos, sin, ... of each harmonic.
      real(dp), intent(in) :: u(:)
      !> Harmonics of Lambda/eta.
      integer, intent(in) :: harmonic(:)
      !> Root of the sum of squared amplitudes of phi [1].
      real(dp), intent(in) :: force
      !> Sums of the amplitudes times powers of their harmonics.
      real(dp) :: moment(0:4), third, h, kappa
      integer :: i, k, highest

      moment = 0
      do k = 1, size(harmonic)
         moment = moment + hypot(u(2*k), u(2*k + 1))*real(harmonic(k), dp)**[(i, i=0, 4)]
      end do
      third = maxval(law%stiffness)*moment(3) + maxval(law%damping)*frequency_ratio/eta*moment(4)
      moment(0) = moment(0) + abs(u(1)) + maxval(abs(law%origin))
      do i = 1, size(law%harmonic)
         h = eta*law%harmonic(i)
         kappa = maxval(abs(law%amplitude(i, :)))
         third = third + kappa*(h**3*moment(0) + 3*h**2*moment(1) + 3*h*moment(2) + moment(3))
         if (allocated(law%offset)) third = third + maxval(abs(law%offset(i, :)))*h**3
      end do
      highest = maxval([1, harmonic])
      load_resolution = max(resolution(norm2(u(2:)), moment(3), highest), resolution(force, third, highest))
   end function load_resolution

   !> Sets the largest force and the dynamic factor of a mesh.
   pure subroutine put_force(system, static_force, mesh, largest, largest_reversed, load)
      type(system_type), intent(in) :: system
      !> Force of each element at rest at the speed of the motion, over k b_c [1], (element).
      real(dp), intent(in) :: static_force(:)
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Largest value of phi and largest value of -phi over the period [1].
      real(dp), intent(in) :: largest, largest_reversed
      !> Gets force_maximum and dynamic_factor.
      type(mesh_load_type), intent(inout) :: load

      associate (n => system%mesh_element(mesh))
         load%force_maximum = max(largest, largest_reversed)
         if (static_force(n) > 0) load%force_maximum = largest
         if (static_force(n) < 0) load%force_maximum = largest_reversed
         load%dynamic_factor = -1
         if (abs(static_force(n)) > 0) load%dynamic_factor = load%force_maximum/abs(static_force(n))
         load%force_maximum = load%force_maximum*system%load_unit(mesh)
      end associate
   end subroutine put_force

   !> Finds the largest force of one mesh.
   subroutine read_force(self, system, mesh, frequency_ratio, u, harmonic, transform, load, contact, ends)
      class(force_reader_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Number of the mesh.
      integer, intent(in) :: mesh
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Coefficients of the mesh displacement over b_c [1], (coefficient): mean, cos, sin, ... of each harmonic.
      real(dp), intent(in) :: u(:)
      !> Harmonics of Lambda/eta.
      integer, intent(in) :: harmonic(:)
      !> Samples of the displacement of the mesh; overwritten.
      type(transform_type), intent(inout) :: transform
      !> Gets force_maximum and dynamic_factor.
      type(mesh_load_type), intent(inout) :: load
      !> Contact of the mesh at this motion; needed where its force may be largest at events.
      type(contact_type), intent(in), optional :: contact
      !> Smallest and largest value of phi [1].
      real(dp), intent(out), optional :: ends(2)
      real(dp) :: rate, largest, reversed, below, above, slope(size(u))
      real(dp), allocatable :: damping(:)
      integer :: q, s

      associate (law => system%law(mesh), force => self%force, p => transform%sample, n => system%mesh_element(mesh))
         rate = frequency_ratio/self%eta
         if (law%jumps) damping = [(law%damping(law%region_at(p(q))), q=1, size(p))]
         force = 0
         do s = law%lowest, law%highest
            if (.not. law%stiffness(s) > 0) cycle
            below = -huge(below)
            above = huge(above)
            if (s > law%lowest) below = law%wall(s - 1)
            if (s < law%highest) above = law%wall(s)
            force = force + merge(self%samples(mesh)%kappa(:, s)*(p - law%origin(s)), 0.0_dp, p > below .and. p <= above)
            if (allocated(law%offset)) &
               force = force + merge(self%samples(mesh)%offset(:, s), 0.0_dp, p > below .and. p <= above)
         end do
         ! The derivative by the harmonics, at their places.
         slope(1) = 0
         slope(2::2) = harmonic*u(3::2)
         slope(3::2) = -harmonic*u(2::2)
         call sample(slope, self%winding%place_of(harmonic), transform)
         if (law%jumps) then
            force = force + rate*damping*transform%sample
         else
            force = force + rate*law%damping(1)*transform%sample
         end if
         largest = 0
         reversed = 0
         if (.not. system%static_force(n) < 0 .or. present(ends)) &
            largest = top(force, 1, u, harmonic, law, self%eta, self%winding, frequency_ratio, contact)
         if (.not. system%static_force(n) > 0 .or. present(ends)) &
            reversed = top(force, -1, u, harmonic, law, self%eta, self%winding, frequency_ratio, contact)
      end associate
      if (present(ends)) ends = [-reversed, largest]
      call put_force(system, system%static_force, mesh, largest, reversed, load)
   end subroutine read_force

   !> Largest value of side*phi [1]: Newton's method on the slope from the highest maxima among the samples, and both sides of every
   !> event where phi may be largest there. Without stages, and where phi does not jump, its kinks at the events of the loaded flank
   !> are minima.
   pure real(dp) function top(force, side, u, harmonic, law, eta, winding, frequency_ratio, contact)
      real(dp), intent(in) :: force(:), u(:), frequency_ratio
      integer, intent(in) :: side, harmonic(:), eta
      type(law_type), intent(in) :: law
      type(winding_type), intent(in) :: winding
      type(contact_type), intent(in), optional :: contact
      real(dp) :: least, spacing, theta, phi(0:2), correction
      integer :: i, q

      spacing = 2*pi/size(force)
      top = maxval(side*force)
      if (present(contact)) then
         do i = 1, contact%events
            phi = force_at(contact%instant(i), contact%contact(i))
            top = max(top, side*phi(0))
            phi = force_at(contact%instant(i), contact%contact(merge(i, contact%events + 1, i > 1) - 1))
            top = max(top, side*phi(0))
         end do
      end if
      if (winding%cycles > 0) then
         top = max(top, torus_force_top(winding, force, side, u, harmonic, law, frequency_ratio))
         return
      end if
      least = least_height(force, side)
      q = 0
      do
         call next_maximum(force, side, least, q, theta)
         if (q == 0) exit
         do i = 1, 8
            phi = force_at(theta)
            top = max(top, side*phi(0))
            if (.not. side*phi(2) < 0) exit
            correction = -phi(1)/phi(2)
            if (abs(correction) < 1e-3_dp*spacing) then
               ! The rest of the way up is a parabola.
               top = max(top, side*(phi(0) + 0.5_dp*phi(1)*correction))
               exit
            end if
            theta = theta + max(-spacing, min(spacing, correction))
         end do
      end do

   contains

      !> phi and its first two derivatives at theta = Lambda t/eta, in the region there or a given one.
      pure function force_at(theta, region) result(phi)
         real(dp), intent(in) :: theta
         integer, intent(in), optional :: region
         real(dp) :: phi(0:2), p(0:3)
         integer :: s

         call evaluate(u, harmonic, theta, p(0), p(1), p(2), p(3))
         s = law%region_at(p(0))
         if (present(region)) s = region
         call law%along(s, eta, theta, frequency_ratio, p, phi)
      end function force_at

   end function top

end module geartrain_balance_mesh_load
