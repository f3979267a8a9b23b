!> A balance that carries all harmonics of a motion. A set of harmonics that a branch chose may have some that `needed_harmonics`
!> leaves out.
module geartrain_balance_balance_of_motion
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repetitions_of
   use geartrain_base_kinds, only: dp
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: harmonics_of, setup_for_motion

   !> The harmonics of a motion are carried alone where the excitation reaches more than `many`, and the motion has less than this
   !> share of them.
   integer, parameter :: many = 1000
   real(dp), parameter :: small_share = 0.1_dp

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
   !> motion; where these are a small share, as of hunting teeth, the harmonics of the excitation and of the motion.
   subroutine setup_for_motion(balance, system, motion)
      type(balance_type), intent(inout) :: balance
      type(system_type), pointer, intent(in) :: system
      !> Periodic motion with coefficients.
      type(motion_type), intent(in) :: motion
      logical, allocatable :: carried(:)
      integer, allocatable :: own(:), excited(:)
      integer :: k, highest

      highest = max(1, (size(motion%coefficients, 1) - 1)/2)
      call balance%setup(system, highest, motion%period, 0, repeats=repetitions_of(system, motion))
      allocate (carried(highest), source=.false.)
      own = harmonics_of(motion)
      if (size(balance%harmonic) > many .and. size(own) < small_share*size(balance%harmonic)) then
         excited = motion%period*excited_harmonics(system)
         carried(pack(excited, excited <= highest)) = .true.
         carried(own) = .true.
      else
         carried(balance%harmonic) = .true.
         carried(own) = .true.
         if (count(carried) == size(balance%harmonic)) return
      end if
      call balance%setup(system, highest, motion%period, 0, pack([(k, k=1, highest)], carried), repetitions_of(system, motion))
   end subroutine setup_for_motion

end module geartrain_balance_balance_of_motion
