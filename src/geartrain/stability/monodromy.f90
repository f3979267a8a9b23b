!> Floquet multipliers of a periodic motion from its monodromy matrix, integrated piece by piece between contact events.
!> Liouville's formula, det M = exp(-T sum over n of W_nn gamma_n), whatever the contacts, checks every one of them.
module geartrain_stability_monodromy
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_lapack, only: dgeev, dgemm, dgetrf
   use geartrain_model_system, only: system_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_flow, only: flow_type
   implicit none (type, external)
   private
   public :: monodromy_type, eigenvalues, is_stable, neutral

   !> A multiplier as near as this to the unit circle counts as neutral, which is not stable.
   real(dp), parameter :: neutral = 1e-9_dp

   !> Relative error of a step and the order of the series: multipliers to about 1e-9. A high order is cheap, because the
   !> recurrence costs the same for every term.
   real(dp), parameter :: tolerance = 1e-10_dp
   integer, parameter :: order = 28
   !> A piece is cut where its determinant falls below exp(-6): a smaller one drowns in rounding and checks nothing.
   real(dp), parameter :: largest_decay = 6

   !> Work space of one branch.
   type :: monodromy_type
      integer :: states = 0
      !> Monodromy matrix, transposed, (state, state).
      real(dp), allocatable :: transposed(:, :)
      !> |log(det M) - log(Liouville)| summed over the pieces [1].
      real(dp) :: liouville_defect = 0
      type(flow_type), private :: flow
      real(dp), allocatable, private :: product(:, :), factors(:, :), instant(:)
      integer, allocatable, private :: mesh(:), contact(:), pivot(:)
   contains
      procedure :: setup
      procedure :: integrate
      procedure :: multipliers
      procedure, private :: collect_events
      procedure, private :: close_piece
   end type monodromy_type

contains

   subroutine setup(self, system)
      class(monodromy_type), intent(inout) :: self
      type(system_type), intent(in) :: system

      self%states = 2*system%elements
      call self%flow%setup(system, self%states, .false., order, tolerance)
      allocate (self%transposed(self%states, self%states), self%product(self%states, self%states), &
                self%factors(self%states, self%states), self%pivot(self%states), self%instant(64), self%mesh(64), &
                self%contact(64))
   end subroutine setup

   !> Monodromy matrix over the period 2 pi eta/Lambda of the motion at which `balance` was last evaluated.
   subroutine integrate(self, balance, frequency)
      class(monodromy_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: frequency
      real(dp) :: period, decay, piece_start, piece_limit, next
      integer :: events, i, j

      period = 2*pi*balance%eta/frequency
      decay = sum(self%flow%system%coupling(2, :)*self%flow%system%damping)
      piece_limit = period
      if (decay > 0) piece_limit = period/ceiling(max(1.0_dp, decay*period/largest_decay))
      call self%collect_events(balance, period, events)
      self%flow%contact = 1
      do i = 1, balance%unknowns
         self%flow%contact(balance%mesh(i)) = balance%contact(i)%first_contact
      end do
      call identity(self%flow%x)
      call identity(self%transposed)
      call self%flow%start(frequency, 0.0_dp)
      self%liouville_defect = 0
      piece_start = 0
      do i = 1, events + 1
         next = period
         if (i <= events) next = self%instant(i)
         do while (next > piece_start + piece_limit)
            call self%flow%advance(piece_start + piece_limit)
            call self%close_piece(decay*(self%flow%time - piece_start))
            piece_start = self%flow%time
         end do
         call self%flow%advance(next)
         if (i > events) exit
         j = self%mesh(i)
         self%flow%contact(j) = self%contact(i)
      end do
      call self%close_piece(decay*(self%flow%time - piece_start))
   end subroutine integrate

   !> Events of all meshes in order of time.
   subroutine collect_events(self, balance, period, events)
      class(monodromy_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: period
      integer, intent(out) :: events
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
            t = balance%contact(i)%instant(k)/(2*pi)*period
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
      self%factors = self%flow%x
      call dgetrf(n, n, self%factors, n, self%pivot, info)
      log_determinant = 0
      do i = 1, n
         log_determinant = log_determinant + log(max(abs(self%factors(i, i)), tiny(1.0_dp)))
      end do
      self%liouville_defect = self%liouville_defect + abs(log_determinant + decay)
      call dgemm('N', 'N', n, n, n, 1.0_dp, self%transposed, n, self%flow%x, n, 0.0_dp, self%product, n)
      self%transposed = self%product
      call identity(self%flow%x)
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

   !> Eigenvalues of a matrix (destroyed), largest magnitude first; NaN if LAPACK does not converge.
   subroutine eigenvalues(matrix, values)
      use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
      real(dp), intent(inout) :: matrix(:, :)
      complex(dp), intent(out) :: values(:)
      real(dp) :: wr(size(values)), wi(size(values)), work(8*size(values)), empty(1, 1)
      complex(dp) :: held
      integer :: info, i, j

      call dgeev('N', 'N', size(values), matrix, size(values), wr, wi, empty, 1, empty, 1, work, size(work), info)
      values = cmplx(wr, wi, dp)
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

   !> All multipliers inside the unit circle, by more than their rounding.
   pure logical function is_stable(multipliers)
      complex(dp), intent(in) :: multipliers(:)

      is_stable = all(abs(multipliers) < 1 - neutral)
   end function is_stable

end module geartrain_stability_monodromy
