!> Largest values of a motion whose balance has a winding, over all phases of the sources of excitation.
!>
!> Where the teeth stand as they stood only after thousands of cycles, nearly all phases come together within the period, and the
!> period itself is an accident of the ratios. Displacements and forces are functions on the torus of the phases: the highest maxima
!> along the winding lie beside those of the torus, from where Newton's method finds the tops.
module geartrain_balance_torus_extremes
   use geartrain_balance_winding, only: winding_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_sorting, only: ascending
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: fine_samples, own_resolution, sample
   use geartrain_mesh_law_law, only: law_type
   implicit none (type, external)
   private
   public :: find_torus_extremes, torus_force_top

   !> Maxima of the samples that are climbed from; depth below the highest, over the range of the samples, down to which they are.
   integer, parameter :: most_climbed = 16
   real(dp), parameter :: deepest = 0.1_dp
   !> Steps of Newton's method; largest change of a harmonic's phase in one [rad]; gain of a step, over the range, that ends it.
   integer, parameter :: most_steps = 20
   real(dp), parameter :: longest = 1, least_gain = 1e-10_dp
   !> Gain over the one that a step expects that the rest of a climb may have.
   real(dp), parameter :: generous = 30
   integer, parameter :: most_phases = 4

   !> One or two sums of the same waves on the torus, of Re(amplitude exp(i numbers . phases)).
   type :: torus_waves_type
      !> Numbers of the waves, (source, wave).
      integer, allocatable :: numbers(:, :)
      !> Amplitudes, (wave, sum), and means, (sum).
      complex(dp), allocatable :: amplitude(:, :)
      real(dp) :: mean(2) = 0
   end type torus_waves_type

   !> Value, gradient and second derivatives of a function on the torus.
   type :: value_type
      real(dp) :: f = 0, g(most_phases) = 0, h(most_phases, most_phases) = 0
   end type value_type

contains

   !> Waves of a displacement, if asked for with its derivative with respect to theta as the second sum.
   pure function torus_waves(winding, u, harmonic, sums) result(waves)
      type(winding_type), intent(in) :: winding
      !> Coefficients, (coefficient).
      real(dp), intent(in) :: u(:)
      !> Harmonics of Lambda, all of which have places.
      integer, intent(in) :: harmonic(:)
      !> 1 or 2.
      integer, intent(in) :: sums
      type(torus_waves_type) :: waves
      integer :: k

      allocate (waves%numbers(winding%sources(), size(harmonic)), waves%amplitude(size(harmonic), sums))
      waves%mean = [u(1), 0.0_dp]
      do k = 1, size(harmonic)
         waves%numbers(:, k) = winding%numbers_of(harmonic(k))
         waves%amplitude(k, 1) = cmplx(u(2*k), -u(2*k + 1), dp)
         if (sums == 2) waves%amplitude(k, 2) = cmplx(0, harmonic(k), dp)*waves%amplitude(k, 1)
      end do
   end function torus_waves

   !> Finds the extremes of a displacement or a torque.
   subroutine find_torus_extremes(winding, u, harmonic, transform, smallest, largest)
      type(winding_type), intent(in) :: winding
      !> Coefficients, (coefficient).
      real(dp), intent(in) :: u(:)
      !> Harmonics of Lambda, all of which have places.
      integer, intent(in) :: harmonic(:)
      !> Work space, planned anew.
      type(transform_type), intent(inout) :: transform
      !> Extremes, in the unit of u.
      real(dp), intent(out) :: smallest, largest
      type(torus_waves_type) :: waves

      call transform%plan(fine_samples(winding%shortened(own_resolution(u, harmonic))))
      call sample(u, winding%place_of(harmonic), transform)
      waves = torus_waves(winding, u, harmonic, 1)
      largest = top_of(winding, transform%sample, 1, waves)
      smallest = -top_of(winding, transform%sample, -1, waves)
   end subroutine find_torus_extremes

   !> Largest value of side*phi of a mesh between contact events [1].
   pure real(dp) function torus_force_top(winding, force, side, u, harmonic, law, frequency_ratio) result(top)
      type(winding_type), intent(in) :: winding
      !> Samples of phi along the winding [1].
      real(dp), intent(in) :: force(:)
      !> +1 or -1.
      integer, intent(in) :: side
      !> Coefficients of the displacement over b_c [1], (coefficient).
      real(dp), intent(in) :: u(:)
      !> Harmonics of Lambda, all of which have places.
      integer, intent(in) :: harmonic(:)
      !> Force law of the mesh.
      type(law_type), intent(in) :: law
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio

      top = top_of(winding, force, side, torus_waves(winding, u, harmonic, 2), law, frequency_ratio)
   end function torus_force_top

   !> Largest value of side*f on the torus, f by its waves, or the force by a law that they make.
   pure real(dp) function top_of(winding, values, side, waves, law, frequency_ratio) result(top)
      type(winding_type), intent(in) :: winding
      !> Samples of f along the winding.
      real(dp), intent(in) :: values(:)
      integer, intent(in) :: side
      type(torus_waves_type), intent(in) :: waves
      type(law_type), intent(in), optional :: law
      real(dp), intent(in), optional :: frequency_ratio
      integer, allocatable :: maxima(:), own(:, :)
      real(dp) :: range
      integer :: k, n, q

      n = size(values)
      top = maxval(side*values)
      range = maxval(values) - minval(values)
      if (.not. range > 0) return
      if (present(law)) then
         ! Harmonics without a place have no amplitude.
         allocate (own(winding%sources(), size(law%harmonic)), source=0)
         do k = 1, size(law%harmonic)
            if (winding%place_of(law%harmonic(k)) > 0) own(:, k) = winding%numbers_of(law%harmonic(k))
         end do
      end if
      maxima = pack([(q, q=1, n)], side*values >= top - deepest*range .and. side*values >= side*cshift(values, -1) &
                    .and. side*values > side*cshift(values, 1))
      maxima = maxima(ascending(-side*values(maxima)))
      do k = 1, min(size(maxima), most_climbed)
         call climb(winding%phases_at(maxima(k) - 1, n))
      end do

   contains

      !> Raises `top` to the top next to a place.
      pure subroutine climb(start)
         real(dp), intent(in) :: start(:)
         real(dp) :: phase(size(start)), step(size(start)), fastest(size(start)), gain
         type(value_type) :: value
         integer :: i, region

         phase = start
         fastest = [(real(maxval([1, abs(waves%numbers(i, :))]), dp), i=1, size(start))]
         region = 0
         do i = 1, most_steps
            call find_value(phase, i == 1, region, value)
            if (present(law)) then
               ! Where the law is another one the force has a kink, which is no maximum.
               if (region < law%lowest) return
            end if
            top = max(top, side*value%f)
            call find_step(side*value%g(:size(start)), -side*value%h(:size(start), :size(start)), step)
            step = step*min(1.0_dp, longest/max(maxval(abs(step)*fastest), tiny(longest)))
            gain = dot_product(side*value%g(:size(start)), step)/2
            if (.not. gain > least_gain*range) return
            if (side*value%f + generous*gain < top) return
            phase = phase + step
         end do
      end subroutine climb

      !> f and its derivatives; of a force in a region of the law, that at the first place. Region below all: it is left.
      pure subroutine find_value(phase, first, region, value)
         real(dp), intent(in) :: phase(:)
         logical, intent(in) :: first
         integer, intent(inout) :: region
         type(value_type), intent(out) :: value
         type(value_type) :: p(2), kappa, offset
         real(dp) :: damping
         integer :: i

         p = sums(waves%numbers, waves%amplitude, waves%mean, phase)
         value = p(1)
         if (.not. present(law)) return
         if (first) region = law%region_at(p(1)%f)
         if (region /= law%region_at(p(1)%f)) region = law%lowest - 1
         if (region < law%lowest) return
         kappa = one_sum(own, law%amplitude(:, region), law%stiffness(region), phase)
         p(1)%f = p(1)%f - law%origin(region)
         damping = law%damping(region)*frequency_ratio
         value%f = kappa%f*p(1)%f + damping*p(2)%f
         value%g = kappa%g*p(1)%f + kappa%f*p(1)%g + damping*p(2)%g
         do i = 1, most_phases
            value%h(:, i) = kappa%h(:, i)*p(1)%f + kappa%g*p(1)%g(i) + kappa%g(i)*p(1)%g + kappa%f*p(1)%h(:, i) &
                            + damping*p(2)%h(:, i)
         end do
         if (.not. allocated(law%offset)) return
         offset = one_sum(own, law%offset(:, region), 0.0_dp, phase)
         value%f = value%f + offset%f
         value%g = value%g + offset%g
         value%h = value%h + offset%h
      end subroutine find_value

   end function top_of

   !> Values of one or two sums of the same waves.
   pure function sums(numbers, amplitude, mean, phase) result(value)
      integer, intent(in) :: numbers(:, :)
      complex(dp), intent(in) :: amplitude(:, :)
      real(dp), intent(in) :: mean(2), phase(:)
      type(value_type) :: value(2)
      real(dp) :: k(size(phase)), angle
      complex(dp) :: z, term
      integer :: i, j, n, w

      n = size(phase)
      value(:)%f = mean
      do w = 1, size(numbers, 2)
         k = numbers(:, w)
         angle = dot_product(k, phase)
         z = cmplx(cos(angle), sin(angle), dp)
         do j = 1, size(amplitude, 2)
            term = amplitude(w, j)*z
            associate (value => value(j))
               value%f = value%f + term%re
               value%g(:n) = value%g(:n) - k*term%im
               do i = 1, n
                  value%h(:n, i) = value%h(:n, i) - k*k(i)*term%re
               end do
            end associate
         end do
      end do
   end function sums

   !> Value of one sum of waves.
   pure type(value_type) function one_sum(numbers, amplitude, mean, phase) result(value)
      integer, intent(in) :: numbers(:, :)
      complex(dp), intent(in) :: amplitude(:)
      real(dp), intent(in) :: mean, phase(:)
      type(value_type) :: both(2)

      both = sums(numbers, reshape(amplitude, [size(amplitude), 1]), [mean, 0.0_dp], phase)
      value = both(1)
   end function one_sum

   !> Newton's step to a maximum; where the second derivatives are those of none, a step upwards.
   pure subroutine find_step(slope, fall, step)
      !> Gradient, and second derivatives with the other sign.
      real(dp), intent(in) :: slope(:), fall(:, :)
      real(dp), intent(out) :: step(:)
      real(dp) :: factor(size(slope), size(slope)), shift, scale
      integer :: i, j, n
      logical :: regular

      n = size(slope)
      scale = maxval(abs(fall))
      shift = 1e-9_dp*scale
      do
         factor = fall
         regular = .true.
         do j = 1, n
            factor(j, j) = factor(j, j) + shift - sum(factor(j, :j - 1)**2)
            regular = regular .and. factor(j, j) > 1e-3_dp*shift
            if (.not. regular) exit
            factor(j, j) = sqrt(factor(j, j))
            do i = j + 1, n
               factor(i, j) = (factor(i, j) - dot_product(factor(i, :j - 1), factor(j, :j - 1)))/factor(j, j)
            end do
         end do
         if (regular) exit
         step = 0
         if (.not. scale > 0 .or. shift > 10*scale) return
         shift = max(0.01_dp*scale, 4*shift)
      end do
      step = slope
      do j = 1, n
         step(j) = (step(j) - dot_product(factor(j, :j - 1), step(:j - 1)))/factor(j, j)
      end do
      do j = n, 1, -1
         step(j) = (step(j) - dot_product(factor(j + 1:, j), step(j + 1:)))/factor(j, j)
      end do
   end subroutine find_step

end module geartrain_balance_torus_extremes
