!> The field of the free parameter of a branch: of Lambda or, of a branch over a parameter of the train, of its value.
module geartrain_trace_free_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing
   use geartrain_base_kinds, only: dp
   use geartrain_flow_motion_fields, only: about_frequency
   use geartrain_trace_branch, only: branch_type
   implicit none (type, external)
   private
   public :: about_ends, carry_free, free_name, free_unit

   character(*), parameter :: about_ends = 'Lambda, or value of the parameter'

contains

   !> Name of the fields of the free parameter.
   pure function free_name(branch) result(name)
      type(branch_type), intent(in) :: branch
      character(9) :: name

      name = 'frequency'
      if (allocated(branch%parameter)) name = 'parameter'
   end function free_name

   !> Unit of the free parameter.
   pure function free_unit(branch) result(unit)
      type(branch_type), intent(in) :: branch
      character(12) :: unit

      unit = '1'
      if (allocated(branch%parameter_unit)) unit = branch%parameter_unit
   end function free_unit

   !> Visits the value of the free parameter at a place on a branch.
   subroutine carry_free(branch, fields, value)
      type(branch_type), intent(in) :: branch
      !> The fields of the results, at an item of a list.
      class(fields_type), intent(inout) :: fields
      !> The value [1, or unit of the parameter].
      real(dp), intent(inout) :: value
      character(12) :: unit

      unit = free_unit(branch)
      if (fields%way == listing) unit = ''
      if (fields%way == listing .or. .not. allocated(branch%parameter)) &
         call carry(fields, row('frequency', '', '1', about_frequency), value)
      if (fields%way == listing .or. allocated(branch%parameter)) &
         call carry(fields, row('parameter', '', unit, 'value of the parameter in its unit, in place of `frequency`', &
                                'with `parameter`'), value)
   end subroutine carry_free

end module geartrain_trace_free_fields
