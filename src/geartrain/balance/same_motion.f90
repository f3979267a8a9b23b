!> Whether two motions are equal: by their figures, their coefficients or their states.
module geartrain_balance_same_motion
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: is_same_motion

   !> Largest difference of two equal motions over the largest displacement, coefficient or coordinate of the state [1]. Newton's
   !> method and the flow give a motion to 1e-9 or better; the motions of two branches at one Lambda are farther apart, except
   !> next to the bifurcation at which the branches meet.
   real(dp), parameter :: tolerance = 1e-6_dp

   !> Two motions of equal Lambda and period.
   interface is_same_motion
      module procedure :: same_figures, same_coefficients, same_state
   end interface is_same_motion

contains

   !> Compares rms, mean and maximum, which a shift of a motion by some periods of the fundamental does not change.
   pure logical function same_figures(one, other, uncertainty) result(same)
      !> Motions with figures.
      type(motion_type), intent(in) :: one, other
      !> Relative error of the motions, where it may be larger than the tolerance [1]; 0 unless it is given.
      real(dp), intent(in), optional :: uncertainty
      real(dp) :: allowed

      allowed = allowed_difference(uncertainty)*max(maxval(abs(one%maximum)), maxval(abs(one%minimum)))
      same = all(abs(one%rms - other%rms) <= allowed .and. abs(one%mean - other%mean) <= allowed &
                 .and. abs(one%maximum - other%maximum) <= allowed)
   end function same_figures

   !> Compares Fourier coefficients.
   pure logical function same_coefficients(one, other, uncertainty) result(same)
      !> Mesh displacements over characteristic length [1], (coefficient, mesh).
      real(dp), intent(in) :: one(:, :), other(:, :)
      !> Relative error of the motions, where it may be larger than the tolerance [1]; 0 unless it is given.
      real(dp), intent(in), optional :: uncertainty

      same = maxval(abs(one - other)) <= allowed_difference(uncertainty)*maxval(abs(one))
   end function same_coefficients

   !> Compares states.
   pure logical function same_state(one, other) result(same)
      !> States at phase 0 [1], (state).
      real(dp), intent(in) :: one(:), other(:)

      same = maxval(abs(one - other)) <= tolerance*maxval(abs(one))
   end function same_state

   !> Relative difference up to which motions are equal [1].
   pure real(dp) function allowed_difference(uncertainty)
      real(dp), intent(in), optional :: uncertainty

      allowed_difference = tolerance
      if (present(uncertainty)) allowed_difference = tolerance + uncertainty
   end function allowed_difference

end module geartrain_balance_same_motion
