!> A balance that carries all harmonics of a motion. A set of harmonics that a branch chose may have some that `needed_harmonics`
!> leaves out.
module geartrain_balance_balance_of_motion
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: harmonics_of, setup_for_motion

contains

   !> Harmonics that a motion has, ascending.
   pure function harmonics_of(motion) result(harmonic)
      !> Motion with coefficients.
      type(motion_type), intent(in) :: motion
      integer, allocatable :: harmonic(:)
      integer :: k, highest

      highest = (size(motion%coefficients, 1) - 1)/2
      harmonic = pack([(k, k=1, highest)], [(any(abs(motion%coefficients(2*k:2*k + 1, :)) > 0), k=1, highest)])
   end function harmonics_of

   !> Prepares a balance with exact coefficients. It carries the harmonics that the excitation reaches and all harmonics of the
   !> motion.
   subroutine setup_for_motion(balance, system, motion)
      type(balance_type), intent(inout) :: balance
      type(system_type), pointer, intent(in) :: system
      !> Periodic motion with coefficients.
      type(motion_type), intent(in) :: motion
      logical, allocatable :: carried(:)
      integer :: k, highest

      highest = max(1, (size(motion%coefficients, 1) - 1)/2)
      call balance%setup(system, highest, motion%period, 0, repeats=repetitions_of(system, motion))
      allocate (carried(highest), source=.false.)
      carried(balance%harmonic) = .true.
      carried(harmonics_of(motion)) = .true.
      if (count(carried) > size(balance%harmonic)) call balance%setup(system, highest, motion%period, 0, &
                                                                      pack([(k, k=1, highest)], carried), &
                                                                      repetitions_of(system, motion))
   end subroutine setup_for_motion

end module geartrain_balance_balance_of_motion
