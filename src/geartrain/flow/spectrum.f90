!> All Lyapunov exponents of a flow and the rotation number of a quasi-periodic one, from its sections.
module geartrain_flow_spectrum
   use geartrain_base_kinds, only: dp, pi
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_lyapunov, only: exponent_of, settled_part
   use geartrain_flow_section_map, only: section_map_type
   use geartrain_flow_section_trend, only: section_trend_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: lyapunov_spectrum, rotation_number

   !> Least radius over the largest at which a curve in a plane is taken to go round its middle.
   real(dp), parameter :: roundness = 0.05_dp
   !> Fewest sections of a curve for its turns.
   integer, parameter :: fewest = 32
   !> Most curves that the sections of a torus are looked for on; turns as near as this to a fraction are those from curve to curve.
   integer, parameter :: most_curves = 8
   real(dp), parameter :: fraction = 1e-5_dp

contains

   !> The largest Lyapunov exponents, as many as asked for: tangents carried along the flow and made orthogonal again after each
   !> period of the fundamental (Benettin and others, 1980), in the norm of the energy.
   subroutine lyapunov_spectrum(system, map, state, periods, exponents, errors, lost, sections, trend)
      type(system_type), intent(in) :: system
      !> The map from section to section.
      type(section_map_type), intent(in) :: map
      !> State at phase 0, then after the periods [1], (state).
      real(dp), intent(inout) :: state(:)
      !> Periods of the fundamental over which is averaged, after a fifth as many in which the tangents turn.
      integer, intent(in) :: periods
      !> Exponents per unit of time [1], largest first, and their uncertainties at 95 % [1], (exponent): as many as states or fewer.
      real(dp), intent(out) :: exponents(:), errors(:)
      !> Set where the flow is not valid: an event was passed over, the state ran away, or an interrupt ended it.
      logical, intent(inout) :: lost
      !> States after each period of the average [1], (state, period).
      real(dp), intent(out), optional :: sections(:, :)
      !> Trend of these states.
      type(section_trend_type), intent(out), optional :: trend
      type(energy_type) :: energy
      real(dp) :: tangents(size(state), size(exponents)), growth(periods, size(exponents)), length(size(exponents))
      integer :: first, i, k, largest

      call energy%setup(system)
      if (present(trend)) call trend%begin(system)
      tangents = 0
      do i = 1, size(exponents)
         tangents(i, i) = 1
      end do
      exponents = 0
      errors = 0
      do k = -periods/5 + 1, periods
         call map%pass_period(state, lost, tangents)
         if (.not. all(abs(tangents) < 1e100_dp) .or. system%interrupt%raised()) lost = .true.
         if (lost) return
         do i = 1, size(exponents)
            tangents(:, i) = energy%coordinates(tangents(:, i))
         end do
         call orthogonalise(tangents, length)
         do i = 1, size(exponents)
            tangents(:, i) = energy%state(tangents(:, i))
         end do
         if (k < 1) cycle
         growth(k, :) = log(max(length, tiny(1.0_dp)))*map%frequency_ratio/(2*pi)
         if (present(sections)) sections(:, k) = state
         if (present(trend)) call trend%add(state)
      end do
      ! The same part for all, so that their sum stays the mean of the divergence.
      first = settled_part(growth(:, 1), map%frequency_ratio)
      if (present(trend)) trend%first = first
      do i = 1, size(exponents)
         call exponent_of(growth(first:, i), exponents(i), errors(i))
      end do
      ! They come out in order but for their uncertainty.
      do i = 1, size(exponents)
         largest = i - 1 + maxloc(exponents(i:), 1)
         if (largest == i) cycle
         exponents([i, largest]) = exponents([largest, i])
         errors([i, largest]) = errors([largest, i])
      end do
   end subroutine lyapunov_spectrum

   !> Makes vectors orthogonal and of length 1 one after another (Gram and Schmidt, twice); their lengths before that.
   pure subroutine orthogonalise(vectors, length)
      real(dp), intent(inout) :: vectors(:, :)
      real(dp), intent(out) :: length(:)
      integer :: i, j, pass

      do i = 1, size(vectors, 2)
         do pass = 1, 2
            do j = 1, i - 1
               vectors(:, i) = vectors(:, i) - dot_product(vectors(:, j), vectors(:, i))*vectors(:, j)
            end do
         end do
         length(i) = norm2(vectors(:, i))
         if (length(i) > 0) vectors(:, i) = vectors(:, i)/length(i)
      end do
   end subroutine orthogonalise

   !> Turns of the sections about their middle in a period of the fundamental, 0 to 1/2: where the motion is quasi-periodic, the
   !> distance of its second frequency over that of the fundamental from the nearest whole number; on a torus about a motion of
   !> period n, whose sections lie on n closed curves and go from one to the next, from the nearest multiple of 1/n, 0 to 1/(2n).
   !> Negative: the sections go round no point of any plane of displacement and velocity.
   pure real(dp) function rotation_number(system, sections) result(turns)
      type(system_type), intent(in) :: system
      !> Successive states at phase 0 [1], (state, period).
      real(dp), intent(in) :: sections(:, :)
      real(dp) :: own
      integer :: n

      turns = -1
      if (size(sections, 2) < fewest) return
      turns = turns_of(system, sections)
      if (.not. is_fraction(turns)) return
      ! The turns from one curve to the next. On each curve alone:
      do n = 2, min(most_curves, size(sections, 2)/fewest)
         own = turns_of(system, sections(:, ::n))
         if (is_fraction(own)) cycle
         turns = own/n
         return
      end do
      turns = -1

   contains

      !> Whether turns are of a small whole number of periods, or none.
      pure logical function is_fraction(turns)
         real(dp), intent(in) :: turns
         integer :: k

         is_fraction = turns < 0 .or. any([(abs(k*turns - nint(k*turns)) < fraction, k=1, most_curves)])
      end function is_fraction

   end function rotation_number

   !> Turns of the sections about the middle of their range, see `rotation_number`.
   !>
   !> The average has weights that are 0 with all derivatives at the ends, so that it converges faster than any power of the number
   !> of sections (Das and others, 2017).
   pure real(dp) function turns_of(system, sections) result(turns)
      type(system_type), intent(in) :: system
      real(dp), intent(in) :: sections(:, :)
      complex(dp) :: z(size(sections, 2)), steps(size(sections, 2) - 1), middle
      real(dp) :: round_, best, error
      integer :: j, n

      turns = -1
      best = roundness
      do j = 1, system%displacements
         n = size(sections, 2)
         z = cmplx(scaled(sections(j, :)), scaled(sections(system%displacements + j, :)), dp)
         if (.not. maxval(abs(z)) > 0) cycle
         round_ = minval(abs(z))/maxval(abs(z))
         if (.not. round_ > best) cycle
         best = round_
         steps = z(2:)/z(:n - 1)
         steps = steps/abs(steps)
         middle = sum(steps)
         if (.not. abs(middle) > 0) cycle
         middle = middle/abs(middle)
         call exponent_of(atan2(aimag(steps/middle), real(steps/middle, dp)), turns, error)
         turns = abs(turns + atan2(aimag(middle), real(middle, dp)))/(2*pi)
         turns = abs(turns - nint(turns))
      end do

   contains

      !> Values about the middle of their range, over half of it.
      pure function scaled(values)
         real(dp), intent(in) :: values(:)
         real(dp) :: scaled(size(values)), low, high

         low = minval(values)
         high = maxval(values)
         scaled = 0
         if (high > low) scaled = (2*values - low - high)/(high - low)
      end function scaled

   end function turns_of

end module geartrain_flow_spectrum
