!> What the teeth of a mesh bear over a period: the largest mesh force, its ratio to the static one (the dynamic factor), and the
!> shares of the period without contact and with contact of the back flanks.
!>
!> The mesh force over k b_c is phi = kappa(t) g(p) + gamma p', damping included, as everywhere in the equations.
module geartrain_balance_mesh_load
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, least_height, next_maximum, sample
   use geartrain_model_system, only: series_type, series_value, system_type
   implicit none (type, external)
   private
   public :: mesh_load_type, force_reader_type, elastic, put_force, stiffness_samples

   type :: mesh_load_type
      !> Largest mesh force over the period in the direction of the static one [N]; without a static force, in either direction.
      real(dp) :: force_maximum = 0
      !> The same over the static (mean) mesh force [1]; negative where there is no static force, hence no such factor.
      real(dp) :: dynamic_factor = -1
      !> Shares of the period with |p| < b and with p < -b [1]; 0 without backlash.
      real(dp) :: separation = 0, back_contact = 0
   end type mesh_load_type

   !> Reads the largest mesh force off Fourier coefficients: work space and stiffness samples, made once.
   type :: force_reader_type
      integer, private :: eta = 0
      !> kappa at the samples, (sample, mesh), and the mesh force over k b_c, (sample).
      real(dp), allocatable, private :: kappa(:, :), force(:)
   contains
      procedure :: setup
      procedure :: read => read_force
   end type force_reader_type

contains

   !> Prepares for periods of `eta` mesh periods in `samples` samples; nothing to do where they are those of the last call.
   subroutine setup(self, system, eta, samples)
      class(force_reader_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: eta, samples

      if (allocated(self%force)) then
         if (self%eta == eta .and. size(self%force) == samples) return
         deallocate (self%kappa, self%force)
      end if
      self%eta = eta
      allocate (self%force(samples))
      self%kappa = stiffness_samples(system, eta, samples)
   end subroutine setup

   !> kappa of every mesh at `samples` equidistant instants of `eta` mesh periods, (sample, mesh).
   pure function stiffness_samples(system, eta, samples) result(kappa)
      type(system_type), intent(in) :: system
      integer, intent(in) :: eta, samples
      real(dp) :: kappa(samples, system%meshes)
      integer :: j, q

      do j = 1, system%meshes
         do q = 1, samples
            kappa(q, j) = 1 + series_value(system%mesh_stiffness(j), 2*pi*eta*(q - 1)/real(samples, dp))
         end do
      end do
   end function stiffness_samples

   !> g(p): what the displacement p exceeds the half backlash by.
   elemental real(dp) function elastic(p, half_backlash)
      real(dp), intent(in) :: p, half_backlash

      elastic = sign(max(abs(p) - half_backlash, 0.0_dp), p)
   end function elastic

   !> Puts the largest force into `load`, from the largest value of phi and that of -phi.
   pure subroutine put_force(system, mesh, largest, largest_reversed, load)
      type(system_type), intent(in) :: system
      integer, intent(in) :: mesh
      real(dp), intent(in) :: largest, largest_reversed
      type(mesh_load_type), intent(inout) :: load

      associate (n => system%mesh_element(mesh))
         load%force_maximum = max(largest, largest_reversed)
         if (system%static_force(n) > 0) load%force_maximum = largest
         if (system%static_force(n) < 0) load%force_maximum = largest_reversed
         load%dynamic_factor = -1
         if (abs(system%static_force(n)) > 0) load%dynamic_factor = load%force_maximum/abs(system%static_force(n))
         load%force_maximum = load%force_maximum*system%stiffness(n)*system%characteristic_length
      end associate
   end subroutine put_force

   !> The largest force of one mesh, of the motion with the coefficients u whose samples `transform` holds. Overwrites these.
   subroutine read_force(self, system, mesh, frequency_ratio, u, harmonic, transform, load)
      class(force_reader_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: mesh
      !> Lambda.
      real(dp), intent(in) :: frequency_ratio
      real(dp), intent(in) :: u(:)
      integer, intent(in) :: harmonic(:)
      type(transform_type), intent(inout) :: transform
      type(mesh_load_type), intent(inout) :: load
      real(dp) :: rate, largest, reversed

      associate (n => system%mesh_element(mesh), b => system%half_backlash(mesh), force => self%force)
         rate = system%damping(n)*frequency_ratio/self%eta
         force = self%kappa(:, mesh)*elastic(transform%sample, b)
         call sample(u, harmonic, transform, derivative=.true.)
         force = force + rate*transform%sample
         largest = 0
         reversed = 0
         if (.not. system%static_force(n) < 0) largest = top(force, 1, u, harmonic, system%mesh_stiffness(mesh), self%eta, b, rate)
         if (.not. system%static_force(n) > 0) reversed = top(force, -1, u, harmonic, system%mesh_stiffness(mesh), self%eta, b, &
                                                              rate)
      end associate
      call put_force(system, mesh, largest, reversed, load)
   end subroutine read_force

   !> Largest value of side*phi: Newton on the slope from the highest maxima among the samples.
   !> The kinks of phi, at contact events of the flank that bears the load, are minima: none is missed by that.
   pure real(dp) function top(force, side, u, harmonic, stiffness, eta, half_backlash, rate)
      real(dp), intent(in) :: force(:), u(:), half_backlash, rate
      integer, intent(in) :: side, harmonic(:), eta
      type(series_type), intent(in) :: stiffness
      real(dp) :: least, spacing, theta, phi, slope, curvature, correction
      integer :: i, q

      spacing = 2*pi/size(force)
      top = maxval(side*force)
      least = least_height(force, side)
      q = 0
      do
         call next_maximum(force, side, least, q, theta)
         if (q == 0) exit
         do i = 1, 8
            call force_at(theta, u, harmonic, stiffness, eta, half_backlash, rate, phi, slope, curvature)
            top = max(top, side*phi)
            if (.not. side*curvature < 0) exit
            correction = -slope/curvature
            if (abs(correction) < 1e-4_dp) then
               ! What is left of the way up is a parabola.
               top = max(top, side*(phi + 0.5_dp*slope*correction))
               exit
            end if
            theta = theta + max(-spacing, min(spacing, correction))
         end do
      end do
   end function top

   !> phi and its first two derivatives with respect to theta = Lambda t/eta.
   pure subroutine force_at(theta, u, harmonic, stiffness, eta, half_backlash, rate, phi, slope, curvature)
      real(dp), intent(in) :: theta, u(:), half_backlash, rate
      integer, intent(in) :: harmonic(:), eta
      type(series_type), intent(in) :: stiffness
      real(dp), intent(out) :: phi, slope, curvature
      complex(dp) :: term
      real(dp) :: p, p1, p2, p3, g, g1, g2, kappa, kappa1, kappa2
      integer :: h, k

      call evaluate(u, harmonic, theta, p, p1, p2, p3)
      kappa = 1
      kappa1 = 0
      kappa2 = 0
      do h = 1, size(stiffness%amplitude)
         k = h*stiffness%order*eta
         term = stiffness%amplitude(h)*exp(cmplx(0, k*theta, dp))
         kappa = kappa + term%re
         kappa1 = kappa1 - k*term%im
         kappa2 = kappa2 - real(k, dp)**2*term%re
      end do
      g = elastic(p, half_backlash)
      g1 = p1
      g2 = p2
      if (half_backlash > 0 .and. abs(p) <= half_backlash) then
         g1 = 0
         g2 = 0
      end if
      phi = kappa*g + rate*p1
      slope = kappa1*g + kappa*g1 + rate*p2
      curvature = kappa2*g + 2*kappa1*g1 + kappa*g2 + rate*p3
   end subroutine force_at

end module geartrain_balance_mesh_load
