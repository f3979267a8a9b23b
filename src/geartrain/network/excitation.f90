!> Harmonics of Lambda that excite a train, by the torques, the mesh stiffnesses and the transmission errors; how its meshes turn.
module geartrain_network_excitation
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: excited_harmonics, highest_order, lowest_harmonic, nearest_return, reach_of_sources

contains

   !> Harmonics of Lambda that a torque, a mesh stiffness or a transmission error excites, ascending.
   pure function excited_harmonics(system) result(harmonic)
      !> System with at least its excitation, see `put_excitation`.
      type(system_type), intent(in) :: system
      integer, allocatable :: harmonic(:)
      integer :: j

      allocate (harmonic(0))
      do j = 1, size(system%torque)
         call merge_excited(system%torque(j), harmonic)
      end do
      do j = 1, system%meshes
         call merge_excited(system%law(j)%variation(), harmonic)
         call merge_excited(system%transmission_error(j), harmonic)
      end do
   end function excited_harmonics

   !> Least number of harmonics of Lambda that includes the lowest harmonic of every source of excitation: torques, mesh
   !> stiffnesses, transmission errors. 1 for a train without excitation.
   pure integer function reach_of_sources(system) result(reach)
      !> System with at least its excitation, see `put_excitation`.
      type(system_type), intent(in) :: system
      integer :: j

      reach = maxval([1, (lowest_harmonic(system%torque(j)), j=1, size(system%torque))])
      do j = 1, system%meshes
         reach = max(reach, lowest_harmonic(system%law(j)%variation()), lowest_harmonic(system%transmission_error(j)))
         ! Errors of the gears, and of the stiffness of their teeth, may have lower harmonics than those of the mesh.
         reach = max(reach, lowest_harmonic(system%law(j)%variation(), system%law(j)%order))
         reach = max(reach, lowest_harmonic(system%transmission_error(j), system%law(j)%order))
      end do
   end function reach_of_sources

   !> Lowest harmonic of Lambda in a series; 0 where there is none.
   pure integer function lowest_harmonic(series, order) result(lowest)
      !> A source of excitation, in any unit.
      type(series_type), intent(in) :: series
      !> Only multiples of this order count, a whole number over how often the waveform repeats itself in a period; absent: all.
      real(dp), intent(in), optional :: order
      real(dp) :: divisor
      integer :: h

      divisor = 1
      if (present(order)) divisor = order
      lowest = 0
      do h = size(series%harmonic), 1, -1
         if (.not. abs(series%amplitude(h)) > 0) cycle
         associate (multiple => series%harmonic(h)/divisor)
            if (abs(multiple - anint(multiple)) < 1e-9_dp*multiple) lowest = series%harmonic(h)
         end associate
      end do
   end function lowest_harmonic

   !> Takes the excited harmonics of a series into an ascending list. The work grows with the lists and not with the orders, which
   !> may be a million.
   pure subroutine merge_excited(series, list)
      type(series_type), intent(in) :: series
      integer, allocatable, intent(inout) :: list(:)
      integer, allocatable :: added(:)
      integer :: merged(size(list) + size(series%harmonic)), i, j, n

      added = pack(series%harmonic, abs(series%amplitude) > 0)
      i = 1
      j = 1
      n = 0
      do while (i <= size(list) .or. j <= size(added))
         n = n + 1
         if (j > size(added)) then
            merged(n) = list(i)
         else if (i > size(list)) then
            merged(n) = added(j)
         else
            merged(n) = min(list(i), added(j))
         end if
         if (i <= size(list)) then
            if (list(i) == merged(n)) i = i + 1
         end if
         if (j <= size(added)) then
            if (added(j) == merged(n)) j = j + 1
         end if
      end do
      list = merged(:n)
   end subroutine merge_excited

   !> Frequency of the fastest mesh over Lambda [1].
   pure real(dp) function highest_order(system)
      type(system_type), intent(in) :: system

      highest_order = maxval([1.0_dp, system%law%order])
   end function highest_order

   !> A number of cycles of the fastest mesh after which the other meshes stand most nearly where they stood.
   pure integer function nearest_return(system, least, most) result(cycles)
      type(system_type), intent(in) :: system
      !> Limits of the number.
      integer, intent(in) :: least, most
      real(dp) :: turns(system%meshes), off, nearest
      integer :: k

      nearest = huge(nearest)
      cycles = least
      do k = least, most
         turns = k*system%law%order/highest_order(system)
         off = sum((turns - anint(turns))**2)
         if (off < nearest) cycles = k
         nearest = min(nearest, off)
      end do
   end function nearest_return

end module geartrain_network_excitation
