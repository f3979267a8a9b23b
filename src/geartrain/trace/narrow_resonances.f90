!> Where resonances lie that are narrower than a step: the tangents at both of its ends know nothing of them.
!>
!> Where teeth stay in contact harmonic h of the motion has a resonance at eta omega_n/h = Lambda, whose half width is zeta_n
!> Lambda. Over a parameter the natural frequencies omega_n are known at some values of it, and between them by the secant.
module geartrain_trace_narrow_resonances
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_network_natural_modes, only: stiffness_at_rest
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: eigenvalues_of
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

   type :: narrow_resonances_type
      !> Number of modes looked at, 0 of a large train; -1: not known yet.
      integer :: modes = -1
      !> Natural frequency over the characteristic frequency and damping ratio [1], (mode, value), where the parameter has the
      !> values, (value); over Lambda there is one.
      real(dp), allocatable, private :: frequency(:, :), ratio(:, :), value(:)
   contains
      procedure :: setup
      procedure :: locate
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
      if (balance%system%elements > most_elements) return
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

end module geartrain_trace_narrow_resonances
