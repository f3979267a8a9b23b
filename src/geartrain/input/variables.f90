!> The table of input variables: the list of groups of a case file, the group &output, and the visit of all groups.
module geartrain_input_variables
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_train_train_variables, only: visit_model
   implicit none (type, external)
   private
   public :: groups, visit_case, visit_output

   type(group_row_type), parameter :: groups(*) = [ &
      group_row_type('train', 'The train as a whole: one group, first in the file.'), &
      group_row_type('body', 'A body that turns as one: a gear, a rotor. A chain has none; in other trains &shaft and &mesh join &
         &bodies by name, in any order.'), &
      group_row_type('planetary', 'A planetary set: a short form of bodies, its planets, and of their meshes with sun and ring, &
         &in place of which it stands.'), &
      group_row_type('shaft', 'A shaft. A chain lists &shaft and &mesh in turn from motor to load: shaft, mesh, ..., mesh, &
         &shaft.'), &
      group_row_type('mesh', 'A gear pair. In a chain each &mesh stands between two &shaft.'), &
      group_row_type('coupling', 'A torsional coupling with play or in stages, as a spline or a clutch damper. In trains with &
         &bodies only.'), &
      group_row_type('bearing', 'A bearing of a body, which then moves in its transverse plane as well as it turns. In trains with &
         &bodies only.'), &
      analyses, &
      group_row_type('output', 'Where the results go.')]

contains

   !> Leads a visitor over all groups of a case, in the order of a case file.
   subroutine visit_case(case, visitor)
      !> The case; set by a visitor that reads.
      type(case_type), intent(inout), target :: case
      !> The visitor.
      class(visitor_type), intent(inout) :: visitor
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      call visit_model(case%train, visitor)
      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis)
         if (analysis%asked) call analysis%visit_variables(visitor)
      end do
      call visit_output(case%output_file, visitor)
   end subroutine visit_case

   !> Leads a visitor over the variables of &output.
   subroutine visit_output(file, v)
      !> Name of the results file; set by a visitor that reads.
      character(:), allocatable, intent(inout) :: file
      !> The visitor.
      class(visitor_type), intent(inout) :: v

      call v%enter('output', 1)
      call v%on_text(row('file', '', 'name of the HDF5 file, relative to the working directory; blank: the name of the case file &
                         &with .h5'), file)
      call v%leave()
   end subroutine visit_output

end module geartrain_input_variables
