!> Resonances that a step passes unseen because they are narrower than it: the tangents at both of its ends know nothing of them.
!>
!> Where teeth stay in contact harmonic h of the motion has a resonance at Lambda_r = eta omega_n/h, whose half width is
!> zeta_n Lambda_r. Away from it, the amplitude of the mode over its amplitude there is 2 zeta_n/|1 - (Lambda/Lambda_r)**2|, so the
!> ends of the step tell how large the motion may be in between. Where it may be off the cubic through both ends, the balance is
!> solved there. Where teeth part a resonance is as wide as the branch is bent, and the branch is followed through it.
module geartrain_trace_narrow_resonances
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_cubic, only: share_at
   use geartrain_network_natural_modes, only: stiffness_at_rest
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: eigenvalues_of
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   use geartrain_trace_step_geometry, only: arc_length, go_along
   use geartrain_trace_step_length, only: carries_same, curve_limit
   implicit none (type, external)
   private
   public :: narrow_resonances_type

   !> Most elements of a train whose modes are computed.
   integer, parameter :: most_elements = 64
   !> Width of a resonance that its points show, over its half width [1].
   real(dp), parameter :: shown = 4
   !> Distance from the cubic at which a step is refused, over `curve_limit` [1].
   real(dp), parameter :: off_cubic = 5

   type :: narrow_resonances_type
      private
      !> Natural frequency over the characteristic frequency and damping ratio, by the diagonal of the modal damping matrix [1],
      !> (mode).
      real(dp), allocatable :: frequency(:), ratio(:)
   contains
      procedure :: find
      procedure :: hide
   end type narrow_resonances_type

contains

   !> Finds the modes of a train at rest, each mesh with its mean stiffness; of a large train none.
   subroutine find(self, system)
      class(narrow_resonances_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      real(dp) :: square(system%displacements), vector(system%elements, system%displacements)
      integer :: i, info

      self%frequency = [real(dp) ::]
      self%ratio = [real(dp) ::]
      if (system%elements > most_elements) return
      call eigenvalues_of(system, stiffness_at_rest(system), square, info, vector)
      if (info /= 0) return
      self%frequency = sqrt(max(square, 0.0_dp))
      ! The squares of an eigenvector are the shares of the elements in the strain energy.
      self%ratio = [(self%frequency(i)/2*sum(vector(:, i)**2*system%damping), i=1, size(square))]
   end subroutine find

   !> Whether the branch is off the cubic through the ends of a step without a fold at a resonance between them.
   logical function hide(self, corrector, here, next)
      class(narrow_resonances_type), intent(in) :: self
      type(corrector_type), intent(inout) :: corrector
      !> The ends, with their tangents.
      type(solution_point_type), intent(in) :: here, next
      real(dp) :: at, amplitude, low, high, length, limit
      type(solution_point_type) :: guess, solution
      integer :: h, n
      logical :: success

      hide = .false.
      if (.not. allocated(self%frequency) .or. .not. carries_same(here, next)) return
      low = min(here%frequency_ratio, next%frequency_ratio)
      high = max(here%frequency_ratio, next%frequency_ratio)
      limit = off_cubic*curve_limit(corrector, next)
      length = arc_length(here, next, corrector%units)
      do h = 1, size(next%harmonic)
         do n = 1, size(self%frequency)
            at = corrector%balance%eta*self%frequency(n)/next%harmonic(h)
            if (.not. (at > low .and. at < high .and. high - low > shown*self%ratio(n)*at)) cycle
            amplitude = min(norm2(here%u(2*h:2*h + 1, :))*abs(1 - (here%frequency_ratio/at)**2), &
                            norm2(next%u(2*h:2*h + 1, :))*abs(1 - (next%frequency_ratio/at)**2))
            if (amplitude <= 2*self%ratio(n)*limit*corrector%units%length) cycle
            guess = here
            call go_along(here, next, share_at([here%frequency_ratio, next%frequency_ratio], &
                                               [here%tangent_frequency, next%tangent_frequency]*length, at), &
                          corrector%units, guess)
            guess%frequency_ratio = at
            solution = guess
            call corrector%solve_at(solution, success)
            hide = .not. success
            if (success) hide = corrector%length_of(solution%u - guess%u) > limit
            if (hide) return
         end do
      end do
   end function hide

end module geartrain_trace_narrow_resonances
