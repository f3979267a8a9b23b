!> Many harmonics and long trains: what is done there for speed gives what the plain way gives.
module unit_scale
   use fixtures, only: body, long_train, paper_train, settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, shaft_type, solutions_at, &
                        train_type
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_linalg_arnoldi, only: arnoldi_type
   use geartrain_network_alike, only: share_alike
   use geartrain_network_system, only: build_system, system_type
   use geartrain_network_system_spectrum, only: eigenvalue_ranges, eigenvalues_of, largest_eigenvalue
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_start, only: begin_trace, solution_of, resting
   use geartrain_trace_tracer, only: tracer_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: chain, equal_branches, joined, scale_tests

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
      if (tests%runs('counted_eigenvalues')) then
         call counted_eigenvalues(tests, chain(20), .false., 'a chain')
         call counted_eigenvalues(tests, equal_branches(3, 4), .true., 'equal branches')
         call counted_eigenvalues(tests, dragged(equal_branches(3, 4)), .false., 'damping to ground, not alike')
         call counted_eigenvalues(tests, joined(equal_branches(2, 8), 8), .false., 'a loop')
      end if
      if (tests%runs('leading_multipliers')) then
         call leading_multipliers(tests, chain(50), 0.83_dp, 1.0_dp, .true., '50 shafts')
         call leading_multipliers(tests, damped_in_contact(chain(50)), 0.83_dp, 1.0_dp, .true., '50 shafts, damped in contact')
         call leading_multipliers(tests, chain(100), 0.83_dp, 1.0_dp, .true., '100 shafts')
         ! A single mesh is unstable.
         call leading_multipliers(tests, one_strange(chain(60), 41), 2.0_dp, 0.0_dp, .true., 'one mesh of many')
         call leading_multipliers(tests, one_strange(chain(100), 57), 2.0_dp, 0.0_dp, .true., 'one mesh of more')
         ! Up to nine multipliers are one: more than vectors are carried together.
         call leading_multipliers(tests, equal_branches(10, 5), 0.83_dp, 0.0_dp, .false., '10 equal branches')
         call leading_multipliers(tests, equal_branches(3, 24), 0.83_dp, 0.0_dp, .true., '3 equal branches')
         call leading_multipliers(tests, dragged(equal_branches(3, 24)), 0.83_dp, 1.0_dp, .true., 'damping to ground')
         call leading_multipliers(tests, joined(equal_branches(2, 30), 30), 0.83_dp, 1.0_dp, .true., 'a loop')
         call leading_multipliers(tests, joined(dragged(damped_in_contact(equal_branches(2, 30))), 30), 0.83_dp, 1.0_dp, .true., &
                                  'a loop, damped to ground and in contact')
      end if
   end subroutine scale_tests

   !> Ranges of eigenvalues by counting hold those that LAPACK finds, to the rounding of the largest, and end next to them.
   subroutine counted_eigenvalues(tests, train, alike, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      !> Whether most elements lie alike with two others.
      logical, intent(in) :: alike
      character(*), intent(in) :: name
      real(dp), parameter :: ratio = 1.3_dp, rounding = 1e-12_dp, next_to = 1e-6_dp
      type(system_type), target :: system
      real(dp), allocatable :: values(:), ranges(:, :)
      integer :: i, info, n

      call build_system(train, system)
      allocate (values(system%displacements))
      call eigenvalues_of(system, system%spring, values, info)
      n = size(values)
      call bounds(1, largest_eigenvalue(system, system%spring), values(n), 'the largest')
      ranges = eigenvalue_ranges(system, system%spring, ratio)
      call bounds(1, ranges(2, 1), values(n), 'the top of the highest range')
      do i = n - 1, 1, -1
         if (values(i + 1) <= ratio*values(i)) cycle
         call bounds(-1, ranges(1, 1), values(i + 1), 'the bottom of a range')
         ranges = ranges(:, 2:)
         call bounds(1, ranges(2, 1), values(i), 'the top of a range')
      end do
      call tests%is_true(size(ranges, 2) == 1, name//': no more ranges')
      call bounds(-1, ranges(1, 1), values(1), 'the bottom of the lowest range')
      call tests%is_true((share_alike(system, 2) > 0.5_dp) .eqv. alike, name//': elements that lie alike')

   contains

      !> A number is not below an eigenvalue (side 1), or not above it (-1), and next to it.
      subroutine bounds(side, bound, value, what)
         integer, intent(in) :: side
         real(dp), intent(in) :: bound, value
         character(*), intent(in) :: what

         call tests%is_true(side*(bound - value) >= -rounding*values(n), name//': bounded: '//what)
         call tests%is_close(bound, value, next_to*value + rounding*values(n), name//': '//what)
      end subroutine bounds

   end subroutine counted_eigenvalues

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
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer

      settings = settings_of(0.85_dp, 1.0_dp, 12)
      settings%stability = .false.
      call response(train, settings, branch, error)
      call solutions_at(train, settings, branch, 0.9_dp, motions, error)
      settings%subharmonic = eta
      call begin_trace(train, settings, systems, tracer)
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
      integer, parameter :: n = 200, wanted = 6, pair = 2
      type(arnoldi_type) :: space
      complex(dp) :: values(wanted), product
      real(dp) :: x(n, pair), y(n, pair), residuals(wanted)
      integer :: i, k
      logical :: independent

      call space%begin(n, 60, pair)
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
      call space%ritz(values, residuals)
      call tests%is_close(maxval(residuals), 0.0_dp, 1e-9_dp, 'Arnoldi: residual')
      do i = 1, wanted/2
         call tests%is_close(abs(values(2*i)), 0.9_dp**i, 1e-10_dp, 'Arnoldi: magnitude')
         call tests%is_close(abs(atan2(sin(real(i, dp)), cos(real(i, dp)))), abs(atan2(values(2*i)%im, values(2*i)%re)), 1e-9_dp, &
                             'Arnoldi: angle')
      end do
   end subroutine diagonal

   function damped_in_contact(train) result(changed)
      type(train_type), intent(in) :: train
      type(train_type) :: changed

      changed = train
      changed%meshes%damping_acts = 'contact'
   end function damped_in_contact

   !> Every third body is damped to ground, each otherwise.
   function dragged(train) result(changed)
      type(train_type), intent(in) :: train
      type(train_type) :: changed
      integer :: i

      changed = train
      do i = 1, size(changed%bodies), 3
         changed%bodies(i)%damping_to_ground = 0.01_dp*(1 + mod(i, 7))
      end do
   end function dragged

   !> The ends of the first two of equal branches, of so many pairs each, are joined by a shaft.
   function joined(train, pairs) result(changed)
      type(train_type), intent(in) :: train
      integer, intent(in) :: pairs
      type(train_type) :: changed
      type(shaft_type) :: shaft

      changed = train
      shaft = shaft_type(stiffness=2e6_dp, damping_ratio=0.01_dp)
      shaft%between(1) = 'to '//integer_text(pairs)
      shaft%between(2) = 'to '//integer_text(2*pairs)
      changed%shafts = [changed%shafts, shaft]
   end function joined

   !> The leading multipliers without the matrix are those of the matrix, each as often as it is there.
   subroutine leading_multipliers(tests, train, frequency_ratio, amplitude, without, name)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      !> Lambda [1]; how much the meshes vibrate [1]: with 1 some of them separate.
      real(dp), intent(in) :: frequency_ratio, amplitude
      !> The matrix is not needed.
      logical, intent(in) :: without
      character(*), intent(in) :: name
      type(system_type), target :: system
      type(balance_type) :: balance
      type(monodromy_type) :: few, whole
      real(dp), allocatable :: u(:, :)
      complex(dp), allocatable :: leading(:), all_of_them(:)
      integer :: i

      call build_system(train, system)
      call balance%setup(system, 6, 1, 0)
      allocate (u(balance%block, balance%unknowns), source=0.0_dp)
      u(1, :) = 1.4_dp
      u(2, :) = [(amplitude*0.6_dp*cos(real(i, dp)), i=1, balance%unknowns)]
      u(5, :) = amplitude*0.1_dp
      call balance%evaluate(u, frequency_ratio)
      if (amplitude > 0) call tests%is_true(count(balance%contact%events > 0) > 10, name//': some meshes separate')
      call few%setup(system)
      call tests%is_true(few%given < few%states, name//': fewer than there are states')
      call few%integrate(balance, frequency_ratio)
      call tests%is_true(few%confirmed, name//': confirmed')
      if (without) call tests%is_true(.not. allocated(few%transposed), name//': no matrix was needed')
      call whole%setup(system, all_of_them=.true.)
      call whole%integrate(balance, frequency_ratio)
      allocate (leading(few%given), all_of_them(whole%given))
      call few%multipliers(leading)
      call whole%multipliers(all_of_them)
      call tests%is_close(maxval(abs(abs(leading) - abs(all_of_them(:few%given)))), 0.0_dp, 1e-8_dp, name//': leading multipliers')
      do i = 1, few%given
         call tests%is_close(minval(abs(all_of_them - leading(i))), 0.0_dp, 1e-8_dp, name//': each is one of all')
      end do
      ! For the verdict alone: the first point of a branch, and the next ones, which begin with its vectors.
      do i = 1, 3
         call few%integrate(balance, frequency_ratio, verdict=.true.)
         call few%multipliers(leading)
         call tests%is_true(few%confirmed, name//': verdict confirmed')
         associate (first => abs(all_of_them(1)))
            call tests%is_close(abs(leading(1)), first, max(1e-8_dp, 0.02_dp*(1 - first)), name//': largest for the verdict')
         end associate
         call tests%is_close(maxval(abs(abs(leading) - abs(all_of_them(:few%given)))), 0.0_dp, 1e-3_dp, name//': the others')
      end do
   end subroutine leading_multipliers

   !> The train, the stiffness of one of whose meshes varies by much more than that of the others.
   function one_strange(given, mesh) result(train)
      type(train_type), intent(in) :: given
      integer, intent(in) :: mesh
      type(train_type) :: train
      integer :: j

      train = given
      do j = 1, size(train%meshes)
         train%meshes(j)%stiffness_cos = [merge(0.9_dp, 0.02_dp, j == mesh)]
      end do
   end function one_strange

   !> From one gear so many branches of so many pairs of figure 3, all alike, down and up by turns.
   function equal_branches(branches, pairs) result(train)
      integer, intent(in) :: branches, pairs
      type(train_type) :: train
      type(train_type) :: plain
      character(8) :: before, from, to
      integer :: i, j, n

      plain = chain(pairs + 1)
      train = plain
      train%input_torque = 0
      train%prime_mover_inertia = 0
      train%load_inertia = 0
      deallocate (train%shafts, train%meshes)
      allocate (train%bodies(1 + 2*branches*pairs), train%shafts(branches*pairs), train%meshes(branches*pairs))
      train%bodies(1) = body('hub', 0.01_dp, balances=.true.)
      n = 0
      do i = 1, branches
         before = 'hub'
         do j = 1, pairs
            n = n + 1
            from = 'from '//integer_text(n)
            to = 'to '//integer_text(n)
            associate (mesh => train%meshes(n), b => train%bodies(2*n:2*n + 1))
               mesh = plain%meshes(j)
               b(1) = body(trim(from), mesh%driving_inertia)
               b(2) = body(trim(to), mesh%driven_inertia, merge(-150.0_dp, 0.0_dp, j == pairs))
               mesh%driving_inertia = 0
               mesh%driven_inertia = 0
               mesh%between(1) = from
               mesh%between(2) = to
            end associate
            train%shafts(n) = shaft_type(stiffness=1e7_dp, damping_ratio=0.01_dp)
            train%shafts(n)%between(1) = before
            train%shafts(n)%between(2) = from
            before = to
         end do
      end do
   end function equal_branches

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
