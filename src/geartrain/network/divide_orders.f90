!> Divides the orders of a train, so that a motion that repeats its waveform within a period goes through it once.
module geartrain_network_divide_orders
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: divide_orders

contains

   !> Divides all orders of a train; harmonics without an amplitude, which need not be multiples of the divisor, are dropped.
   pure subroutine divide_orders(times, system)
      !> Common divisor of the orders.
      integer, intent(in) :: times
      type(system_type), intent(inout) :: system
      integer :: j

      if (times == 1) return
      do j = 1, size(system%torque)
         call divide(times, system%torque(j))
      end do
      do j = 1, system%meshes
         call divide_law(times, system%law(j))
         call divide(times, system%transmission_error(j))
      end do
      if (allocated(system%speed_loads)) system%speed_loads%reference = times*system%speed_loads%reference
      system%excitation_order = system%excitation_order/times
   end subroutine divide_orders

   pure subroutine divide_law(times, law)
      integer, intent(in) :: times
      type(law_type), intent(inout) :: law
      complex(dp), allocatable :: amplitude(:, :), offset(:, :)
      logical :: kept(size(law%harmonic))
      integer :: s

      ! Where kappa of no region varies, no offset does.
      kept = any(abs(law%amplitude) > 0, 2)
      if (allocated(law%offset)) then
         allocate (offset(count(kept), law%lowest:law%highest))
         do s = law%lowest, law%highest
            offset(:, s) = pack(law%offset(:, s), kept)
         end do
         call move_alloc(offset, law%offset)
      end if
      allocate (amplitude(count(kept), law%lowest:law%highest))
      do s = law%lowest, law%highest
         amplitude(:, s) = pack(law%amplitude(:, s), kept)
      end do
      call move_alloc(amplitude, law%amplitude)
      law%harmonic = pack(law%harmonic, kept)/times
      law%order = law%order/times
   end subroutine divide_law

   pure subroutine divide(times, series)
      integer, intent(in) :: times
      type(series_type), intent(inout) :: series

      series%harmonic = pack(series%harmonic, abs(series%amplitude) > 0)/times
      series%amplitude = pack(series%amplitude, abs(series%amplitude) > 0)
   end subroutine divide

end module geartrain_network_divide_orders
