!> Another code of the same equations, to check against: the rotations of all bodies as they are, I theta'' = T - B^T F, by
!> extrapolated midpoint steps that end where a contact changes. It knows the train as it is given, none of the library's systems.
module independent
   use geartrain, only: dp, train_type
   implicit none (type, external)
   private
   public :: machine_type, accelerate, build_machine, contacts, displacements, fly, joint_forces

   type :: joint_type
      integer :: a = 0, b = 0
      real(dp) :: ra = 1, rb = 1, stiffness = 0, damping = 0, gap = 0
      !> Damping while the teeth are apart; of the back flanks: stiffness and phase.
      real(dp) :: damping_apart = 0, back_stiffness = 0, back_phase = 0
      !> Harmonics of kappa and of the transmission error: a(k) cos + b(k) sin of k times the order.
      real(dp), allocatable :: kappa(:, :), error(:, :)
      integer :: order = 1
      logical :: mesh = .false.
   end type joint_type

   type :: machine_type
      real(dp), allocatable :: inertia(:), torque(:), fluctuation(:), drag(:)
      type(joint_type), allocatable :: joint(:)
      !> Fundamental mesh frequency at time 0 and its rate of change [rad/s, rad/s^2]; a step.
      real(dp) :: omega = 0, acceleration = 0, step = 0
      !> Turns of each body per cycle of the fundamental: the angles are absolute; 0: the speed is not known.
      real(dp), allocatable :: turns(:)
   end type machine_type

   !> Substeps of the midpoint rule that are extrapolated.
   integer, parameter :: substeps(*) = [2, 4, 6, 8, 10, 12, 14]

contains

   !> Bodies of a train without rigid shafts, of any shape.
   subroutine build_machine(train, frequency_ratio, machine)
      type(train_type), intent(in) :: train
      !> Lambda.
      real(dp), intent(in) :: frequency_ratio
      type(machine_type), intent(out) :: machine
      real(dp) :: fastest
      integer :: i, n, balancing

      n = size(train%bodies)
      machine%inertia = train%bodies%inertia
      machine%torque = train%bodies%torque
      machine%drag = train%bodies%damping_to_ground
      allocate (machine%fluctuation(n), machine%turns(n), source=0.0_dp)
      do i = 1, n
         if (allocated(train%bodies(i)%torque_cos)) machine%fluctuation(i) = train%bodies(i)%torque_cos(1)
      end do
      machine%omega = frequency_ratio*train%characteristic_frequency
      allocate (machine%joint(size(train%shafts) + size(train%meshes)))
      do i = 1, size(train%shafts)
         associate (joint => machine%joint(i), shaft => train%shafts(i))
            joint%a = number(train, shaft%between(1))
            joint%b = number(train, shaft%between(2))
            joint%stiffness = shaft%stiffness
            joint%damping = 2*shaft%damping_ratio &
                            *sqrt(shaft%stiffness/(1/machine%inertia(joint%a) + 1/machine%inertia(joint%b)))
            joint%damping_apart = joint%damping
            joint%back_stiffness = joint%stiffness
            allocate (joint%kappa(2, 0), joint%error(2, 0))
         end associate
      end do
      do i = 1, size(train%meshes)
         associate (joint => machine%joint(size(train%shafts) + i), mesh => train%meshes(i))
            joint%mesh = .true.
            joint%a = number(train, mesh%between(1))
            joint%b = number(train, mesh%between(2))
            joint%ra = mesh%driving_radius
            joint%rb = mesh%driven_radius
            joint%stiffness = mesh%stiffness
            joint%damping = 2*mesh%damping_ratio*sqrt(mesh%stiffness/(joint%ra**2/machine%inertia(joint%a) &
                                                                      + joint%rb**2/machine%inertia(joint%b)))
            joint%gap = mesh%half_backlash
            joint%damping_apart = merge(joint%damping, 0.0_dp, mesh%damping_acts == 'always')
            joint%back_stiffness = merge(mesh%back_stiffness, mesh%stiffness, mesh%back_stiffness > 0)
            joint%back_phase = mesh%back_phase
            joint%order = max(1, mesh%order)
            joint%kappa = both(mesh%stiffness_cos, mesh%stiffness_sin)
            joint%error = both(mesh%error_cos, mesh%error_sin)
         end associate
      end do
      balancing = findloc(train%bodies%balances, .true., 1)
      machine%torque(balancing) = -balance_of(machine, balancing)
      fastest = 0
      do i = 1, size(machine%joint)
         associate (joint => machine%joint(i))
            fastest = max(fastest, max(joint%stiffness, joint%back_stiffness)*(joint%ra**2/machine%inertia(joint%a) &
                                                                               + joint%rb**2/machine%inertia(joint%b)))
         end associate
      end do
      machine%step = 1/sqrt(2*fastest)
   end subroutine build_machine

   !> A ramp of bodies whose turns are known: the balancing body gives what accelerates them all, by the power at the mean speeds.
   subroutine accelerate(train, turns, acceleration, machine, y)
      type(train_type), intent(in) :: train
      !> Turns per cycle of the fundamental, (body); rate of its frequency [rad/s^2].
      real(dp), intent(in) :: turns(:), acceleration
      type(machine_type), intent(inout) :: machine
      !> Vibration at time 0; gets the mean speeds.
      real(dp), intent(inout) :: y(:)

      machine%acceleration = acceleration
      machine%turns = turns
      associate (b => findloc(train%bodies%balances, .true., 1), n => size(turns))
         machine%torque(b) = machine%torque(b) + acceleration*sum(machine%inertia*turns**2)/turns(b)
         y(n + 1:) = y(n + 1:) + turns*machine%omega
      end associate
   end subroutine accelerate

   integer function number(train, name)
      type(train_type), intent(in) :: train
      character(*), intent(in) :: name

      do number = 1, size(train%bodies)
         if (train%bodies(number)%name == name) return
      end do
      error stop 'a name of no body'
   end function number

   pure function both(cosine, sine) result(series)
      real(dp), allocatable, intent(in) :: cosine(:), sine(:)
      real(dp), allocatable :: series(:, :)
      integer :: n

      n = 0
      if (allocated(cosine)) n = size(cosine)
      if (allocated(sine)) n = max(n, size(sine))
      allocate (series(2, n), source=0.0_dp)
      if (allocated(cosine)) series(1, :size(cosine)) = cosine
      if (allocated(sine)) series(2, :size(sine)) = sine
   end function both

   !> What the other torques do on the body, by the ratios: each body turns radius(body)/radius(other) times as fast.
   pure real(dp) function balance_of(machine, body)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: body
      real(dp) :: speed(size(machine%inertia))
      integer :: i, k

      speed = 0
      speed(body) = 1
      do k = 1, size(speed)
         do i = 1, size(machine%joint)
            associate (joint => machine%joint(i))
               if (abs(speed(joint%a)) > 0) then
                  speed(joint%b) = speed(joint%a)*joint%ra/joint%rb
               else if (abs(speed(joint%b)) > 0) then
                  speed(joint%a) = speed(joint%b)*joint%rb/joint%ra
               end if
            end associate
         end do
      end do
      balance_of = sum(speed*machine%torque) - machine%torque(body)
   end function balance_of

   !> Displacement and velocity of each joint [m, m/s] at the state y (angles, speeds) and the time t [s].
   pure subroutine displacements(machine, t, y, p, v)
      type(machine_type), intent(in) :: machine
      real(dp), intent(in) :: t, y(:)
      real(dp), intent(out) :: p(:), v(:)
      real(dp) :: phase, rate
      integer :: i, k, n

      n = size(machine%inertia)
      do i = 1, size(machine%joint)
         associate (joint => machine%joint(i))
            p(i) = joint%ra*y(joint%a) - joint%rb*y(joint%b)
            v(i) = joint%ra*y(n + joint%a) - joint%rb*y(n + joint%b)
            do k = 1, size(joint%error, 2)
               phase = k*joint%order*phase_of(machine, t)
               rate = k*joint%order*(machine%omega + machine%acceleration*t)
               p(i) = p(i) + joint%error(1, k)*cos(phase) + joint%error(2, k)*sin(phase)
               v(i) = v(i) + rate*(joint%error(2, k)*cos(phase) - joint%error(1, k)*sin(phase))
            end do
         end associate
      end do
   end subroutine displacements

   !> Phase of the fundamental mesh cycle [rad].
   pure real(dp) function phase_of(machine, t)
      type(machine_type), intent(in) :: machine
      real(dp), intent(in) :: t

      phase_of = machine%omega*t + machine%acceleration*t**2/2
   end function phase_of

   !> Derivative of the state with given contacts.
   pure function slope_of(machine, contact, t, y) result(slope)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: contact(:)
      real(dp), intent(in) :: t, y(:)
      real(dp) :: slope(size(y)), force(size(contact))
      integer :: i, n

      n = size(machine%inertia)
      force = joint_forces(machine, contact, t, y)
      slope(:n) = y(n + 1:)
      slope(n + 1:) = machine%torque + machine%fluctuation*cos(phase_of(machine, t)) &
                      - machine%drag*(y(n + 1:) - machine%turns*(machine%omega + machine%acceleration*t))
      do i = 1, size(contact)
         associate (joint => machine%joint(i))
            slope(n + joint%a) = slope(n + joint%a) - joint%ra*force(i)
            slope(n + joint%b) = slope(n + joint%b) + joint%rb*force(i)
         end associate
      end do
      slope(n + 1:) = slope(n + 1:)/machine%inertia
   end function slope_of

   !> Force of each mesh [N], torque of each shaft [N m].
   pure function joint_forces(machine, contact, t, y) result(force)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: contact(:)
      real(dp), intent(in) :: t, y(:)
      real(dp) :: force(size(contact)), p(size(contact)), v(size(contact)), kappa, phase
      integer :: i, k

      call displacements(machine, t, y, p, v)
      do i = 1, size(contact)
         associate (joint => machine%joint(i))
            kappa = 1
            phase = joint%order*phase_of(machine, t)
            if (contact(i) < 0) phase = phase - joint%back_phase
            do k = 1, size(joint%kappa, 2)
               kappa = kappa + joint%kappa(1, k)*cos(k*phase) + joint%kappa(2, k)*sin(k*phase)
            end do
            select case (contact(i))
            case (1)
               force(i) = joint%stiffness*kappa*(p(i) - joint%gap) + joint%damping*v(i)
            case (0)
               force(i) = joint%damping_apart*v(i)
            case (-1)
               force(i) = joint%back_stiffness*kappa*(p(i) + joint%gap) + joint%damping*v(i)
            end select
         end associate
      end do
   end function joint_forces

   !> One extrapolated step.
   pure function stepped(machine, contact, t, h, y) result(end_)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: contact(:)
      real(dp), intent(in) :: t, h, y(:)
      real(dp) :: end_(size(y)), table(size(y), size(substeps)), before(size(y)), now(size(y)), next(size(y)), small
      integer :: i, k, m

      do i = 1, size(substeps)
         small = h/substeps(i)
         before = y
         now = y + small*slope_of(machine, contact, t, y)
         do m = 1, substeps(i) - 1
            next = before + 2*small*slope_of(machine, contact, t + m*small, now)
            before = now
            now = next
         end do
         table(:, i) = 0.5_dp*(now + before + small*slope_of(machine, contact, t + h, now))
         do k = i - 1, 1, -1
            table(:, k) = table(:, k + 1) + (table(:, k + 1) - table(:, k))/((real(substeps(i), dp)/substeps(k))**2 - 1)
         end do
      end do
      end_ = table(:, 1)
   end function stepped

   pure function contacts(machine, p) result(contact)
      type(machine_type), intent(in) :: machine
      real(dp), intent(in) :: p(:)
      integer :: contact(size(p)), i

      do i = 1, size(p)
         contact(i) = 1
         if (machine%joint(i)%gap > 0 .and. p(i) <= machine%joint(i)%gap) contact(i) = merge(-1, 0, p(i) < -machine%joint(i)%gap)
      end do
   end function contacts

   !> From time `from` to `to` [s].
   subroutine fly(machine, from, to, y)
      type(machine_type), intent(in) :: machine
      real(dp), intent(in) :: from, to
      real(dp), intent(inout) :: y(:)
      real(dp), dimension(size(machine%joint)) :: p, v, past, begun
      integer, dimension(size(p)) :: contact, next
      real(dp) :: t, h, end_(size(y))
      integer :: i, latest, met, to_contact

      t = from
      call displacements(machine, t, y, p, v)
      contact = contacts(machine, p)
      latest = 0
      do while (to - t > 1e-14_dp*abs(to - from))
         h = min(machine%step, to - t)
         begun = v
         end_ = stepped(machine, contact, t, h, y)
         call displacements(machine, t + h, end_, past, v)
         ! A contact may begin and end within the step, where a displacement turns: the step ends there.
         do i = 1, size(p)
            if (.not. begun(i)*v(i) < 0) cycle
            if (abs(abs(past(i)) - machine%joint(i)%gap) > h*max(abs(begun(i)), abs(v(i)))) cycle
            next = contacts(machine, past)
            if (next(i) /= contact(i)) cycle
            call turn(machine, contact, t, y, i, begun(i), v(i), h, next)
            if (next(i) == contact(i)) cycle
            end_ = stepped(machine, contact, t, h, y)
            call displacements(machine, t + h, end_, past, v)
         end do
         met = 0
         do i = 1, size(p)
            next = contacts(machine, past)
            if (next(i) == contact(i)) cycle
            met = i
            to_contact = merge(next(i), 0, contact(i) == 0)
            call shorten(machine, contact, t, y, i, machine%joint(i)%gap*merge(next(i), contact(i), contact(i) == 0), &
                         i == latest, h)
            end_ = stepped(machine, contact, t, h, y)
            call displacements(machine, t + h, end_, past, v)
         end do
         if (met > 0) contact(met) = to_contact
         latest = met
         t = t + h
         y = end_
         p = past
      end do
   end subroutine fly

   !> Looks where joint i turns within the step; where it is beyond a wall there the step h ends there.
   subroutine turn(machine, contact, t, y, i, before, after, h, there)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: contact(:), i
      !> Time, state and velocity of the joint at the beginning of the step; its velocity at the end.
      real(dp), intent(in) :: t, y(:), before, after
      real(dp), intent(inout) :: h
      !> Contacts where it turns.
      integer, intent(out) :: there(:)
      real(dp) :: p(size(contact)), v(size(contact)), left, right, middle
      integer :: k

      left = 0
      right = h
      middle = h*before/(before - after)
      do k = 1, 12
         call displacements(machine, t + middle, stepped(machine, contact, t, middle, y), p, v)
         there = contacts(machine, p)
         if (there(i) /= contact(i)) then
            h = middle
            return
         end if
         if (v(i)*before > 0) then
            left = middle
         else
            right = middle
         end if
         middle = (left + right)/2
      end do
   end subroutine turn

   !> Ends the step h where joint i meets a wall [m]: regula falsi, the kept end halved.
   subroutine shorten(machine, contact, t, y, i, wall, just_left, h)
      type(machine_type), intent(in) :: machine
      integer, intent(in) :: contact(:), i
      real(dp), intent(in) :: t, y(:), wall
      !> It has just left this wall or the other: the beginning of the step is no end of the bracket.
      logical, intent(in) :: just_left
      real(dp), intent(inout) :: h
      real(dp) :: left, right, middle, f_left, f_right, f
      integer :: k, kept

      left = merge(1e-6_dp*h, 0.0_dp, just_left)
      right = h
      f_left = beyond(left)
      f_right = beyond(right)
      if (.not. f_left*f_right < 0) then
         ! At once; where it rests at the wall but for rounding the step need not end.
         if (abs(f_right) > 1e-12_dp*machine%joint(i)%gap) h = left
         return
      end if
      kept = 0
      do k = 1, 100
         middle = (left*f_right - right*f_left)/(f_right - f_left)
         f = beyond(middle)
         if (f*f_left > 0) then
            left = middle
            f_left = f
            if (kept == 1) f_right = f_right/2
            kept = 1
         else
            right = middle
            f_right = f
            if (kept == -1) f_left = f_left/2
            kept = -1
         end if
         if (abs(f) < 1e-15_dp*machine%joint(i)%gap .or. right - left < 1e-16_dp*machine%step) exit
      end do
      h = middle

   contains

      real(dp) function beyond(h)
         real(dp), intent(in) :: h
         real(dp) :: p(size(contact)), v(size(contact))

         call displacements(machine, t + h, stepped(machine, contact, t, h, y), p, v)
         beyond = p(i) - wall
      end function beyond

   end subroutine shorten

end module independent
