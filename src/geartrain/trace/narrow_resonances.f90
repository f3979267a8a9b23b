!> Where resonances lie that are narrower than a step: the tangents at both of its ends know nothing of them.
!>
!> Where teeth stay in contact harmonic h of the motion has a resonance where h Lambda/eta is the damped frequency of a mode, whose
!> half width is eta/h times the rate at which the mode decays. Both follow from the eigenvalues of the linear train: heavy damping
!> of one mode moves others by more than they are wide. Over a parameter they are known at some of its values, which bracket the
!> resonances. Of a large train the modes are not known beforehand: those within a step are counted, where one of them may be narrow
!> enough; their undamped frequencies are taken.
module geartrain_trace_narrow_resonances
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_eigenvalues, only: find_eigenvalues
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_network_natural_modes, only: state_matrix, stiffness_at_rest
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: count_above, enclose, make_pencil, pencil_type
   implicit none (type, external)
   private
   public :: narrow_resonances_type

   !> Most elements of a train whose modes are computed; parts of a path between whose ends the modes are known, and most steps of
   !> the secant.
   integer, parameter :: most_elements = 64, parts = 32, most_steps = 12
   !> Width of a resonance that its points show, over its half width; accuracy of its place, over its half width [1].
   real(dp), parameter :: shown = 2, accuracy = 0.1_dp
   !> Half width over the length of a step from which on the ends show the peak to 2 % [1].
   real(dp), parameter :: wide = 2.5_dp
   !> Distance from an end of a step at which a resonance counts as within, over its half width [1].
   real(dp), parameter :: at_end = 1e-6_dp
   !> Least damping ratio [1]: no step is made shorter than the resonance of such a mode.
   real(dp), parameter :: least_ratio = 1e-6_dp
   !> Solutions with a matrix next to singular that lead to a mode, and how near it is, relative [1].
   integer, parameter :: inverse_steps = 3
   real(dp), parameter :: beside = 1e-7_dp

   !> Resonances of a harmonic over a parameter, place and half width of each.
   type :: list_type
      integer :: harmonic = 0
      real(dp), allocatable :: at(:), half_width(:)
   end type list_type

   type :: narrow_resonances_type
      !> The modes are known.
      logical :: known = .false.
      !> Resonances found by `find`: how many, place of each, and half width.
      integer :: number = 0
      real(dp), allocatable :: at(:), half_width(:)
      !> Damped frequency and rate of decay over the characteristic frequency [1], (mode, value), ascending, 0 of an overdamped
      !> mode, where the parameter has the values, (value); over Lambda there is one.
      real(dp), allocatable, private :: frequency(:, :), decay(:, :), value(:)
      !> Over a parameter, lists of the harmonics asked for so far.
      type(list_type), allocatable, private :: list(:)
      !> Of a large train stiffness and inertia, stiffness of each element at rest over its mean stiffness [1], (element), and a
      !> damping ratio over omega that no mode is below [1].
      type(pencil_type), allocatable, private :: pencil
      real(dp), allocatable, private :: factor(:)
      real(dp), private :: least = 0
   contains
      procedure :: setup
      procedure :: find
      procedure :: any_near
      procedure, private :: find_places
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

      self%known = .true.
      allocate (self%at(balance%system%displacements), self%half_width(balance%system%displacements), self%list(0))
      if (balance%system%elements > most_elements) then
         if (allocated(balance%path)) return
         self%factor = stiffness_at_rest(balance%system)
         allocate (self%pencil)
         call make_pencil(balance%system, self%factor, self%pencil)
         ! The damping ratio of a mode is half its frequency times a mean over the elements.
         self%least = minval(balance%system%damping, self%factor > 0)/2
         return
      end if
      self%value = [0.0_dp]
      if (allocated(balance%path)) self%value = balance%path%low + (balance%path%high - balance%path%low)*[(k, k=0, parts)]/parts
      allocate (self%frequency(balance%system%coordinates, size(self%value)))
      allocate (self%decay, mold=self%frequency)
      if (.not. allocated(balance%path)) then
         call find_modes(balance%system, self%frequency(:, 1), self%decay(:, 1))
         return
      end if
      do k = 1, size(self%value)
         call balance%path%system_at(self%value(k), system)
         call find_modes(system, self%frequency(:, k), self%decay(:, k))
      end do
   end subroutine setup

   !> Finds the resonances of a harmonic within a step that are narrower than the step.
   subroutine find(self, balance, harmonic, ends)
      class(narrow_resonances_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Number of the harmonic of Lambda/eta.
      integer, intent(in) :: harmonic
      !> Lambda, or the parameter, at both ends of the step.
      real(dp), intent(in) :: ends(2)
      real(dp), allocatable :: at(:), half_width(:)

      self%number = 0
      if (allocated(self%pencil)) call self%find_in_large(balance, harmonic, ends)
      if (.not. allocated(self%value)) return
      call self%find_places(balance, harmonic, at, half_width)
      self%number = count(is_within(ends, at, half_width))
      self%at = pack(at, is_within(ends, at, half_width))
      self%half_width = pack(half_width, is_within(ends, at, half_width))
   end subroutine find

   !> Whether a resonance of a harmonic may have its peak within a step, and higher than at the ends; of a large train it is not
   !> known.
   logical function any_near(self, balance, harmonic, ends) result(near)
      class(narrow_resonances_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Number of the harmonic of Lambda/eta.
      integer, intent(in) :: harmonic
      !> Lambda, or the parameter, at both ends of the step.
      real(dp), intent(in) :: ends(2)
      real(dp), allocatable :: at(:), half_width(:)

      near = .false.
      if (.not. self%known) call self%setup(balance)
      if (.not. allocated(self%value)) return
      call self%find_places(balance, harmonic, at, half_width)
      near = any(at + half_width/2 > minval(ends) .and. at - half_width/2 < maxval(ends) .and. &
                 half_width < wide*abs(ends(2) - ends(1)))
   end function any_near

   !> Finds all resonances of a harmonic: over a parameter once for the whole path.
   subroutine find_places(self, balance, harmonic, at, half_width)
      class(narrow_resonances_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: harmonic
      !> Place of each, and half width.
      real(dp), allocatable, intent(out) :: at(:), half_width(:)
      type(list_type), allocatable :: lists(:)
      integer :: k, mode, n

      associate (factor => real(balance%eta, dp)/harmonic, f => self%frequency)
         if (.not. allocated(balance%path)) then
            at = factor*pack(f(:, 1), f(:, 1) > 0)
            half_width = factor*pack(self%decay(:, 1), f(:, 1) > 0)
            return
         end if
         n = findloc(self%list%harmonic, harmonic, 1)
         if (n == 0) then
            n = size(self%list) + 1
            allocate (lists(n))
            lists(:n - 1) = self%list
            lists(n)%harmonic = harmonic
            allocate (lists(n)%at(0), lists(n)%half_width(0))
            associate (resonant => balance%path%frequency_ratio/factor)
               do k = 1, parts
                  do mode = 1, size(f, 1)
                     if ((f(mode, k) < resonant) .eqv. (f(mode, k + 1) < resonant)) cycle
                     call locate(balance, mode, resonant, self%value(k:k + 1), f(mode, k:k + 1) - resonant, lists(n))
                  end do
               end do
            end associate
            call move_alloc(lists, self%list)
         end if
         at = self%list(n)%at
         half_width = self%list(n)%half_width
      end associate
   end subroutine find_places

   !> Finds the resonances of a large train: its modes between two frequencies, one by one.
   subroutine find_in_large(self, balance, harmonic, ends)
      class(narrow_resonances_type), intent(inout) :: self
      !> As of `find`.
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: harmonic
      real(dp), intent(in) :: ends(2)
      real(dp) :: below, above, omega(2), frequency, ratio
      integer :: n

      omega = [minval(ends), maxval(ends)]*harmonic/balance%eta
      if (least_width() >= abs(ends(2) - ends(1))/shown) return
      do n = count_above(self%pencil, omega(2)**2) + 1, count_above(self%pencil, omega(1)**2)
         call enclose(self%pencil, n, omega(1)**2, omega(2)**2, below, above)
         call find_mode(balance%system, self%pencil, self%factor, above, frequency, ratio)
         associate (at => balance%eta*frequency/harmonic)
            if (.not. all(is_within(ends, [at], [ratio*at]))) cycle
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

   !> Adds the resonance over a parameter between two values of it.
   subroutine locate(balance, mode, resonant, ends, off, list)
      type(balance_type), intent(in) :: balance
      !> Number of the mode; frequency in resonance over the characteristic frequency [1].
      integer, intent(in) :: mode
      real(dp), intent(in) :: resonant
      !> The values, and the frequency of the mode there less the one in resonance, of different signs.
      real(dp), intent(in) :: ends(2), off(2)
      !> Resonances of the harmonic.
      type(list_type), intent(inout) :: list
      type(system_type) :: system
      real(dp), dimension(balance%system%coordinates) :: frequency, decay
      real(dp) :: x(2), y(2), at, half_width
      integer :: i, last, side

      x = ends
      y = off
      last = 0
      do i = 1, most_steps
         at = x(1) - y(1)*(x(2) - x(1))/(y(2) - y(1))
         call balance%path%system_at(at, system)
         call find_modes(system, frequency, decay)
         half_width = decay(mode)*abs(ends(2) - ends(1))/abs(off(2) - off(1))
         if (abs(frequency(mode) - resonant) <= accuracy*decay(mode)) exit
         ! The other end counts by half where this one moves again (Illinois).
         side = merge(1, 2, (frequency(mode) < resonant) .eqv. (y(1) < 0))
         x(side) = at
         y(side) = frequency(mode) - resonant
         if (side == last) y(3 - side) = y(3 - side)/2
         last = side
      end do
      list%at = [list%at, at]
      list%half_width = [list%half_width, half_width]
   end subroutine locate

   !> Whether a resonance is within a step, or at its ends, and narrower.
   pure function is_within(ends, at, half_width)
      real(dp), intent(in) :: ends(2), at(:), half_width(:)
      logical :: is_within(size(at))

      is_within = at > minval(ends) - at_end*half_width .and. at < maxval(ends) + at_end*half_width .and. &
                  abs(ends(2) - ends(1)) > shown*half_width
   end function is_within

   !> Damped frequencies over the characteristic frequency, ascending after a 0 for each overdamped mode, and rates of decay, at
   !> least `least_ratio` of the frequency [1]; 0 where the eigenvalues are not found.
   subroutine find_modes(system, frequency, decay)
      type(system_type), intent(in) :: system
      !> By mode.
      real(dp), intent(out) :: frequency(:), decay(:)
      real(dp) :: matrix(system%states, system%states)
      complex(dp) :: value(system%states)
      integer :: info, n

      frequency = 0
      decay = 0
      matrix = state_matrix(system)
      call find_eigenvalues(system%states, matrix, value, info)
      if (info /= 0) return
      value = pack(value, value%im > 0, [(cmplx(0, 0, dp), n=1, system%states)])
      n = count(value%im > 0)
      value(:n) = value(ascending(value(:n)%im))
      associate (first => size(frequency) - n + 1)
         frequency(first:) = value(:n)%im
         decay(first:) = max(-value(:n)%re, least_ratio*value(:n)%im)
      end associate
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
