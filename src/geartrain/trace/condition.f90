!> The equation beside the balance that picks one point of a branch: the point lies in a plane, or a mesh just separates there.
module geartrain_trace_condition
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: condition_type

   !> A linear condition, which the guess meets; those that extend it and vary override `evaluate`.
   type :: condition_type
      !> The gradient changes from point to point.
      logical :: varies = .false.
      !> What is to be 0 [1].
      real(dp) :: value = 0
      !> Its derivatives with respect to the coefficients of the unknown meshes over b_c, (block, unknown), and to Lambda.
      real(dp), allocatable :: row(:, :)
      real(dp) :: row_frequency = 0
   contains
      procedure :: evaluate
   end type condition_type

contains

   !> Finds the value and its derivatives: of a linear condition they stay as they are.
   subroutine evaluate(self, balance, u, frequency_ratio)
      class(condition_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Coefficients of the unknown meshes over b_c [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio

      associate (unused => balance, unused_u => u, unused_frequency => frequency_ratio)
      end associate
      self%value = 0
   end subroutine evaluate

end module geartrain_trace_condition
