!> Where resonances lie that are narrower than a step: the tangents at both of its ends know nothing of them.
!>
!> Where teeth stay in contact harmonic h of the motion has a resonance at eta omega_n/h = Lambda, whose half width is zeta_n
!> Lambda. Over a parameter the natural frequencies omega_n are known at some values of it, and between them by the secant. Of a
!> large train the modes are not known beforehand: those within a step are counted, where one of them may be narrow enough.
module geartrain_trace_narrow_resonances
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_network_natural_modes, only: stiffness_at_rest
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: count_above, eigenvalues_of, enclose, make_pencil, pencil_type
   implicit none (type, external)
   private
   public :: narrow_resonances_type

   !> Most elements of a train whose modes are computed; parts of a path between whose ends the modes are known, and most steps of
   !> the secant.
   integer, parameter :: most_elements = 64, parts = 32, most_steps = 12
   !> Width of a resonance that its points show, over its half width; accuracy of its place, over its half width [1].
   real(dp), parameter :: shown = 4, accuracy = 0.1_dp
   !> Least damping ratio [1]: no step is made shorter than the resonance of such a mode.
   real(dp), parameter :: least_ratio = 1e-6_dp
   !> Solutions with a matrix next to singular that lead to a mode, and how near it is, relative [1].
   integer, parameter :: inverse_steps = 3
   real(dp), parameter :: beside = 1e-7_dp

   type :: narrow_resonances_type
      !> Number of modes known, 0 of a large train; -1: not known yet.
      integer :: modes = -1
      !> Resonances found by `find`: how many, place of each, and half width.
      integer :: number = 0
      real(dp), allocatable :: at(:), half_width(:)
      !> Natural frequency over the characteristic frequency and damping ratio [1], (mode, value), where the parameter has the
      !> values, (value); over Lambda there is one.
      real(dp), allocatable, private :: frequency(:, :), ratio(:, :), value(:)
      !> Of a large train stiffness and inertia, stiffness of each element at rest over its mean stiffness [1], (element), and a
      !> damping ratio over omega that no mode is below [1].
      type(pencil_type), allocatable, private :: pencil
      real(dp), allocatable, private :: factor(:)
      real(dp), private :: least = 0
   contains
      procedure :: setup
      procedure :: find
      procedure, private :: locate
      procedure, private :: find_in_large
   end type narrow_resonances_type

contains

   !> Finds the modes, each mesh with its mean stiffness.
   subroutine setup(self, balance)
      class(narrow_resonances_type), intent(inout) :: self
      !> The balance of the branch.
      type(balance_type), intent(in) :: balance
      type(system_type) :: system
      integer :: k

      self%modes = 0
      allocate (self%at(balance%system%displacements), self%half_width(balance%system%displacements))
      if (balance%system%elements > most_elements) then
         if (allocated(balance%path)) return
         self%factor = stiffness_at_rest(balance%system)
         allocate (self%pencil)
         call make_pencil(balance%system, self%factor, self%pencil)
         ! The damping ratio of a mode is half its frequency times a mean over the elements.
         self%least = minval(balance%system%damping, self%factor > 0)/2
         return
      end if
      self%modes = balance%system%displacements
      self%value = [0.0_dp]
      if (allocated(balance%path)) self%value = balance%path%low + (balance%path%high - balance%path%low)*[(k, k=0, parts)]/parts
      allocate (self%frequency(self%modes, size(self%value)), self%ratio(self%modes, size(self%value)))
      if (.not. allocated(balance%path)) then
         call find_modes(balance%system, self%frequency(:, 1), self%ratio(:, 1))
         return
      end if
      do k = 1, size(self%value)
         call balance%path%system_at(self%value(k), system)
         call find_modes(system, self%frequency(:, k), self%ratio(:, k))
      end do
   end subroutine setup

   !> Finds the resonances of a harmonic within a step that are narrower than the step.
   subroutine find(self, balance, harmonic, ends, widest)
      class(narrow_resonances_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Number of the harmonic of Lambda/eta.
      integer, intent(in) :: harmonic
      !> Lambda, or the parameter, at both ends of the step; half width from which on a resonance does not matter.
      real(dp), intent(in) :: ends(2), widest
      logical :: found
      integer :: mode

      self%number = 0
      if (allocated(self%pencil)) call self%find_in_large(balance, harmonic, ends, widest)
      do mode = 1, self%modes
         associate (n => self%number + 1)
            call self%locate(balance, mode, harmonic, ends, self%at(n), self%half_width(n), found)
            if (found) found = self%half_width(n) < widest
         end associate
         if (found) self%number = self%number + 1
      end do
   end subroutine find

   !> Finds the resonances of a large train: its modes between two frequencies, one by one.
   subroutine find_in_large(self, balance, harmonic, ends, widest)
      class(narrow_resonances_type), intent(inout) :: self
      !> As of `find`.
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: harmonic
      real(dp), intent(in) :: ends(2), widest
      real(dp) :: below, above, omega(2), frequency, ratio
      integer :: n

      omega = [minval(ends), maxval(ends)]*harmonic/balance%eta
      if (least_width() >= min(widest, abs(ends(2) - ends(1))/shown)) return
      do n = count_above(self%pencil, omega(2)**2) + 1, count_above(self%pencil, omega(1)**2)
         call enclose(self%pencil, n, omega(1)**2, omega(2)**2, below, above)
         call find_mode(balance%system, self%pencil, self%factor, above, frequency, ratio)
         associate (at => balance%eta*frequency/harmonic)
            if (.not. (is_within(ends, at, ratio*at) .and. ratio*at < widest)) cycle
            self%number = self%number + 1
            self%at(self%number) = at
            self%half_width(self%number) = ratio*at
         end associate
      end do

   contains

      !> No resonance in the step has a smaller half width.
      pure real(dp) function least_width()
         least_width = max(least_ratio, self%least*omega(1))*minval(ends)
      end function least_width

   end subroutine find_in_large

   !> Finds the resonance of a mode and a harmonic within a step; `found` only if it is narrower than the step.
   subroutine locate(self, balance, mode, harmonic, ends, at, half_width, found)
      class(narrow_resonances_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      !> Numbers of the mode and of the harmonic of Lambda/eta.
      integer, intent(in) :: mode, harmonic
      !> Lambda, or the parameter, at both ends of the step.
      real(dp), intent(in) :: ends(2)
      !> Place and half width of the resonance.
      real(dp), intent(out) :: at, half_width
      !> There is one within the step, and it is narrower.
      logical, intent(out) :: found

      if (allocated(balance%path)) then
         call locate_on_path(self, balance, mode, harmonic, ends, at, half_width, found)
         return
      end if
      at = balance%eta*self%frequency(mode, 1)/harmonic
      half_width = self%ratio(mode, 1)*at
      found = is_within(ends, at, half_width)
   end subroutine locate

   !> Finds the resonance over a parameter.
   subroutine locate_on_path(self, balance, mode, harmonic, ends, at, half_width, found)
      class(narrow_resonances_type), intent(in) :: self
      !> As of `locate`.
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: mode, harmonic
      real(dp), intent(in) :: ends(2)
      real(dp), intent(out) :: at, half_width
      logical, intent(out) :: found
      type(system_type) :: system
      real(dp), dimension(self%modes) :: frequency, ratio
      real(dp) :: x(2), y(2), resonant, slope
      integer :: i, last, side

      at = ends(1)
      half_width = 0
      resonant = balance%path%frequency_ratio*harmonic/balance%eta
      x = ends
      y = [(at_value(ends(i)) - resonant, i=1, 2)]
      found = (y(1) < 0) .neqv. (y(2) < 0)
      if (.not. found) return
      slope = abs(y(2) - y(1))/abs(x(2) - x(1))
      last = 0
      do i = 1, most_steps
         at = x(1) - y(1)*(x(2) - x(1))/(y(2) - y(1))
         call balance%path%system_at(at, system)
         call find_modes(system, frequency, ratio)
         half_width = ratio(mode)*resonant/slope
         found = is_within(ends, at, half_width)
         if (.not. found .or. abs(frequency(mode) - resonant) <= accuracy*ratio(mode)*resonant) return
         ! The other end counts by half where this one moves again (Illinois).
         side = merge(1, 2, (frequency(mode) < resonant) .eqv. (y(1) < 0))
         x(side) = at
         y(side) = frequency(mode) - resonant
         if (side == last) y(3 - side) = y(3 - side)/2
         last = side
      end do

   contains

      !> Natural frequency at a value of the parameter, about.
      pure real(dp) function at_value(value)
         real(dp), intent(in) :: value
         integer :: k

         k = max(1, min(count(self%value <= value), size(self%value) - 1))
         associate (v => self%value(k:k + 1), f => self%frequency(mode, k:k + 1))
            at_value = f(1) + (value - v(1))*(f(2) - f(1))/(v(2) - v(1))
         end associate
      end function at_value

   end subroutine locate_on_path

   !> Whether a resonance is within a step and narrower.
   pure logical function is_within(ends, at, half_width)
      real(dp), intent(in) :: ends(2), at, half_width

      is_within = at > minval(ends) .and. at < maxval(ends) .and. abs(ends(2) - ends(1)) > shown*half_width
   end function is_within

   !> Natural frequencies over the characteristic frequency, ascending, 0 where LAPACK does not converge, and damping ratios by the
   !> diagonal of the modal damping matrix, at least `least_ratio` [1].
   subroutine find_modes(system, frequency, ratio)
      type(system_type), intent(in) :: system
      !> By mode.
      real(dp), intent(out) :: frequency(:), ratio(:)
      real(dp) :: vector(system%elements, size(frequency))
      integer :: i, info

      call eigenvalues_of(system, stiffness_at_rest(system), frequency, info, vector)
      frequency = merge(sqrt(max(frequency, 0.0_dp)), 0.0_dp, info == 0)
      ! The squares of an eigenvector are the shares of the elements in the strain energy.
      ratio = [(max(least_ratio, frequency(i)/2*sum(vector(:, i)**2*system%damping)), i=1, size(frequency))]
   end subroutine find_modes

   !> A mode whose eigenvalue is next to a number, by solutions with a matrix next to singular.
   subroutine find_mode(system, pencil, factor, near, frequency, ratio)
      type(system_type), intent(in) :: system
      type(pencil_type), intent(in) :: pencil
      !> Stiffness of each element over its mean stiffness [1], (element); a number next to the eigenvalue [1].
      real(dp), intent(in) :: factor(:), near
      !> Natural frequency over the characteristic frequency; damping ratio as of `find_modes`.
      real(dp), intent(out) :: frequency, ratio
      complex(dp) :: factors(pencil%graph%entries), shape(size(pencil%inertia))
      real(dp) :: energy(system%elements)
      integer :: i

      associate (graph => pencil%graph, k => pencil%stiffness)
         associate (upper => graph%nodes, lower => graph%nodes + graph%slots)
            factors = k
            factors(lower + 1:) = k(upper + 1:lower)
            ! Off the real axis, where no pivot is 0.
            factors(:upper) = factors(:upper) - near*cmplx(1, beside, dp)*pencil%inertia
         end associate
         call factor_scalars(graph, factors)
         shape = [(modulo(i*sqrt(2.0_dp), 1.0_dp) - 0.5_dp, i=1, size(shape))]
         do i = 1, inverse_steps
            shape = pencil%inertia*shape
            call solve_scalars(graph, factors, shape)
            shape = shape/sqrt(sum(pencil%inertia*abs(shape)**2))
         end do
      end associate
      do i = 1, system%elements
         associate (element => system%network%elements(i))
            energy(i) = factor(i)*system%stiffness(i)*abs(sum(element%entry*shape(element%node)))**2
         end associate
      end do
      frequency = sqrt(sum(energy))/system%characteristic_frequency
      ratio = max(least_ratio, frequency/2*sum(energy*system%damping)/sum(energy))
   end subroutine find_mode

end module geartrain_trace_narrow_resonances
