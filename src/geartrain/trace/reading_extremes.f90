!> Points within a step where a reading is highest that is not highest where the motion of a mesh is: the force of a mesh or of a
!> bearing, the torque of a shaft.
!>
!> As in geartrain_trace_step_extremes values and derivatives at both ends of the step make a cubic that says where to look. A
!> maximum that is hardly above the ends needs no point.
module geartrain_trace_reading_extremes
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: highest_share, value_on
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_readings_at, only: count_readings, find_rates_of, floors, swings
   use geartrain_trace_step_extremes, only: quantities_type, solve_within
   use geartrain_trace_step_geometry, only: arc_length
   implicit none (type, external)
   private
   public :: cut_at_reading, values_type

   !> Height of a maximum above the ends of a step from which on it is met, over the ends [1].
   real(dp), parameter :: least_height = 0.02_dp
   !> Derivative at a maximum over the largest at the ends of the step; places that are tried.
   real(dp), parameter :: flat = 0.02_dp
   integer, parameter :: most_places = 6
   !> Least distance of a maximum from the ends of a step, as a share of it.
   real(dp), parameter :: off_ends = 1e-3_dp

   !> Readings at a point of the branch: alternating parts and their derivatives along the branch, (reading).
   type :: values_type
      !> Coefficients and Lambda of the point, and Lambda's part of its tangent; not allocated: none.
      real(dp), allocatable :: u(:, :)
      real(dp) :: frequency_ratio = 0, tangent_frequency = 0
      real(dp), allocatable :: y(:), slope(:), least(:)
   end type values_type

contains

   !> Cuts a step at its first maximum of a reading, if any.
   subroutine cut_at_reading(corrector, transform, here, next, at_next, torques, latest, cut)
      !> Corrector of the branch; it worked on `next` last.
      type(corrector_type), intent(inout) :: corrector
      !> Work space.
      type(transform_type), intent(inout) :: transform
      !> Beginning of the step.
      type(solution_point_type), intent(in) :: here
      !> Its end.
      type(solution_point_type), intent(inout) :: next
      !> Quantities of the meshes there.
      type(quantities_type), intent(inout) :: at_next
      !> Torques of shafts and forces of bearings are read.
      logical, intent(in) :: torques
      !> Values at the point looked at latest.
      type(values_type), intent(inout) :: latest
      !> `next` became a point within the step.
      logical, intent(out) :: cut
      type(solution_point_type) :: first, last, point
      type(quantities_type) :: at_point
      type(values_type) :: at_first, at_last, found
      real(dp) :: length, share, least, steepest, y(2), slope(2)
      integer :: i, r, reading
      logical :: success

      cut = .false.
      if (.not. are_of(latest, here)) call find_values(corrector, here, torques, latest)
      at_first = latest
      ! The balance is left evaluated at `next`, by which it is recorded.
      call find_values(corrector, next, torques, latest)
      at_last = latest
      length = arc_length(here, next, corrector%units)
      reading = 0
      least = 1 - off_ends
      do r = 1, size(at_first%y)
         share = share_of(at_first, at_last, r, length)
         if (share < off_ends .or. share > least) cycle
         least = share
         reading = r
      end do
      if (reading > 0) then
         first = here
         last = next
         steepest = max(abs(at_first%slope(reading)), abs(at_last%slope(reading)))
         share = least
         do i = 1, most_places
            call solve_within(corrector, transform, first, last, share, point, at_point, success)
            if (.not. success) exit
            call find_values(corrector, point, torques, found)
            cut = abs(found%slope(reading)) < flat*steepest .or. i == most_places
            if (cut) exit
            if (found%slope(reading) > 0) then
               first = point
               at_first = found
            else
               last = point
               at_last = found
            end if
            y = [at_first%y(reading), at_last%y(reading)]
            slope = [at_first%slope(reading), at_last%slope(reading)]*arc_length(first, last, corrector%units)
            share = highest_share(y, slope)
            if (share < off_ends .or. share > 1 - off_ends) share = 0.5_dp
         end do
      end if
      if (cut) then
         next = point
         at_next = at_point
         latest = found
      else if (reading > 0) then
         ! The point is recorded by what the corrector worked on last.
         point = next
         call corrector%correct(point, success)
      end if
   end subroutine cut_at_reading

   subroutine find_values(corrector, solution, torques, values)
      type(corrector_type), intent(inout) :: corrector
      type(solution_point_type), intent(in) :: solution
      logical, intent(in) :: torques
      type(values_type), intent(inout) :: values
      real(dp), dimension(corrector%balance%block, count_readings(corrector%balance, torques)) :: readings, rates

      values%u = solution%u
      values%frequency_ratio = solution%frequency_ratio
      values%tangent_frequency = solution%tangent_frequency
      call find_rates_of(corrector, solution, readings, rates)
      values%y = swings(readings)
      values%slope = sum(readings(2:, :)*rates(2:, :), 1)/max(values%y, tiny(1.0_dp))
      values%least = floors(corrector%balance, readings)
   end subroutine find_values

   !> Whether values were found at this solution point, with this tangent.
   pure logical function are_of(values, solution)
      type(values_type), intent(in) :: values
      type(solution_point_type), intent(in) :: solution

      are_of = allocated(values%u)
      if (are_of) are_of = all(shape(values%u) == shape(solution%u))
      if (are_of) are_of = all(abs(values%u - solution%u) <= 0) .and. &
                           abs(values%frequency_ratio - solution%frequency_ratio) <= 0 .and. &
                           abs(values%tangent_frequency - solution%tangent_frequency) <= 0
   end function are_of

   !> Share of a step at which a reading is highest by the cubic; -1: nowhere by as much as matters.
   pure real(dp) function share_of(first, last, r, length) result(share)
      type(values_type), intent(in) :: first, last
      !> Number of the reading; length of the step [1].
      integer, intent(in) :: r
      real(dp), intent(in) :: length
      real(dp) :: y(2), slope(2)

      y = [first%y(r), last%y(r)]
      slope = [first%slope(r), last%slope(r)]*length
      share = -1
      if (.not. (slope(1) > 0 .and. slope(2) < 0)) return
      share = highest_share(y, slope)
      if (share < 0) return
      if (.not. value_on(y, slope, share) > max((1 + least_height)*maxval(y), first%least(r), last%least(r))) share = -1
   end function share_of

end module geartrain_trace_reading_extremes
