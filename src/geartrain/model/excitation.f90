!> Harmonics of Lambda that excite a train: by the torques, the mesh stiffnesses and the transmission errors.
module geartrain_model_excitation
   use geartrain_base_series, only: series_type
   use geartrain_model_system, only: system_type
   implicit none (type, external)
   private
   public :: excited_harmonics, lowest_harmonic, reach_of_sources

contains

   !> Harmonics of Lambda that a torque, a mesh stiffness or a transmission error excites, ascending.
   pure function excited_harmonics(system) result(harmonic)
      !> System with at least its excitation, see `put_excitation`.
      type(system_type), intent(in) :: system
      integer, allocatable :: harmonic(:)
      logical, allocatable :: excited(:)
      integer :: j, r

      r = maxval([0, (highest_harmonic(system%torque(j)), j=1, size(system%torque))])
      do j = 1, system%meshes
         r = max(r, highest_harmonic(system%law(j)%variation()), highest_harmonic(system%transmission_error(j)))
      end do
      allocate (excited(r), source=.false.)
      do j = 1, size(system%torque)
         call mark(system%torque(j), excited)
      end do
      do j = 1, system%meshes
         call mark(system%law(j)%variation(), excited)
         call mark(system%transmission_error(j), excited)
      end do
      harmonic = pack([(r, r=1, size(excited))], excited)
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
      end do
   end function reach_of_sources

   !> Lowest harmonic of Lambda in a series; 0 for an empty series.
   pure integer function lowest_harmonic(series) result(lowest)
      !> A source of excitation, in any unit.
      type(series_type), intent(in) :: series

      integer :: h

      lowest = 0
      do h = size(series%harmonic), 1, -1
         if (abs(series%amplitude(h)) > 0) lowest = series%harmonic(h)
      end do
   end function lowest_harmonic

   !> Highest harmonic of Lambda in a series; 0 for an empty series.
   pure integer function highest_harmonic(series) result(highest)
      type(series_type), intent(in) :: series

      highest = maxval([0, series%harmonic])
   end function highest_harmonic

   pure subroutine mark(series, excited)
      type(series_type), intent(in) :: series
      logical, intent(inout) :: excited(:)
      integer :: h

      do h = 1, size(series%amplitude)
         if (abs(series%amplitude(h)) > 0) excited(series%harmonic(h)) = .true.
      end do
   end subroutine mark

end module geartrain_model_excitation
