!> The linearised balance with one border row and column, and its solution: by elimination where all harmonics are explicit.
!>
!> Of many harmonics only the lowest ones are eliminated. At harmonic r the rest of the matrix is the identity plus a part of order
!> 1/r**2, so GMRES, with the factors of the lowest harmonics and of the mean stiffness at the others as preconditioner, needs no
!> more iterations for more harmonics.
module geartrain_balance_bordered_system
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_equal_system, only: equal_system_type
   use geartrain_balance_fixed_space, only: fixed_space_type
   use geartrain_balance_linear_flow, only: linear_flow_type
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_linalg_least_residual, only: least_residual_type
   implicit none (type, external)
   private
   public :: bordered_system_type

   !> Least residual of GMRES relative to the right-hand side; iterations after which more harmonics are made explicit.
   real(dp), parameter :: tolerance = 1e-10_dp
   integer, parameter :: most_iterations = 40, most_iterations_in_time = 100, most_iterations_in_contact = 200
   !> Least residual with the linearised train in time as preconditioner: of a chosen set of harmonics, whose solution begins from
   !> the former tangent, and of others.
   real(dp), parameter :: tolerance_of_set = 1e-3_dp, tolerance_in_time = 1e-6_dp

   type :: bordered_system_type
      !> Border column and row, (block, unknown), and their corner: the caller sets row and corner between `linearize` and
      !> `factor`, and the column where it is not dS/dLambda.
      real(dp), allocatable :: column(:, :), row(:, :)
      real(dp) :: corner = 0
      !> Sign of the determinant of the explicit harmonics: constant along a smooth branch that keeps its sense.
      integer :: orientation = 1
      !> `orientation` is that of the linearised train in time, which is not comparable with that of the explicit harmonics.
      logical :: oriented_in_time = .false.
      !> Iterations of GMRES in the latest `solve`; 0 by elimination.
      integer :: iterations = 0
      !> Equal branches move equally, and `orientation` is the sign of the determinant in the space of such motions.
      logical :: equal = .false.
      !> Matrix of the explicit harmonics; in the coefficients of one of the branches that move equally.
      type(bordered_type), private :: lowest
      type(equal_system_type), private :: reduced
      !> Factors of each harmonic that is not explicit, (entries of the graph, harmonic).
      complex(dp), allocatable, private :: factors(:, :)
      !> The linearised train in time, which takes the place of `lowest` and `factors` for sets of many harmonics.
      type(linear_flow_type), private :: flow
      logical, private :: flows = .false., suits_flow = .false.
      !> The period is long, and solutions are as exact as with the linearised train in time.
      logical, private :: has_long_period = .false.
      !> Number of explicit harmonics that the factors are of.
      integer, private :: factored = 0
      !> Iterations of GMRES after which other ways are taken.
      integer, private :: most = most_iterations
      !> Orthonormal basis of GMRES, (block, unknown, vector), and its entries in the border row, (vector).
      real(dp), allocatable, private :: basis(:, :, :), basis_y(:)
      !> What the preconditioner makes of the basis: the solution is a sum of it.
      real(dp), allocatable, private :: solved(:, :, :), solved_y(:)
      type(least_residual_type), private :: least
   contains
      procedure :: setup
      procedure :: linearize
      procedure :: factor
      procedure :: difference_signs
      procedure :: keeps
      procedure :: solve
      procedure :: solve_border
      procedure :: solves_in_time
      procedure :: solve_tail
      procedure, private :: factor_again
      procedure, private :: factor_now
      procedure, private :: solve_lowest
      procedure, private :: least_accuracy
      procedure, private :: factor_tail
      procedure, private :: precondition
      procedure, private :: iterate
   end type bordered_system_type

contains

   !> Prepares work space; to be called after each `balance%setup`.
   subroutine setup(self, balance)
      class(bordered_system_type), intent(inout) :: self
      !> Balance to be linearised.
      type(balance_type), intent(in) :: balance

      if (allocated(self%column)) deallocate (self%column, self%row)
      allocate (self%column(balance%block, balance%unknowns), self%row(balance%block, balance%unknowns))
      if (allocated(self%basis)) deallocate (self%basis, self%basis_y, self%solved, self%solved_y)
      self%suits_flow = balance%suits_flow()
      self%has_long_period = (self%suits_flow .or. balance%is_wound()) .and. balance%has_long_period()
      self%most = merge(most_iterations_in_time, most_iterations, self%suits_flow)
      if (self%has_long_period) self%most = most_iterations_in_contact
      if (balance%is_direct() .and. .not. balance%is_wound()) return
      allocate (self%basis(balance%block, balance%unknowns, self%most + 1), self%basis_y(self%most + 1))
      allocate (self%solved(balance%block, balance%unknowns, self%most), self%solved_y(self%most))
   end subroutine setup

   !> Takes dS/du at the last `evaluate`, and dS/dLambda as the border column.
   subroutine linearize(self, balance)
      class(bordered_system_type), intent(inout) :: self
      !> Balance after `evaluate`.
      type(balance_type), intent(in) :: balance

      ! Where no teeth part harmonics are coupled weakly, and the period may be that of hunting teeth.
      self%flows = self%suits_flow .and. balance%suits_flow() .and. (balance%parts() .or. .not. self%has_long_period) &
                   .and. .not. balance%is_wound()
      if (.not. self%flows) call balance%jacobian(self%lowest)
      self%column = balance%d_frequency
   end subroutine linearize

   !> Whether `factor` keeps the matrix, so that `difference_signs` may wait until they are needed: they cost as much as a step of
   !> Newton's method. So they may where there are none.
   pure logical function keeps(self, fixed)
      class(bordered_system_type), intent(in) :: self
      !> Which equal branches move equally.
      type(fixed_space_type), intent(in) :: fixed

      keeps = fixed%is_whole() .or. fixed%joins() .and. .not. self%flows
   end function keeps

   !> Signs of the determinants of the parts of a fixed space, of the explicit harmonics, as bits; to be called between
   !> `linearize` and `factor`, or after `factor` where that `keeps` the matrix.
   integer function difference_signs(self, balance, fixed) result(signs)
      class(bordered_system_type), intent(inout) :: self
      !> Balance as at `linearize`.
      type(balance_type), intent(in) :: balance
      !> Which equal branches move equally.
      type(fixed_space_type), intent(in) :: fixed

      if (self%flows) call balance%jacobian(self%lowest)
      signs = fixed%signs(self%lowest)
   end function difference_signs

   !> Factors the matrix with its border; `linearize` must have been called since the last `factor`, which overwrites it.
   subroutine factor(self, balance, regular, fixed, turn)
      class(bordered_system_type), intent(inout) :: self
      !> Balance as at `linearize`.
      type(balance_type), intent(in) :: balance
      !> Whether the matrix of the explicit harmonics is regular; false also after an interrupt.
      logical, intent(out) :: regular
      !> Space of the right sides and of the solutions: only in it `solve` solves then.
      type(fixed_space_type), intent(in), optional :: fixed
      !> Which planets move one after the other, where no branches move equally.
      type(planet_turn_type), intent(in), optional :: turn
      type(planet_turn_type) :: at_once

      self%equal = .false.
      if (present(fixed) .and. .not. self%flows) self%equal = fixed%joins()
      if (self%equal) call self%reduced%setup(fixed%orbit, fixed%mean, fixed%inverse, at_once, balance%system%cut%graph)
      if (present(turn) .and. .not. (self%equal .or. self%flows)) then
         self%equal = allocated(turn%orbit)
         if (self%equal) call self%reduced%setup(turn%orbit, turn%mean, turn%inverse, turn, balance%system%cut%graph)
      end if
      call self%factor_now(balance, regular)
   end subroutine factor

   !> Factors the matrix as `equal` states.
   subroutine factor_now(self, balance, regular)
      class(bordered_system_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> See `factor`.
      logical, intent(out) :: regular
      integer :: info

      self%oriented_in_time = self%flows
      self%factored = balance%explicit
      if (self%flows) then
         call self%flow%factor(balance, self%column, self%row, self%corner, regular)
         self%orientation = self%flow%orientation
         return
      end if
      associate (n => self%lowest%block)
         if (self%equal) then
            call self%reduced%factor(self%lowest, self%column(:n, :), self%row(:n, :), self%corner, info)
            self%orientation = self%reduced%orientation
         else
            self%lowest%column = self%column(:n, :)
            self%lowest%row = self%row(:n, :)
            self%lowest%corner = self%corner
            call self%lowest%factor(info)
            self%orientation = self%lowest%orientation
         end if
      end associate
      regular = info == 0
      if (regular .and. .not. balance%is_direct()) call self%factor_tail(balance)
   end subroutine factor_now

   !> Solves for the explicit harmonics, in place.
   subroutine solve_lowest(self, x, y)
      class(bordered_system_type), intent(inout) :: self
      !> Right-hand side, afterwards the solution, (explicit block, unknown), and its entry in the border row.
      real(dp), intent(inout) :: x(:, :), y

      if (self%equal) then
         call self%reduced%solve(x, y)
      else
         call self%lowest%solve(x, y)
      end if
   end subroutine solve_lowest

   !> Solves in place.
   subroutine solve(self, balance, x, y, accuracy)
      class(bordered_system_type), intent(inout) :: self
      !> Balance as at `factor`; gets more explicit harmonics where GMRES does not converge.
      type(balance_type), intent(inout) :: balance
      !> Right-hand side, afterwards the solution, (block, unknown), and its entry in the border row: NaN after an interrupt, and
      !> where the matrix with more explicit harmonics is singular.
      real(dp), intent(inout) :: x(:, :), y
      !> Residual relative to the right-hand side at which GMRES ends [1]; `least_accuracy` unless it is given, and at least.
      real(dp), intent(in), optional :: accuracy
      real(dp) :: enough
      logical :: done, regular

      regular = .true.
      ! A motion whose teeth part, or part no more, has another number of explicit harmonics than the one before.
      if (balance%explicit /= self%factored) call self%factor_again(balance, regular)
      enough = self%least_accuracy(balance)
      if (present(accuracy)) enough = max(enough, accuracy)
      self%iterations = 0
      ! Iterations cannot reduce a rest without the symmetry, which near a solution is as large as the residual.
      if (self%equal .and. .not. balance%is_direct()) call self%reduced%project(x)
      do while (regular .and. .not. balance%is_direct())
         call self%iterate(balance, enough, x, y, done)
         if (done) return
         regular = .not. balance%system%interrupt%raised()
         if (.not. regular) exit
         if (.not. self%flows) call balance%make_explicit(2*balance%explicit)
         call self%factor_again(balance, regular)
      end do
      if (regular) then
         call self%solve_lowest(x, y)
      else
         y = ieee_value(y, ieee_quiet_nan)
         x = y
      end if
   end subroutine solve

   !> Solves for a right-hand side that is 0 but for 1 in the border row. Where the balance carries a set of harmonics GMRES begins
   !> from a guess: only sets are worth the risk that, where two branches meet, a residual does not contain the part of the guess
   !> along either branch.
   subroutine solve_border(self, balance, near, near_y, x, y)
      class(bordered_system_type), intent(inout) :: self
      !> Balance as at `factor`; see `solve`.
      type(balance_type), intent(inout) :: balance
      !> Multiple of a guess of the solution, (block, unknown), and of its entry in the border row.
      real(dp), intent(in) :: near(:, :), near_y
      !> The solution, see `solve`.
      real(dp), intent(out) :: x(:, :), y
      real(dp) :: scale, share

      share = 1
      if (balance%chosen .and. .not. balance%is_direct()) then
         scale = sum(self%row*near) + self%corner*near_y
         if (abs(scale) > 0) then
            call balance%apply(near, x)
            x = -(x + near_y*self%column)/scale
            share = sqrt(sum(x**2))
         end if
      end if
      y = 0
      if (share < 1) then
         call self%solve(balance, x, y, self%least_accuracy(balance)/max(share, self%least_accuracy(balance)))
         x = near/scale + x
         y = near_y/scale + y
      else
         x = 0
         y = 1
         call self%solve(balance, x, y)
      end if
   end subroutine solve_border

   !> Residual relative to the right-hand side to which GMRES solves at most.
   pure real(dp) function least_accuracy(self, balance)
      class(bordered_system_type), intent(in) :: self
      type(balance_type), intent(in) :: balance

      least_accuracy = tolerance
      if (self%flows .or. self%has_long_period) least_accuracy = merge(tolerance_of_set, tolerance_in_time, balance%chosen)
   end function least_accuracy

   !> Factors for the number of explicit harmonics that the balance has now, without the linearised train in time. Where that suits
   !> the train the orientation is kept: the two are not comparable.
   subroutine factor_again(self, balance, regular)
      class(bordered_system_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Whether the matrix of the explicit harmonics is regular; false also after an interrupt.
      logical, intent(out) :: regular
      integer :: held
      logical :: held_in_time

      self%flows = .false.
      call balance%jacobian(self%lowest)
      held = self%orientation
      held_in_time = self%oriented_in_time
      call self%factor_now(balance, regular)
      if (self%suits_flow) self%orientation = held
      if (self%suits_flow) self%oriented_in_time = held_in_time
   end subroutine factor_again

   !> Whether the linearised train in time is at hand, which knows all harmonics.
   pure logical function solves_in_time(self)
      class(bordered_system_type), intent(in) :: self

      solves_in_time = self%flows
   end function solves_in_time

   !> Error of the balance to first order, by the residual at the harmonics of a tail, where `solves_in_time`.
   subroutine solve_tail(self, balance, harmonic, tail, x, y)
      class(bordered_system_type), intent(inout) :: self
      !> Balance as at `factor`.
      type(balance_type), intent(in) :: balance
      !> Harmonics of the tail.
      integer, intent(in) :: harmonic(:)
      !> Right-hand side at the tail, afterwards the solution, (tail, unknown).
      complex(dp), intent(inout) :: tail(:, :)
      !> Solution at the carried harmonics, (block, unknown), and the entry in the border row.
      real(dp), intent(out) :: x(:, :), y

      call self%flow%solve_tail(balance, self%column, harmonic, tail, x, y)
   end subroutine solve_tail

   !> Factors the matrix of each harmonic that is not explicit, each mesh with its mean stiffness in contact.
   subroutine factor_tail(self, balance)
      class(bordered_system_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      integer :: m, tail

      tail = size(balance%harmonic) - balance%explicit
      if (allocated(self%factors)) then
         if (size(self%factors, 2) /= tail) deallocate (self%factors)
      end if
      if (.not. allocated(self%factors)) allocate (self%factors(balance%system%cut%graph%entries, tail))
      do m = 1, tail
         associate (k => balance%explicit + m)
            call balance%mean_matrix(balance%harmonic(k), balance%receptance(k), self%factors(:, m))
         end associate
         call factor_scalars(balance%system%cut%graph, self%factors(:, m))
      end do
   end subroutine factor_tail

   !> Solves approximately, in place: the explicit harmonics and the border exactly, every other harmonic by itself.
   subroutine precondition(self, balance, x, y)
      class(bordered_system_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(inout) :: x(:, :), y
      complex(dp) :: p(balance%unknowns)
      integer :: k, m

      if (self%flows) then
         call self%flow%solve(balance, self%column, self%row, x, y)
         return
      end if
      call self%solve_lowest(x(:self%lowest%block, :), y)
      do m = 1, size(self%factors, 2)
         k = balance%explicit + m
         p = cmplx(x(2*k, :) - y*self%column(2*k, :), -x(2*k + 1, :) + y*self%column(2*k + 1, :), dp)
         call solve_scalars(balance%system%cut%graph, self%factors(:, m), p)
         x(2*k, :) = p%re
         x(2*k + 1, :) = -p%im
      end do
   end subroutine precondition

   !> GMRES, preconditioned from the right; leaves x and y unchanged where it does not converge.
   subroutine iterate(self, balance, enough, x, y, converged)
      class(bordered_system_type), intent(inout) :: self
      type(balance_type), intent(inout) :: balance
      real(dp), intent(in) :: enough
      real(dp), intent(inout) :: x(:, :), y
      logical, intent(out) :: converged
      real(dp) :: h(self%most), g(self%most), length, rest, residual
      integer :: j, n

      length = sqrt(sum(x**2) + y**2)
      converged = .not. length > 0
      if (converged) return
      associate (v => self%basis, vy => self%basis_y, z => self%solved, zy => self%solved_y)
         v(:, :, 1) = x/length
         vy(1) = y/length
         call self%least%begin(self%most, length)
         do n = 1, self%most
            if (balance%system%interrupt%raised()) return
            z(:, :, n) = v(:, :, n)
            zy(n) = vy(n)
            call self%precondition(balance, z(:, :, n), zy(n))
            call balance%apply(z(:, :, n), v(:, :, n + 1))
            v(:, :, n + 1) = v(:, :, n + 1) + zy(n)*self%column
            vy(n + 1) = sum(self%row*z(:, :, n)) + self%corner*zy(n)
            do j = 1, n
               h(j) = sum(v(:, :, j)*v(:, :, n + 1)) + vy(j)*vy(n + 1)
               v(:, :, n + 1) = v(:, :, n + 1) - h(j)*v(:, :, j)
               vy(n + 1) = vy(n + 1) - h(j)*vy(j)
            end do
            rest = sqrt(sum(v(:, :, n + 1)**2) + vy(n + 1)**2)
            if (rest > 0) v(:, :, n + 1) = v(:, :, n + 1)/rest
            if (rest > 0) vy(n + 1) = vy(n + 1)/rest
            call self%least%add(h(:n), rest, residual)
            if (residual < 0) return
            converged = residual <= enough*length
            if (converged) exit
         end do
         self%iterations = min(n, self%most)
         if (.not. converged) return
         g(:n) = self%least%weights()
         x = 0
         y = 0
         do j = 1, n
            x = x + g(j)*z(:, :, j)
            y = y + g(j)*zy(j)
         end do
      end associate
   end subroutine iterate

end module geartrain_balance_bordered_system
