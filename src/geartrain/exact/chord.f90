!> The chord between two orbits and their tangents: whether both orbits are of one curve, which may have a corner between them.
module geartrain_exact_chord
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: tangents_meet

   !> Distance of the chord from the plane of both tangents, over its length, at most; square of the sine of the angle between the
   !> tangents below which they count as parallel [1].
   real(dp), parameter :: passing = 0.1_dp, parallel = 1e-2_dp

contains

   !> Whether the tangents at the ends of a chord nearly meet between them. The tangents of one curve do, also where it has a
   !> corner; the tangents of different branches pass each other.
   pure logical function tangents_meet(weight, frequency_unit, chord, chord_frequency, first, first_frequency, last, last_frequency)
      !> Metric of the states, (state, section); unit of Lambda in it [1].
      real(dp), intent(in) :: weight(:, :), frequency_unit
      !> The chord: states (state, section), and Lambda.
      real(dp), intent(in) :: chord(:, :), chord_frequency
      !> Tangent at its beginning: states (state, section), and Lambda.
      real(dp), intent(in) :: first(:, :), first_frequency
      !> Tangent at its end: states (state, section), and Lambda.
      real(dp), intent(in) :: last(:, :), last_frequency
      real(dp) :: length, a, b, c, one, other, apart, ahead, back, left

      length = sum(weight*chord**2) + (chord_frequency/frequency_unit)**2
      one = sum(weight*first**2) + (first_frequency/frequency_unit)**2
      other = sum(weight*last**2) + (last_frequency/frequency_unit)**2
      a = sum(weight*chord*first) + chord_frequency*first_frequency/frequency_unit**2
      b = sum(weight*chord*last) + chord_frequency*last_frequency/frequency_unit**2
      c = sum(weight*first*last) + first_frequency*last_frequency/frequency_unit**2
      apart = one*other - c**2
      if (apart > parallel*one*other) then
         ! Least squares: the chord is `ahead` along the first tangent and `back` along the last one.
         ahead = (other*a - c*b)/apart
         back = (one*b - c*a)/apart
         left = length - ahead*a - back*b
         tangents_meet = ahead > 0 .and. back > 0
      else
         tangents_meet = a > 0
         left = length
         if (one > 0) left = length - a**2/one
      end if
      tangents_meet = tangents_meet .and. left < passing**2*length
   end function tangents_meet

end module geartrain_exact_chord
