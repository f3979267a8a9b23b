!> The balance's Jacobians against central differences, and its linear part against other routes.
module unit_balance
   use fixtures, only: long_train, paper_train, single_pair
   use geartrain, only: dp, error_type, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_graph, only: graph_type
   use geartrain_network_receptance, only: find_receptance, receptance_type
   use geartrain_network_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: balance_tests

contains

   subroutine balance_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('jacobian')) then
         call jacobian_at_random(tests, paper_train(), 6, 1, 0, 5.0_dp, 'exact, separation and back contact')
         call jacobian_at_random(tests, paper_train(), 6, 1, 0, 0.05_dp, 'exact, in contact')
         call jacobian_at_random(tests, paper_train(), 9, 3, 0, 5.0_dp, 'exact, sub-harmonic 3')
         call jacobian_at_random(tests, paper_train(), 6, 1, 128, 5.0_dp, 'sampled')
         call jacobian_at_random(tests, long_train(5), 8, 1, 0, 5.0_dp, 'everything, 5 shafts')
         call jacobian_at_random(tests, long_train(3), 6, 2, 0, 5.0_dp, 'everything, 3 shafts')
         call jacobian_at_random(tests, single_pair(0.05_dp, 0.3_dp, 0.4_dp), 12, 1, 0, 5.0_dp, 'single pair')
      end if
      if (tests%runs('singular_block')) call singular_block(tests)
      if (tests%runs('condensed_linear_mesh')) call condensed_linear_mesh(tests)
      if (tests%runs('receptance_derivative')) call receptance_derivative(tests)
      if (tests%runs('beside_a_wall')) call beside_a_wall(tests)
   end subroutine balance_tests

   !> Regular matrices of which a diagonal block is singular, the first in the order of elimination or a later one.
   subroutine singular_block(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: n = 3, nodes = 4, pairs(2, 4) = reshape([1, 2, 2, 3, 3, 1, 3, 4], [2, 4])
      type(bordered_type) :: matrix
      type(graph_type) :: graph
      real(dp) :: whole(n*nodes + 1, n*nodes + 1), random(n*nodes + 1, n*nodes + 1), right(n*nodes + 1), x(n, nodes), y
      integer :: pivot(n*nodes + 1), i, info, j, singular

      call graph%setup(nodes, pairs)
      do singular = 1, nodes
         call matrix%resize(n, graph)
         call pseudo_random(random)
         whole = 0
         do i = 1, nodes
            do j = 1, nodes
               if (graph%entry_of(i, j) == 0) cycle
               whole(n*(i - 1) + 1:n*i, n*(j - 1) + 1:n*j) = random(n*(i - 1) + 1:n*i, n*(j - 1) + 1:n*j)
               if (i == j .and. i == singular) whole(n*i, n*(i - 1) + 1:n*i) = 0
               matrix%entry(:, :, graph%entry_of(i, j)) = whole(n*(i - 1) + 1:n*i, n*(j - 1) + 1:n*j)
            end do
         end do
         whole(:, n*nodes + 1) = random(:, n*nodes + 1)
         whole(n*nodes + 1, :) = random(n*nodes + 1, :)
         matrix%column = reshape(whole(:n*nodes, n*nodes + 1), [n, nodes])
         matrix%row = reshape(whole(n*nodes + 1, :n*nodes), [n, nodes])
         matrix%corner = whole(n*nodes + 1, n*nodes + 1)
         right = random(:, 1)
         x = reshape(right(:n*nodes), [n, nodes])
         y = right(n*nodes + 1)
         call matrix%factor(info)
         call tests%is_true(info == 0, 'block '//integer_text(singular)//' is singular: the matrix is regular')
         if (info /= 0) cycle
         call matrix%solve(x, y)
         call factor_matrix(n*nodes + 1, whole, pivot, info)
         call solve_factored(n*nodes + 1, 1, whole, pivot, right)
         call tests%is_close(maxval(abs([reshape(x, [n*nodes]), y] - right)), 0.0_dp, 1e-11_dp*maxval(abs(right)), &
                             'block '//integer_text(singular)//' is singular: the solution')
      end do
   end subroutine singular_block

   !> dS/ds over a backlash where the teeth all but part. While they are in contact the residual is linear in the backlash, so
   !> that a long difference to the side where they stay in contact is exact but for rounding.
   subroutine beside_a_wall(tests)
      class(tests_type), intent(inout) :: tests
      !> Gap that is left, over the amplitude [1]: less than the differences within `evaluate` move the wall.
      real(dp), parameter :: gap = 1e-8_dp, shortest = 20e-6_dp, longest = 40e-6_dp, at = 30e-6_dp, amplitude = 0.5_dp
      type(system_type), target :: system
      type(balance_type) :: balance
      type(error_type), allocatable :: error
      real(dp), allocatable :: u(:, :), rate(:, :), long_difference(:, :)

      allocate (balance%path)
      call balance%path%setup(paper_train(), 'mesh 2 half_backlash', 0.7_dp, shortest, longest, error)
      call tests%is_true(.not. allocated(error), 'a path over a backlash')
      if (allocated(error)) return
      call balance%path%system_at(at, system)
      call balance%setup(system, 5, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(1, :) = system%half_backlash(balance%mesh) + amplitude
      u(2, :) = amplitude*(1 - gap)
      call balance%evaluate(u, at)
      rate = balance%d_frequency
      long_difference = balance%residual
      call balance%evaluate(u, shortest)
      long_difference = (long_difference - balance%residual)/(at - shortest)
      call tests%is_close(maxval(abs(rate - long_difference)), 0.0_dp, 1e-8_dp*maxval(abs(long_difference)), &
                          'dS/ds beside a wall')
   end subroutine beside_a_wall

   !> dS/du and dS/dLambda by central differences (step 1e-6, error about 1e-8 of the entries for a force whose second
   !> derivative is bounded between events).
   subroutine jacobian_at_random(tests, train, harmonics, eta, samples, spread, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics, eta, samples
      real(dp), intent(in) :: spread
      character(*), intent(in) :: name
      type(system_type), target :: system
      type(balance_type) :: balance
      type(bordered_type) :: matrix
      real(dp), allocatable :: u(:, :), moved(:, :), difference(:, :)
      real(dp), parameter :: h = 1e-6_dp, frequency_ratio = 0.73_dp
      real(dp) :: worst, largest
      integer :: entry, i, j, k, n

      call build_system(train, system)
      call balance%setup(system, harmonics, eta, samples)
      n = balance%unknowns
      allocate (u(balance%block, n), moved(balance%block, n), difference(balance%block, n))
      call pseudo_random(u)
      u = spread*u
      u(1, :) = u(1, :) + 0.1_dp*spread
      if (spread < 0.1_dp) u(1, :) = u(1, :) + 3
      call balance%evaluate(u, frequency_ratio)
      call balance%jacobian(matrix)
      if (spread > 1) call tests%is_true(samples > 0 .or. &
         all(balance%contact(:)%events > 0 .or. system%half_backlash(balance%mesh) <= 0), &
                                         name//': the state has contact events')
      largest = maxval(abs(matrix%entry(:, :, :n)))
      worst = 0
      do i = 1, n
         do k = 1, balance%block
            moved = u
            moved(k, i) = u(k, i) + h
            call balance%evaluate(moved, frequency_ratio)
            difference = balance%residual
            moved(k, i) = u(k, i) - h
            call balance%evaluate(moved, frequency_ratio)
            difference = (difference - balance%residual)/(2*h)
            do j = 1, n
               entry = system%cut%graph%entry_of(j, i)
               if (entry > 0) difference(:, j) = difference(:, j) - matrix%entry(:, k, entry)
            end do
            worst = max(worst, maxval(abs(difference)))
         end do
      end do
      call tests%is_close(worst/largest, 0.0_dp, 1e-7_dp, name//': dS/du against differences')
      call balance%evaluate(u, frequency_ratio + h)
      difference = balance%residual
      call balance%evaluate(u, frequency_ratio - h)
      difference = (difference - balance%residual)/(2*h)
      call tests%is_close(maxval(abs(difference - matrix%column))/maxval(abs(matrix%column)), 0.0_dp, 1e-7_dp, &
                          name//': dS/dLambda against differences')
   end subroutine jacobian_at_random

   !> A linear mesh of constant stiffness is condensed; one with a stiffness harmonic of 1e-13 is an unknown. Their
   !> displacements agree to that.
   subroutine condensed_linear_mesh(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      real(dp), allocatable :: condensed(:, :), whole(:, :)

      train = long_train(5)
      call linear_solution(train, condensed)
      train%meshes(2)%stiffness_cos = [1e-13_dp]
      call linear_solution(train, whole)
      call tests%is_close(maxval(abs(condensed - whole)), 0.0_dp, 1e-11_dp, 'a condensed mesh moves as an unknown one')
   end subroutine condensed_linear_mesh

   !> Newton from rest, all meshes in contact.
   subroutine linear_solution(train, coefficients)
      type(train_type), intent(in) :: train
      real(dp), allocatable, intent(out) :: coefficients(:, :)
      type(system_type), target :: system
      type(balance_type) :: balance
      type(bordered_type) :: matrix
      real(dp), allocatable :: u(:, :), step(:, :)
      real(dp) :: y
      integer :: i, info

      call build_system(train, system)
      call balance%setup(system, 6, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(1, :) = 10
      do i = 1, 3
         call balance%evaluate(u, 0.31_dp)
         call balance%jacobian(matrix)
         matrix%row = 0
         matrix%corner = 1
         call matrix%factor(info)
         step = -balance%residual
         y = 0
         call matrix%solve(step, y)
         u = u + step
      end do
      call balance%evaluate(u, 0.31_dp)
      allocate (coefficients(13, system%meshes))
      call balance%full_coefficients(u, coefficients)
   end subroutine linear_solution

   !> dH/dLambda and da/dLambda, elimination included, by central differences.
   subroutine receptance_derivative(tests)
      class(tests_type), intent(inout) :: tests
      type(system_type) :: system
      type(train_type) :: train
      type(receptance_type) :: here, above, below
      integer :: j
      integer, parameter :: linear(3) = [2, 3, 6]
      real(dp), parameter :: h = 1e-6_dp

      train = long_train(7)
      do j = 1, 3
         train%meshes(linear(j))%half_backlash = 0
         train%meshes(linear(j))%stiffness_cos = [real(dp) ::]
         train%meshes(linear(j))%stiffness_sin = [real(dp) ::]
         train%meshes(linear(j))%error_cos = [1e-6_dp*j]
      end do
      train%torque_cos = [5.0_dp]
      call build_system(train, system)
      call find_receptance(system, 0.8_dp, 1, 1, here)
      call find_receptance(system, 0.8_dp + h, 1, 1, above)
      call find_receptance(system, 0.8_dp - h, 1, 1, below)
      call tests%is_close(maxval(abs((above%h - below%h)/(2*h) - here%dh))/maxval(abs(here%dh)), 0.0_dp, 1e-8_dp, &
                          'dH/dLambda with eliminated meshes')
      call tests%is_close(maxval(abs((above%a - below%a)/(2*h) - here%da))/maxval(abs(here%da)), 0.0_dp, 1e-8_dp, &
                          'da/dLambda with eliminated meshes')
   end subroutine receptance_derivative

   !> The same numbers in every run, in (-0.5, 0.5), falling with the harmonic as real motions do.
   subroutine pseudo_random(u)
      real(dp), intent(out) :: u(:, :)
      integer :: i, k

      do i = 1, size(u, 2)
         do k = 1, size(u, 1)
            u(k, i) = sin(12.9898_dp*k + 78.233_dp*i)*43758.5453_dp
            u(k, i) = (u(k, i) - floor(u(k, i)) - 0.5_dp)/(1 + 0.1_dp*k)*2
         end do
      end do
   end subroutine pseudo_random

end module unit_balance
