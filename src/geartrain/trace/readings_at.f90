!> What a branch is read for at a solution point: displacements and forces of meshes, torques of shafts and forces of bearings,
!> harmonic by harmonic, as the linear equations of the train give them from the forces of the unknown meshes.
module geartrain_trace_readings_at
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balanced_torque, only: element_forces, shaft_coefficients
   use geartrain_base_kinds, only: dp
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   implicit none (type, external)
   private
   public :: count_readings, find_readings, find_rates_of, floors, swings

   !> Least alternating reading that counts, over the largest of its kind [1].
   real(dp), parameter :: felt = 1e-4_dp
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
      real(dp) :: force(balance%block, balance%system%elements)
      integer :: s

      call balance%evaluate(u, frequency_ratio)
      call element_forces(balance, force)
      associate (m => balance%system%meshes, paths => balance%system%torque_paths)
         call balance%full_coefficients(u, readings(:, :m))
         readings(:, m + 1:2*m) = force(:, balance%system%mesh_element)
         if (size(readings, 2) == 2*m) return
         call shaft_coefficients(balance, force, readings(:, 2*m + 1:))
         do s = 1, paths%rows
            if (.not. paths%known(s)) readings(:, 2*m + s) = 0
         end do
      end associate
   end subroutine find_readings

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
