!> Forces of the unknown meshes at the harmonics of a balance, over k b_c, and their derivatives by the coefficients of p:
!>    phi = Toeplitz(w) p - sigma + d/dt (Toeplitz(d) p + j)
!> with the spectra of the contact of each mesh: stiffness w, offset sigma, damping d and impulse j (geartrain_mesh_law_spectra).
module geartrain_balance_mesh_forces
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_balance_products, only: add_coefficients, find_wave, sparse_product, toeplitz, wave_product
   use geartrain_balance_winding, only: winding_type
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, transform_length
   use geartrain_mesh_law_law, only: law_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: mesh_forces_type

   !> With at most `most_direct` harmonics d phi/du is a matrix. With more only its block of the lowest `explicit_of_many`
   !> harmonics is, and the whole derivative is applied by FFT.
   integer, parameter :: most_direct = 16, explicit_of_many = 10
   !> Likewise where harmonics are carried by their amplitudes: the lowest of a sparse set reach no farther than the highest natural
   !> frequency, below which harmonics are coupled strongly.
   integer, parameter :: most_direct_chosen = 160, explicit_of_many_chosen = 80
   !> Likewise where teeth begin to part in a long period: its samples, or its steps in time, cost more than elimination.
   integer, parameter :: most_direct_parting = 600

   !> Most rows of a matrix that are eliminated where teeth part on a winding.
   integer, parameter :: most_wound_rows = 2000
   !> Unknown meshes and rows of a matrix from which on it is large.
   integer, parameter :: least_dense = 4, least_dense_rows = 600
   !> Most elements of the linearised train in time: a step costs the square of their number, and flow_steps.c has room for so many.
   integer, parameter :: most_flow_elements = 24

   !> The contacts are those at the last `find_forces`.
   type, extends(motion_contacts_type) :: mesh_forces_type
      !> Carried harmonics of Lambda/eta, ascending; coefficients of a mesh, 1 + 2*size(harmonic).
      integer, allocatable :: harmonic(:)
      integer :: block = 1
      !> Winding on which the contacts and their spectra are found, without cycles: the period. Place of each carried harmonic.
      type(winding_type) :: winding
      integer, allocatable :: place(:)
      !> Highest harmonic asked for; carried are all of 1..highest where eta > 1, else those that the excitation reaches, or a set
      !> that the caller chose.
      integer :: highest = 0
      logical :: chosen = .false.
      !> Equal branches move equally on the branch that is followed: one of them is eliminated for all. Set by the caller.
      logical :: equal = .false.
      !> Unknowns that move by themselves, for all of which elimination has rows; 0: all of them.
      integer :: independent = 0
      !> Samples a period by which the coefficients are found; 0: the coefficients are exact.
      integer :: samples = 0
      !> phi [1], (block, unknown), and d phi/du [1], (1 + 2*explicit, 1 + 2*explicit, unknown), of the mean and the lowest
      !> `explicit` carried harmonics.
      real(dp), allocatable :: force(:, :), tangent(:, :, :)
      integer :: explicit = 0
      !> Least number of explicit harmonics, whatever the frequency.
      integer :: least_explicit = 0
      !> The force of each harmonic depends on that harmonic alone, (unknown): the element keeps to a region of its law in which
      !> its stiffness is constant.
      logical, allocatable :: uncoupled(:)
      !> d phi/dLambda at constant coefficients [1], (block, unknown).
      real(dp), allocatable :: force_rate(:, :)
      !> Lambda [1] at the last `find_forces`.
      real(dp) :: frequency_ratio = 0
      !> Plan of the waveforms of the meshes; where not all harmonics are explicit also the plan of products, and stiffness in
      !> contact [1], (sample, unknown), with damping [1] where it changes with the contact.
      type(transform_type), private :: fine, products
      real(dp), allocatable, private :: wave(:, :), damping_wave(:, :)
   contains
      procedure :: setup
      procedure :: find_forces
      procedure :: is_direct
      procedure :: is_wound
      procedure :: keeps_distance
      procedure :: suits_flow
      procedure :: parts
      procedure :: make_explicit
      procedure :: adjust_explicit
      procedure :: tangent_product
      procedure :: damping_of
      procedure :: mean_stiffness
      procedure, private :: find_force
      procedure, private :: sparse
      procedure, private :: stays
      procedure, private :: constant_stiffness
      procedure, private :: damp_tangent
      procedure, private :: rate_of
   end type mesh_forces_type

contains

   !> Chooses the carried harmonics and prepares work space and plans for `find_forces`.
   subroutine setup(self, system, highest, eta, samples, chosen, repeats, winding)
      class(mesh_forces_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      !> Highest harmonic of Lambda/eta to carry; sub-harmonic index; samples a period by which coefficients are found, 0: exact.
      integer, intent(in) :: highest, eta, samples
      !> Harmonics to carry, ascending, up to `highest`; absent: those that the excitation reaches.
      integer, intent(in), optional :: chosen(:)
      !> How often the motions go through their waveform within the period, a divisor of the excitation's: multiples of it are
      !> carried; absent: as often as the excitation where eta is 1, else once.
      integer, intent(in), optional :: repeats
      !> Winding in which all harmonics to carry have places; absent: none.
      type(winding_type), intent(in), optional :: winding
      type(law_type) :: law
      integer :: i, r

      self%system => system
      self%eta = eta
      self%highest = highest
      self%samples = samples
      self%repeats = merge(system%excitation_order, 1, eta == 1)
      if (present(repeats)) self%repeats = repeats
      self%harmonic = [(r, r=self%repeats, highest, self%repeats)]
      self%chosen = present(chosen)
      if (present(chosen)) then
         self%harmonic = chosen
      else if (eta == 1 .and. self%repeats == system%excitation_order) then
         self%harmonic = needed_harmonics(system, highest)
      end if
      self%block = 1 + 2*size(self%harmonic)
      self%winding%cycles = 0
      if (present(winding)) self%winding = winding
      self%place = self%winding%place_of(self%harmonic)
      self%mesh = system%cut%mesh
      self%unknowns = size(self%mesh)
      if (.not. allocated(self%contact)) allocate (self%contact(self%unknowns), self%uncoupled(self%unknowns))
      do i = 1, self%unknowns
         law = system%law(self%mesh(i))
         call self%winding%wind(law)
         call self%contact(i)%setup(law, eta, self%place, 2*max(self%winding%place_of(highest), maxval([0, self%place])), samples)
      end do
      call self%fine%plan(fine_samples(maxval([1, self%place])))
      if (allocated(self%force)) deallocate (self%force, self%force_rate, self%wave, self%damping_wave, self%tangent)
      allocate (self%force(self%block, self%unknowns), self%force_rate(self%block, self%unknowns))
      self%explicit = size(self%harmonic)
      if (self%chosen) then
         if (self%explicit > most_direct_chosen) self%explicit = explicit_of_many_chosen
      else
         if (self%explicit > most_direct) self%explicit = explicit_of_many
      end if
      self%least_explicit = self%explicit
      ! No alias of a product with spectra up to twice the highest harmonic reaches a carried harmonic.
      if (self%is_wound() .or. .not. self%is_direct()) call self%products%plan(transform_length(4*maxval(self%place) + 1))
      allocate (self%wave(merge(self%products%samples, 0, self%is_wound() .or. .not. self%is_direct()), self%unknowns))
      allocate (self%damping_wave(merge(size(self%wave, 1), 0, any(system%law(self%mesh)%jumps)), self%unknowns))
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
   end subroutine setup

   !> Forces and derivatives of all unknown meshes.
   subroutine find_forces(self, u, frequency_ratio)
      class(mesh_forces_type), intent(inout) :: self
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown): mean, cos, sin, ...; Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      integer :: i
      logical :: was_direct

      self%frequency_ratio = frequency_ratio
      was_direct = self%is_direct()
      do i = 1, self%unknowns
         call self%find_force(i, u(:, i))
      end do
      if (.not. (self%chosen .and. self%has_long_period())) return
      i = min(size(self%harmonic), explicit_of_many_chosen)
      if (self%is_wound()) then
         ! The products of a winding cost less than elimination of many rows.
         associate (rows => merge(self%independent, self%unknowns, self%independent > 0)*self%block)
            if (size(self%harmonic) <= most_direct_chosen .and. (rows <= most_wound_rows .or. .not. self%parts())) &
               i = size(self%harmonic)
         end associate
      else
         if (size(self%harmonic) <= most_direct_chosen) return
         if (self%parts() .and. size(self%harmonic) <= most_direct_parting) i = size(self%harmonic)
      end if
      if (i > self%explicit .or. self%is_direct() .and. i < self%explicit) call self%make_explicit(i)
      if (self%is_direct() .or. .not. was_direct) return
      ! Products by waves need the waves.
      do i = 1, self%unknowns
         call self%find_force(i, u(:, i))
      end do
   end subroutine find_forces

   !> Mean damping over stiffness [1] of an unknown mesh at the last `find_forces`.
   pure real(dp) function damping_of(self, i)
      class(mesh_forces_type), intent(in) :: self
      !> Number of the unknown mesh.
      integer, intent(in) :: i

      damping_of = self%contact(i)%spectra%mean_damping(self%contact(i)%law)
   end function damping_of

   !> Mean dynamic stiffness of an unknown mesh over its stiffness [1] at the last `find_forces`: mean stiffness in contact plus i
   !> times mean damping times the frequency of a harmonic.
   pure complex(dp) function mean_stiffness(self, i, harmonic)
      class(mesh_forces_type), intent(in) :: self
      !> Number of the unknown mesh; harmonic of Lambda/eta.
      integer, intent(in) :: i, harmonic

      mean_stiffness = cmplx(real(self%contact(i)%spectra%stiffness(0), dp), &
                             self%damping_of(i)*harmonic*self%frequency_ratio/self%eta, dp)
   end function mean_stiffness

   !> Whether `tangent` holds the derivatives at all carried harmonics.
   pure logical function is_direct(self)
      class(mesh_forces_type), intent(in) :: self

      is_direct = self%explicit == size(self%harmonic)
   end function is_direct

   !> Whether the contacts are found on a winding.
   pure logical function is_wound(self)
      class(mesh_forces_type), intent(in) :: self

      is_wound = self%winding%cycles > 0
   end function is_wound

   !> Whether all meshes kept away from their walls at the last `find_forces`, by their amplitudes: no winding matters then.
   pure logical function keeps_distance(self)
      class(mesh_forces_type), intent(in) :: self

      keeps_distance = all(self%contact(:self%unknowns)%keeps_distance())
   end function keeps_distance

   !> Whether the linearised train in time (linear_flow.f90) replaces elimination as preconditioner: for chosen sets of harmonics,
   !> and where elimination would factor one large matrix because each mesh is coupled with each.
   pure logical function suits_flow(self)
      class(mesh_forces_type), intent(in) :: self

      suits_flow = self%chosen
      if (.not. (self%chosen .or. self%equal)) suits_flow = self%system%cut%graph%entries == self%unknowns**2 &
         .and. self%unknowns >= least_dense .and. self%unknowns*self%block > least_dense_rows
      suits_flow = suits_flow .and. .not. self%is_direct() .and. suits(self%system)
   end function suits_flow

   !> Whether the linearised train in time is written for a train: no damping to ground, no damping that changes with the contact,
   !> few elements.
   pure logical function suits(system)
      type(system_type), intent(in) :: system

      suits = system%elements <= most_flow_elements .and. system%displacements == system%coordinates .and. &
              .not. any(system%law%jumps)
   end function suits

   !> Whether a mesh leaves a region of its law at the last `find_forces`.
   pure logical function parts(self)
      class(mesh_forces_type), intent(in) :: self

      parts = any(self%contact(:self%unknowns)%events > 0)
   end function parts

   !> Stiffness of an uncoupled unknown mesh over its stiffness on the drive flank [1].
   pure real(dp) function constant_stiffness(self, i)
      class(mesh_forces_type), intent(in) :: self
      integer, intent(in) :: i

      constant_stiffness = real(self%contact(i)%spectra%stiffness(0), dp)
   end function constant_stiffness

   !> Whether unknown mesh i keeps to a region of its law: its stiffness has but the harmonics of kappa.
   pure logical function stays(self, i)
      class(mesh_forces_type), intent(in) :: self
      integer, intent(in) :: i

      stays = self%has_long_period() .and. self%samples == 0 .and. self%contact(i)%events == 0 &
              .and. .not. self%contact(i)%law%jumps
   end function stays

   !> Makes `tangent` hold the derivatives at this many harmonics or more, now and after each `find_forces`.
   subroutine make_explicit(self, harmonics)
      class(mesh_forces_type), intent(inout) :: self
      !> Number of explicit harmonics, the lowest carried ones; all where fewer are carried.
      integer, intent(in) :: harmonics
      integer :: i

      self%least_explicit = min(harmonics, size(self%harmonic))
      call self%adjust_explicit(self%least_explicit)
      do i = 1, self%unknowns
         call toeplitz(self%place(:self%explicit), self%contact(i)%spectra%stiffness, self%tangent(:, :, i))
         call self%damp_tangent(i)
      end do
   end subroutine make_explicit

   !> Makes room in `tangent` for the derivatives at so many harmonics, for the next `find_forces`.
   subroutine adjust_explicit(self, harmonics)
      class(mesh_forces_type), intent(inout) :: self
      !> Number of explicit harmonics, the lowest carried ones, no fewer than `make_explicit` asked for.
      integer, intent(in) :: harmonics

      if (harmonics == self%explicit) return
      self%explicit = harmonics
      deallocate (self%tangent)
      allocate (self%tangent(1 + 2*self%explicit, 1 + 2*self%explicit, self%unknowns))
   end subroutine adjust_explicit

   !> phi of unknown mesh i by the spectra of its contact, and its derivatives (geartrain_mesh_law_spectra).
   subroutine find_force(self, i, u)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: u(:)
      integer :: k

      call self%contact(i)%update(u, self%fine)
      associate (contact => self%contact(i))
         self%uncoupled(i) = self%samples == 0 .and. contact%events == 0 .and. .not. contact%law%varies(contact%first_contact)
      end associate
      if (self%uncoupled(i)) then
         self%tangent(:, :, i) = 0
         do k = 1, size(self%tangent, 1)
            self%tangent(k, k, i) = self%constant_stiffness(i)
         end do
      else
         call toeplitz(self%place(:self%explicit), self%contact(i)%spectra%stiffness, self%tangent(:, :, i))
      end if
      associate (f => self%force(:, i), spectra => self%contact(i)%spectra)
         if (self%uncoupled(i)) then
            f = self%constant_stiffness(i)*u
         else if (self%is_direct()) then
            f = 0
            do k = 1, self%block
               f = f + u(k)*self%tangent(:, k, i)
            end do
         else if (self%stays(i)) then
            call self%sparse(i, u, f)
         else
            call find_wave(self%place, spectra%stiffness, self%products, self%wave(:, i))
            if (self%contact(i)%law%jumps) &
               call find_wave(self%place, spectra%damping, self%products, self%damping_wave(:, i))
            call wave_product(self%place, self%wave(:, i), u, self%products, f)
         end if
         call add_coefficients(self%place, -1.0_dp, spectra%offset, f)
      end associate
      call self%damp_tangent(i)
      call self%rate_of(i, u, self%force_rate(:, i))
      self%force(:, i) = self%force(:, i) + self%frequency_ratio*self%force_rate(:, i)
   end subroutine find_force

   !> Product of the stiffness of unknown mesh i, which `stays`, with coefficients x.
   subroutine sparse(self, i, x, f)
      class(mesh_forces_type), intent(in) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: x(:)
      real(dp), intent(out) :: f(:)
      complex(dp), allocatable :: value(:)
      integer, allocatable :: harmonic(:)

      associate (law => self%contact(i)%law, stiffness => self%contact(i)%spectra%stiffness)
         value = stiffness(pack(self%eta*law%harmonic, self%eta*law%harmonic <= ubound(stiffness, 1)))
         harmonic = pack(self%eta*law%harmonic, self%eta*law%harmonic <= ubound(stiffness, 1))
         call sparse_product(self%harmonic, self%winding%harmonic_at(harmonic), stiffness(0)%re, value, x, f)
      end associate
   end subroutine sparse

   !> Derivative of damping p + impulse with respect to time per Lambda, of unknown mesh i at the coefficients x; `linear`: of what
   !> a change x adds.
   subroutine rate_of(self, i, x, rate, linear)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), intent(in) :: x(:)
      real(dp), intent(out) :: rate(:)
      logical, intent(in), optional :: linear
      real(dp) :: gamma
      real(dp), allocatable :: integral(:), matrix(:, :)
      integer :: k

      rate(1) = 0
      if (self%contact(i)%law%jumps .and. .not. self%uncoupled(i)) then
         associate (spectra => self%contact(i)%spectra)
            allocate (integral(self%block))
            if (self%is_direct()) then
               allocate (matrix(self%block, self%block))
               call toeplitz(self%place, spectra%damping, matrix)
               integral = matmul(matrix, x)
            else
               call wave_product(self%place, self%damping_wave(:, i), x, self%products, integral)
            end if
            if (.not. present(linear)) call add_coefficients(self%place, 1.0_dp, spectra%impulse, integral)
         end associate
         do k = 1, size(self%harmonic)
            gamma = real(self%harmonic(k), dp)/self%eta
            rate(2*k) = gamma*integral(2*k + 1)
            rate(2*k + 1) = -gamma*integral(2*k)
         end do
      else
         gamma = self%damping_of(i)/self%eta
         do k = 1, size(self%harmonic)
            rate(2*k) = gamma*self%harmonic(k)*x(2*k + 1)
            rate(2*k + 1) = -gamma*self%harmonic(k)*x(2*k)
         end do
      end if
   end subroutine rate_of

   !> Adds what damping does to the tangent of unknown mesh i: gamma dp'/du.
   subroutine damp_tangent(self, i)
      class(mesh_forces_type), intent(inout) :: self
      integer, intent(in) :: i
      real(dp), allocatable :: matrix(:, :)
      real(dp) :: rate, gamma
      logical :: jumps
      integer :: k

      gamma = self%damping_of(i)
      jumps = self%contact(i)%law%jumps .and. .not. self%uncoupled(i)
      if (jumps) then
         allocate (matrix(1 + 2*self%explicit, 1 + 2*self%explicit))
         call toeplitz(self%place(:self%explicit), self%contact(i)%spectra%damping, matrix)
      end if
      associate (tangent => self%tangent(:, :, i))
         do k = 1, self%explicit
            rate = self%harmonic(k)*self%frequency_ratio/self%eta
            if (jumps) then
               tangent(2*k, :) = tangent(2*k, :) + rate*matrix(2*k + 1, :)
               tangent(2*k + 1, :) = tangent(2*k + 1, :) - rate*matrix(2*k, :)
            else
               tangent(2*k, 2*k + 1) = tangent(2*k, 2*k + 1) + gamma*rate
               tangent(2*k + 1, 2*k) = tangent(2*k + 1, 2*k) - gamma*rate
            end if
         end do
      end associate
   end subroutine damp_tangent

   !> (d phi/du) x of an unknown mesh at all carried harmonics, where these are not all explicit.
   subroutine tangent_product(self, i, x, f)
      class(mesh_forces_type), intent(inout) :: self
      !> Number of the unknown mesh.
      integer, intent(in) :: i
      !> Change of the coefficients of the mesh [1], (block).
      real(dp), intent(in) :: x(:)
      !> Change of its force [1], (block).
      real(dp), intent(out) :: f(:)
      real(dp) :: rate(self%block)

      if (self%uncoupled(i)) then
         f = self%constant_stiffness(i)*x
      else if (self%stays(i)) then
         call self%sparse(i, x, f)
      else
         call wave_product(self%place, self%wave(:, i), x, self%products, f)
      end if
      call self%rate_of(i, x, rate, linear=.true.)
      f = f + self%frequency_ratio*rate
   end subroutine tangent_product

end module geartrain_balance_mesh_forces
