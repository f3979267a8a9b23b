!> Floquet multipliers of a periodic motion from its monodromy matrix, integrated piece by piece between contact events.
!> Liouville's formula, det M = exp(-T sum over n of W_nn gamma_n), whatever the contacts, checks every one of them.
module geartrain_stability_monodromy
   use geartrain_base_eigenvalues, only: find_eigenvalues
   use geartrain_base_elimination, only: factor_matrix
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_lapack, only: dgemm
   use geartrain_model_system, only: system_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_stability_propagator, only: propagator_type
   implicit none (type, external)
   private
   public :: monodromy_type, eigenvalues, is_stable, is_neutral, neutral

   !> A multiplier as near as this to the unit circle counts as neutral, which is not stable.
   real(dp), parameter :: neutral = 1e-9_dp

   !> Largest error of the determinant before a matrix is integrated again with shorter steps, and how often that is done.
   real(dp), parameter :: largest_defect = 1e-7_dp
   integer, parameter :: most_attempts = 3
   !> A piece is cut where some motion may have fallen to exp(-6): the determinant of a longer one drowns in rounding.
   real(dp), parameter :: largest_decay = 6

   !> Work space of one branch.
   type :: monodromy_type
      integer :: states = 0
      !> Monodromy matrix, transposed, (state, state).
      real(dp), allocatable :: transposed(:, :)
      !> |log(det M) - log(Liouville)| summed over the pieces [1].
      real(dp) :: liouville_defect = 0
      type(propagator_type), private :: propagator
      real(dp), allocatable, private :: product(:, :), piece(:, :), factors(:, :), instant(:)
      integer, allocatable, private :: mesh(:), contact(:), now(:), pivot(:)
   contains
      procedure :: setup
      procedure :: integrate
      procedure :: multipliers
      procedure, private :: carry
      procedure, private :: collect_events
      procedure, private :: close_piece
   end type monodromy_type

contains

   subroutine setup(self, system)
      class(monodromy_type), intent(inout) :: self
      type(system_type), intent(in) :: system

      self%states = 2*system%elements
      call self%propagator%setup(system)
      allocate (self%now(system%meshes))
      allocate (self%transposed(self%states, self%states), self%product(self%states, self%states), &
                self%piece(self%states, self%states), &
                self%factors(self%states, self%states), self%pivot(self%states), self%instant(64), self%mesh(64), &
                self%contact(64))
   end subroutine setup

   !> Monodromy matrix over the period 2 pi eta/Lambda of the motion at which `balance` was last evaluated.
   subroutine integrate(self, balance, frequency, shift)
      class(monodromy_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: frequency
      !> What each contact event is moved by [rad], (event, unknown mesh).
      real(dp), intent(in), optional :: shift(:, :)
      real(dp) :: period
      integer :: events, attempt

      period = 2*pi*balance%eta/frequency
      call self%collect_events(balance, period, events, shift)
      do attempt = 0, most_attempts - 1
         call self%propagator%start(frequency, 2.0_dp**attempt)
         call self%carry(balance, period, events)
         if (self%liouville_defect < largest_defect) exit
      end do
   end subroutine integrate

   !> The product of the pieces from event to event over the period.
   subroutine carry(self, balance, period, events)
      class(monodromy_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: period
      integer, intent(in) :: events
      real(dp) :: decay, piece_start, piece_limit, time, next
      integer :: i

      decay = sum(balance%system%coupling(2, :)*balance%system%damping)
      piece_limit = period/ceiling(max(1.0_dp, self%propagator%fastest_decay*period/largest_decay))
      self%now = 1
      do i = 1, balance%unknowns
         self%now(balance%mesh(i)) = balance%contact(i)%first_contact
      end do
      call identity(self%transposed)
      self%liouville_defect = 0
      piece_start = 0
      time = 0
      do i = 1, events + 1
         next = period
         if (i <= events) next = self%instant(i)
         do while (next > piece_start + piece_limit)
            call self%propagator%advance(time, piece_start + piece_limit, self%now)
            time = piece_start + piece_limit
            call self%close_piece(decay*(time - piece_start))
            piece_start = time
         end do
         call self%propagator%advance(time, next, self%now)
         time = next
         if (i <= events) self%now(self%mesh(i)) = self%contact(i)
      end do
      call self%close_piece(decay*(time - piece_start))
   end subroutine carry

   !> Events of all meshes in order of time.
   subroutine collect_events(self, balance, period, events, shift)
      class(monodromy_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: period
      integer, intent(out) :: events
      real(dp), intent(in), optional :: shift(:, :)
      integer :: i, k, place
      real(dp) :: t

      events = 0
      do i = 1, balance%unknowns
         do k = 1, balance%contact(i)%events
            if (events == size(self%instant)) then
               self%instant = [self%instant, self%instant]
               self%mesh = [self%mesh, self%mesh]
               self%contact = [self%contact, self%contact]
            end if
            t = balance%contact(i)%instant(k)
            if (present(shift)) t = t + shift(k, i)
            t = t/(2*pi)*period
            events = events + 1
            place = events
            do while (place > 1)
               if (self%instant(place - 1) <= t) exit
               self%instant(place) = self%instant(place - 1)
               self%mesh(place) = self%mesh(place - 1)
               self%contact(place) = self%contact(place - 1)
               place = place - 1
            end do
            self%instant(place) = t
            self%mesh(place) = balance%mesh(i)
            self%contact(place) = balance%contact(i)%contact(k)
         end do
      end do
   end subroutine collect_events

   !> Multiplies the piece onto the product, checks its determinant against exp(-decay) and begins the next.
   subroutine close_piece(self, decay)
      class(monodromy_type), intent(inout) :: self
      real(dp), intent(in) :: decay
      real(dp) :: log_determinant
      integer :: n, i, info

      n = self%states
      call self%propagator%get(self%piece)
      self%factors = self%piece
      call factor_matrix(n, self%factors, self%pivot, info)
      log_determinant = 0
      do i = 1, n
         log_determinant = log_determinant + log(max(abs(self%factors(i, i)), tiny(1.0_dp)))
      end do
      self%liouville_defect = self%liouville_defect + abs(log_determinant + decay)
      call dgemm('N', 'N', n, n, n, 1.0_dp, self%transposed, n, self%piece, n, 0.0_dp, self%product, n)
      self%transposed = self%product
      call self%propagator%restart()
   end subroutine close_piece

   pure subroutine identity(a)
      real(dp), intent(out) :: a(:, :)
      integer :: i

      a = 0
      do i = 1, size(a, 1)
         a(i, i) = 1
      end do
   end subroutine identity

   !> The multipliers, largest magnitude first.
   subroutine multipliers(self, values)
      class(monodromy_type), intent(inout) :: self
      complex(dp), intent(out) :: values(:)

      self%product = self%transposed
      call eigenvalues(self%product, values)
   end subroutine multipliers

   !> Eigenvalues of a matrix (destroyed), largest magnitude first; NaN where they do not converge.
   subroutine eigenvalues(matrix, values)
      use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
      real(dp), intent(inout) :: matrix(:, :)
      complex(dp), intent(out) :: values(:)
      complex(dp) :: held
      integer :: info, i, j

      call find_eigenvalues(size(values), matrix, values, info)
      if (info /= 0) values = ieee_value(0.0_dp, ieee_quiet_nan)
      do i = 2, size(values)
         held = values(i)
         do j = i - 1, 1, -1
            if (abs(values(j)) >= abs(held)) exit
            values(j + 1) = values(j)
         end do
         values(j + 1) = held
      end do
   end subroutine eigenvalues

   !> The largest multiplier, that is the first, is on the unit circle as far as rounding tells; or it is not a number.
   pure logical function is_neutral(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      is_neutral = .not. abs(abs(multipliers(1)) - 1) > neutral
   end function is_neutral

   !> All multipliers inside the unit circle, by more than their rounding.
   pure logical function is_stable(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      is_stable = all(abs(multipliers) < 1 - neutral)
   end function is_stable

end module geartrain_stability_monodromy
