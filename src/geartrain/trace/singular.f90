!> The matrix that is singular where a branch bifurcates. Period doubling: the Jacobian of the balance of twice the period, on the
!> odd harmonics, which a motion of the branch lacks. Branch point, where another branch of equal period crosses: the Jacobian of
!> the balance of the branch with the tangent as its border.
!>
!> With vectors b and c, the test function 1/(c . A^-1 b) is smooth along the branch, and zero where the matrix A is singular in a
!> direction to which neither b nor c is orthogonal. b and c are made from vectors without any symmetry, because the critical vector
!> of equal stages may be orthogonal to every vector that is alike in all meshes. For a period doubling b and c are the eigenvectors
!> of the smallest eigenvalues at a solution point nearby, which separate several directions. For a branch point, whose bordered
!> matrix has no useful eigenvectors (border and Lambda may differ in symmetry), b is any vector and c = A^-1 b nearby.
!>
!> Of N equal branches that move equally N - 1 directions become critical at once. b and c are then differences of the first two
!> branches, which A exchanges with differences, so that the test function sees one direction; or they are equal in all branches.
module geartrain_trace_singular
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_system, only: system_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_special_points, only: generic_vector
   implicit none (type, external)
   private
   public :: singular_type

   !> Pairs of vectors b and c, one test function each, and steps of the iteration that finds eigenvectors.
   integer, parameter :: most_modes = 3, iterations = 6
   !> Number of carried harmonics up to which the matrix is eliminated as a whole.
   integer, parameter :: most_explicit = 128

   type :: singular_type
      !> Correctors of the branch and, for period doublings, of twice its period. Of two components of one type gfortran 12 frees
      !> only one, unless they are allocatable.
      type(corrector_type), allocatable :: single, double
      !> The matrix is singular at period doublings, else at branch points.
      logical :: doubles = .false.
      !> Number of the part of the fixed space whose symmetry ends there (fixed_space_type); 0: equal branches go on as they move.
      integer :: group = 0
      !> Vectors b and c: coefficients [1], (block, unknown, mode), and Lambda part [1], (mode).
      real(dp), allocatable, private :: b(:, :, :), b_frequency(:), c(:, :, :), c_frequency(:)
   contains
      procedure :: setup
      procedure :: period
      procedure :: lift
      procedure :: find_modes
      procedure :: test
      procedure :: solution
      procedure, private :: solve
      procedure, private :: factor_at
      procedure, private :: restrict
   end type singular_type

contains

   !> Plans the balances and correctors of the search.
   subroutine setup(self, corrector, systems, doubles, group)
      class(singular_type), intent(inout) :: self
      type(corrector_type), intent(in) :: corrector
      !> Room for the systems that the two balances work on.
      type(system_type), pointer, intent(in) :: systems(:)
      !> Searches for period doublings, else for branch points.
      logical, intent(in) :: doubles
      !> Number of the part of the fixed space whose symmetry ends there; 0 unless it is given.
      integer, intent(in), optional :: group

      self%doubles = doubles
      if (present(group)) self%group = group
      allocate (self%single, self%double)
      self%single%fixed = corrector%fixed
      associate (balance => corrector%balance)
         call plan(self%single, systems(1), 1, balance%repeats)
         if (.not. doubles) return
         if (mod(balance%repeats, 2) == 0) then
            call plan(self%double, systems(2), 1, balance%repeats/2)
         else
            call plan(self%double, systems(2), 2, 1)
         end if
      end associate

   contains

      !> Plans a balance of `times` the sub-harmonic index, whose motions go `repeats` times through their waveform.
      subroutine plan(own, system, times, repeats)
         type(corrector_type), intent(inout) :: own
         type(system_type), target, intent(inout) :: system
         integer, intent(in) :: times, repeats

         own%units = corrector%units
         if (allocated(corrector%balance%path)) own%balance%path = corrector%balance%path
         associate (balance => corrector%balance)
            system = balance%system
            if (balance%chosen .and. times == 1 .and. repeats == balance%repeats) then
               call own%balance%setup(system, balance%highest, balance%eta, balance%samples, balance%harmonic, repeats)
            else
               call own%balance%setup(system, times*balance%highest, times*balance%eta, times*balance%samples, repeats=repeats)
            end if
         end associate
         call own%setup()
      end subroutine plan

   end subroutine setup

   !> Period of whose frequency the harmonics of the critical points are multiples, in periods of the excitation.
   pure integer function period(self)
      class(singular_type), intent(in) :: self

      period = self%single%balance%eta
      if (self%doubles) period = self%double%balance%eta
      period = period*self%single%balance%system%excitation_order
   end function period

   !> Factors the matrix at a solution point of the branch, whether it is regular or not: rounding keeps the factors finite.
   subroutine factor_at(self, solution)
      class(singular_type), intent(inout) :: self
      type(solution_point_type), intent(in) :: solution
      type(solution_point_type) :: twice

      if (self%doubles) then
         call self%lift(solution, twice)
         call factor(self%double, twice, bordered=.false.)
      else
         call factor(self%single, solution, bordered=.true.)
      end if
   end subroutine factor_at

   !> Factors the Jacobian of a balance, bordered by the tangent or with the border decoupled.
   subroutine factor(corrector, solution, bordered)
      type(corrector_type), intent(inout) :: corrector
      type(solution_point_type), intent(in) :: solution
      logical, intent(in) :: bordered
      logical :: regular

      associate (balance => corrector%balance, matrix => corrector%matrix)
         call balance%evaluate(solution%u, solution%frequency_ratio)
         ! Elimination, unlike GMRES, is as exact next to a critical point as elsewhere.
         if (size(balance%harmonic) <= most_explicit) call balance%make_explicit(size(balance%harmonic))
         call matrix%linearize(balance)
         if (bordered) then
            call corrector%across(solution, matrix%row, matrix%corner)
         else
            matrix%column = 0
            matrix%row = 0
            matrix%corner = 1
         end if
         call matrix%factor(balance, regular)
      end associate
   end subroutine factor

   !> A motion of the branch as a motion of twice the period.
   subroutine lift(self, solution, twice)
      class(singular_type), intent(in) :: self
      !> Solution point of the balance `single`.
      type(solution_point_type), intent(in) :: solution
      !> The motion on the harmonics of the balance `double`, the tangent 0.
      type(solution_point_type), intent(out) :: twice
      integer :: k, r

      associate (balance => self%double%balance, harmonic => self%single%balance%harmonic)
         allocate (twice%u(balance%block, balance%unknowns), twice%tangent(balance%block, balance%unknowns), source=0.0_dp)
         twice%u(1, :) = solution%u(1, :)
         do k = 1, size(harmonic)
            ! The balance of twice the period carries every harmonic that it can have.
            r = harmonic(k)*(balance%eta/self%single%balance%eta)/balance%repeats
            twice%u(2*r:2*r + 1, :) = solution%u(2*k:2*k + 1, :)
         end do
         twice%frequency_ratio = solution%frequency_ratio
      end associate
   end subroutine lift

   !> Solves in place with the latest factors.
   subroutine solve(self, u, y)
      class(singular_type), intent(inout) :: self
      real(dp), intent(inout) :: u(:, :), y

      if (self%doubles) then
         call self%double%matrix%solve(self%double%balance, u, y)
      else
         call self%single%matrix%solve(self%single%balance, u, y)
      end if
   end subroutine solve

   !> Restricts coefficients to differences within the group, or to those in which equal branches move equally.
   subroutine restrict(self, x)
      class(singular_type), intent(in) :: self
      real(dp), intent(inout) :: x(:, :)

      if (self%group > 0) then
         call self%single%fixed%keep_difference(self%group, x)
      else
         if (self%doubles) call self%single%fixed%project_at_once(x)
         if (.not. self%doubles) call self%single%fixed%project(x)
      end if
   end subroutine restrict

   !> Number of unknowns that are free in the restricted coefficients.
   integer function free_unknowns(self)
      class(singular_type), intent(in) :: self
      real(dp) :: x(1, self%single%balance%unknowns)
      integer :: i, k

      free_unknowns = self%single%balance%unknowns
      if (self%single%fixed%is_whole()) return
      free_unknowns = 0
      do i = 1, size(x, 2)
         x = 0
         x(1, i) = 1
         call self%restrict(x)
         k = findloc(abs(x(1, :)) > 0, .true., 1)
         if (k == i) free_unknowns = free_unknowns + 1
      end do
   end function free_unknowns

   !> Chooses the vectors b and c.
   subroutine find_modes(self, solution)
      class(singular_type), intent(inout) :: self
      !> Solution point of the branch, with its tangent, from which the search begins.
      type(solution_point_type), intent(in) :: solution
      integer :: i, j, rows, columns

      call self%factor_at(solution)
      associate (balance => self%single%balance, twice => self%double%balance)
         rows = merge(twice%block, balance%block, self%doubles)
         columns = balance%unknowns
      end associate
      allocate (self%b(rows, columns, most_modes), self%b_frequency(most_modes))
      do j = 1, most_modes
         call generic_vector(j, self%b(:, :, j), self%b_frequency(j))
         if (self%doubles) call keep_odd(self%double%balance%harmonic/self%double%balance%repeats, self%b(:, :, j))
         call self%restrict(self%b(:, :, j))
         if (self%doubles .or. self%group > 0) self%b_frequency(j) = 0
      end do
      if (self%doubles) call find_eigenvectors(self)
      self%c = self%b
      self%c_frequency = self%b_frequency
      if (self%doubles) return
      do i = 1, most_modes
         call self%single%fixed%as_right_side(self%c(:, :, i))
         call self%solve(self%c(:, :, i), self%c_frequency(i))
         call self%restrict(self%c(:, :, i))
         self%c_frequency(i) = self%c_frequency(i)/self%single%units%frequency_ratio
         call normalize(self%c(:, :, i), self%c_frequency(i))
      end do
   end subroutine find_modes

   pure subroutine normalize(u, y)
      real(dp), intent(inout) :: u(:, :), y
      real(dp) :: length

      length = sqrt(sum(u**2) + y**2)
      u = u/length
      y = y/length
   end subroutine normalize

   !> Turns b into unit eigenvectors of the smallest real eigenvalues of the matrix factored last, smallest first.
   subroutine find_eigenvectors(self)
      class(singular_type), intent(inout) :: self
      real(dp), allocatable :: solved(:, :, :)
      real(dp) :: reduced(most_modes, most_modes), weight(most_modes, most_modes), y
      integer :: i, j, l, found, n

      ! A single mesh with one harmonic has no more than two odd coefficients.
      n = min(most_modes, (size(self%b, 1)/2)*free_unknowns(self))
      do i = 0, iterations
         do j = 1, n
            y = 0
            if (i > 0) call self%solve(self%b(:, :, j), y)
            ! Rounding must not grow towards other directions that are critical nearby.
            if (i > 0) call self%restrict(self%b(:, :, j))
            do l = 1, j - 1
               self%b(:, :, j) = self%b(:, :, j) - sum(self%b(:, :, l)*self%b(:, :, j))*self%b(:, :, l)
            end do
            self%b(:, :, j) = self%b(:, :, j)/norm2(self%b(:, :, j))
         end do
      end do
      solved = self%b
      do j = 1, n
         y = 0
         call self%solve(solved(:, :, j), y)
         call self%restrict(solved(:, :, j))
         do i = 1, n
            reduced(i, j) = sum(self%b(:, :, i)*solved(:, :, j))
         end do
      end do
      call real_modes(reduced(:n, :n), weight, found)
      do j = 1, found
         solved(:, :, j) = 0
         do i = 1, n
            solved(:, :, j) = solved(:, :, j) + weight(i, j)*self%b(:, :, i)
         end do
      end do
      self%b = solved(:, :, :found)
      self%b_frequency = [(0.0_dp, i=1, found)]
   end subroutine find_eigenvectors

   !> Unit eigenvectors of the real eigenvalues of a small matrix, the largest eigenvalue first.
   subroutine real_modes(matrix, vector, found)
      real(dp), intent(in) :: matrix(:, :)
      real(dp), intent(out) :: vector(:, :)
      integer, intent(out) :: found
      complex(dp) :: values(size(matrix, 1))
      real(dp) :: copy(size(matrix, 1), size(matrix, 1)), scale
      integer :: i, j, l, n, info, pivot(size(matrix, 1))

      n = size(matrix, 1)
      copy = matrix
      call find_eigenvalues(n, copy, values, info)
      found = 0
      if (info /= 0) return
      scale = maxval(abs(values))
      do
         i = maxloc(abs(values), 1)
         if (.not. abs(values(i)) > 0) return
         if (abs(values(i)%im) <= 1e-10_dp*scale) then
            found = found + 1
            copy = matrix
            do j = 1, n
               copy(j, j) = copy(j, j) - values(i)%re - 1e-12_dp*scale
            end do
            call factor_matrix(n, copy, pivot, info)
            associate (v => vector(:n, found))
               ! For a double eigenvalue another start gives another vector.
               v = [(cos(real(l*found, dp)), l=1, n)]
               do j = 1, 3
                  call solve_factored(n, 1, copy, pivot, v)
                  v = v/norm2(v)
               end do
            end associate
         end if
         values(i) = 0
      end do
   end subroutine real_modes

   !> Sets the mean and the even harmonics of a set of coefficients to 0.
   pure subroutine keep_odd(harmonic, u)
      integer, intent(in) :: harmonic(:)
      real(dp), intent(inout) :: u(:, :)
      integer :: k

      u(1, :) = 0
      do k = 1, size(harmonic)
         if (mod(harmonic(k), 2) == 0) u(2*k:2*k + 1, :) = 0
      end do
   end subroutine keep_odd

   !> The test functions 1/(c . A^-1 b) at a solution point.
   subroutine test(self, solution, f)
      class(singular_type), intent(inout) :: self
      !> Solution point of the branch, with its tangent.
      type(solution_point_type), intent(in) :: solution
      !> Values of the test functions [1], (mode).
      real(dp), allocatable, intent(out) :: f(:)
      real(dp) :: x(size(self%b, 1), size(self%b, 2)), y
      integer :: j

      allocate (f(size(self%b_frequency)))
      call self%factor_at(solution)
      do j = 1, size(f)
         call self%solution(j, x, y)
         f(j) = 1/(sum(self%c(:, :, j)*x) + self%c_frequency(j)*y/self%single%units%frequency_ratio)
      end do
   end subroutine test

   !> A^-1 b at the latest `test`: next to a critical point a multiple of the critical vector.
   subroutine solution(self, mode, x, y)
      class(singular_type), intent(inout) :: self
      !> Number of the vector b.
      integer, intent(in) :: mode
      !> Coefficients [1], (block, unknown), and Lambda part [1].
      real(dp), intent(out) :: x(:, :), y

      x = self%b(:, :, mode)
      y = self%b_frequency(mode)
      if (.not. self%doubles) call self%single%fixed%as_right_side(x)
      call self%solve(x, y)
      call self%restrict(x)
   end subroutine solution

end module geartrain_trace_singular
