!> Units of the metric of a branch: the displacements of the train and the Lambda at which a mesh excites its own vibration. Steps,
!> tolerances, guards and random starts so depend neither on characteristic values nor on the size of a train.
module geartrain_network_units
   use geartrain_base_kinds, only: dp
   use geartrain_network_network, only: stiffening
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: largest_drive, largest_load, largest_unit, length_unit_of, mesh_frequencies, units_of, units_type

   !> Displacement of a train that rattles under a small load, over its deflection [1]: it does not reach the other flank.
   real(dp), parameter :: rattle = 5
   !> Frequency of a vibration in which all meshes of a train take part, over that of a mesh alone [1].
   real(dp), parameter :: slower = 0.5_dp

   type :: units_type
      !> Unit of mesh displacement over characteristic length [1], and of Lambda [1]. Along a path in a parameter the length of the
      !> path in place of that of Lambda [unit of the parameter].
      real(dp) :: length = 1, frequency_ratio = 1
   contains
      procedure :: size_of
   end type units_type

contains

   !> Units of the metric in which branches of a train are traced.
   pure type(units_type) function units_of(system) result(units)
      type(system_type), intent(in) :: system

      units%length = length_unit_of(system)
      units%frequency_ratio = slower*minval(mesh_frequencies(system)/system%law%order)
   end function units_of

   !> Largest displacement or velocity of states, or of changes of states, each in its unit [1]. Without the units the
   !> characteristic frequency decides which of a displacement and a velocity is the larger number.
   pure real(dp) function size_of(self, displacements, states)
      class(units_type), intent(in) :: self
      !> Number of displacements of a state; the velocities follow.
      integer, intent(in) :: displacements
      !> States [1], (state, :).
      real(dp), intent(in) :: states(:, :)

      size_of = max(maxval(abs(states(:displacements, :))), maxval(abs(states(displacements + 1:, :)))/self%frequency_ratio) &
                /self%length
   end function size_of

   !> Frequency at which each mesh vibrates alone on the flank that bears its mean load, over characteristic frequency [1], (mesh).
   pure function mesh_frequencies(system) result(frequency)
      type(system_type), intent(in) :: system
      real(dp) :: frequency(system%meshes), stiff(system%elements)

      stiff = stiffening(system%network)
      associate (n => system%mesh_element)
         frequency = sqrt(system%own(n)*stiff(n)*bearing_stiffness(system))
      end associate
   end function mesh_frequencies

   !> Stiffness of the flank that bears the mean load of each mesh, over its stiffness [1], (mesh).
   pure function bearing_stiffness(system) result(stiffness)
      type(system_type), intent(in) :: system
      real(dp) :: stiffness(system%meshes)
      integer :: j

      do j = 1, system%meshes
         associate (law => system%law(j))
            stiffness(j) = law%stiffness(law%bearing(system%static_force(system%mesh_element(j))))
         end associate
      end do
   end function bearing_stiffness

   !> Unit of displacement of the motions of a train, over characteristic length [1].
   pure real(dp) function length_unit_of(system) result(length)
      type(system_type), intent(in) :: system
      real(dp) :: drive, gap

      drive = max(largest_load(system), largest_error(system))
      gap = maxval(system%half_backlash)
      if (drive > 0) gap = min(gap, rattle*drive)
      length = max(drive, gap)
      if (.not. length > 0) length = 1
   end function length_unit_of

   !> Unit of displacement of motions that cross the gap, over characteristic length [1]: amplitude limits are multiples of it.
   pure real(dp) function largest_unit(system)
      type(system_type), intent(in) :: system

      largest_unit = max(largest_load(system), maxval(system%half_backlash))
      if (.not. largest_unit > 0) largest_unit = 1
   end function largest_unit

   !> Largest deflection of a mesh under the mean load, over characteristic length [1].
   pure real(dp) function largest_load(system)
      type(system_type), intent(in) :: system

      largest_load = maxval(abs(system%static_force(system%mesh_element))/bearing_stiffness(system))
   end function largest_load

   !> Largest displacement that a mean load, a transmission error or, in time with the meshes, a fluctuating torque would cause,
   !> over characteristic length [1]; 0: nothing excites the train.
   pure real(dp) function largest_drive(system)
      type(system_type), intent(in) :: system
      type(units_type) :: units
      integer :: i

      units = units_of(system)
      largest_drive = max(largest_load(system), largest_error(system))
      do i = 1, size(system%torque)
         largest_drive = max(largest_drive, sum(abs(system%torque(i)%amplitude))*maxval(abs(system%torque_gain(:, i))) &
                                            /units%frequency_ratio**2)
      end do
   end function largest_drive

   !> Bound of all transmission errors over characteristic length [1].
   pure real(dp) function largest_error(system)
      type(system_type), intent(in) :: system
      integer :: j

      largest_error = 0
      do j = 1, system%meshes
         largest_error = max(largest_error, sum(abs(system%transmission_error(j)%amplitude)))
      end do
   end function largest_error

end module geartrain_network_units
