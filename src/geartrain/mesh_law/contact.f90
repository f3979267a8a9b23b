!> Contact of one mesh over a period of a given motion: the instants at which it begins and ends, and from them the Fourier
!> coefficients of the mesh force and of its derivative.
!>
!> With chi = 1 in contact (0 in separation) and sigma = +1 on the drive flank, -1 on the back flank, 0 in between,
!>    kappa g(p) = (chi kappa) p - b (sigma kappa),
!> and both brackets are trigonometric polynomials between the crossings of p = +-b: their coefficients are closed form.
!> The paper's sampled DFT, equations (12) and (13), is the same formula with sampled brackets.
module geartrain_mesh_law_contact
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, sample
   use geartrain_model_system, only: series_type, series_value
   implicit none (type, external)
   private
   public :: contact_type

   type :: contact_type
      real(dp) :: half_backlash = 0
      !> kappa(theta) = 1 + sum over h of Re(amplitude(h) exp(i h stride theta)).
      complex(dp), allocatable :: kappa(:)
      integer :: stride = 1
      !> Harmonics of theta that the motion has, and the highest index of the spectra.
      integer, allocatable :: harmonic(:)
      integer :: highest = 0
      !> Contact at theta = 0 and the events after it: instants [rad], ascending, and the contact that each leads to:
      !> +1 drive flank, 0 separation, -1 back flank.
      integer :: first_contact = 1, events = 0
      real(dp), allocatable :: instant(:)
      integer, allocatable :: contact(:)
      !> Two-sided Fourier coefficients of chi kappa and of sigma kappa, indices 0..highest.
      complex(dp), allocatable :: stiffness(:), offset(:)
      type(transform_type), private :: sampled
      real(dp), allocatable, private :: p(:), slope(:), kappa_sample(:)
      integer, allocatable, private :: flank_sample(:)
      logical, private :: exact = .true.
   contains
      procedure :: setup
      procedure :: update
      procedure :: shares
      procedure :: clearance
      procedure :: spectra
      procedure, private :: find_events
      procedure, private :: sampled_spectra
   end type contact_type

contains

   !> Prepares work space: no allocation and no planning happens in `update`, except where many events need more room.
   subroutine setup(self, half_backlash, stiffness, eta, harmonic, highest, samples)
      class(contact_type), intent(inout) :: self
      !> b/b_c [1]; 0 for a linear mesh.
      real(dp), intent(in) :: half_backlash
      type(series_type), intent(in) :: stiffness
      !> Sub-harmonic index: theta = Lambda t/eta.
      integer, intent(in) :: eta
      integer, intent(in) :: harmonic(:), highest
      !> 0: exact coefficients; else the number of samples of the DFT.
      integer, intent(in) :: samples
      integer :: q

      self%half_backlash = half_backlash
      self%kappa = stiffness%amplitude
      self%stride = stiffness%order*eta
      self%harmonic = harmonic
      self%highest = highest
      self%exact = samples == 0
      if (allocated(self%stiffness)) deallocate (self%stiffness, self%offset)
      allocate (self%stiffness(0:highest), self%offset(0:highest))
      if (.not. allocated(self%instant)) allocate (self%instant(64), self%contact(64))
      if (self%exact) return
      call self%sampled%plan(samples)
      if (allocated(self%flank_sample)) deallocate (self%flank_sample)
      allocate (self%flank_sample(samples))
      self%kappa_sample = [(1 + series_value(stiffness, 2*pi*eta*(q - 1)/real(samples, dp)), q=1, samples)]
   end subroutine setup

   !> Events and spectra of the motion with the coefficients `u` (mean, cos, sin, ...).
   subroutine update(self, u, fine)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      !> A plan of `fine_samples` of the highest harmonic: one serves all meshes.
      type(transform_type), intent(inout) :: fine

      self%events = 0
      self%first_contact = 1
      if (self%half_backlash > 0) then
         call self%find_events(u, fine)
         if (.not. self%exact) then
            call self%sampled_spectra(u)
            return
         end if
      end if
      call self%spectra(self%stiffness, self%offset)
   end subroutine update

   !> Two-sided Fourier coefficients of chi kappa and of sigma kappa as far as the arrays reach, by the events of the last `update`.
   pure subroutine spectra(self, stiffness, offset)
      class(contact_type), intent(in) :: self
      complex(dp), intent(out) :: stiffness(0:), offset(0:)
      integer :: h

      if (self%events > 0) then
         call exact_spectra(self, stiffness, offset)
         return
      end if
      stiffness = 0
      offset = 0
      if (self%first_contact == 0) return
      stiffness(0) = 1
      do h = 1, min(size(self%kappa), ubound(stiffness, 1)/self%stride)
         stiffness(h*self%stride) = self%kappa(h)/2
      end do
      if (self%half_backlash > 0) offset = self%first_contact*stiffness
   end subroutine spectra

   !> Shares of the period without contact and with contact of the back flanks, at the last `update`.
   pure subroutine shares(self, separation, back_contact)
      class(contact_type), intent(in) :: self
      real(dp), intent(out) :: separation, back_contact
      real(dp) :: share(-1:1), last
      integer :: i, now

      share = 0
      last = 0
      now = self%first_contact
      do i = 1, self%events
         share(now) = share(now) + (self%instant(i) - last)/(2*pi)
         last = self%instant(i)
         now = self%contact(i)
      end do
      share(now) = share(now) + (2*pi - last)/(2*pi)
      separation = share(0)
      back_contact = share(-1)
   end subroutine shares

   !> How near an extreme of p, by the parabola through three samples, comes to one of the walls, at the last `update`: a change
   !> of p by as much makes a contact or ends one. Huge for a linear mesh.
   pure real(dp) function clearance(self)
      class(contact_type), intent(in) :: self
      real(dp) :: before, here, after, extreme
      integer :: q, n

      clearance = huge(1.0_dp)
      if (.not. self%half_backlash > 0) return
      n = size(self%p)
      before = self%p(n)
      here = self%p(1)
      do q = 1, n
         after = self%p(merge(1, q + 1, q == n))
         if ((here - before)*(after - here) <= 0 .and. abs(before - 2*here + after) > 0) then
            extreme = here - (after - before)**2/(8*(before - 2*here + after))
            clearance = min(clearance, abs(abs(extreme) - self%half_backlash))
         end if
         before = here
         here = after
      end do
   end function clearance

   !> Samples bracket the crossings of +-b, Newton polishes them; where two samples on one side of a wall turn back between
   !> them, the extreme decides whether the wall was crossed twice.
   subroutine find_events(self, u, fine)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      type(transform_type), intent(inout) :: fine
      real(dp) :: spacing, wall, f0, f1, turn, f_turn
      integer :: q, next, side, first

      call sample(u, self%harmonic, fine)
      if (allocated(self%p)) then
         if (size(self%p) /= fine%samples) deallocate (self%p, self%slope)
      end if
      if (.not. allocated(self%p)) allocate (self%p(fine%samples), self%slope(fine%samples))
      self%p = fine%sample
      self%first_contact = contact_of(self%p(1), self%half_backlash)
      if (all(self%p > self%half_backlash + 0.1_dp*(maxval(self%p) - minval(self%p)))) return
      call sample(u, self%harmonic, fine, derivative=.true.)
      self%slope = fine%sample
      spacing = 2*pi/fine%samples
      do q = 1, fine%samples
         next = merge(1, q + 1, q == fine%samples)
         ! Nothing happens between two samples of one contact, the first of which is too far from a wall to reach it and turn.
         if (abs(abs(self%p(q)) - self%half_backlash) >= spacing*abs(self%slope(q)) .and. &
             (self%p(q) > self%half_backlash .eqv. self%p(next) > self%half_backlash) .and. &
             (self%p(q) < -self%half_backlash .eqv. self%p(next) < -self%half_backlash)) cycle
         first = self%events + 1
         do side = 1, -1, -2
            wall = side*self%half_backlash
            f0 = side*(self%p(q) - wall)
            f1 = side*(self%p(next) - wall)
            if ((f0 > 0) .neqv. (f1 > 0)) then
               call add_event(self, crossing(self, u, wall, (q - 1)*spacing, q*spacing, self%p(q) - wall), &
                              merge(side, 0, f1 > 0), first)
            else if (abs(f0) < spacing*abs(self%slope(q)) .and. abs(f1) < spacing*abs(self%slope(next)) .and. &
                     (self%p(q) - wall)*self%slope(q) < 0 .and. (self%p(q) - wall)*self%slope(next) > 0) then
               call turning(self, u, wall, (q - 1)*spacing, q*spacing, turn, f_turn)
               if ((side*f_turn > 0) .eqv. (f0 > 0)) cycle
               call add_event(self, crossing(self, u, wall, (q - 1)*spacing, turn, self%p(q) - wall), &
                              merge(0, side, f0 > 0), first)
               call add_event(self, crossing(self, u, wall, turn, q*spacing, f_turn), merge(side, 0, f0 > 0), first)
            end if
         end do
      end do
   end subroutine find_events

   pure integer function contact_of(p, half_backlash)
      real(dp), intent(in) :: p, half_backlash

      contact_of = 0
      if (p > half_backlash) contact_of = 1
      if (p < -half_backlash) contact_of = -1
   end function contact_of

   !> Inserts an event in order among those since `first`.
   subroutine add_event(self, instant, contact, first)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: instant
      integer, intent(in) :: contact, first
      integer :: i

      if (self%events == size(self%instant)) then
         self%instant = [self%instant, self%instant]
         self%contact = [self%contact, self%contact]
      end if
      self%events = self%events + 1
      i = self%events
      do while (i > first)
         if (self%instant(i - 1) <= instant) exit
         self%instant(i) = self%instant(i - 1)
         self%contact(i) = self%contact(i - 1)
         i = i - 1
      end do
      self%instant(i) = instant
      self%contact(i) = contact
   end subroutine add_event

   !> The root of p - wall in [left, right], whose ends have different signs (`f_left` is the left one): Newton, kept in
   !> the bracket by bisection.
   pure real(dp) function crossing(self, u, wall, left, right, f_left) result(theta)
      class(contact_type), intent(in) :: self
      real(dp), intent(in) :: u(:), wall, left, right, f_left
      real(dp) :: a, b, p, slope, curvature, new
      integer :: i

      a = left
      b = right
      theta = (a + b)/2
      do i = 1, 60
         call evaluate(u, self%harmonic, theta, p, slope, curvature)
         if ((p - wall > 0) .eqv. (f_left > 0)) then
            a = theta
         else
            b = theta
         end if
         new = (a + b)/2
         if (abs(slope)*(b - a) > abs(p - wall)) new = theta - (p - wall)/slope
         if (new < a .or. new > b) new = (a + b)/2
         if (abs(new - theta) < 4e-15_dp*(1 + abs(theta))) exit
         theta = new
      end do
   end function crossing

   !> The extreme of p in [left, right], where its slope changes sign, and p - wall there.
   pure subroutine turning(self, u, wall, left, right, theta, f)
      class(contact_type), intent(in) :: self
      real(dp), intent(in) :: u(:), wall, left, right
      real(dp), intent(out) :: theta, f
      real(dp) :: a, b, p, slope, curvature, slope_left, new
      integer :: i

      a = left
      b = right
      call evaluate(u, self%harmonic, a, p, slope_left, curvature)
      theta = (a + b)/2
      do i = 1, 60
         call evaluate(u, self%harmonic, theta, p, slope, curvature)
         f = p - wall
         if ((slope > 0) .eqv. (slope_left > 0)) then
            a = theta
         else
            b = theta
         end if
         new = (a + b)/2
         if (abs(curvature)*(b - a) > abs(slope)) new = theta - slope/curvature
         if (new < a .or. new > b) new = (a + b)/2
         if (abs(new - theta) < 1e-12_dp) exit
         theta = new
      end do
   end subroutine turning

   !> Closed form: a jump of size J at theta adds J exp(-i k theta)/(2 pi i k) to coefficient k; then the product with kappa.
   pure subroutine exact_spectra(self, stiffness, offset)
      class(contact_type), intent(in) :: self
      complex(dp), intent(out) :: stiffness(0:), offset(0:)
      complex(dp), dimension(0:ubound(stiffness, 1) + self%stride*size(self%kappa)) :: chi, sigma
      complex(dp) :: z, power, jump
      real(dp) :: length, last, chi_jump, flank_jump
      integer :: i, k, now

      chi = 0
      sigma = 0
      last = 0
      now = self%first_contact
      do i = 1, self%events
         length = (self%instant(i) - last)/(2*pi)
         chi(0) = chi(0) + abs(now)*length
         sigma(0) = sigma(0) + now*length
         chi_jump = abs(self%contact(i)) - abs(now)
         flank_jump = self%contact(i) - now
         z = exp(cmplx(0, -self%instant(i), dp))
         power = cmplx(0, -1/(2*pi), dp)
         do k = 1, ubound(chi, 1)
            power = power*z
            chi(k) = chi(k) + chi_jump*power
            sigma(k) = sigma(k) + flank_jump*power
         end do
         last = self%instant(i)
         now = self%contact(i)
      end do
      length = (2*pi - last)/(2*pi)
      chi(0) = chi(0) + abs(now)*length
      sigma(0) = sigma(0) + now*length
      do k = 1, ubound(chi, 1)
         chi(k) = chi(k)/k
         sigma(k) = sigma(k)/k
      end do
      stiffness = chi(0:ubound(stiffness, 1))
      offset = sigma(0:ubound(stiffness, 1))
      do i = 1, size(self%kappa)
         jump = self%kappa(i)/2
         do k = 0, ubound(stiffness, 1)
            stiffness(k) = stiffness(k) + jump*two_sided(chi, k - i*self%stride) &
                                + conjg(jump)*chi(k + i*self%stride)
            offset(k) = offset(k) + jump*two_sided(sigma, k - i*self%stride) &
                             + conjg(jump)*sigma(k + i*self%stride)
         end do
      end do
   end subroutine exact_spectra

   pure complex(dp) function two_sided(coefficient, k)
      complex(dp), intent(in) :: coefficient(0:)
      integer, intent(in) :: k

      two_sided = coefficient(abs(k))
      if (k < 0) two_sided = conjg(two_sided)
   end function two_sided

   !> The paper's DFT: chi kappa and sigma kappa at equidistant samples.
   subroutine sampled_spectra(self, u)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      integer :: k

      associate (q => self%sampled%samples, x => self%sampled%sample)
         call sample(u, self%harmonic, self%sampled)
         do k = 1, q
            self%flank_sample(k) = contact_of(x(k), self%half_backlash)
         end do
         x = abs(self%flank_sample)*self%kappa_sample
         call self%sampled%to_coefficients()
         self%stiffness = self%sampled%coefficient(1:self%highest + 1)/q
         x = self%flank_sample*self%kappa_sample
         call self%sampled%to_coefficients()
         self%offset = self%sampled%coefficient(1:self%highest + 1)/q
      end associate
   end subroutine sampled_spectra

end module geartrain_mesh_law_contact
