!> The leading multipliers of a motion without contact events whose damping outweighs the variation of its stiffness: a verdict
!> without a flight, for trains of any size.
!>
!> A perturbation that neither grows nor decays is y(t) = sum over k of y_k exp(i (nu + k base) t), and so takes as much power out
!> of the varying stiffness as its damping does: the sum over the elements of k_n <gamma_n y_n'^2 - kappa_n' y_n^2/2> is 0. Each
!> element has a frequency nu_n: where |nu| > nu_n its mean is above 0 for every y_n. nu_n is the rotation number of
!> y'' = -(kappa_n'/2)/gamma_n y. So no multiplier crosses the unit circle outside the window |nu| <= max nu_n while the variation
!> grows from 0 to what it is. With a decay sigma, kappa_n'/2 + 2 sigma kappa_n in its place, the same holds for the circle of
!> radius exp(-sigma period), but for elements of constant stiffness, which the modes of the mean train stand for.
!>
!> Within the window a perturbation without a share at nu itself, |nu| < base/2, is damped too, where the amplitudes of kappa are
!> small beside gamma Lambda. What is left are the slow modes of the mean train. Their exponents follow from the mean train and, to
!> second order in the variation, from what it makes of them at the frequencies nu + h Lambda.
module geartrain_floquet_slow_multipliers
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_network_lowest_modes, only: lowest_modes_type
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: make_pencil, pencil_type
   implicit none (type, external)
   private
   public :: slow_multipliers_type

   !> Modes that are found at first, and beyond what the window needs; most modes in the window; most solutions for them.
   integer, parameter :: first_modes = 8, more_modes = 2, most_modes = 96, most_solutions = 400
   !> Decay that is asked of all other perturbations over the slowest of the mean train; largest change of a decay by the variation;
   !> largest amplitude of what the variation adds to a mode, over the mode's, in the norm of elastic energy.
   real(dp), parameter :: faster = 1.1_dp, largest_change = 0.1_dp, largest_addition = 0.1_dp
   !> Widest window, as a share of half the base frequency; room for the error of a rotation number.
   real(dp), parameter :: widest = 0.9_dp, room = 1.02_dp
   !> Share of the diagonal elements that the others of a row may have.
   real(dp), parameter :: dominant = 0.9_dp
   !> Samples of kappa over a period of its highest harmonic.
   integer, parameter :: samples = 48

   !> Work space of one branch.
   type :: slow_multipliers_type
      private
      type(system_type), pointer :: system => null()
      !> The latest motion had the regions `contact` of the laws, (mesh); 0: none yet.
      integer, allocatable :: contact(:)
      !> There is an element without stiffness or damping, or damping to ground; or modes were not found.
      logical :: excluded = .false.
      !> Mean stiffness over that of the element [1]; gamma [1], (element).
      real(dp), allocatable :: stiffness(:), damping(:)
      !> Modes of the mean train; damping of each, which is twice its decay [1], (mode).
      type(lowest_modes_type) :: modes
      real(dp), allocatable :: modal_damping(:)
      !> Damping on the graph of the modes' pencil [kg m^2], (entry).
      real(dp), allocatable :: damper(:)
      !> Harmonics of Lambda in any kappa, and half their complex amplitudes [1], (harmonic) and (element, harmonic).
      integer, allocatable :: harmonic(:)
      complex(dp), allocatable :: amplitude(:, :)
      !> Meshes of varying stiffness: greatest common divisor of the harmonics of kappa, gamma, sum of the amplitudes of kappa [1],
      !> (varying mesh). Samples of kappa over 2 pi/divisor of the phase [1], first(i):first(i + 1) - 1 those of varying mesh i.
      integer, allocatable :: divisor(:), first(:)
      real(dp), allocatable :: gamma(:), strength(:), kappa(:)
   contains
      procedure :: setup
      procedure :: find
      procedure, private :: take_contact
      procedure, private :: tabulate
      procedure, private :: know_modes
      procedure, private :: window
      procedure, private :: exponents
   end type slow_multipliers_type

contains

   !> Prepares for the motions of a train.
   subroutine setup(self, system)
      class(slow_multipliers_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system

      self%system => system
      allocate (self%contact(system%meshes), source=0)
   end subroutine setup

   !> Multipliers of a motion without contact events. No success: the damping does not outweigh the variation surely enough.
   subroutine find(self, contact, frequency_ratio, period, values, success)
      class(slow_multipliers_type), intent(inout) :: self
      !> Region of its law in which each mesh stays, (mesh).
      integer, intent(in) :: contact(:)
      !> Lambda [1]; period of the waveform [1].
      real(dp), intent(in) :: frequency_ratio, period
      !> Multipliers, largest magnitude first, (leading).
      complex(dp), intent(out) :: values(:)
      !> The largest value is the largest multiplier, to some percent of its distance from the unit circle.
      logical, intent(out) :: success
      complex(dp), allocatable :: exponent(:)
      real(dp) :: beyond, decay, limit
      integer :: i, k, number
      logical :: left(2*most_modes)

      success = .false.
      if (any(contact /= self%contact)) call self%take_contact(contact)
      if (self%excluded) return
      if (self%window(frequency_ratio, 0.0_dp, widest*pi/period) >= huge(limit)) return
      call self%know_modes(max(first_modes, (size(values) + 1)/2), success)
      if (.not. success) return
      decay = faster*minval(self%modal_damping)/2
      limit = self%window(frequency_ratio, decay, widest*pi/period)
      success = limit < huge(limit)
      if (.not. success) return
      ! Beyond this frequency no mode of the mean train decays as slowly.
      beyond = room*sqrt(2*decay*maxval(self%stiffness/self%damping))
      if (max(limit, beyond) > self%modes%frequency(size(self%modes%frequency))) then
         number = self%modes%below(max(limit, beyond)) + more_modes
         success = number <= most_modes
         if (success) call self%know_modes(number, success)
         if (.not. success) return
      end if
      number = count(self%modes%frequency <= limit)
      success = 2*number*size(self%harmonic) <= most_solutions
      if (success) call self%exponents(number, frequency_ratio, exponent, success)
      if (.not. success) return
      left(:size(exponent)) = .true.
      do i = 1, size(values)
         k = maxloc(exponent%re, 1, left(:size(exponent)))
         left(k) = .false.
         values(i) = exp(exponent(k)*period)
      end do
   end subroutine find

   !> Takes a mean train.
   subroutine take_contact(self, contact)
      class(slow_multipliers_type), intent(inout) :: self
      integer, intent(in) :: contact(:)
      type(pencil_type) :: damping
      integer :: j

      self%contact = contact
      associate (system => self%system)
         self%stiffness = system%spring
         self%damping = system%damping
         do j = 1, system%meshes
            self%stiffness(system%mesh_element(j)) = system%law(j)%stiffness(contact(j))
            self%damping(system%mesh_element(j)) = system%law(j)%damping(contact(j))
         end do
         self%excluded = system%displacements < system%coordinates .or. &
                         .not. (all(self%stiffness > 0) .and. all(self%damping > 0))
         if (self%excluded) return
         call self%modes%begin(system, self%stiffness)
         call make_pencil(system, self%damping, damping)
         self%damper = damping%stiffness
      end associate
      self%modal_damping = [real(dp) ::]
      call self%tabulate()
   end subroutine take_contact

   !> Lists the harmonics of kappa, and samples kappa of each mesh.
   subroutine tabulate(self)
      class(slow_multipliers_type), intent(inout) :: self
      real(dp), allocatable :: kappa(:)
      integer :: h, i, j, k, count

      self%harmonic = [integer ::]
      do j = 1, self%system%meshes
         associate (law => self%system%law(j))
            do i = 1, size(law%harmonic)
               if (abs(law%amplitude(i, self%contact(j))) > 0 .and. all(self%harmonic /= law%harmonic(i))) &
                  self%harmonic = [self%harmonic, law%harmonic(i)]
            end do
         end associate
      end do
      if (allocated(self%amplitude)) deallocate (self%amplitude)
      allocate (self%amplitude(self%system%elements, size(self%harmonic)), source=(0.0_dp, 0.0_dp))
      self%first = [1]
      self%divisor = [integer ::]
      self%gamma = [real(dp) ::]
      self%strength = [real(dp) ::]
      self%kappa = [real(dp) ::]
      do j = 1, self%system%meshes
         associate (law => self%system%law(j), s => self%contact(j), n => self%system%mesh_element(j))
            if (.not. law%varies(s)) cycle
            h = 0
            do i = 1, size(law%harmonic)
               if (.not. abs(law%amplitude(i, s)) > 0) cycle
               k = findloc(self%harmonic, law%harmonic(i), 1)
               self%amplitude(n, k) = law%amplitude(i, s)/2
               h = common_divisor(h, law%harmonic(i))
            end do
            count = samples*maxval(law%harmonic)/h
            kappa = [(law%stiffness_at(s, 2*pi*k/(h*real(count, dp))), k=0, count)]
            self%kappa = [self%kappa, kappa]
            self%divisor = [self%divisor, h]
            self%gamma = [self%gamma, law%damping(s)]
            self%strength = [self%strength, sum(abs(law%amplitude(:, s)))]
            self%first = [self%first, size(self%kappa) + 1]
         end associate
      end do
   end subroutine tabulate

   pure recursive integer function common_divisor(a, b) result(divisor)
      integer, intent(in) :: a, b

      divisor = a
      if (b > 0) divisor = common_divisor(b, mod(a, b))
   end function common_divisor

   !> Makes sure that so many modes are known.
   subroutine know_modes(self, number, success)
      class(slow_multipliers_type), intent(inout) :: self
      integer, intent(in) :: number
      logical, intent(out) :: success
      integer :: i

      success = size(self%modal_damping) >= number
      if (success) return
      call self%modes%find(self%system, number, success)
      self%excluded = .not. success
      if (.not. success) return
      associate (weight => self%system%stiffness/self%system%characteristic_frequency**2*self%damping)
         self%modal_damping = [(sum(weight*self%modes%shape(:, i)**2), i=1, number)]
      end associate
   end subroutine know_modes

   !> Largest frequency at which a perturbation may decay as slowly as that [1]; huge: it is above `limit`, or not known.
   real(dp) function window(self, frequency_ratio, decay, limit)
      class(slow_multipliers_type), intent(in) :: self
      real(dp), intent(in) :: frequency_ratio, decay, limit
      real(dp) :: turn
      integer :: i

      window = 0
      do i = 1, size(self%gamma)
         associate (time => 2*pi/(self%divisor(i)*frequency_ratio))
            turn = rotation(self%kappa(self%first(i):self%first(i + 1) - 1), self%gamma(i), decay, time)
            if (turn < pi) window = max(window, room*turn/time)
            if (turn >= pi .or. window > limit) then
               window = huge(window)
               return
            end if
         end associate
      end do
      ! Within the window what has no share at nu itself is damped as well (Gershgorin's circles).
      associate (rate => self%divisor*frequency_ratio)
         if (any(self%strength > dominant*self%gamma*rate*(1 - min(1.0_dp, window/rate))**2)) window = huge(window)
      end associate
   end function window

   !> Angle by which the solutions of y'' = -(kappa'/2 + 2 decay kappa)/gamma y turn over a period of kappa; pi: by pi or more.
   pure real(dp) function rotation(kappa, gamma, decay, time)
      !> kappa at equal distances, both ends included [1]; gamma, decay, period [1].
      real(dp), intent(in) :: kappa(:), gamma, decay, time
      real(dp) :: h, kick, y(2), slope(2)
      integer :: i, n

      rotation = pi
      n = size(kappa) - 1
      h = time/n
      ! The solution with the value 1 at first, and that with the slope 1, in steps that keep the area.
      y = [1.0_dp, h/2]
      slope = [0.0_dp, 1.0_dp]
      do i = 1, n
         kick = ((kappa(i + 1) - kappa(i))/2 + decay*h*(kappa(i + 1) + kappa(i)))/gamma
         slope = slope - kick*y
         y = y + merge(h/2, h, i == n)*slope
         if (.not. y(2) > 0) return
      end do
      if (y(1) + slope(2) > -2) rotation = acos(min(1.0_dp, (y(1) + slope(2))/2))
   end function rotation

   !> Exponents of the first modes, and of the mean train's other modes that are known. No success: the variation changes them too
   !> much for the second order to be exact.
   subroutine exponents(self, number, frequency_ratio, values, success)
      class(slow_multipliers_type), intent(in) :: self
      integer, intent(in) :: number
      real(dp), intent(in) :: frequency_ratio
      complex(dp), allocatable, intent(out) :: values(:)
      logical, intent(out) :: success
      complex(dp) :: factors(self%modes%pencil%graph%entries), moved(self%system%elements), change(number), s
      real(dp) :: matrix(2*number, 2*number), weight(self%system%elements), added, expected(number), found(number)
      integer :: i, j, k, side, info

      associate (frequency => self%modes%frequency, shape => self%modes%shape, damping => self%modal_damping)
         weight = self%system%stiffness/self%system%characteristic_frequency**2
         matrix = 0
         success = .true.
         do j = 1, number
            change = 0
            added = 0
            do k = 1, size(self%harmonic)
               do side = -1, 1, 2
                  s = cmplx(0, frequency(j) + side*self%harmonic(k)*frequency_ratio, dp)
                  call factor_at_s()
                  call respond(shape(:, j), merge(self%amplitude(:, k), conjg(self%amplitude(:, k)), side > 0), moved)
                  added = added + sum(weight*self%stiffness*abs(moved)**2)
                  moved = weight*merge(conjg(self%amplitude(:, k)), self%amplitude(:, k), side > 0)*moved
                  change = change + cmplx(matmul(moved%re, shape(:, :number)), matmul(moved%im, shape(:, :number)), dp)
               end do
            end do
            success = success .and. added <= largest_addition**2*frequency(j)**2
            ! The real part acts as a stiffness, the imaginary part as a damping.
            matrix(j, number + j) = 1
            matrix(number + 1:, j) = -change%re
            matrix(number + 1:, number + j) = -change%im/frequency(j)
            matrix(number + j, j) = matrix(number + j, j) - frequency(j)**2
            do i = 1, number
               matrix(number + i, number + j) = matrix(number + i, number + j) &
                                                - sum(weight*self%damping*shape(:, i)*shape(:, j))
            end do
         end do
         if (.not. success) return
         allocate (values(2*size(frequency)))
         if (number > 0) call find_eigenvalues(2*number, matrix, values(:2*number), info)
         success = number == 0
         if (.not. success) success = info == 0
         if (.not. success) return
         do i = number + 1, size(frequency)
            values(2*i - 1) = cmplx(-damping(i)/2, sqrt(max(0.0_dp, frequency(i)**2 - damping(i)**2/4)), dp)
            values(2*i) = conjg(values(2*i - 1))
         end do
         expected = sorted(damping(:number)/2)
         found = pack(sorted(-values(:2*number)%re), [(mod(i, 2) == 1, i=1, 2*number)])
         success = all(abs(found - expected) <= largest_change*expected)
      end associate

   contains

      !> Factors of the mean train at the exponent s.
      subroutine factor_at_s()
         associate (pencil => self%modes%pencil, graph => self%modes%pencil%graph)
            associate (upper => graph%nodes, lower => graph%nodes + graph%slots)
               factors = pencil%stiffness + s*self%damper
               factors(lower + 1:) = factors(upper + 1:lower)
               factors(:upper) = factors(:upper) + s**2*pencil%inertia
               call factor_scalars(graph, factors)
            end associate
         end associate
      end subroutine factor_at_s

      !> Displacements that the forces of an amplitude of kappa times displacements make, (element).
      subroutine respond(displacement, amplitude, response)
         real(dp), intent(in) :: displacement(:)
         complex(dp), intent(in) :: amplitude(:)
         complex(dp), intent(out) :: response(:)
         complex(dp) :: theta(self%modes%pencil%graph%nodes), force
         integer :: n

         theta = 0
         associate (elements => self%system%network%elements)
            do n = 1, size(elements)
               if (.not. abs(amplitude(n)) > 0) cycle
               force = -weight(n)*amplitude(n)*displacement(n)
               theta(elements(n)%node) = theta(elements(n)%node) + elements(n)%entry*force
            end do
            call solve_scalars(self%modes%pencil%graph, factors, theta)
            do n = 1, size(elements)
               response(n) = sum(elements(n)%entry*theta(elements(n)%node))
            end do
         end associate
      end subroutine respond
   end subroutine exponents

   !> Numbers in ascending order.
   pure function sorted(numbers)
      real(dp), intent(in) :: numbers(:)
      real(dp) :: sorted(size(numbers))

      sorted = numbers(ascending(numbers))
   end function sorted

end module geartrain_floquet_slow_multipliers
