!> Many harmonics and long trains: what is done there for speed gives what the plain way gives.
module unit_scale
   use fixtures, only: long_train, paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, solutions_at, train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_start, only: begin_trace, solution_of, resting
   use geartrain_continuation_tracer, only: tracer_type
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_linalg_arnoldi, only: arnoldi_type, pair
   use geartrain_model_system, only: build_system, system_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: scale_tests

contains

   subroutine scale_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('either_solver')) then
         call either_solver(tests, paper_train(), 48, 1, 10, 'figure 3, teeth apart')
         call either_solver(tests, paper_train(), 60, 2, 10, 'figure 3, sub-harmonic 2')
         call either_solver(tests, paper_train(), 32, 1, 1, 'figure 3, one harmonic eliminated')
         call either_solver(tests, long_train(5), 40, 1, 10, 'everything, 5 shafts')
      end if
      if (tests%runs('iterations')) call iterations(tests)
      if (tests%runs('diagonal')) call diagonal(tests)
      if (tests%runs('leading_multipliers')) then
         call leading_multipliers(tests, 'always')
         call leading_multipliers(tests, 'contact')
      end if
   end subroutine scale_tests

   !> The same solution, tangent and orientation, all harmonics eliminated and the lowest `explicit` ones.
   subroutine either_solver(tests, train, harmonics, eta, explicit, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics, eta, explicit
      character(*), intent(in) :: name
      type(solution_point_type) :: whole, part
      integer :: spent
      logical :: success, apart

      call solve(train, harmonics, eta, harmonics, whole, spent, success, apart)
      call tests%is_true(success .and. spent == 0, name//': solved by elimination')
      if (train%title /= 'everything') call tests%is_true(apart, name//': the teeth part')
      call solve(train, harmonics, eta, explicit, part, spent, success, apart)
      call tests%is_true(success .and. spent > 0, name//': solved by GMRES')
      call tests%is_close(maxval(abs(part%u - whole%u))/maxval(abs(whole%u)), 0.0_dp, 1e-10_dp, name//': the same solution')
      call tests%is_close(maxval(abs(part%tangent - whole%tangent)), 0.0_dp, 1e-7_dp, name//': the same tangent')
      call tests%is_true(part%orientation == whole%orientation, name//': the same orientation')
   end subroutine either_solver

   !> At Lambda = 0.9, from a motion of 12 harmonics.
   subroutine solve(train, harmonics, eta, explicit, solution, iterations, success, apart)
      type(train_type), intent(in) :: train
      integer, intent(in) :: harmonics, eta, explicit
      type(solution_point_type), intent(out) :: solution
      integer, intent(out) :: iterations
      !> apart: teeth part somewhere in the period.
      logical, intent(out) :: success, apart
      type(response_settings_type) :: settings
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error
      type(tracer_type) :: tracer

      settings = settings_of(0.85_dp, 1.0_dp, 12)
      settings%stability = .false.
      call response(train, settings, branch, error)
      call solutions_at(train, settings, branch, 0.9_dp, motions, error)
      settings%subharmonic = eta
      call begin_trace(train, settings, tracer)
      associate (corrector => tracer%corrector)
         call corrector%balance%setup(tracer%system, harmonics, eta, 0)
         call corrector%setup()
         solution = resting(tracer, 0.9_dp)
         if (size(motions) > 0) solution = solution_of(tracer, motions(1))
         call corrector%balance%evaluate(solution%u, solution%frequency_ratio)
         call corrector%balance%make_explicit(explicit)
         call corrector%setup()
         call corrector%solve_at(solution, success)
         ! Once more, so that the tangent is that of the solution and not that of the last step towards it.
         if (success) call corrector%solve_at(solution, success)
         apart = any(corrector%balance%contact%events > 0)
         if (success) call corrector%orient(solution, 1)
         iterations = corrector%matrix%iterations
      end associate
   end subroutine solve

   !> No more iterations at 192 harmonics than at 48: the matrix is the identity plus a compact part.
   subroutine iterations(tests)
      class(tests_type), intent(inout) :: tests
      type(solution_point_type) :: solution
      integer :: at_48, at_192
      logical :: success, apart

      call solve(paper_train(), 48, 1, 10, solution, at_48, success, apart)
      call solve(paper_train(), 192, 1, 10, solution, at_192, success, apart)
      call tests%is_true(success .and. at_192 <= at_48 + 1 .and. at_48 < 20, 'iterations do not grow with the harmonics')
   end subroutine iterations

   !> Eigenvalues known beforehand: pairs 0.9**k exp(+-i k) of a block-diagonal matrix.
   subroutine diagonal(tests)
      class(tests_type), intent(inout) :: tests
      integer, parameter :: n = 200, wanted = 6
      type(arnoldi_type) :: space
      complex(dp) :: values(wanted), product
      real(dp) :: x(n, pair), y(n, pair), residual
      integer :: i, k
      logical :: independent

      call space%begin(n, 60)
      do while (space%dimension < 60)
         call space%latest(x)
         do i = 1, n/2
            do k = 1, pair
               product = 0.9_dp**i*exp(cmplx(0, i, dp))*cmplx(x(2*i - 1, k), x(2*i, k), dp)
               y(2*i - 1, k) = product%re
               y(2*i, k) = product%im
            end do
         end do
         call space%extend(y, independent)
         call tests%is_true(independent, 'Arnoldi: the space grows')
      end do
      call space%ritz(values, residual)
      call tests%is_close(residual, 0.0_dp, 1e-9_dp, 'Arnoldi: residual')
      do i = 1, wanted/2
         call tests%is_close(abs(values(2*i)), 0.9_dp**i, 1e-10_dp, 'Arnoldi: magnitude')
         call tests%is_close(abs(atan2(sin(real(i, dp)), cos(real(i, dp)))), abs(atan2(values(2*i)%im, values(2*i)%re)), 1e-9_dp, &
                             'Arnoldi: angle')
      end do
   end subroutine diagonal

   !> 50 shafts whose meshes separate at times: the leading multipliers without the matrix are those of the matrix.
   subroutine leading_multipliers(tests, damping_acts)
      class(tests_type), intent(inout) :: tests
      character(*), intent(in) :: damping_acts
      type(train_type) :: train
      type(system_type) :: system
      type(balance_type) :: balance
      type(monodromy_type) :: few, whole
      real(dp), allocatable :: u(:, :)
      complex(dp), allocatable :: leading(:), all_of_them(:)
      integer :: i

      train = chain(50)
      train%meshes%damping_acts = damping_acts
      call build_system(train, system)
      call balance%setup(system, 6, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(1, :) = 1.4_dp
      u(2, :) = [(0.6_dp*cos(real(i, dp)), i=1, balance%unknowns)]
      u(5, :) = 0.1_dp
      call balance%evaluate(u, 0.83_dp)
      call tests%is_true(count(balance%contact%events > 0) > 10, 'leading multipliers: some meshes separate')
      call few%setup(system)
      call tests%is_true(few%given < few%states, 'leading multipliers: fewer than there are states')
      call few%integrate(balance, 0.83_dp)
      call tests%is_true(.not. allocated(few%transposed), 'leading multipliers: no matrix was needed')
      call whole%setup(system, all_of_them=.true.)
      call whole%integrate(balance, 0.83_dp)
      allocate (leading(few%given), all_of_them(whole%given))
      call few%multipliers(leading)
      call whole%multipliers(all_of_them)
      call tests%is_close(maxval(abs(abs(leading) - abs(all_of_them(:few%given)))), 0.0_dp, 1e-8_dp, 'leading multipliers')
      do i = 1, few%given
         call tests%is_close(minval(abs(all_of_them - leading(i))), 0.0_dp, 1e-8_dp, 'leading multipliers: each is one of all')
      end do
   end subroutine leading_multipliers

   !> The first pair of figure 3, down and up by turns.
   function chain(shafts) result(train)
      integer, intent(in) :: shafts
      type(train_type) :: train
      type(train_type) :: one
      integer :: j

      one = paper_train()
      train = one
      deallocate (train%shafts, train%meshes)
      allocate (train%shafts(shafts), train%meshes(shafts - 1))
      do j = 1, shafts
         train%shafts(j) = one%shafts(merge(1, 2, j == 1 .or. j == shafts))
      end do
      do j = 1, shafts - 1
         train%meshes(j) = one%meshes(1)
         if (mod(j, 2) == 1) cycle
         train%meshes(j)%driving_radius = one%meshes(1)%driven_radius
         train%meshes(j)%driven_radius = one%meshes(1)%driving_radius
         train%meshes(j)%driving_inertia = one%meshes(1)%driven_inertia
         train%meshes(j)%driven_inertia = one%meshes(1)%driving_inertia
      end do
   end function chain

end module unit_scale
