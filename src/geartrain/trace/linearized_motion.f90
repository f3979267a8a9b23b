!> A motion as a solution of the balance with its own harmonics, and dS/du there, bordered and factored.
module geartrain_trace_linearized_motion
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balance_of_motion, only: harmonics_of, setup_for_motion
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_needed_harmonics, only: needed_harmonics
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: evaluate, fine_samples, next_maximum, sample
   use geartrain_network_gradient, only: sides_type
   use geartrain_network_system, only: system_type
   use geartrain_network_units, only: units_of
   use geartrain_trace_corrector, only: corrector_type, solution_point_type
   implicit none (type, external)
   private
   public :: factor, grazes, prepare, prepare_balance, residual_rate, solution_on, step_of_residual

   !> Carried harmonics up to which the matrix is eliminated as a whole.
   integer, parameter :: most_explicit = 128
   !> Distance of an extreme from a wall, relative to the amplitude, below which the motion grazes.
   real(dp), parameter :: at_wall = 1e-7_dp
   !> Change of a parameter over its value for differences of a residual at the same contact events: the error by resonances is
   !> 1e-11, that by rounding too.
   real(dp), parameter :: step_of_residual = 3e-5_dp

contains

   !> Plans the balance with the harmonics of a motion.
   subroutine prepare(corrector, system, motion)
      !> Gets the balance.
      type(corrector_type), intent(inout) :: corrector
      type(system_type), pointer, intent(in) :: system
      !> A periodic motion with its coefficients.
      type(motion_type), intent(in) :: motion

      corrector%units = units_of(system)
      call prepare_balance(corrector%balance, system, motion)
      call corrector%setup()
   end subroutine prepare

   !> Plans a balance with the harmonics of a motion.
   subroutine prepare_balance(balance, system, motion)
      type(balance_type), intent(inout) :: balance
      type(system_type), pointer, intent(in) :: system
      !> A periodic motion with its coefficients.
      type(motion_type), intent(in) :: motion
      integer, allocatable :: carried(:)
      integer :: highest, repeats

      highest = max(1, (size(motion%coefficients, 1) - 1)/2)
      carried = harmonics_of(motion)
      repeats = repetitions_of(system, motion)
      ! Of many harmonics only those that the motion has: the rest of a set is not carried.
      if (size(carried) > 0 .and. motion%period == 1 .and. repeats == system%excitation_order .and. &
          size(needed_harmonics(system, highest)) > most_explicit) then
         call balance%setup(system, highest, motion%period, 0, carried, repeats)
      else
         call setup_for_motion(balance, system, motion)
      end if
   end subroutine prepare_balance

   !> A motion as a guess of a solution on the harmonics of a balance.
   function solution_on(balance, motion) result(solution)
      type(balance_type), intent(in) :: balance
      !> A periodic motion with its coefficients.
      type(motion_type), intent(in) :: motion
      type(solution_point_type) :: solution
      integer :: k

      allocate (solution%u(balance%block, balance%unknowns), source=0.0_dp)
      solution%frequency_ratio = motion%frequency_ratio
      solution%u(1, :) = motion%coefficients(1, balance%mesh)
      do k = 1, size(balance%harmonic)
         associate (r => balance%harmonic(k))
            if (2*r < size(motion%coefficients, 1)) solution%u(2*k:2*k + 1, :) = motion%coefficients(2*r:2*r + 1, balance%mesh)
         end associate
      end do
   end function solution_on

   !> Evaluates the balance and factors dS/du, bordered.
   subroutine factor(corrector, solution, row, corner, regular)
      !> After `prepare`.
      type(corrector_type), intent(inout) :: corrector
      !> Where.
      type(solution_point_type), intent(in) :: solution
      !> The border: row, (block, unknown), and corner.
      real(dp), intent(in) :: row(:, :), corner
      !> The matrix is not singular.
      logical, intent(out) :: regular

      associate (balance => corrector%balance, matrix => corrector%matrix)
         call balance%evaluate(solution%u, solution%frequency_ratio)
         if (size(balance%harmonic) <= most_explicit) call balance%make_explicit(size(balance%harmonic))
         call matrix%linearize(balance)
         matrix%row = row
         matrix%corner = corner
         call matrix%factor(balance, regular)
      end associate
   end subroutine factor

   !> Derivative of the residual with respect to a parameter, at constant coefficients and Lambda.
   subroutine residual_rate(balance, at, sides, solution, s)
      !> A balance after `prepare_balance`; afterwards of another train.
      type(balance_type), intent(inout) :: balance
      !> The balance of the train, evaluated at the motion.
      type(balance_type), intent(in) :: at
      !> The trains beside the train, with a step of `step_of_residual`.
      type(sides_type), target, intent(in) :: sides
      !> Where.
      type(solution_point_type), intent(in) :: solution
      !> The derivative [1/unit of the parameter], (block, unknown).
      real(dp), intent(out) :: s(:, :)
      type(system_type), pointer :: side
      integer :: i

      s = 0
      do i = 1, size(sides%system)
         side => sides%system(i)
         call balance%take(side, at)
         call balance%evaluate(solution%u, solution%frequency_ratio)
         s = s + sides%weight(i)*balance%residual
      end do
   end subroutine residual_rate

   !> Whether an extreme of a displacement lies on a wall.
   logical function grazes(balance, u)
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Coefficients [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      type(transform_type) :: transform
      real(dp) :: theta, p, slope, curvature, range
      integer :: i, q, side, step

      grazes = .false.
      do i = 1, balance%unknowns
         range = norm2(u(2:, i))
         if (balance%contact(i)%clearance() > 0.1_dp*range) cycle
         call transform%plan(fine_samples(maxval([1, balance%harmonic])))
         call sample(u(:, i), balance%harmonic, transform)
         do side = -1, 1, 2
            q = 0
            do
               call next_maximum(transform%sample, side, -huge(1.0_dp), q, theta)
               if (q == 0) exit
               do step = 1, 8
                  call evaluate(u(:, i), balance%harmonic, theta, p, slope, curvature)
                  if (.not. abs(curvature) > 0) exit
                  theta = theta - max(-0.1_dp, min(0.1_dp, slope/curvature))
               end do
               grazes = grazes .or. any(abs(p - balance%contact(i)%law%wall) < at_wall*range)
            end do
         end do
      end do
   end function grazes

end module geartrain_trace_linearized_motion
