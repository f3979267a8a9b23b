!> Which symmetry a branch keeps to: branches of the train that move equally, or planets that move one after the other.
module geartrain_balance_symmetric_space
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_fixed_space, only: fixed_space_type
   use geartrain_balance_planet_turn, only: planet_turn_type
   use geartrain_base_kinds, only: dp
   use geartrain_network_equal_branches, only: equal_branches_type
   use geartrain_network_planet_symmetry, only: symmetry_type
   implicit none (type, external)
   private
   public :: find_symmetric_space, note_equal

contains

   !> Finds the symmetry of a motion.
   subroutine find_symmetric_space(balance, sets, symmetries, u, tangent, fixed, turn)
      !> The balance; notes which unknowns move alike.
      type(balance_type), intent(inout) :: balance
      !> Equal branches of the train.
      type(equal_branches_type), intent(in) :: sets(:)
      !> Planetary sets whose planets may move one after the other; not allocated: none.
      type(symmetry_type), allocatable, intent(in) :: symmetries(:)
      !> The motion, and a direction in which it is to be followed: coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), tangent(:, :)
      !> Which branches move equally.
      type(fixed_space_type), intent(inout) :: fixed
      !> Which planets move one after the other, where no branches move equally; on the torus of a winding those in phase as well.
      type(planet_turn_type), intent(out) :: turn

      ! On a winding planets in phase are found with the others.
      if (size(sets) > 0) call fixed%find(balance%system, sets(:merge(0, size(sets), balance%is_wound())), u, tangent)
      if (fixed%is_whole() .and. allocated(symmetries) .and. balance%waves() == 1 .and. balance%eta == 1) &
         call turn%find(balance%system, symmetries, balance%winding, balance%mesh, balance%harmonic, u, tangent)
      if (size(sets) > 0 .and. balance%is_wound() .and. .not. allocated(turn%orbit)) &
         call fixed%find(balance%system, sets, u, tangent)
      call note_equal(balance, fixed, turn)
   end subroutine find_symmetric_space

   !> Tells the balance which unknowns move equally.
   subroutine note_equal(balance, fixed, turn)
      !> The balance.
      type(balance_type), intent(inout) :: balance
      !> Which branches move equally.
      type(fixed_space_type), intent(in) :: fixed
      !> Which planets move one after the other.
      type(planet_turn_type), intent(in) :: turn
      integer :: i

      balance%equal = allocated(turn%orbit) .or. .not. fixed%is_whole()
      balance%independent = 0
      if (allocated(turn%orbit)) then
         balance%independent = count(turn%orbit == [(i, i=1, size(turn%orbit))])
      else if (fixed%joins()) then
         balance%independent = count(fixed%orbit == [(i, i=1, size(fixed%orbit))])
      end if
   end subroutine note_equal

end module geartrain_balance_symmetric_space
