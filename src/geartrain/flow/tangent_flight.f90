!> A flight of the state by the flow, with its tangents carried by the propagator along the contacts that the flow meets: for
!> Newton's method and multipliers to about 1e-9, in a third of the time of tangents in the flow, which are exact to rounding.
module geartrain_flow_tangent_flight
   use geartrain_base_kinds, only: dp, pi
   use geartrain_floquet_propagator, only: propagator_type
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_orbit, only: flow_order, flow_tolerance, propagate
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: tangent_flight_type

   type :: tangent_flight_type
      type(system_type), pointer :: system => null()
      type(flow_type), private :: flow
      type(propagator_type), private :: propagator
      !> Displacements and velocities of the coordinates that are states; not allocated: the flow carries the tangents.
      integer, allocatable, private :: kept(:)
   contains
      procedure :: setup
      procedure :: fly
   end type tangent_flight_type

contains

   subroutine setup(self, system, exact)
      class(tangent_flight_type), intent(inout) :: self
      type(system_type), target, intent(in) :: system
      !> Tangents exact to rounding.
      logical, intent(in), optional :: exact
      integer :: i

      self%system => system
      if (allocated(self%kept)) deallocate (self%kept)
      ! Of dry friction the flow alone knows what sticks.
      if (any(system%friction > 0)) return
      if (present(exact)) then
         if (exact) return
      end if
      call self%flow%setup(self%system, 1, flow_order, flow_tolerance)
      call self%propagator%setup(self%system)
      self%kept = [(i, i=1, system%displacements), (system%coordinates + i, i=1, system%coordinates)]
   end subroutine setup

   !> Carries a state and its tangents over a period; less far where it is interrupted.
   subroutine fly(self, frequency_ratio, period, state, final, monodromy)
      class(tangent_flight_type), intent(inout) :: self
      !> Lambda [1]; state at phase 0 [1], (state).
      real(dp), intent(in) :: frequency_ratio, state(:)
      !> Number of periods of the fundamental.
      integer, intent(in) :: period
      !> State after the period [1], (state); monodromy matrix [1], (state, state).
      real(dp), intent(out) :: final(:), monodromy(:, :)
      real(dp), allocatable :: transposed(:, :)
      integer :: contact(self%system%meshes)
      real(dp) :: length, begun
      integer :: i, j
      logical :: sheared

      if (.not. allocated(self%kept)) then
         call propagate(self%system, frequency_ratio, period, state, final, monodromy)
         return
      end if
      associate (flow => self%flow)
         flow%x(1, :) = state
         call self%propagator%start(frequency_ratio, 1.0_dp)
         length = 2*pi/frequency_ratio
         do i = 1, period
            call flow%start(frequency_ratio, 0.0_dp)
            contact = flow%contact
            begun = 0
            do while (flow%time < length)
               if (self%system%interrupt%raised()) exit
               call flow%step(length)
               if (all(flow%contact == contact)) cycle
               call self%propagator%advance(begun, flow%time, contact)
               do j = 1, size(contact)
                  if (flow%contact(j) /= contact(j)) call self%propagator%pass_wall(j, contact(j), flow%contact(j), sheared)
               end do
               contact = flow%contact
               begun = flow%time
            end do
            call self%propagator%advance(begun, length, contact)
         end do
         final = flow%x(1, :)
         allocate (transposed(2*self%system%coordinates, 2*self%system%coordinates))
      end associate
      call self%propagator%get(transposed)
      monodromy = transpose(transposed(self%kept, self%kept))
   end subroutine fly

end module geartrain_flow_tangent_flight
