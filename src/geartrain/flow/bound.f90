!> A motion counts as unbounded where it exceeds a million times the motions that the loads, the gaps and the errors of the train,
!> or the state at its start, explain. Velocities are divided by the highest frequency of the motion, so that the verdict depends
!> neither on the characteristic length nor on the characteristic frequency.
module geartrain_flow_bound
   use geartrain_base_kinds, only: dp
   use geartrain_flow_start_state, only: resting_state
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: largest_eigenvalue
   use geartrain_network_units, only: largest_drive
   implicit none (type, external)
   private
   public :: bound_type

   !> Largest size over the size that is explained [1].
   real(dp), parameter :: far = 1e6_dp

   type :: bound_type
      !> Explained displacement over characteristic length [1]; highest frequency of the motion over characteristic frequency [1].
      real(dp), private :: length = 0, frequency = 0
      integer, private :: displacements = 0
   contains
      procedure :: setup
      procedure :: limit
      procedure :: holds
      procedure, private :: size_of
   end type bound_type

contains

   !> Finds the scales of a train.
   pure subroutine setup(self, system, frequency_ratio)
      class(bound_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Lambda, the highest of the motion [1].
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: stiffest(system%elements)
      integer :: j

      stiffest = system%spring
      do j = 1, system%meshes
         stiffest(system%mesh_element(j)) = system%law(j)%stiffest()
      end do
      self%displacements = system%displacements
      self%frequency = max(sqrt(largest_eigenvalue(system, stiffest)), frequency_ratio)
      self%length = max(largest_drive(system), maxval(system%half_backlash), self%size_of(resting_state(system)))
   end subroutine setup

   !> Largest size of a bounded motion over characteristic length [1].
   pure real(dp) function limit(self, state)
      class(bound_type), intent(in) :: self
      !> State with which the motion starts [1], (state); absent: one that the train explains.
      real(dp), intent(in), optional :: state(:)

      limit = far*self%length
      if (present(state)) limit = max(limit, far*self%size_of(state))
   end function limit

   !> Whether a state is within a limit; one that is no number is not.
   pure logical function holds(self, state, limit)
      class(bound_type), intent(in) :: self
      !> State [1], (state); from `limit`.
      real(dp), intent(in) :: state(:), limit

      holds = self%size_of(state) <= limit
   end function holds

   !> Largest displacement, or velocity over the highest frequency [1]; NaN where the state is no number.
   pure real(dp) function size_of(self, state)
      class(bound_type), intent(in) :: self
      real(dp), intent(in) :: state(:)

      associate (d => self%displacements)
         size_of = sum(state - state)
         if (size_of <= 0) size_of = max(maxval(abs(state(:d))), maxval(abs(state(d + 1:)))/self%frequency)
      end associate
   end function size_of

end module geartrain_flow_bound
