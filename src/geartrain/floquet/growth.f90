!> How fast the slowest perturbation of a motion dies out, or the fastest grows, without its Floquet multipliers: over a part of the
!> period, where the period is that of hunting teeth and 30,000 mesh cycles long.
!>
!> Perturbations obey x' = A(theta_1, theta_2, ..) x with a phase for each mesh. After a time at which all meshes stand nearly where
!> they stood, the matrix of the perturbations is nearly exp(B time) in the coordinates of Floquet: the logarithms of its
!> eigenvalues over the time are the exponents, but for what the meshes lack of a whole number of cycles, over the time. The time is
!> doubled until it has every beat of two harmonics of the excitation and the largest exponent has changed by little beside its
!> distance from 0, twice or once by very little; at the whole period it is exact.
module geartrain_floquet_growth
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use geartrain_base_kinds, only: dp, pi
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_multipliers, only: neutral
   use geartrain_linalg_lapack, only: dgemm
   use geartrain_network_excitation, only: excited_harmonics, highest_order, nearest_return
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: find_growth, growth_type, shifted_rate

   !> Cycles of the fastest mesh in the first part, of which a quarter and half are kept; the part grows by two until its rate is
   !> sure.
   integer, parameter :: first_cycles = 32
   !> Cycles after which a rate that is not to be sure is left as it is, and any rate: the motion is next to neutral.
   integer, parameter :: rough_cycles = 128, most_cycles = 2048
   !> A part this share of the period is as well the whole.
   real(dp), parameter :: almost_whole = 0.6_dp
   !> Distance of a rate from 0, over its error, above which its sign is decided [1].
   real(dp), parameter :: surely = 4
   !> Change of the rate from the first part to the second, over the rate, below which no third is needed where the first has every
   !> beat; changes from a quarter to half of the first part and to the first, for no second; error of the rate then, over the rate.
   real(dp), parameter :: closely = 1e-4_dp, very_closely(2) = [6e-5_dp, 3e-5_dp], cautious = 0.01_dp

   type :: growth_type
      !> Real part of the largest Floquet exponent and its estimated error [1/dimensionless time]; NaN: interrupted.
      real(dp) :: rate = 0, error = 0
      !> The time over which it was found [1].
      real(dp) :: time = 0
      !> The error is small beside the rate, and determinants confirm the matrices.
      logical :: sure = .false.
   end type growth_type

contains

   !> Finds the growth rate of a motion.
   subroutine find_growth(monodromy, motion, frequency_ratio, growth, roughly, enough)
      !> Matrix of the perturbations, set up for the train.
      type(monodromy_type), intent(inout) :: monodromy
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> The rate.
      type(growth_type), intent(out) :: growth
      !> The motion is not known well enough for a verdict: a rate over `rough_cycles` is enough.
      logical, intent(in), optional :: roughly
      !> Error of the rate that is small enough, whether or not the sign is sure [1/dimensionless time]; absent: none is.
      real(dp), intent(in), optional :: enough
      real(dp) :: product(monodromy%states, monodromy%states), before(monodromy%states, monodromy%states)
      real(dp), allocatable :: early(:, :, :)
      real(dp) :: early_scale(2), early_time(2)
      real(dp) :: beat, change(2), mesh_cycle, log_scale, period, rate, scale, small, time
      integer :: n, cycles
      logical :: confirmed, rough

      rough = .false.
      if (present(roughly)) rough = roughly
      small = 0
      if (present(enough)) small = enough
      n = monodromy%states
      period = 2*pi*motion%eta/frequency_ratio/motion%repeats
      mesh_cycle = 2*pi/(frequency_ratio*highest_order(motion%system))
      beat = 2*pi*motion%eta/(frequency_ratio*slowest_beat(motion%system))
      log_scale = 0
      change = huge(change)
      confirmed = .true.
      cycles = first_cycles
      ! Earlier parts tell something only where the first one has every beat.
      if (.not. mesh_cycle*nearest_return(motion%system, first_cycles, first_cycles + first_cycles/2) < beat) then
         cycles = first_cycles/4
         allocate (early(n, n, 2))
      end if
      do while (growth%time < period)
         time = mesh_cycle*nearest_return(motion%system, cycles, cycles + cycles/2)
         if (time > almost_whole*period) time = period
         call monodromy%integrate_from(motion, frequency_ratio, growth%time, time - growth%time)
         confirmed = confirmed .and. monodromy%confirmed
         if (.not. growth%time > 0) then
            product = monodromy%transposed
         else
            before = product
            call dgemm('N', 'N', n, n, n, 1.0_dp, before, n, monodromy%transposed, n, 0.0_dp, product, n)
         end if
         ! No product of many parts leaves the range of numbers.
         scale = maxval(abs(product))
         if (scale > 0 .and. scale <= huge(scale)) then
            product = product/scale
            log_scale = log_scale + log(scale)
         end if
         monodromy%transposed = product
         if (cycles < first_cycles .and. time < period) then
            early = reshape([early(:, :, 2), product], [n, n, 2])
            early_scale = [early_scale(2), log_scale]
            early_time = [early_time(2), time]
            growth%time = time
            cycles = 2*cycles
            cycle
         end if
         rate = (log_largest(monodromy) + log_scale)/time
         if (cycles > first_cycles) change = [abs(rate - growth%rate), change(1)/2]
         if (cycles == 2*first_cycles .and. .not. growth%time < beat .and. change(1) < closely*abs(rate)) &
            change(2) = cautious*abs(rate)
         if (cycles == first_cycles .and. allocated(early)) then
            if (agrees_early()) change = cautious*abs(rate)
         end if
         if (.not. time < period) change = 0
         growth = growth_type(rate=rate, error=maxval(change) + neutral/time, time=time)
         growth%sure = confirmed .and. abs(rate) > surely*growth%error .and. .not. time < min(beat, period)
         if (growth%sure .or. ieee_is_nan(rate) .or. cycles >= merge(rough_cycles, most_cycles, rough)) exit
         if (growth%error < small .and. .not. time < beat) exit
         cycles = 2*cycles
      end do

   contains

      !> Whether the rates over half and a quarter of the first part are those of the first part.
      logical function agrees_early()
         real(dp) :: half, quarter

         monodromy%transposed = early(:, :, 2)
         half = (log_largest(monodromy) + early_scale(2))/early_time(2)
         agrees_early = abs(rate - half) < very_closely(2)*abs(rate)
         if (agrees_early) then
            monodromy%transposed = early(:, :, 1)
            quarter = (log_largest(monodromy) + early_scale(1))/early_time(1)
            agrees_early = abs(half - quarter) < very_closely(1)*abs(rate)
         end if
         monodromy%transposed = product
      end function agrees_early

   end subroutine find_growth

   !> The rate over the time of a growth, of a motion with other contact events [1/dimensionless time].
   real(dp) function shifted_rate(monodromy, motion, frequency_ratio, growth, shift)
      !> Matrix of the perturbations, set up for the train.
      type(monodromy_type), intent(inout) :: monodromy
      !> Contacts of the motion over its period.
      class(motion_contacts_type), intent(in) :: motion
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Growth of the motion as it is.
      type(growth_type), intent(in) :: growth
      !> What each contact event is moved by [rad], (event, unknown mesh).
      real(dp), intent(in) :: shift(:, :)

      call monodromy%integrate_from(motion, frequency_ratio, 0.0_dp, growth%time, shift)
      shifted_rate = log_largest(monodromy)/growth%time
   end function shifted_rate

   !> Logarithm of the largest eigenvalue of the latest matrix [1].
   real(dp) function log_largest(monodromy)
      type(monodromy_type), intent(inout) :: monodromy
      complex(dp) :: multipliers(monodromy%given)

      call monodromy%multipliers(multipliers)
      log_largest = log(max(abs(multipliers(1)), tiny(log_largest)))
   end function log_largest

   !> Least distance of two harmonics of the excitation, or of one from 0 [1]: one mesh cycle of 503 and one of 504 in a turn drift
   !> past one another once a turn, and stability with them.
   pure integer function slowest_beat(system)
      type(system_type), intent(in) :: system
      integer, allocatable :: harmonic(:)

      harmonic = excited_harmonics(system)
      slowest_beat = 1
      if (size(harmonic) > 0) slowest_beat = minval(harmonic - [0, harmonic(:size(harmonic) - 1)])
   end function slowest_beat

end module geartrain_floquet_growth
