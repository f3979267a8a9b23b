!> Mean torques that follow the speed, as powers of Lambda: propellers, fans, drives of constant power.
module geartrain_network_speed_loads
   use geartrain_base_kinds, only: dp, pi
   use geartrain_network_network, only: balance_torques, network_type
   use geartrain_network_torque_paths, only: find_torque_paths, torque_paths_type
   use geartrain_train_body, only: follows_speed
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_speed_loads, speed_loads_type

   !> A load is the torque of a body as given, with the torques of the bodies that balance it. At Lambda it is the factor
   !> (Lambda/reference)^exponent times this torque.
   type :: speed_loads_type
      !> Lambda at which the torque is as given [1]; exponent; factor for which the static forces of the system stand [1], (load).
      real(dp), allocatable :: reference(:), exponent(:), factor(:)
      !> Torque on each node as given [N m], (node, load); its effects: acceleration of each element [1], (element, load), torque of
      !> each row of the torque paths [N m], (row, load), and right side of the mean equation of each unknown [1], (unknown, load).
      real(dp), allocatable :: torque(:, :), acceleration(:, :), constant(:, :), mean(:, :)
      !> Torque on each node with all factors 1 and the scale of its rounding [N m], (node); constants of the torque paths [N m],
      !> (row).
      real(dp), allocatable :: all_torque(:), magnitude(:), all_constant(:)
   contains
      procedure :: factors_at
      procedure :: rates_at
      procedure :: accelerate
      procedure :: series_of
   end type speed_loads_type

contains

   !> Finds the loads that follow the speed; not allocated where there is none.
   pure subroutine find_speed_loads(train, network, torque_body, torque_gain, paths, loads)
      !> The plain train.
      type(train_type), intent(in) :: train
      type(network_type), intent(in) :: network
      !> Body of each fluctuating torque, (torque).
      integer, intent(in) :: torque_body(:)
      !> Acceleration of each element per torque over b_c [m/(N m)], (element, torque).
      real(dp), intent(in) :: torque_gain(:, :)
      !> Torque paths of the train.
      type(torque_paths_type), intent(in) :: paths
      !> The loads; `mean` is not set.
      type(speed_loads_type), allocatable, intent(out) :: loads
      type(train_type) :: doubled
      type(torque_paths_type) :: other
      real(dp) :: torque(size(network%node))
      integer, allocatable :: body(:)
      integer :: i, k

      if (.not. allocated(train%bodies)) return
      body = pack([(i, i=1, size(train%bodies))], follows_speed(train%bodies) .and. train%bodies%turns > 0 &
                  .and. abs(train%bodies%torque) > 0)
      if (size(body) == 0) return
      allocate (loads)
      loads%exponent = train%bodies(body)%torque_speed_exponent
      loads%reference = train%bodies(body)%torque_speed*(2*pi/60)/train%bodies(body)%turns/train%characteristic_frequency
      loads%all_torque = network%torque
      loads%magnitude = network%magnitude
      loads%all_constant = paths%constant
      allocate (loads%factor(size(body)), source=1.0_dp)
      allocate (loads%torque(size(network%torque), size(body)), loads%acceleration(size(torque_gain, 1), size(body)), &
                loads%constant(paths%rows, size(body)), source=0.0_dp)
      do k = 1, size(body)
         torque = 0
         torque(body(k)) = train%bodies(body(k))%torque
         call balance_torques(network, torque)
         do i = 1, size(torque)
            if (.not. abs(torque(i)) > 0) cycle
            ! The bodies come first among the fluctuating torques, in their order.
            loads%acceleration(:, k) = loads%acceleration(:, k) + torque_gain(:, i)*(torque(i)/train%characteristic_length)
            associate (node => network%node(i))
               ! The torques of balancing bodies are not among those of the network.
               if (node > 0 .and. i == body(k)) loads%torque(node, k) = loads%torque(node, k) + torque(i)
            end associate
         end do
         doubled = train
         doubled%bodies(body(k))%torque = 2*doubled%bodies(body(k))%torque
         call find_torque_paths(doubled, network, torque_body, other)
         loads%constant(:, k) = other%constant - paths%constant
      end do
   end subroutine find_speed_loads

   !> Factor of each load [1], (load).
   pure function factors_at(self, frequency_ratio) result(factor)
      class(speed_loads_type), intent(in) :: self
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: factor(size(self%exponent))

      factor = (frequency_ratio/self%reference)**self%exponent
   end function factors_at

   !> Derivative of each factor with respect to Lambda [1], (load).
   pure function rates_at(self, frequency_ratio) result(rate)
      class(speed_loads_type), intent(in) :: self
      !> Lambda [1], > 0.
      real(dp), intent(in) :: frequency_ratio
      real(dp) :: rate(size(self%exponent))

      rate = self%exponent*self%factors_at(frequency_ratio)/frequency_ratio
   end function rates_at

   !> Adds the Taylor coefficients in time of the accelerations by the loads, less the loads whose static forces the system has.
   pure subroutine accelerate(self, frequency_ratio, acceleration, excitation)
      class(speed_loads_type), intent(in) :: self
      !> Lambda at the instant, > 0, and its rate of change [1].
      real(dp), intent(in) :: frequency_ratio, acceleration
      !> Accelerations [1], (0:order, element).
      real(dp), intent(inout) :: excitation(0:, :)
      integer :: k, n

      do k = 1, size(self%factor)
         associate (series => self%series_of(k, frequency_ratio, acceleration, ubound(excitation, 1)))
            do n = 1, size(excitation, 2)
               excitation(:, n) = excitation(:, n) + self%acceleration(n, k)*series
            end do
         end associate
      end do
   end subroutine accelerate

   !> Taylor coefficients in time of the factor of a load, less the factor for which the static forces stand [1], (0:order).
   pure function series_of(self, load, frequency_ratio, acceleration, order) result(series)
      class(speed_loads_type), intent(in) :: self
      !> Number of the load; order of the series.
      integer, intent(in) :: load, order
      !> Lambda at the instant, > 0, and its rate of change [1].
      real(dp), intent(in) :: frequency_ratio, acceleration
      real(dp) :: series(0:order)
      integer :: k

      series = 0
      series(0) = (frequency_ratio/self%reference(load))**self%exponent(load)
      ! From f' Lambda = exponent acceleration f.
      do k = 0, order - 1
         if (.not. abs(series(k)) > 0) exit
         series(k + 1) = series(k)*(self%exponent(load) - k)/(k + 1)*(acceleration/frequency_ratio)
      end do
      series(0) = series(0) - self%factor(load)
   end function series_of

end module geartrain_network_speed_loads
