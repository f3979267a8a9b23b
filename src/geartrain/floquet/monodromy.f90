!> Floquet multipliers of a periodic motion from its monodromy matrix, integrated piece by piece between contact events.
!> Liouville's formula, det M = exp(-sum over n of W_nn times the integral of gamma_n), checks every one of them.
!> Of a train of many states only the leading multipliers are found, by products with a few vectors.
module geartrain_floquet_monodromy
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_sorting, only: ascending
   use geartrain_floquet_leading_multipliers, only: leading, leading_multipliers_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_multipliers, only: eigenvalues
   use geartrain_floquet_propagator, only: propagator_type
   use geartrain_floquet_time_reversal, only: time_reversal_type
   use geartrain_linalg_elimination, only: factor_matrix
   use geartrain_linalg_lapack, only: dgemm
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: has_all_multipliers, monodromy_type

   !> Largest error of the determinant before a matrix is integrated again with shorter steps, and how often that is done: after
   !> the last the multipliers are not confirmed.
   real(dp), parameter :: largest_defect = 1e-7_dp
   integer, parameter :: most_attempts = 3
   !> A piece is cut where some motion may have fallen to exp(-6): the determinant of a longer one drowns in rounding.
   real(dp), parameter :: largest_decay = 6
   !> Halves shorter than this [rad of the fastest motion] are not worth making a whole of.
   real(dp), parameter :: shortest_half = 6
   !> Of an interval, which is no part of its own.
   real(dp), parameter :: rounding = 1e-12_dp

   !> From so many states on only the leading multipliers are found.
   integer, parameter :: many_states = 160

   !> Work space of one branch.
   type :: monodromy_type
      !> Displacements and velocities of all coordinates that the matrix has, and those of them that are states of the train.
      integer :: states = 0
      integer, allocatable, private :: kept(:)
      !> Number of multipliers that are given: of all states, or of the leading ones.
      integer :: given = 0
      !> Monodromy matrix, transposed, (state, state); not held where the leading multipliers suffice.
      real(dp), allocatable :: transposed(:, :)
      !> |log(det M) - log(Liouville)| summed over the pieces [1].
      real(dp) :: liouville_defect = 0
      !> The determinant, or of a train of many states the leading vector, confirms the latest multipliers.
      logical :: confirmed = .true.
      type(propagator_type), private :: propagator
      !> Finds multipliers without the matrix; the multipliers that were found so.
      type(leading_multipliers_type), private :: search
      complex(dp), allocatable, private :: found(:)
      !> What makes a whole of a half.
      type(time_reversal_type), private :: reversal
      !> `transposed` holds nothing yet: it stands for the identity. The open piece has met a wall at which a force jumps.
      logical, private :: empty = .true., sheared = .false.
      logical, private :: interrupted = .false.
      !> Rate at which the determinant decays, every mesh on its drive flank; what the open piece has less of it by meshes whose
      !> damping is another; its beginning and the longest one.
      real(dp), private :: decay = 0, spared = 0, piece_start = 0, piece_limit = 0
      real(dp), allocatable, private :: product(:, :), piece(:, :), before(:, :), factors(:, :), instant(:)
      integer, allocatable, private :: mesh(:), contact(:), now(:), pivot(:)
   contains
      procedure :: setup
      procedure :: integrate
      procedure :: integrate_from
      procedure :: multipliers
      procedure :: is_partial
      procedure, private :: prepare_matrix
      procedure, private :: take_train
      procedure, private :: carry
      procedure, private :: carry_along
      procedure, private :: advance
      procedure, private :: change
      procedure, private :: collect_events
      procedure, private :: close_piece
   end type monodromy_type

contains

   subroutine setup(self, system, all_of_them)
      class(monodromy_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> All multipliers, however many states there are.
      logical, intent(in), optional :: all_of_them
      logical :: whole
      integer :: i

      self%states = 2*system%coordinates
      allocate (self%now(system%meshes))
      whole = has_all_multipliers(system)
      if (present(all_of_them)) whole = whole .or. all_of_them
      self%given = system%states
      self%kept = [(i, i=1, system%displacements), (system%coordinates + i, i=1, system%coordinates)]
      if (whole) return
      self%given = leading
      call self%search%setup(system)
   end subroutine setup

   !> Whether a train has so few states that all multipliers are found, by the matrix.
   pure logical function has_all_multipliers(system)
      type(system_type), intent(in) :: system

      has_all_multipliers = 2*system%coordinates < many_states
   end function has_all_multipliers

   subroutine prepare_matrix(self, system)
      class(monodromy_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system

      call self%propagator%setup(system)
      call self%reversal%setup(system)
      allocate (self%transposed(self%states, self%states), self%product(self%states, self%states), &
                self%piece(self%states, self%states), self%before(self%states, self%states), &
                self%factors(self%states, self%states), self%pivot(self%states))
   end subroutine prepare_matrix

   !> Takes another train with as many coordinates.
   subroutine take_train(self, system)
      class(monodromy_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      type(propagator_type) :: propagator
      type(time_reversal_type) :: reversal
      type(leading_multipliers_type) :: search

      if (self%is_partial()) then
         self%search = search
         call self%search%setup(system)
      end if
      if (.not. allocated(self%transposed)) return
      self%propagator = propagator
      self%reversal = reversal
      call self%propagator%setup(system)
      call self%reversal%setup(system)
   end subroutine take_train

   !> Monodromy matrix of a motion, or its leading multipliers alone: over the period 2 pi eta/Lambda or, where the motion repeats
   !> itself within it, over one repetition. A mesh of order 71 that gains 1.5 a tooth has a multiplier of 1e12 over the period, in
   !> whose rounding all others would drown.
   subroutine integrate(self, motion, frequency_ratio, shift, verdict)
      class(monodromy_type), intent(inout) :: self
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> What each contact event is moved by [rad], (event, unknown mesh).
      real(dp), intent(in), optional :: shift(:, :)
      !> Only a verdict is wanted: of a train of many states multipliers that are all inside the unit circle are found roughly.
      logical, intent(in), optional :: verdict
      real(dp) :: period, begin
      integer :: events, attempt, i
      logical :: roughly, success

      if (motion%varies) call self%take_train(motion%system)
      period = 2*pi*motion%eta/frequency_ratio
      ! Handed on as it is, an absent array would have its bounds read by gfortran 12.
      if (present(shift)) then
         call self%collect_events(motion, period, 0.0_dp, huge(period), shift)
      else
         call self%collect_events(motion, period, 0.0_dp, huge(period))
      end if
      events = size(self%instant)
      self%confirmed = .true.
      period = period/motion%repeats
      if (mod(events, motion%repeats) == 0) then
         events = events/motion%repeats
      else
         ! Two contacts may differ by rounding at a grazing one.
         events = count(self%instant(:events) < period)
      end if
      self%now = 1
      if (allocated(self%found)) deallocate (self%found)
      if (self%is_partial()) then
         roughly = .false.
         if (present(verdict)) roughly = verdict
         allocate (self%found(self%given))
         call self%search%find(motion, frequency_ratio, period, self%instant(:events), self%mesh(:events), self%contact(:events), &
                               roughly, self%found, success)
         if (success) return
         deallocate (self%found)
      end if
      self%interrupted = motion%system%interrupt%raised()
      if (self%interrupted) return
      if (.not. allocated(self%transposed)) call self%prepare_matrix(motion%system)
      do attempt = 0, most_attempts - 1
         call self%propagator%start(frequency_ratio, 2.0_dp**attempt)
         do i = 1, motion%unknowns
            self%now(motion%mesh(i)) = motion%contact(i)%first_contact
         end do
         ! The multipliers do not depend on where the period begins: at an event or, without any, where a half gives the whole.
         if (events > 0) then
            begin = self%instant(1)
         else
            begin = max(-period, self%reversal%centre_near(self%now, frequency_ratio, 0.0_dp)) - period/2
         end if
         call self%carry(motion, frequency_ratio, begin, period, events)
         self%interrupted = motion%system%interrupt%raised()
         self%confirmed = self%liouville_defect < largest_defect
         if (self%confirmed .or. self%interrupted) exit
      end do
   end subroutine integrate

   !> Matrix of the perturbations over a part of the period.
   subroutine integrate_from(self, motion, frequency_ratio, begin, length, shift)
      class(monodromy_type), intent(inout) :: self
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Lambda [1]; time at which the part begins, from 0 to the period, and its length [1].
      real(dp), intent(in) :: frequency_ratio, begin, length
      !> What each contact event is moved by [rad], (event, unknown mesh).
      real(dp), intent(in), optional :: shift(:, :)
      real(dp) :: period
      integer :: attempt, i

      if (motion%varies) call self%take_train(motion%system)
      if (.not. allocated(self%transposed)) call self%prepare_matrix(motion%system)
      if (allocated(self%found)) deallocate (self%found)
      period = 2*pi*motion%eta/frequency_ratio
      self%now = 1
      if (present(shift)) then
         call self%collect_events(motion, period, begin, begin + length, shift)
      else
         call self%collect_events(motion, period, begin, begin + length)
      end if
      do attempt = 0, most_attempts - 1
         call self%propagator%start(frequency_ratio, 2.0_dp**attempt)
         do i = 1, motion%unknowns
            self%now(motion%mesh(i)) = motion%contact(i)%contact_at(begin/period*2*pi)
         end do
         call self%carry(motion, frequency_ratio, begin, length, size(self%instant))
         self%interrupted = motion%system%interrupt%raised()
         self%confirmed = self%liouville_defect < largest_defect
         if (self%confirmed .or. self%interrupted) exit
      end do
   end subroutine integrate_from

   !> The product of the pieces from event to event.
   subroutine carry(self, motion, frequency_ratio, begin, length, events)
      class(monodromy_type), intent(inout) :: self
      class(motion_contacts_type), intent(in) :: motion
      real(dp), intent(in) :: frequency_ratio, begin, length
      integer, intent(in) :: events
      real(dp) :: now, next
      integer :: i

      self%decay = motion%system%decay
      self%piece_limit = length/ceiling(max(1.0_dp, self%propagator%fastest_decay*length/largest_decay))
      self%empty = .true.
      self%liouville_defect = 0
      self%spared = 0
      self%sheared = .false.
      self%piece_start = begin
      now = begin
      do i = 1, events + 1
         next = begin + length
         if (i <= events) next = self%instant(i)
         if (next > now) call self%carry_along(frequency_ratio, now, next)
         if (i <= events) call self%change(i, self%propagator)
         now = next
      end do
      call self%close_piece(begin + length)
   end subroutine carry

   !> Passes event i with a propagator.
   subroutine change(self, i, propagator)
      class(monodromy_type), intent(inout) :: self
      integer, intent(in) :: i
      type(propagator_type), intent(inout) :: propagator

      associate (mesh => self%mesh(i))
         call propagator%pass_wall(mesh, self%now(mesh), self%contact(i), self%sheared)
         self%now(mesh) = self%contact(i)
      end associate
   end subroutine change

   !> Along constant contacts: where kappa is even about an instant between, the part as long before it as after it is made of the
   !> latter.
   recursive subroutine carry_along(self, frequency_ratio, from, to)
      class(monodromy_type), intent(inout) :: self
      real(dp), intent(in) :: frequency_ratio, from, to
      real(dp) :: middle, first, last, least
      integer :: n
      logical :: begins

      n = self%states
      least = shortest_half/self%propagator%fastest
      middle = -huge(1.0_dp)
      if (to - from > 2*least) middle = self%reversal%centre_near(self%now, frequency_ratio, (from + to)/2)
      if (min(middle - from, to - middle) < least) then
         call self%advance(from, to)
         return
      end if
      first = max(from, 2*middle - to)
      last = min(to, 2*middle - from)
      if (first - from > rounding*(to - from)) call self%carry_along(frequency_ratio, from, first)
      call self%close_piece(first)
      begins = self%empty
      if (.not. begins) self%before = self%transposed
      self%empty = .true.
      self%piece_start = middle
      call self%advance(middle, last)
      call self%close_piece(last)
      if (begins) then
         self%product = self%transposed
         call self%reversal%complete(self%now, self%product, self%transposed, self%piece)
      else
         call self%reversal%complete(self%now, self%transposed, self%piece, self%product)
         call dgemm('N', 'N', n, n, n, 1.0_dp, self%before, n, self%piece, n, 0.0_dp, self%transposed, n)
      end if
      if (to - last > rounding*(to - from)) call self%carry_along(frequency_ratio, last, to)
   end subroutine carry_along

   !> Along constant contacts, cut into pieces.
   subroutine advance(self, from, to)
      class(monodromy_type), intent(inout) :: self
      real(dp), intent(in) :: from, to
      real(dp) :: time, rate

      time = from
      rate = self%propagator%spared(self%now)
      do while (to > self%piece_start + self%piece_limit)
         call self%propagator%advance(time, self%piece_start + self%piece_limit, self%now)
         self%spared = self%spared + rate*(self%piece_start + self%piece_limit - time)
         time = self%piece_start + self%piece_limit
         call self%close_piece(time)
      end do
      call self%propagator%advance(time, to, self%now)
      self%spared = self%spared + rate*(to - time)
   end subroutine advance

   !> Events of all meshes from one time to another, in order of time.
   subroutine collect_events(self, motion, period, from, to, shift)
      class(monodromy_type), intent(inout) :: self
      class(motion_contacts_type), intent(in) :: motion
      real(dp), intent(in) :: period, from, to
      real(dp), intent(in), optional :: shift(:, :)
      integer, allocatable :: mesh(:), contact(:), order(:)
      real(dp), allocatable :: instant(:)
      integer :: i, k, n

      n = 0
      do i = 1, motion%unknowns
         n = n + motion%contact(i)%events
      end do
      allocate (mesh(n), contact(n), order(n), instant(n))
      n = 0
      do i = 1, motion%unknowns
         associate (found => motion%contact(i))
            do k = 1, found%events
               instant(n + 1) = found%instant(k)
               if (present(shift)) instant(n + 1) = instant(n + 1) + shift(k, i)
               instant(n + 1) = instant(n + 1)/(2*pi)*period
               if (.not. (instant(n + 1) >= from .and. instant(n + 1) < to)) cycle
               n = n + 1
               mesh(n) = motion%mesh(i)
               contact(n) = found%contact(k)
            end do
         end associate
      end do
      order(:n) = ascending(instant(:n))
      self%instant = instant(order(:n))
      self%mesh = mesh(order(:n))
      self%contact = contact(order(:n))
   end subroutine collect_events

   !> Multiplies the piece that ends at `time` onto the product, checks its determinant and begins the next.
   subroutine close_piece(self, time)
      class(monodromy_type), intent(inout) :: self
      real(dp), intent(in) :: time
      real(dp) :: log_determinant
      integer :: n, i, info

      if (.not. (time > self%piece_start .or. self%sheared)) return
      n = self%states
      call self%propagator%get(self%piece)
      self%factors = self%piece
      call factor_matrix(n, self%factors, self%pivot, info)
      log_determinant = 0
      do i = 1, n
         log_determinant = log_determinant + log(max(abs(self%factors(i, i)), tiny(1.0_dp)))
      end do
      self%liouville_defect = self%liouville_defect + abs(log_determinant + self%decay*(time - self%piece_start) - self%spared)
      if (self%empty) then
         self%transposed = self%piece
      else
         call dgemm('N', 'N', n, n, n, 1.0_dp, self%transposed, n, self%piece, n, 0.0_dp, self%product, n)
         self%transposed = self%product
      end if
      self%empty = .false.
      self%sheared = .false.
      self%spared = 0
      call self%propagator%restart()
      self%piece_start = time
   end subroutine close_piece

   !> Whether of so many states only the leading multipliers are found, without a matrix.
   pure logical function is_partial(self)
      class(monodromy_type), intent(in) :: self

      is_partial = self%given < size(self%kept)
   end function is_partial

   !> The multipliers, largest magnitude first; NaN where the latest `integrate` was interrupted.
   subroutine multipliers(self, values)
      class(monodromy_type), intent(inout) :: self
      !> Multipliers [1], (given).
      complex(dp), intent(out) :: values(:)
      complex(dp) :: all_of_them(size(self%kept))
      real(dp), allocatable :: matrix(:, :)

      if (allocated(self%found)) then
         values = self%found
      else if (self%interrupted) then
         values = ieee_value(0.0_dp, ieee_quiet_nan)
         return
      else
         matrix = self%transposed(self%kept, self%kept)
         call eigenvalues(matrix, all_of_them)
         values = all_of_them(:size(values))
      end if
   end subroutine multipliers

end module geartrain_floquet_monodromy
