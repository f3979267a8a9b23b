!> Fields of how the planets of planetary sets share the load.
module geartrain_flow_load_share_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: about_planet, carry_shares

   character(*), parameter :: about_planet = 'planet, set by set', with_sets = 'with planetary sets'
   type(row), parameter :: shares(2) = [ &
      row('load_share', 'planet', '1', 'mean force of the planet with the sun (ring, without a sun) over their sum in its set; &
          &NaN: no load', with_sets, optional=.true.), &
      row('load_share_maximum', 'planet', '1', 'as load_share, of the largest force', with_sets, optional=.true.)]

   !> Carries the fields of the load shares of the planets.
   interface carry_shares
      module procedure :: carry_shares_1, carry_shares_2
   end interface carry_shares

contains

   !> Load shares of a motion.
   subroutine carry_shares_1(fields, share, share_maximum)
      class(fields_type), intent(inout) :: fields
      !> Mean and largest share of each planet [1], (planet); not allocated: none.
      real(dp), allocatable, intent(inout) :: share(:), share_maximum(:)

      call carry(fields, shares(1), share)
      call carry(fields, shares(2), share_maximum)
   end subroutine carry_shares_1

   !> Load shares at each point of a branch.
   subroutine carry_shares_2(fields, share, share_maximum)
      class(fields_type), intent(inout) :: fields
      !> Mean and largest share of each planet [1], (planet, point); not allocated: none.
      real(dp), allocatable, intent(inout) :: share(:, :), share_maximum(:, :)
      type(row) :: about(2)

      about = shares
      about%dimensions = 'point planet'
      call carry(fields, about(1), share)
      call carry(fields, about(2), share_maximum)
   end subroutine carry_shares_2

end module geartrain_flow_load_share_fields
