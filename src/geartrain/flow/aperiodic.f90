!> What the flow does in the long run where no period was found: its kind and largest Lyapunov exponent, and whether two such flows
!> are on one attractor.
!>
!> Flows on one chaotic attractor never meet, but their sections have the same moments: mean and spread of every coordinate of the
!> state. The uncertainty of a moment comes from six blocks of the sections; as so few of them may lie close together by chance, it
!> is at least the largest of all coordinates, over their spread.
module geartrain_flow_aperiodic
   use geartrain_base_kinds, only: dp
   use geartrain_flow_flow_kind, only: flow_kind
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_flow_spectrum, only: lyapunov_spectrum
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: aperiodic_type

   !> Blocks of the sections; largest difference of moments of one attractor over its uncertainty, to which is added this share of
   !> the spread.
   integer, parameter :: blocks = 6
   real(dp), parameter :: most_deviations = 6, equal = 0.01_dp

   type :: aperiodic_type
      !> 'chaotic', 'quasi-periodic', 'still settling' or 'undecided', see geartrain_balance_motion.
      character(14) :: kind = 'undecided'
      !> Largest Lyapunov exponent and its uncertainty at 95 %, per unit of time [1].
      real(dp) :: exponent = 0, error = 0
      !> Mean and spread (standard deviation) of each coordinate of the sections and their standard errors [1], (state, 2).
      real(dp), allocatable, private :: moment(:, :), uncertainty(:, :)
   contains
      procedure :: find
      procedure :: is_same
   end type aperiodic_type

contains

   !> Finds kind and moments.
   subroutine find(self, system, map, state, periods)
      class(aperiodic_type), intent(out) :: self
      type(system_type), intent(in) :: system
      !> The map from section to section.
      type(section_map_type), intent(in) :: map
      !> State at phase 0 on the attractor [1], (state).
      real(dp), intent(in) :: state(:)
      !> Periods of the fundamental, at least 60.
      integer, intent(in) :: periods
      real(dp) :: now(size(state)), sections(size(state), periods), exponents(1), errors(1)
      real(dp) :: part(size(state), 2, blocks)
      type(section_trend_type) :: trend
      integer :: i, n
      logical :: lost

      now = state
      lost = .false.
      call lyapunov_spectrum(system, map, now, periods, exponents, errors, lost, sections, trend)
      if (lost) return
      self%exponent = exponents(1)
      self%error = errors(1)
      self%kind = flow_kind(system, map%frequency_ratio, now, self%exponent, self%error, trend)
      n = periods/blocks
      do i = 1, blocks
         part(:, :, i) = moments(sections(:, (i - 1)*n + 1:i*n))
      end do
      self%moment = sum(part, 3)/blocks
      allocate (self%uncertainty(size(state), 2))
      associate (width => max(self%moment(:, 2), tiny(1.0_dp)))
         do i = 1, 2
            associate (uncertainty => self%uncertainty(:, i))
               uncertainty = sqrt(sum((part(:, i, :) - spread(self%moment(:, i), 2, blocks))**2, 2)/(blocks*(blocks - 1)))
               uncertainty = max(uncertainty, width*maxval(uncertainty/width))
            end associate
         end do
      end associate
   end subroutine find

   !> Mean and standard deviation of each coordinate.
   pure function moments(sections)
      real(dp), intent(in) :: sections(:, :)
      real(dp) :: moments(size(sections, 1), 2)

      moments(:, 1) = sum(sections, 2)/size(sections, 2)
      moments(:, 2) = sqrt(sum((sections - spread(moments(:, 1), 2, size(sections, 2)))**2, 2)/size(sections, 2))
   end function moments

   !> Whether another flow may be on the same attractor, by the moments.
   pure logical function is_same(self, other)
      class(aperiodic_type), intent(in) :: self
      !> The other flow.
      type(aperiodic_type), intent(in) :: other
      real(dp), allocatable :: allowed(:, :)

      is_same = allocated(self%moment) .and. allocated(other%moment)
      if (.not. is_same) return
      allowed = most_deviations*sqrt(self%uncertainty**2 + other%uncertainty**2) &
                + equal*spread(max(self%moment(:, 2), other%moment(:, 2)), 2, 2)
      is_same = all(abs(self%moment - other%moment) <= allowed)
   end function is_same

end module geartrain_flow_aperiodic
