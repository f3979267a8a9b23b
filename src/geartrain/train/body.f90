!> A body that turns as one, in SI units: a gear, a rotor, a flange.
module geartrain_train_body
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: table_harmonics
   implicit none (type, external)
   private
   public :: body_type, follows_speed, has_table_of_torque, name_length, plain_torque, pulses

   !> Most characters of a name.
   integer, parameter :: name_length = 64

   type :: body_type
      !> Name by which shafts and meshes refer to the body.
      character(:), allocatable :: name
      !> Polar moment of inertia [kg m^2]; 0 is allowed where a rigid shaft joins it with others; negative: by the drawing.
      real(dp) :: inertia = -1
      !> Inertia [kg m^2] that adds to `inertia` or to that of the drawing: of masses that the body carries, as a carrier its
      !> planets.
      real(dp) :: added_inertia = 0
      !> From the drawing: discs whose inertias are added, diameters and widths [m] and densities [kg/m^3]; one bore or density
      !> holds for all discs.
      real(dp), allocatable :: outer_diameter(:), bore(:), width(:), density(:)
      !> Mean torque on the body [N m], positive in its sense of rotation; 0 for the body that balances the others.
      real(dp) :: torque = 0
      !> Amplitudes of the torque at the harmonics 1, 2, ... of Lambda [N m], (harmonic).
      real(dp), allocatable :: torque_cos(:), torque_sin(:)
      !> Amplitudes of the torque at the harmonics 1, 2, ... of the revolution of the body [N m], (harmonic).
      real(dp), allocatable :: revolution_torque_cos(:), revolution_torque_sin(:)
      !> Torque at equidistant angles of one revolution or of two [N m], (angle), and the number of revolutions.
      real(dp), allocatable :: torque_table(:)
      integer :: torque_revolutions = 1
      !> Derived: revolution of the body as a multiple of the fundamental, where it has such a torque; of a torque over two
      !> revolutions both, and the amplitudes are those of the harmonics of both.
      integer :: revolution_order = 1
      !> The mean torque is proportional to this power of the speed [1], and is as given at this speed of the body [rpm].
      real(dp) :: torque_speed_exponent = 0, torque_speed = 0
      !> Derived: turns of the body per period of the fundamental [1]; 0: not known, or the torque does not follow the speed.
      real(dp) :: turns = 0
      !> Damping to ground of the vibration of the body [N m s/rad]; none of its mean rotation.
      real(dp) :: damping_to_ground = 0
      !> Stiffness to ground [N m/rad].
      real(dp) :: stiffness_to_ground = 0
      !> The body stands still.
      logical :: held = .false.
      !> Mean speed over that of the body whose revolutions are the speed [1], signed in one sense of all; in force when
      !> `ratio_given`, where the gears alone do not determine all speeds.
      real(dp) :: speed_ratio = 0
      logical :: ratio_given = .false.
      !> Position of the axis in the transverse plane, x and y [m]; empty: not given.
      real(dp), allocatable :: position(:)
      !> The mean torque of the body balances the mean torques of all others.
      logical :: balances = .false.
   end type body_type

contains

   !> Whether a body has a table of its torque.
   elemental logical function has_table_of_torque(body) result(has)
      type(body_type), intent(in) :: body

      has = .false.
      if (allocated(body%torque_table)) has = size(body%torque_table) > 0
   end function has_table_of_torque

   !> Whether the mean torque of a body follows its speed.
   elemental logical function follows_speed(body) result(follows)
      type(body_type), intent(in) :: body

      follows = abs(body%torque_speed_exponent) > 0
   end function follows_speed

   !> Whether a body has a torque that repeats itself with its revolution.
   elemental logical function pulses(body)
      type(body_type), intent(in) :: body

      pulses = has_table_of_torque(body)
      if (allocated(body%revolution_torque_cos)) pulses = pulses .or. size(body%revolution_torque_cos) > 0
      if (allocated(body%revolution_torque_sin)) pulses = pulses .or. size(body%revolution_torque_sin) > 0
   end function pulses

   !> Replaces the table of the torque by its mean, which adds to the mean torque, and harmonics.
   pure subroutine plain_torque(body)
      type(body_type), intent(inout) :: body
      real(dp), allocatable :: cosine(:), sine(:)
      real(dp) :: mean

      if (.not. has_table_of_torque(body)) return
      call table_harmonics(body%torque_table, mean, cosine, sine)
      if (.not. body%balances) body%torque = body%torque + mean
      if (allocated(body%revolution_torque_cos)) call add(body%revolution_torque_cos, body%torque_revolutions, cosine)
      if (allocated(body%revolution_torque_sin)) call add(body%revolution_torque_sin, body%torque_revolutions, sine)
      call move_alloc(cosine, body%revolution_torque_cos)
      call move_alloc(sine, body%revolution_torque_sin)
      deallocate (body%torque_table)
      body%torque_revolutions = 1
   end subroutine plain_torque

   !> Adds harmonics of a revolution to harmonics of so many revolutions.
   pure subroutine add(amplitude, revolutions, list)
      real(dp), intent(in) :: amplitude(:)
      integer, intent(in) :: revolutions
      real(dp), allocatable, intent(inout) :: list(:)
      integer :: i

      list = [list, [(0.0_dp, i=size(list) + 1, revolutions*size(amplitude))]]
      do i = 1, size(amplitude)
         list(revolutions*i) = list(revolutions*i) + amplitude(i)
      end do
   end subroutine add

end module geartrain_train_body
