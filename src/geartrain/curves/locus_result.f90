!> The curve of a special point over Lambda and a parameter of the train, as it is traced.
module geartrain_curves_locus_result
   use geartrain_base_kinds, only: dp
   use geartrain_base_words, only: words_type
   implicit none (type, external)
   private
   public :: double_point_type, locus_type

   !> A point of the curve at which two conditions meet.
   type :: double_point_type
      character(24) :: kind = ''
      !> Lambda [1], parameter [its unit].
      real(dp) :: frequency_ratio = 0, parameter = 0
      !> Number of the point of the curve before the special point.
      integer :: point = 0
   end type double_point_type

   type :: locus_type
      !> Kind of the special point, and of a contact onset the number of the mesh.
      character(16) :: kind = ''
      integer :: mesh = 0
      !> Name of the parameter, its unit.
      character(:), allocatable :: name, unit
      !> Period of the motions [periods of the fundamental].
      integer :: period = 1
      !> Lambda of the special point with which it began [1].
      real(dp) :: start_frequency = 0
      !> Lambda [1], parameter [its unit], (point); state of the motion [1], (state, point); its multipliers, (state, point).
      real(dp), allocatable :: frequency_ratio(:), parameter(:), state(:, :)
      complex(dp), allocatable :: multipliers(:, :)
      type(double_point_type), allocatable :: special_points(:)
      !> Why it ended at its first and at its last point: 'range', 'closed', 'corner' where the motion grazes a wall of a gap,
      !> 'double point', 'limit' of what is followed, 'symmetry' which the parameter breaks, 'cancelled', 'failed', (side).
      character(16), allocatable :: ends(:)
      !> Share of the range of the parameter covered so far on either side [1], (side); no result.
      real(dp) :: covered(2) = 0
      !> Why it ended on either side, in words; whether it got to the ends of the range, or closed; whether it closed.
      type(words_type), allocatable :: ended
      logical :: complete = .false., closed = .false.
   end type locus_type

end module geartrain_curves_locus_result
