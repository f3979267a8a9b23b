!> Where a branch begins: a tracer for a train, and places to start it from.
module geartrain_branch_start
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: response_settings_type
   use geartrain_branch_chosen_harmonics, only: first_harmonics
   use geartrain_branch_path, only: place_type
   use geartrain_branch_tracer, only: tracer_type
   use geartrain_branch_units, only: largest_unit, units_of
   use geartrain_model_modes, only: natural_frequencies
   use geartrain_model_system, only: build_system
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   implicit none (type, external)
   private
   public :: begin_trace, place_of, resting

   !> Amplitude limit where none is given, rms in the unit of motions that cross the gap. A linear train has none: its branch is
   !> only not recorded between here and infinity, where it passes a multiplier +1.
   real(dp), parameter :: default_amplitude_limit = 12, linear_amplitude_limit = 1e4_dp

contains

   !> A tracer for the train with the settings in force.
   subroutine begin_trace(train, settings, tracer)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(tracer_type), intent(inout) :: tracer

      tracer%settings = settings
      call build_system(train, tracer%system)
      tracer%path%units = units_of(tracer%system)
      if (settings%amplitude_limit > 0) then
         tracer%amplitude_limit = settings%amplitude_limit
      else if (any(tracer%system%backlash > 0)) then
         tracer%amplitude_limit = default_amplitude_limit*largest_unit(tracer%system)
      else
         tracer%amplitude_limit = linear_amplitude_limit*largest_unit(tracer%system)
      end if
      tracer%truncation%natural_frequency = natural_frequencies(tracer%system)
      call tracer%prepare(merge(settings%harmonics, first_harmonics(tracer%system, settings%subharmonic), settings%harmonics > 0))
   end subroutine begin_trace

   !> The train at rest under its mean load, every mesh on its drive flank.
   function resting(tracer, frequency) result(place)
      type(tracer_type), intent(in) :: tracer
      real(dp), intent(in) :: frequency
      type(place_type) :: place

      associate (balance => tracer%path%balance, system => tracer%system)
         allocate (place%u(balance%block, balance%unknowns), source=0.0_dp)
         place%frequency = frequency
         place%u(1, :) = system%load(system%mesh_element(balance%mesh))
         place%u(1, :) = place%u(1, :) + sign(system%backlash(balance%mesh), place%u(1, :))
      end associate
   end function resting

   !> The coefficients of a motion on the harmonics of the balance; the motion's period divides the sub-harmonic index.
   function place_of(tracer, motion) result(place)
      type(tracer_type), intent(in) :: tracer
      type(motion_type), intent(in) :: motion
      type(place_type) :: place
      integer :: i, k, r, ratio

      associate (balance => tracer%path%balance)
         allocate (place%u(balance%block, balance%unknowns), source=0.0_dp)
         place%frequency = motion%frequency
         ratio = tracer%settings%subharmonic/motion%period
         do i = 1, balance%unknowns
            place%u(1, i) = motion%coefficients(1, balance%mesh(i))
            do k = 1, size(balance%harmonic)
               r = balance%harmonic(k)/ratio
               if (r*ratio /= balance%harmonic(k) .or. 2*r + 1 > size(motion%coefficients, 1)) cycle
               place%u(2*k:2*k + 1, i) = motion%coefficients(2*r:2*r + 1, balance%mesh(i))
            end do
         end do
      end associate
   end function place_of

end module geartrain_branch_start
