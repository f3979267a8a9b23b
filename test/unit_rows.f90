!> Rows of elements: rank, rigid motions and how dependent rows follow, against singular values of the dense matrix; trains whose
!> bodies are held, by themselves or by springs to ground.
module unit_rows
   use, intrinsic :: iso_fortran_env, only: int64
   use fixtures, only: body, settings_of, uniform
   use geartrain, only: branch_type, dp, error_type, mesh_type, response, shaft_type, train_type
   use geartrain_base_numbers, only: integer_text
   use geartrain_linalg_lapack, only: dgeev
   use geartrain_linalg_rows, only: row_type, rows_type
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: rows_tests

contains

   subroutine rows_tests(tests)
      class(tests_type), intent(inout) :: tests
      integer :: i

      if (tests%runs('random')) then
         do i = 1, tests%times(200)
            call random_rows(tests, i + 1000*tests%seed)
         end do
      end if
      if (tests%runs('held')) call held(tests)
      if (tests%runs('spring')) call spring_to_ground(tests)
   end subroutine rows_tests

   !> Rows of 1 to 6 entries on 4 to 24 nodes, every third one a combination of rows before it, with a null space of 0 to 3 or more.
   subroutine random_rows(tests, number)
      class(tests_type), intent(inout) :: tests
      integer, intent(in) :: number
      integer(int64) :: generator
      type(row_type), allocatable :: list(:)
      type(rows_type) :: rows
      real(dp), allocatable :: matrix(:, :), own(:, :), left(:, :)
      integer, allocatable :: chosen(:)
      integer :: nodes, wanted, i, j, k, entries, rank
      logical :: independent
      real(dp) :: worst

      generator = 7919*number + 1
      nodes = 4 + mod(number, 21)
      wanted = nodes - mod(number, 4)
      allocate (list(wanted + wanted/2), matrix(wanted + wanted/2, nodes))
      matrix = 0
      do i = 1, size(list)
         if (mod(i, 3) == 0) then
            ! A combination of two rows before it.
            matrix(i, :) = uniform(generator, 0.5_dp, 2.0_dp)*matrix(i - 1, :) - uniform(generator, 0.5_dp, 2.0_dp)*matrix(i - 2, :)
         else
            entries = 1 + int(uniform(generator, 0.0_dp, 5.999_dp))
            do j = 1, min(entries, nodes)
               matrix(i, 1 + mod(i + j*int(uniform(generator, 1.0_dp, 2.999_dp)), nodes)) = uniform(generator, 0.03_dp, 0.3_dp) &
                                                                *sign(1.0_dp, uniform(generator, -1.0_dp, 1.0_dp))
            end do
         end if
         list(i)%node = pack([(k, k=1, nodes)], abs(matrix(i, :)) > 0)
         list(i)%entry = pack(matrix(i, :), abs(matrix(i, :)) > 0)
      end do
      own = matmul(matrix, transpose(matrix))
      rank = nodes - count(eigenvalues(matmul(transpose(matrix), matrix)) < 1e-12_dp*maxval(abs(own)))
      call rows%setup(nodes, rank)
      allocate (chosen(0))
      do i = 1, size(list)
         ! More rows than the rank would be an error that the room for shares does not allow for.
         if (rows%rank == rank) exit
         call rows%add(list(i), independent)
         if (independent) chosen = [chosen, i]
      end do
      call tests%is_true(size(chosen) == rank, 'rows '//integer_text(number)//': rank')
      if (size(chosen) /= rank) return
      call tests%is_true(count(rows%free) == nodes - rank, 'rows '//integer_text(number)//': motions')
      left = rows%motion(:, pack([(k, k=1, nodes)], rows%free))
      worst = 0
      if (size(left, 2) > 0) worst = maxval(abs(matmul(matrix, left)))/maxval(abs(left))
      call tests%is_close(worst, 0.0_dp, 1e-11_dp, 'rows '//integer_text(number)//': motions deflect no row')
      worst = 0
      do i = 1, size(list)
         worst = max(worst, maxval(abs(matmul(rows%follow(list(i)), matrix(chosen, :)) - matrix(i, :))))
      end do
      ! Rounding grows with the condition of the chosen rows, which the shares show.
      call tests%is_close(worst, 0.0_dp, 1e-13_dp*max(1.0_dp, maxval(abs(rows%share))), 'rows '//integer_text(number)// &
                          ': every row follows from the independent ones')
   end subroutine random_rows

   !> Eigenvalues of a symmetric matrix.
   function eigenvalues(matrix) result(value)
      real(dp), intent(in) :: matrix(:, :)
      real(dp) :: value(size(matrix, 1)), imaginary(size(matrix, 1)), work(10*size(matrix, 1))
      real(dp) :: copy(size(matrix, 1), size(matrix, 1))
      real(dp) :: none(1, 1)
      integer :: info

      copy = matrix
      call dgeev('N', 'N', size(copy, 1), copy, size(copy, 1), value, imaginary, none, 1, none, 1, work, size(work), info)
   end function eigenvalues

   !> A motor, a pinion, a wheel and a fan on a shaft behind the wheel.
   function geared() result(train)
      type(train_type) :: train

      train%characteristic_length = 1e-5_dp
      train%characteristic_frequency = 1e4_dp
      train%bodies = [body('motor', 2e-3_dp, 60.0_dp), body('pinion', 1e-3_dp), body('wheel', 4e-3_dp), body('fan', 8e-3_dp)]
      train%shafts = [shaft_type(between=[character(64) :: 'motor', 'pinion'], stiffness=2e4_dp, damping_ratio=0.03_dp), &
                      shaft_type(between=[character(64) :: 'wheel', 'fan'], stiffness=3e4_dp, damping_ratio=0.03_dp)]
      train%meshes = [mesh_type(between=[character(64) :: 'pinion', 'wheel'], driving_radius=0.04_dp, driven_radius=0.07_dp, &
                                stiffness=2e8_dp, damping=500.0_dp, damping_given=.true., half_backlash=2e-5_dp)]
      train%meshes(1)%stiffness_cos = [0.25_dp]
   end function geared

   !> A held body equals one of 1e12 times the inertia, at every point of a response.
   subroutine held(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, heavy
      type(branch_type) :: branch, other
      type(error_type), allocatable :: error
      real(dp) :: worst
      integer :: i

      train = geared()
      train%shafts%damping_given = .true.
      train%shafts%damping = [1.0_dp, 2.0_dp]
      heavy = train
      train%bodies(4)%held = .true.
      heavy%bodies(4)%inertia = 1e12_dp*heavy%bodies(4)%inertia
      heavy%bodies(4)%balances = .true.
      call response(train, settings_of(0.9_dp, 1.6_dp, 8), branch, error)
      call tests%is_true(.not. allocated(error), 'held: a response')
      call response(heavy, settings_of(0.9_dp, 1.6_dp, 8), other, error)
      call tests%is_true(.not. allocated(error), 'heavy: a response')
      call tests%is_true(branch%points == other%points .and. branch%points > 10, 'held: as many points')
      if (branch%points /= other%points) return
      associate (n => branch%points)
         worst = maxval(abs(branch%rms(1, :n) - other%rms(1, :n)))/maxval(branch%rms(1, :n))
         call tests%is_close(worst, 0.0_dp, 1e-9_dp, 'held: rms')
         worst = maxval(abs(branch%shaft_torque_maximum(2, :n) - other%shaft_torque_maximum(2, :n)))
         call tests%is_close(worst, 0.0_dp, 1e-9_dp*maxval(branch%shaft_torque_maximum(2, :n)), 'held: torque of the shaft')
         ! The fan is held by the torque of its shaft: the train is at rest under 60 N m times 0.07/0.04.
         do i = 1, n
            worst = max(worst, abs(branch%shaft_torque_minimum(3, i) + branch%shaft_torque_maximum(2, i)), &
                        abs(branch%shaft_torque_maximum(3, i) + branch%shaft_torque_minimum(2, i)), &
                        abs(branch%shaft_torque_mean(3, i) + 105.0_dp))
         end do
         call tests%is_close(worst, 0.0_dp, 1e-9_dp*105, 'held: reaction torque')
      end associate
   end subroutine held

   !> A pair whose wheel a spring holds: natural frequencies of two masses, one of them on a spring.
   subroutine spring_to_ground(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(modes_type) :: modes
      type(error_type), allocatable :: error
      real(dp) :: a, b, k, s, square(2)

      train = geared()
      train%bodies = [train%bodies(2), train%bodies(3)]
      train%bodies(1)%torque = 10
      train%shafts = [shaft_type ::]
      train%bodies(2)%stiffness_to_ground = 5e4_dp
      call natural_modes(train, modes, error)
      call tests%is_true(.not. allocated(error), 'spring: modes')
      if (allocated(error)) return
      ! Of x = r theta: a x1'' + k (x1 - x2) = 0, b x2'' + k (x2 - x1) + s x2 = 0.
      a = 1e-3_dp/0.04_dp**2
      b = 4e-3_dp/0.07_dp**2
      k = 2e8_dp
      s = 5e4_dp/0.07_dp**2
      associate (sum_of => k/a + (k + s)/b, product_of => k*s/(a*b))
         square = (sum_of + [-1, 1]*sqrt(sum_of**2 - 4*product_of))/2
         square(1) = product_of/square(2)
      end associate
      call tests%is_true(size(modes%natural_frequency) == 2 .and. size(modes%rigid, 2) == 0, 'spring: two modes, no rigid motion')
      call tests%is_close(maxval(abs(modes%natural_frequency/(sqrt(square)/1e4_dp) - 1)), 0.0_dp, 1e-12_dp, 'spring: frequencies')
   end subroutine spring_to_ground

end module unit_rows
