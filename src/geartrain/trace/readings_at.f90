!> What a branch is read for at a solution point: displacements and forces of meshes, torques of shafts and forces of bearings,
!> harmonic by harmonic, as the linear equations of the train give them from the forces of the unknown meshes.
module geartrain_trace_readings_at
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balanced_torque, only: alternating_forces, element_forces, shaft_coefficients
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_base_kinds, only: dp
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   implicit none (type, external)
   private
   public :: coarser, count_readings, find_readings, find_rates_of, floors, swings, weigh_readings

   !> Least alternating reading that counts, over the largest of its kind [1].
   real(dp), parameter :: felt = 1e-4_dp
   !> Reading to which the error of a smaller one of its kind is relative, over the largest [1].
   real(dp), parameter :: counted = 0.1_dp
   !> Tolerance of a reading over the tolerance of the waveform [1]: a torque may need many harmonics where a shaft is in resonance.
   real(dp), parameter :: coarser = 10
   !> Displacement of a mesh without backlash to which its own error is relative at least, over the largest [1].
   real(dp), parameter :: least_share = 1e-6_dp
   !> Part of the unit of length of the branch over which readings are differentiated.
   real(dp), parameter :: difference = 1e-7_dp

contains

   !> Number of readings.
   pure integer function count_readings(balance, torques)
      type(balance_type), intent(in) :: balance
      !> Torques of shafts and forces of bearings are among them.
      logical, intent(in) :: torques

      count_readings = 2*balance%system%meshes + merge(balance%system%torque_paths%rows, 0, torques)
   end function count_readings

   !> Finds the readings at a solution point with their derivatives along the branch, by a difference.
   subroutine find_rates_of(corrector, solution, readings, rates)
      type(corrector_type), intent(inout) :: corrector
      !> The point with its tangent.
      type(solution_point_type), intent(in) :: solution
      !> As of `find_readings`, and their derivatives.
      real(dp), intent(out) :: readings(:, :), rates(:, :)
      real(dp) :: h

      h = difference
      if (.not. corrector%balance%reaches(solution%frequency_ratio + h*solution%tangent_frequency)) h = -h
      call find_readings(corrector%balance, solution%u + h*solution%tangent, &
                             solution%frequency_ratio + h*solution%tangent_frequency, rates)
      call find_readings(corrector%balance, solution%u, solution%frequency_ratio, readings)
      rates = (rates - readings)/h
   end subroutine find_rates_of

   !> Finds the readings at a motion; the balance is left evaluated there.
   subroutine find_readings(balance, u, frequency_ratio, readings)
      type(balance_type), intent(inout) :: balance
      !> Coefficients of the unknown meshes [1], (block, unknown), and Lambda or the parameter.
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> Mean, cos and sin of each carried harmonic, (coefficient, reading): displacements and forces of meshes [1], torques [N m],
      !> forces of bearings [N]. 0 where nothing determines a torque.
      real(dp), intent(out) :: readings(:, :)

      call balance%evaluate(u, frequency_ratio)
      call read_off(balance, u, readings)
   end subroutine find_readings

   !> Finds the readings at the motion at which the balance was evaluated last.
   subroutine read_off(balance, u, readings)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      real(dp), intent(out) :: readings(:, :)
      real(dp) :: force(balance%block, balance%system%elements)
      integer :: s

      call element_forces(balance, force)
      associate (m => balance%system%meshes, paths => balance%system%torque_paths)
         call balance%full_coefficients(u, readings(:, :m))
         readings(:, m + 1:2*m) = force(:, balance%system%mesh_element)
         if (size(readings, 2) == 2*m) return
         call shaft_coefficients(balance, balance%harmonic, force, readings(:, 2*m + 1:))
         do s = 1, paths%rows
            if (.not. paths%known(s)) readings(:, 2*m + s) = 0
         end do
      end associate
   end subroutine read_off

   !> Lets the error estimate of a motion see what readings of linear parts miss at the harmonics of its tail.
   subroutine weigh_readings(balance, u, torques, estimate)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The motion [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Torques of shafts and forces of bearings are read.
      logical, intent(in) :: torques
      !> The estimate.
      type(error_estimate_type), intent(inout) :: estimate
      real(dp), allocatable :: readings(:, :), missing(:, :), force(:, :), displacement(:, :), known(:, :), whole(:)
      real(dp) :: felt_tail(estimate%count), carried(size(balance%harmonic))
      integer :: k, n

      n = estimate%count
      if (n == 0) return
      if (balance%unknowns == balance%system%meshes .and. .not. (torques .and. balance%system%torque_paths%rows > 0)) return
      allocate (readings(balance%block, count_readings(balance, torques)))
      call read_off(balance, u, readings)
      whole = max(swings(readings), counted/felt*floors(balance, readings))
      allocate (missing(1 + 2*n, size(readings, 2)), force(1 + 2*n, balance%system%elements), known(2*n, balance%unknowns))
      allocate (displacement(2*n, balance%system%elements))
      known(1::2, :) = estimate%force(:n, :)%re
      known(2::2, :) = -estimate%force(:n, :)%im
      force(1, :) = 0
      call alternating_forces(balance, estimate%harmonic(:n), known, force(2:, :), displacement)
      associate (m => balance%system%meshes, element => balance%system%mesh_element)
         ! Displacements of the unknown meshes are 0 there, and their forces are as uncertain as they are.
         missing(2:, :m) = displacement(:, element)
         missing(2:, m + 1:2*m) = 0
         if (torques) call shaft_coefficients(balance, estimate%harmonic(:n), force, missing(:, 2*m + 1:))
         do k = 1, merge(balance%system%torque_paths%rows, 0, torques)
            if (.not. balance%system%torque_paths%known(k)) missing(:, 2*m + k) = 0
         end do
      end associate
      do k = 1, balance%system%meshes
         if (any(balance%mesh == k)) cycle
         associate (own => norm2(readings(2:, k)), largest => maxval(whole(:balance%system%meshes)))
            estimate%mesh(k) = max(estimate%mesh(k), norm2(missing(2:, k))/max(own, least_share*largest, tiny(own)))
         end associate
      end do
      whole = 1/max(whole, tiny(whole))
      do k = 1, n
         felt_tail(k) = maxval(norm2(missing(2*k:2*k + 1, :), 1)*whole)
      end do
      do k = 1, size(carried)
         carried(k) = maxval(norm2(readings(2*k:2*k + 1, :), 1)*whole)
      end do
      estimate%missing = maxval(norm2(missing(2:, :), 1)*whole)
      call estimate%weigh(balance, u, carried/coarser, felt_tail/coarser, estimate%missing/coarser)
   end subroutine weigh_readings

   !> Alternating part of each reading [unit of the reading times the square root of 2], (reading).
   pure function swings(readings)
      !> Coefficients, (coefficient, reading).
      real(dp), intent(in) :: readings(:, :)
      real(dp) :: swings(size(readings, 2))

      swings = norm2(readings(2:, :), 1)
   end function swings

   !> Alternating part from which on each reading counts, by the largest mean or alternating part of its kind at a solution point.
   pure function floors(balance, readings)
      type(balance_type), intent(in) :: balance
      !> Readings there, (coefficient, reading).
      real(dp), intent(in) :: readings(:, :)
      real(dp) :: floors(size(readings, 2)), largest(size(readings, 2))
      integer :: ends(5), k

      largest = max(abs(readings(1, :)), swings(readings))
      associate (m => balance%system%meshes, paths => balance%system%torque_paths)
         ends = [0, m, 2*m, 2*m + paths%torques, 2*m + paths%rows]
      end associate
      ends = min(ends, size(readings, 2))
      do k = 1, 4
         floors(ends(k) + 1:ends(k + 1)) = felt*maxval([0.0_dp, largest(ends(k) + 1:ends(k + 1))])
      end do
   end function floors

end module geartrain_trace_readings_at
