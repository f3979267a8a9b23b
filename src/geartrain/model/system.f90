!> The dimensionless system of a train, holding only what the train has: a chain of elastic elements (flexible shafts and
!> meshes; rigid shafts merge inertias), displacement over characteristic length, time times characteristic frequency.
!>
!> Element n lies between inertias n and n+1: p_n = ra_n theta_n - rb_n theta_(n+1) + e_n, a shaft having ra = rb.
!> Each force is over k_n b_c: phi = kappa g(p) + gamma p' in a mesh. From I theta'' + B^T F = T and p = B theta + e:
!>    p'' = -W phi + s(t) + e''      (equations (5) with their signs and indices put right)
module geartrain_model_system
   use geartrain_base_interrupt, only: interrupt_type
   use geartrain_base_kinds, only: dp
   use geartrain_model_body, only: body_type
   use geartrain_model_mesh, only: mesh_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: system_type, build_system, put_excitation, series_type, series_value

   !> A periodic function as complex amplitudes: sum over h of Re(amplitude(h) exp(i h order Lambda t)).
   type :: series_type
      integer :: order = 1
      complex(dp), allocatable :: amplitude(:)
   end type series_type

   type :: system_type
      integer :: meshes = 0, elements = 0
      !> Element of each mesh (mesh); mesh of each element, 0 for a shaft (element).
      integer, allocatable :: mesh_element(:), element_mesh(:)
      !> Radii of the elements at their two inertias [m], mean stiffness along the line of action [N/m], (element).
      real(dp), allocatable :: left_radius(:), right_radius(:), stiffness(:)
      !> W(n, n-1), W(n, n), W(n, n+1) [1], (3, element).
      real(dp), allocatable :: coupling(:, :)
      !> gamma = c omega_c/k [1] and static force over k b_c [1], (element).
      real(dp), allocatable :: damping(:), load(:)
      !> b/b_c [1], (mesh).
      real(dp), allocatable :: backlash(:)
      !> kappa - 1 and e/b_c, (mesh); torque harmonics T/b_c [N m/m] on the first inertia.
      type(series_type), allocatable :: mesh_stiffness(:), transmission_error(:)
      type(series_type) :: torque
      !> Acceleration of element 1 per unit of torque%amplitude [1].
      real(dp) :: torque_gain = 0
      !> The free bodies between the meshes, (meshes + 1).
      type(body_type), allocatable :: bodies(:)
      !> Shaft element of each body, 0 where rigid, (meshes + 1).
      integer, allocatable :: body_element(:)
      !> omega_c [rad/s] and b_c [m].
      real(dp) :: characteristic_frequency = 0, characteristic_length = 0
      !> Greatest common divisor of the orders that excite the train: Lambda harmonics that are no multiple of it stay zero.
      integer :: excitation_order = 1
      !> The train's: all that takes long has a system at hand.
      type(interrupt_type) :: interrupt
   end type system_type

contains

   !> Makes the dimensionless system of a train that has passed `check_train`.
   pure subroutine build_system(train, system)
      type(train_type), intent(in) :: train
      type(system_type), intent(out) :: system
      integer :: j, n, m
      real(dp), allocatable :: inertia(:), damping(:)
      real(dp) :: wc, bc, force, equivalent

      m = size(train%meshes)
      wc = train%characteristic_frequency
      bc = train%characteristic_length
      system%meshes = m
      system%elements = m + count(.not. train%shafts%rigid)
      system%interrupt = train%interrupt
      system%characteristic_frequency = wc
      system%characteristic_length = bc
      allocate (system%bodies(m + 1), system%body_element(m + 1), system%mesh_element(m), inertia(system%elements + 1), &
                system%backlash(m))
      n = system%elements
      allocate (system%element_mesh(n), system%left_radius(n), system%right_radius(n), system%stiffness(n), damping(n), &
                system%coupling(3, n), system%load(n))

      n = 0
      do j = 1, m + 1
         call build_body(train, j, system%bodies(j))
         system%body_element(j) = 0
         if (.not. train%shafts(j)%rigid) then
            n = n + 1
            inertia(n) = system%bodies(j)%left_inertia
            system%body_element(j) = n
            system%element_mesh(n) = 0
            ! A shaft's twist is measured along the base circle of a gear on it: any radius does.
            if (j <= m) then
               system%left_radius(n) = train%meshes(j)%driving_radius
            else
               system%left_radius(n) = train%meshes(m)%driven_radius
            end if
            system%right_radius(n) = system%left_radius(n)
            system%stiffness(n) = system%bodies(j)%stiffness/system%left_radius(n)**2
            damping(n) = system%bodies(j)%damping/system%left_radius(n)**2
         end if
         inertia(n + 1) = system%bodies(j)%right_inertia
         if (j > m) exit
         n = n + 1
         associate (mesh => train%meshes(j))
            system%mesh_element(j) = n
            system%element_mesh(n) = j
            system%left_radius(n) = mesh%driving_radius
            system%right_radius(n) = mesh%driven_radius
            system%stiffness(n) = mesh%stiffness
            equivalent = 1/(mesh%driving_radius**2/mesh%driving_inertia + mesh%driven_radius**2/mesh%driven_inertia)
            damping(n) = 2*mesh%damping_ratio*sqrt(mesh%stiffness*equivalent)
            if (mesh%damping_given) damping(n) = mesh%damping
            system%backlash(j) = mesh%half_backlash/bc
         end associate
      end do

      associate (left => system%left_radius, right => system%right_radius, k => system%stiffness, w => system%coupling)
         force = train%input_torque/left(1)
         do n = 1, system%elements
            if (n > 1) force = force*right(n - 1)/left(n)
            system%load(n) = force/(k(n)*bc)
            w(:, n) = 0
            w(2, n) = (left(n)**2/inertia(n) + right(n)**2/inertia(n + 1))*k(n)/wc**2
            if (n > 1) w(1, n) = -left(n)*right(n - 1)/inertia(n)*k(n - 1)/wc**2
            if (n < system%elements) w(3, n) = -right(n)*left(n + 1)/inertia(n + 1)*k(n + 1)/wc**2
         end do
         system%damping = damping*wc/k
         system%torque_gain = left(1)/(inertia(1)*wc**2)
      end associate
      call put_excitation(train, system)
   end subroutine build_system

   !> What excites the train: torque, mesh stiffnesses and transmission errors as series, and the greatest common divisor of the
   !> harmonics of Lambda in them.
   pure subroutine put_excitation(train, system)
      type(train_type), intent(in) :: train
      type(system_type), intent(inout) :: system
      integer :: j

      system%meshes = size(train%meshes)
      allocate (system%mesh_stiffness(system%meshes), system%transmission_error(system%meshes))
      associate (bc => train%characteristic_length)
         system%torque = series(train%torque_cos, train%torque_sin, 1/bc, 1)
         do j = 1, system%meshes
            associate (mesh => train%meshes(j))
               system%mesh_stiffness(j) = series(mesh%stiffness_cos, mesh%stiffness_sin, 1.0_dp, mesh%order)
               system%transmission_error(j) = series(mesh%error_cos, mesh%error_sin, 1/bc, mesh%order)
            end associate
         end do
      end associate
      system%excitation_order = common_order(system)
   end subroutine put_excitation

   !> The body of shaft j: its gears' inertias, or those of the machines at the ends.
   pure subroutine build_body(train, j, body)
      type(train_type), intent(in) :: train
      integer, intent(in) :: j
      type(body_type), intent(out) :: body

      associate (shaft => train%shafts(j), m => size(train%meshes))
         body%left_inertia = train%prime_mover_inertia
         if (j > 1) body%left_inertia = train%meshes(j - 1)%driven_inertia
         body%right_inertia = train%load_inertia
         if (j <= m) body%right_inertia = train%meshes(j)%driving_inertia
         body%rigid = shaft%rigid
         if (shaft%rigid) then
            body%left_inertia = body%left_inertia + body%right_inertia
            body%right_inertia = body%left_inertia
            return
         end if
         body%stiffness = shaft%stiffness
         body%damping = 2*shaft%damping_ratio*sqrt(shaft%stiffness/(1/body%left_inertia + 1/body%right_inertia))
         if (shaft%damping_given) body%damping = shaft%damping
      end associate
   end subroutine build_body

   !> Series of cos and sin amplitudes, either of which may be absent or shorter; trailing zeros are dropped.
   pure function series(cosine, sine, factor, order)
      real(dp), allocatable, intent(in) :: cosine(:), sine(:)
      real(dp), intent(in) :: factor
      integer, intent(in) :: order
      type(series_type) :: series
      complex(dp), allocatable :: amplitude(:)
      integer :: length, h

      length = 0
      if (allocated(cosine)) length = size(cosine)
      if (allocated(sine)) length = max(length, size(sine))
      allocate (amplitude(length), source=(0.0_dp, 0.0_dp))
      if (allocated(cosine)) amplitude(:size(cosine)) = amplitude(:size(cosine)) + cosine
      if (allocated(sine)) amplitude(:size(sine)) = amplitude(:size(sine)) - (0, 1)*sine
      do h = length, 1, -1
         if (abs(amplitude(h)) > 0) exit
      end do
      series%order = order
      series%amplitude = factor*amplitude(:h)
   end function series

   !> Value of a series at the phase Lambda t [rad].
   pure real(dp) function series_value(series, phase)
      type(series_type), intent(in) :: series
      real(dp), intent(in) :: phase
      integer :: h

      series_value = 0
      do h = 1, size(series%amplitude)
         series_value = series_value + real(series%amplitude(h)*exp(cmplx(0, h*series%order*phase, dp)), dp)
      end do
   end function series_value

   pure integer function common_order(system)
      type(system_type), intent(in) :: system
      integer :: j

      common_order = 0
      call add(system%torque)
      do j = 1, system%meshes
         call add(system%mesh_stiffness(j))
         call add(system%transmission_error(j))
      end do
      if (common_order == 0) common_order = 1

   contains

      pure subroutine add(series)
         type(series_type), intent(in) :: series
         integer :: h

         do h = 1, size(series%amplitude)
            if (abs(series%amplitude(h)) > 0) common_order = greatest_common_divisor(common_order, h*series%order)
         end do
      end subroutine add

   end function common_order

   pure integer function greatest_common_divisor(a, b) result(divisor)
      integer, intent(in) :: a, b
      integer :: x, y, rest

      x = a
      y = b
      do while (y /= 0)
         rest = mod(x, y)
         x = y
         y = rest
      end do
      divisor = x
   end function greatest_common_divisor

end module geartrain_model_system
