!> Contact of one mesh over a period of a given motion: the instants at which the mesh goes from one region of its force law to
!> another, and the Fourier coefficients of the mesh force and of its derivative (geartrain_mesh_law_spectra), exact or by the
!> sampled DFT of the paper, equations (12) and (13).
module geartrain_mesh_law_contact
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_sampled_root, only: sampled_root
   use geartrain_linalg_trigonometric, only: evaluate, sample
   use geartrain_mesh_law_law, only: law_type
   use geartrain_mesh_law_spectra, only: find_spectra, spectra_type
   use geartrain_mesh_law_wall_crossing, only: crossing, turning
   implicit none (type, external)
   private
   public :: contact_type, most_polished

   !> Harmonics up to which crossings found among few samples are polished. Samples above which crossings are found by the samples
   !> alone, where there are eight in a period of the highest harmonic.
   integer, parameter :: most_polished = 512, many_samples = 4096

   type :: contact_type
      !> Force law of the mesh.
      type(law_type) :: law
      !> Sub-harmonic index: theta = Lambda t/eta.
      integer :: eta = 1
      !> Harmonics of theta that the motion has.
      integer, allocatable :: harmonic(:)
      !> Region of the law at theta = 0; number of events of the period.
      integer :: first_contact = 1, events = 0
      !> theta of each event [rad], ascending, and the region after the event; the first `events` elements are in use.
      real(dp), allocatable :: instant(:)
      integer, allocatable :: contact(:)
      !> Fourier coefficients at the latest `update`.
      type(spectra_type) :: spectra
      !> Plan of the sampled DFT; samples of p and of dp/dtheta [1], (sample).
      type(transform_type), private :: sampled
      real(dp), allocatable, private :: p(:), slope(:)
      !> Distance from the nearest wall that p keeps at least [1], where its amplitudes tell it without samples; else 0.
      real(dp), private :: margin = 0
      !> kappa [1] at the samples of the DFT, (sample, region); region at each sample, (sample).
      real(dp), allocatable, private :: kappa_sample(:, :)
      integer, allocatable, private :: region_sample(:)
      !> Whether the coefficients are exact, without a DFT.
      logical, private :: exact = .true.
      !> Whether `keep_events` has given the events, so that `update` finds none.
      logical, private :: kept = .false.
   contains
      procedure :: setup
      procedure :: update
      procedure :: keep_events
      procedure :: moved_instant
      procedure :: extend
      procedure :: shares
      procedure :: clearance
      procedure :: keeps_distance
      procedure :: contact_at
      procedure, private :: find_margin
      procedure, private :: find_events
      procedure, private :: sampled_spectra
   end type contact_type

contains

   !> Prepares work space and plans.
   subroutine setup(self, law, eta, harmonic, highest, samples)
      class(contact_type), intent(inout) :: self
      !> Force law of the mesh.
      type(law_type), intent(in) :: law
      !> Sub-harmonic index.
      integer, intent(in) :: eta
      !> Harmonics of theta that the motion has, and the highest index of the spectra.
      integer, intent(in) :: harmonic(:), highest
      !> 0: exact coefficients; else the number of samples of the DFT.
      integer, intent(in) :: samples
      integer :: q, s

      self%law = law
      self%eta = eta
      self%harmonic = harmonic
      self%exact = samples == 0
      self%kept = .false.
      call self%spectra%reserve(law, highest)
      if (.not. allocated(self%instant)) allocate (self%instant(64), self%contact(64))
      if (self%exact) return
      call self%sampled%plan(samples)
      if (allocated(self%region_sample)) deallocate (self%region_sample, self%kappa_sample)
      allocate (self%region_sample(samples), self%kappa_sample(samples, law%lowest:law%highest))
      do s = law%lowest, law%highest
         self%kappa_sample(:, s) = [(law%stiffness_at(s, 2*pi*eta*(q - 1)/real(samples, dp)), q=1, samples)]
      end do
   end subroutine setup

   !> Finds events and spectra of a motion.
   subroutine update(self, u, fine, events_only)
      class(contact_type), intent(inout) :: self
      !> Coefficients of the mesh displacement over b_c [1], (coefficient): mean, cos, sin, ... of each harmonic.
      real(dp), intent(in) :: u(:)
      !> Plan of `fine_samples` of the highest harmonic, work space shared by all meshes.
      type(transform_type), intent(inout) :: fine
      !> No spectra are wanted; absent: they are.
      logical, intent(in), optional :: events_only

      if (.not. self%kept) then
         self%events = 0
         self%first_contact = 1
      end if
      if (self%law%highest > self%law%lowest .and. .not. self%kept) then
         call self%find_margin(u)
         if (.not. (self%exact .and. self%margin > 0)) call self%find_events(u, fine)
         if (.not. self%exact) then
            call self%sampled_spectra(u)
            return
         end if
      end if
      if (present(events_only)) return
      associate (n => self%events)
         call find_spectra(self%law, self%eta, self%first_contact, self%instant(:n), self%contact(:n), self%spectra)
      end associate
   end subroutine update

   !> Takes over the events of a motion, for motions next to it, until `setup`: the spectra are right to first order, because
   !> elastic force and impulse are continuous at a wall. Differences of them are right however near to a wall the motion comes.
   subroutine keep_events(self, other)
      class(contact_type), intent(inout) :: self
      !> The contact at its latest `update`.
      type(contact_type), intent(in) :: other

      ! Sampled spectra do not come from events, and a backlash of 0 has no walls.
      if (.not. self%exact) return
      if (self%law%lowest /= other%law%lowest .or. self%law%highest /= other%law%highest) return
      self%kept = .true.
      self%events = other%events
      self%first_contact = other%first_contact
      self%instant = other%instant
      self%contact = other%contact
   end subroutine keep_events

   !> theta of an event [rad] as the motion with these coefficients, and the walls of the present law, has it.
   pure real(dp) function moved_instant(self, event, u) result(theta)
      class(contact_type), intent(in) :: self
      !> Number of the event.
      integer, intent(in) :: event
      !> Coefficients of the mesh displacement over b_c [1], (coefficient).
      real(dp), intent(in) :: u(:)
      real(dp) :: p, slope, curvature
      integer :: before, i

      before = self%first_contact
      if (event > 1) before = self%contact(event - 1)
      theta = self%instant(event)
      do i = 1, 3
         call evaluate(u, self%harmonic, theta, p, slope, curvature)
         theta = theta - (p - self%law%wall(min(before, self%contact(event))))/slope
      end do
   end function moved_instant

   !> Computes exact spectra of any length with the events of the latest `update`.
   subroutine extend(self, spectra, highest)
      class(contact_type), intent(in) :: self
      !> Spectra with room from `reserve`.
      type(spectra_type), intent(inout) :: spectra
      !> Highest index to compute; as far as the room reaches unless it is given.
      integer, intent(in), optional :: highest

      call find_spectra(self%law, self%eta, self%first_contact, self%instant(:self%events), self%contact(:self%events), spectra, &
                        highest)
   end subroutine extend

   !> Region at an instant of the period, at the latest `update`.
   pure integer function contact_at(self, theta)
      class(contact_type), intent(in) :: self
      !> theta [rad]; at an event, the region before it.
      real(dp), intent(in) :: theta
      integer :: k

      k = count(self%instant(:self%events) < theta)
      contact_at = self%first_contact
      if (k > 0) contact_at = self%contact(k)
   end function contact_at

   !> Shares of the period in separation and in back contact, at the latest `update`.
   pure subroutine shares(self, separation, back_contact)
      class(contact_type), intent(in) :: self
      !> Share of the period in the gap; share of the period in regions below the gap [1].
      real(dp), intent(out) :: separation, back_contact
      real(dp) :: share(min(self%law%lowest, 0):self%law%highest), last
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
      back_contact = sum(share(:-1))
   end subroutine shares

   !> Least distance of an extreme of p from a wall [1], at the latest `update`: a change of p by this distance may add or remove a
   !> contact. Extremes are those of the parabolas through three samples; of a motion that was not sampled, no more than is known.
   !> Huge for a linear mesh.
   pure real(dp) function clearance(self)
      class(contact_type), intent(in) :: self
      real(dp) :: before, here, after, extreme
      integer :: q, n

      clearance = huge(1.0_dp)
      if (self%margin > 0) clearance = self%margin
      if (self%margin > 0 .or. .not. allocated(self%p)) return
      n = size(self%p)
      before = self%p(n)
      here = self%p(1)
      do q = 1, n
         after = self%p(merge(1, q + 1, q == n))
         if ((here - before)*(after - here) <= 0 .and. abs(before - 2*here + after) > 0) then
            extreme = here - (after - before)**2/(8*(before - 2*here + after))
            clearance = min(clearance, minval(abs(extreme - self%law%wall)))
         end if
         before = here
         here = after
      end do
   end function clearance

   !> Whether p keeps away from all walls, by its amplitudes, at the latest `update`.
   elemental logical function keeps_distance(self)
      class(contact_type), intent(in) :: self

      keeps_distance = self%margin > 0 .or. self%law%highest == self%law%lowest
   end function keeps_distance

   !> Sets `margin` and the region where the sum of all amplitudes does not take p to a wall: of hunting teeth that saves a hundred
   !> thousand samples. The distance left is `far_off` of the amplitudes at least, beside which any error that an estimate is
   !> trusted with is small.
   subroutine find_margin(self, u)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      real(dp), parameter :: far_off = 0.3_dp
      real(dp) :: reach
      integer :: k

      reach = 0
      do k = 2, size(u) - 1, 2
         reach = reach + hypot(u(k), u(k + 1))
      end do
      self%margin = minval(abs(u(1) - self%law%wall)) - reach
      if (.not. self%margin > far_off*reach) self%margin = 0
      if (self%margin > 0) self%first_contact = self%law%region_at(u(1))
   end subroutine find_margin

   !> Finds the crossings of the walls: samples bracket them, Newton's method polishes them. Where the motion turns back towards a
   !> wall between two samples on one side of the wall, the extreme decides whether the wall is crossed twice.
   subroutine find_events(self, u, fine)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      type(transform_type), intent(inout) :: fine
      real(dp) :: spacing, reach, below, above, wall, f0, f1, turn, f_turn
      integer :: q, next, side, first, w, beyond, inside
      logical :: by_samples

      call sample(u, self%harmonic, fine)
      if (allocated(self%p)) then
         if (size(self%p) /= fine%samples) deallocate (self%p, self%slope)
      end if
      if (.not. allocated(self%p)) allocate (self%p(fine%samples), self%slope(fine%samples))
      self%p = fine%sample
      self%first_contact = self%law%region_at(self%p(1))
      if (all(self%p > self%law%wall(self%law%highest - 1) + 0.1_dp*(maxval(self%p) - minval(self%p)))) return
      call sample(u, self%harmonic, fine, derivative=.true.)
      self%slope = fine%sample
      by_samples = fine%samples > many_samples .and. fine%samples >= 8*maxval([0, self%harmonic])
      spacing = 2*pi/fine%samples
      below = huge(below)
      above = huge(above)
      do q = 1, fine%samples
         next = merge(1, q + 1, q == fine%samples)
         reach = spacing*abs(self%slope(q))
         if (stays(self%p(q), self%p(next), reach, below, above)) cycle
         w = self%law%region_at(self%p(q))
         below = -huge(below)
         above = huge(above)
         if (w > self%law%lowest) below = self%law%wall(w - 1)
         if (w < self%law%highest) above = self%law%wall(w)
         if (stays(self%p(q), self%p(next), reach, below, above)) cycle
         first = self%events + 1
         do w = self%law%highest - 1, self%law%lowest, -1
            wall = self%law%wall(w)
            side = merge(1, -1, wall > 0)
            beyond = merge(w + 1, w, wall > 0)
            inside = merge(w, w + 1, wall > 0)
            f0 = side*(self%p(q) - wall)
            f1 = side*(self%p(next) - wall)
            if ((f0 > 0) .neqv. (f1 > 0)) then
               if (by_samples) then
                  turn = (q - 1 + root_at(self, wall, q))*spacing
               else
                  turn = crossing(u, self%harmonic, wall, (q - 1)*spacing, q*spacing, [self%p(q), self%p(next)] - wall, &
                                  [self%slope(q), self%slope(next)])
               end if
               call add_event(self, turn, merge(beyond, inside, f1 > 0), first)
            else if (abs(f0) < spacing*abs(self%slope(q)) .and. abs(f1) < spacing*abs(self%slope(next)) .and. &
                     (self%p(q) - wall)*self%slope(q) < 0 .and. (self%p(q) - wall)*self%slope(next) > 0) then
               call turning(u, self%harmonic, wall, (q - 1)*spacing, q*spacing, turn, f_turn)
               if ((side*f_turn > 0) .eqv. (f0 > 0)) cycle
               call add_event(self, crossing(u, self%harmonic, wall, (q - 1)*spacing, turn, [self%p(q) - wall, f_turn], &
                                             [self%slope(q), 0.0_dp]), merge(inside, beyond, f0 > 0), first)
               call add_event(self, crossing(u, self%harmonic, wall, turn, q*spacing, [f_turn, self%p(next) - wall], &
                                             [0.0_dp, self%slope(next)]), merge(beyond, inside, f0 > 0), first)
            end if
         end do
      end do
   end subroutine find_events

   !> Whether there is no event between two samples p and `next`: both lie between the walls `below` and `above`, and p is farther
   !> from the walls than `reach`.
   pure logical function stays(p, next, reach, below, above)
      real(dp), intent(in) :: p, next, reach, below, above

      stays = p - below >= reach .and. above - p >= reach .and. p > below .and. next > below .and. next <= above
   end function stays

   !> Inserts an event in order of time among the events from number `first` on.
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

   !> Root of p - wall between samples q and q + 1, in spacings of the samples from q on.
   pure real(dp) function root_at(self, wall, q)
      class(contact_type), intent(in) :: self
      real(dp), intent(in) :: wall
      integer, intent(in) :: q
      integer :: i, around(6)

      around = [(modulo(q + i - 1, size(self%p)) + 1, i=-2, 3)]
      root_at = sampled_root(self%p(around) - wall, self%slope(around)*(2*pi/size(self%p)))
   end function root_at

   !> Computes the spectra by the sampled DFT of the paper.
   subroutine sampled_spectra(self, u)
      class(contact_type), intent(inout) :: self
      real(dp), intent(in) :: u(:)
      integer :: k

      associate (q => self%sampled%samples, x => self%sampled%sample, region => self%region_sample, law => self%law, &
                 spectra => self%spectra)
         call sample(u, self%harmonic, self%sampled)
         do k = 1, q
            region(k) = law%region_at(x(k))
         end do
         x = [(self%kappa_sample(k, region(k)), k=1, q)]
         call transform(spectra%stiffness)
         x = [(self%kappa_sample(k, region(k))*law%origin(region(k)), k=1, q)]
         if (allocated(law%offset)) x = x - [(law%offset_at(region(k), 2*pi*self%eta*(k - 1)/q), k=1, q)]
         call transform(spectra%offset)
         if (.not. law%jumps) return
         x = [(law%damping(region(k)), k=1, q)]
         call transform(spectra%damping)
         x = [(law%impulse(region(k)), k=1, q)]
         call transform(spectra%impulse)
      end associate

   contains

      subroutine transform(coefficient)
         complex(dp), intent(out) :: coefficient(0:)

         call self%sampled%to_coefficients()
         coefficient = self%sampled%coefficient(:size(coefficient))/self%sampled%samples
      end subroutine transform

   end subroutine sampled_spectra

end module geartrain_mesh_law_contact
