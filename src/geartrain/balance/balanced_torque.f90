!> Torque of each shaft over a period of a harmonic balance: mean and extremes.
module geartrain_balance_balanced_torque
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_torus_extremes, only: find_torus_extremes
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: extremes, fine_samples, own_resolution
   use geartrain_network_receptance, only: amplitude_at, linear_displacements
   implicit none (type, external)
   private
   public :: alternating_forces, element_forces, find_shaft_torques, mean_forces, shaft_coefficients

contains

   !> Finds mean, minimum and maximum of each row of the torque paths, torques [N m] and forces of bearings [N], (row); NaN where
   !> nothing determines the torque.
   subroutine find_shaft_torques(balance, transform, mean, minimum, maximum, ac)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Planned for `fine_samples` of the harmonics of the balance, planned anew where it carries a set of harmonics; its samples
      !> are overwritten.
      type(transform_type), intent(inout) :: transform
      !> Torques [N m], positive where the first body of the shaft drives the second.
      real(dp), intent(out) :: mean(:), minimum(:), maximum(:)
      !> Root mean square without the mean.
      real(dp), intent(out) :: ac(:)
      real(dp) :: coefficients(balance%block, size(mean)), force(balance%block, balance%system%elements)
      integer :: s

      call element_forces(balance, force)
      call shaft_coefficients(balance, balance%harmonic, force, coefficients)
      mean = coefficients(1, :)
      ac = sqrt(sum(coefficients(2:, :)**2, 1)/2)
      do s = 1, size(mean)
         if (balance%system%torque_paths%known(s)) then
            if (balance%is_wound()) then
               call find_torus_extremes(balance%winding, coefficients(:, s), balance%harmonic, transform, minimum(s), maximum(s))
               cycle
            end if
            if (balance%chosen) call transform%plan(fine_samples(own_resolution(coefficients(:, s), balance%harmonic)))
            call extremes(coefficients(:, s), balance%harmonic, transform, minimum(s), maximum(s))
         else
            mean(s) = ieee_value(mean(s), ieee_quiet_nan)
            minimum(s) = mean(s)
            maximum(s) = mean(s)
         end if
      end do
   end subroutine find_shaft_torques

   !> Mean of phi of every element [1], (element). The displacement of a shaft is relative to its displacement at rest.
   pure subroutine mean_forces(balance, force)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The means; 0 for damping to ground.
      real(dp), intent(out) :: force(:)
      integer :: i

      associate (system => balance%system)
         do i = 1, system%elements
            force(i) = system%static_force(i) + system%spring(i)*system%mean%linear_displacement(system%cut, i, &
                                                                                                balance%force(1, :), &
                                                                                                system%static_force)
         end do
         force(system%cut%element) = balance%force(1, :)
      end associate
   end subroutine mean_forces

   !> Finds mean, cos and sin of each carried harmonic of phi of every element [1].
   pure subroutine element_forces(balance, force)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The coefficients, (block, element).
      real(dp), intent(out) :: force(:, :)
      real(dp) :: displacement(size(force, 1) - 1, size(force, 2))

      call mean_forces(balance, force(1, :))
      call alternating_forces(balance, balance%harmonic, balance%force(2:, :), force(2:, :), displacement)
   end subroutine element_forces

   !> Finds cos and sin of some harmonics of phi of every element, by the forces of the unknown meshes.
   pure subroutine alternating_forces(balance, harmonic, unknown, force, displacement)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The harmonics of Lambda/eta.
      integer, intent(in) :: harmonic(:)
      !> phi of the unknown meshes [1], (2*harmonic, unknown).
      real(dp), intent(in) :: unknown(:, :)
      !> phi, and displacements over b_c, 0 for unknown meshes [1], (2*harmonic, element).
      real(dp), intent(out) :: force(:, :), displacement(:, :)
      complex(dp) :: amplitude(balance%system%elements), phi(balance%unknowns)
      integer :: k

      associate (system => balance%system)
         do k = 1, size(harmonic)
            associate (r => harmonic(k))
               amplitude = 0
               phi = cmplx(unknown(2*k - 1, :), -unknown(2*k, :), dp)
               call linear_displacements(system, balance%frequency_ratio, r, balance%eta, phi, amplitude)
               displacement(2*k - 1, :) = amplitude%re
               displacement(2*k, :) = -amplitude%im
               amplitude = cmplx(system%spring, r*balance%frequency_ratio/balance%eta*system%damping, dp)*amplitude
               amplitude(system%cut%element) = phi
               force(2*k - 1, :) = amplitude%re
               force(2*k, :) = -amplitude%im
            end associate
         end do
      end associate
   end subroutine alternating_forces

   !> Finds the torque of each shaft [N m] and the forces of bearings [N] from the forces of the elements.
   pure subroutine shaft_coefficients(balance, harmonic, force, coefficients)
      !> The balance, last evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The harmonics of Lambda/eta.
      integer, intent(in) :: harmonic(:)
      !> Mean, cos and sin of each harmonic of phi of every element [1], (1 + 2*harmonic, element).
      real(dp), intent(in) :: force(:, :)
      !> The same of each row of the torque paths, or of the first ones, (1 + 2*harmonic, row).
      real(dp), intent(out) :: coefficients(:, :)
      complex(dp) :: total
      integer :: i, k, n, s

      associate (system => balance%system, paths => balance%system%torque_paths)
         do s = 1, size(coefficients, 2)
            coefficients(:, s) = 0
            coefficients(1, s) = paths%constant(s)
            do i = paths%first(s), paths%first(s + 1) - 1
               n = paths%element(i)
               coefficients(:, s) = coefficients(:, s) + paths%gain(i)*system%stiffness(n)*system%characteristic_length*force(:, n)
            end do
            do k = 1, size(harmonic)
               total = 0
               do i = paths%torque_first(s), paths%torque_first(s + 1) - 1
                  total = total + paths%torque_gain(i)*amplitude_at(system%torque(paths%torque(i)), harmonic(k), balance%eta)
               end do
               coefficients(2*k, s) = coefficients(2*k, s) + system%characteristic_length*total%re
               coefficients(2*k + 1, s) = coefficients(2*k + 1, s) - system%characteristic_length*total%im
            end do
         end do
      end associate
   end subroutine shaft_coefficients

end module geartrain_balance_balanced_torque
