!> The table of input variables, last part: the groups of a case file.
module geartrain_input_variables
   use geartrain_analyses_case, only: case_type
   use geartrain_analyses_stability_map_variables, only: visit_stability_map
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_continuation_variables, only: visit_response
   use geartrain_flow_variables, only: visit_attractors, visit_integration
   use geartrain_model_variables, only: visit_model
   implicit none (type, external)
   private
   public :: groups, visit_case, visit_modes, visit_output

   !> A group that a case file may hold.
   type :: group_row_type
      character(16) :: name = ''
      character(200) :: description = ''
   end type group_row_type

   type(group_row_type), parameter :: groups(*) = [ &
      group_row_type('train', 'The train as a whole. Once, first in the file.'), &
      group_row_type('body', 'A body that turns as one: a gear, a rotor. None in a chain; else one for each, and &shaft and &mesh &
                     &join them by name, in any order.'), &
      group_row_type('shaft', 'A shaft. In a chain M times, alternating with &mesh: shaft, mesh, ..., shaft; at least two.'), &
      group_row_type('mesh', 'A gear pair. In a chain M-1 times, each between two &shaft groups.'), &
      group_row_type('modes', 'Asks for undamped and damped natural frequencies and mode shapes of the mean system.'), &
      group_row_type('response', 'Asks for the branch of periodic motions over frequency, by harmonic balance.'), &
      group_row_type('integration', 'Asks for the steady motions that time integration settles on, over frequency.'), &
      group_row_type('attractors', 'Asks for the steady motions that random starts settle on at one frequency, and their &
                     &shares.'), &
      group_row_type('stability_map', 'Asks for the stability over frequency and one parameter of the train, a stability chart.'), &
      group_row_type('output', 'Where the results go.')]

contains

   !> All groups of a case, in the order of a case file.
   subroutine visit_case(case, visitor)
      type(case_type), intent(inout) :: case
      class(visitor_type), intent(inout) :: visitor

      call visit_model(case%train, visitor)
      if (case%modes) call visit_modes(visitor)
      if (allocated(case%response)) call visit_response(case%response, visitor)
      if (allocated(case%integration)) call visit_integration(case%integration, visitor)
      if (allocated(case%attractors)) call visit_attractors(case%attractors, visitor)
      if (allocated(case%stability_map)) call visit_stability_map(case%stability_map, visitor)
      call visit_output(case%output_file, visitor)
   end subroutine visit_case

   !> The group has no variables.
   subroutine visit_modes(v)
      class(visitor_type), intent(inout) :: v

      call v%enter('modes', 1)
      call v%leave()
   end subroutine visit_modes

   subroutine visit_output(file, v)
      character(:), allocatable, intent(inout) :: file
      class(visitor_type), intent(inout) :: v

      call v%enter('output', 1)
      call v%on_text(row('file', '', 'name of the HDF5 file, relative to the working directory; empty: the name of the case file &
                         &with .h5, in the working directory'), file)
      call v%leave()
   end subroutine visit_output

end module geartrain_input_variables
