!> Extremes and means of displacements, forces and torques along the flow, over all instants: from the Taylor series of each step,
!> which end at contact events.
module geartrain_flow_figures
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow, only: flow_type
   use geartrain_flow_force_series, only: energy_loss, include, integral, integral_of_square
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: figures_type

   !> Smallest and largest value of a signal; its integral by time.
   type :: range_type
      real(dp) :: low = huge(1.0_dp), high = -huge(1.0_dp), integral = 0
   end type range_type

   type :: figures_type
      !> Time that the figures span [1].
      real(dp) :: length = 0
      !> Whether the flow passed over an event; see `flow_type`.
      logical :: lost = .false.
      !> Mesh displacements over b_c [1] and forces [N], of couplings [N m], (mesh); rows of the torque paths [N m, N], (row): NaN
      !> where nothing determines a torque.
      type(range_type), allocatable :: displacement(:), force(:), torque(:)
      !> Times on the back flank, in separation and on the drive flank [1], (-1:1, mesh).
      real(dp), allocatable :: spent(:, :)
      !> Energy that each coupling loses [J], (coupling).
      real(dp), allocatable :: loss(:)
      !> First value of the force of each bearing [N], and the integral of the square of its difference from it, (axis and bearing).
      real(dp), allocatable, private :: first(:), square(:)
   contains
      procedure :: setup
      procedure :: follow
      procedure :: clear
      procedure :: bearing_rms
   end type figures_type

contains

   !> Makes room.
   pure subroutine setup(self, system)
      class(figures_type), intent(inout) :: self
      type(system_type), intent(in) :: system

      associate (paths => system%torque_paths)
         allocate (self%displacement(system%meshes), self%force(system%meshes), self%torque(paths%rows), &
                   self%spent(-1:1, system%meshes), self%loss(paths%couplings), self%first(2*paths%bearings), &
                   self%square(2*paths%bearings))
         associate (nan => ieee_value(1.0_dp, ieee_quiet_nan))
            where (.not. paths%known) self%torque = range_type(nan, nan, nan)
         end associate
      end associate
      self%spent = 0
      self%loss = 0
      self%square = 0
   end subroutine setup

   !> Takes the latest step of the flow.
   pure subroutine follow(self, flow, contact, force, torque)
      class(figures_type), intent(inout) :: self
      type(flow_type), intent(in) :: flow
      !> Region of the law of each mesh during the step, (mesh).
      integer, intent(in) :: contact(:)
      !> Taylor coefficients of the forces of the meshes, (0:order, mesh), and of the rows of the torque paths, (0:order, row).
      real(dp), intent(in) :: force(0:, :), torque(0:, :)
      real(dp) :: change(0:flow%order)
      integer :: i

      associate (system => flow%system, paths => flow%system%torque_paths)
         do i = 1, system%meshes
            call take(flow%p(1, system%mesh_element(i), :), self%displacement(i))
            call take(force(:, i), self%force(i))
            associate (spent => self%spent(max(-1, min(1, contact(i))), i))
               spent = spent + flow%length
            end associate
         end do
         do i = 1, paths%rows
            if (paths%known(i)) call take(torque(:, i), self%torque(i))
         end do
         do i = 1, paths%couplings
            self%loss(i) = self%loss(i) + energy_loss(flow, paths%pairs + i, contact(paths%pairs + i))
         end do
         do i = 1, size(self%first)
            change = torque(:, paths%torques + i)
            if (.not. self%length > 0) self%first(i) = change(0)
            change(0) = change(0) - self%first(i)
            self%square(i) = self%square(i) + integral_of_square(change, flow%length)
         end do
      end associate
      self%length = self%length + flow%length
      self%lost = self%lost .or. flow%lost

   contains

      pure subroutine take(series, range)
         real(dp), intent(in) :: series(0:)
         type(range_type), intent(inout) :: range

         call include(series, flow%length, range%low, range%high)
         range%integral = range%integral + integral(series, flow%length)
      end subroutine take

   end subroutine follow

   !> Sets all figures to 0, over a length of 1.
   pure subroutine clear(self)
      class(figures_type), intent(inout) :: self

      self%length = 1
      self%displacement = range_type(0, 0, 0)
      self%force = range_type(0, 0, 0)
      self%torque = range_type(0, 0, 0)
      self%spent = 0
      self%loss = 0
      self%first = 0
      self%square = 0
   end subroutine clear

   !> Root mean square of the force of each bearing without its mean [N], (axis and bearing).
   pure function bearing_rms(self) result(rms)
      class(figures_type), intent(in) :: self
      real(dp) :: rms(size(self%square))

      associate (mean => self%torque(size(self%torque) - size(rms) + 1:)%integral/self%length - self%first)
         rms = sqrt(max(self%square/self%length - mean**2, 0.0_dp))
      end associate
   end function bearing_rms

end module geartrain_flow_figures
