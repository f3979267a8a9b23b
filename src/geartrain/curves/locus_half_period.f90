!> Where the curve of folds of motions of an even period meets motions of half the period, at a doubling of these.
module geartrain_curves_locus_half_period
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   implicit none (type, external)
   private
   public :: change_after_half, is_of_half, passes_half, way_to_half

   !> Change of a motion after half its period, over the units of length and speed, below which it is a motion of half the period.
   real(dp), parameter :: unchanged = 1e-3_dp

contains

   !> Whether a fold is one of motions of half the period, traversed twice.
   pure logical function is_of_half(augmented, point)
      !> The system.
      type(augmented_system_type), intent(in) :: augmented
      !> A fold.
      type(augmented_point_type), intent(in) :: point
      real(dp) :: change(size(point%states, 1), size(point%states, 2)/2)

      is_of_half = .false.
      if (mod(augmented%period, 2) /= 0) return
      change = change_after_half(point%states)
      associate (units => augmented%metric%units, n => augmented%system%displacements)
         is_of_half = maxval(abs(change(:n, :))) < unchanged*units%length .and. &
                      maxval(abs(change(n + 1:, :))) < unchanged*units%length*units%frequency_ratio
      end associate
   end function is_of_half

   !> Whether a step along the curve passes such a fold: beyond it are the same motions half a period later.
   pure logical function passes_half(augmented, here, next)
      !> The system.
      type(augmented_system_type), intent(in) :: augmented
      !> The points at both ends of the step.
      type(augmented_point_type), intent(in) :: here, next

      passes_half = .false.
      if (augmented%kind /= 'fold' .or. mod(augmented%period, 2) /= 0) return
      passes_half = sum(change_after_half(here%states)*change_after_half(next%states)) <= 0 .or. &
                    is_of_half(augmented, next) .and. abs(way_to_half(here)) < 2*augmented%metric%distance(here, next)
   end function passes_half

   !> Way along the tangent after which the motion is one of half the period.
   pure real(dp) function way_to_half(point)
      !> A fold of an even period, with its tangent.
      type(augmented_point_type), intent(in) :: point
      real(dp), dimension(size(point%states, 1), size(point%states, 2)/2) :: change, rate

      change = change_after_half(point%states)
      rate = change_after_half(point%tangent)
      way_to_half = -sum(change*rate)/max(sum(rate**2), tiny(1.0_dp))
   end function way_to_half

   !> Changes after half the period, (state, section of the first half).
   pure function change_after_half(states) result(change)
      !> States, or a tangent, (state, section).
      real(dp), intent(in) :: states(:, :)
      real(dp) :: change(size(states, 1), size(states, 2)/2)

      change = states(:, size(change, 2) + 1:) - states(:, :size(change, 2))
   end function change_after_half

end module geartrain_curves_locus_half_period
