!> Time history of a motion over one period.
module geartrain_motion_waveform
   use geartrain_base_kinds, only: dp, pi
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_motion_orbit, only: sample_orbit
   use geartrain_motion_trigonometric, only: evaluate
   implicit none (type, external)
   private
   public :: waveform

contains

   !> `samples` equidistant instants of one period (16 mesh periods where no period was found): time over
   !> 1/characteristic_frequency, (samples), and mesh displacement over characteristic length, (samples, mesh); integrated
   !> where the motion has a state, else summed from its coefficients.
   subroutine waveform(train, motion, samples, time, displacement)
      type(train_type), intent(in) :: train
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: samples
      real(dp), intent(out) :: time(:), displacement(:, :)
      type(system_type) :: system
      integer, allocatable :: harmonic(:)
      real(dp) :: slope, curvature
      integer :: period, q, j, k

      period = merge(motion%period, 16, motion%period > 0)
      time = [(2*pi*period/motion%frequency*(q - 1)/samples, q=1, samples)]
      if (allocated(motion%state)) then
         call build_system(train, system)
         call sample_orbit(system, motion%frequency, period, motion%state, displacement)
         return
      end if
      harmonic = [(k, k=1, (size(motion%coefficients, 1) - 1)/2)]
      do j = 1, size(displacement, 2)
         do q = 1, samples
            call evaluate(motion%coefficients(:, j), harmonic, 2*pi*(q - 1)/samples, displacement(q, j), slope, curvature)
         end do
      end do
   end subroutine waveform

end module geartrain_motion_waveform
