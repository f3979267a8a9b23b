!> The list of analyses, over which all loops go that read, check, run, write or report cases. A new analysis is registered here: a
!> row of `analyses`, a component of case_type, a component of results_type, and its lines in find_analysis and leave_out.
module geartrain_analyses_list
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_attractors, only: attractors_analysis_type, attractors_row, attractors_settings_type, attractors_type
   use geartrain_analyses_basin_grid, only: basins_settings_type, basins_type
   use geartrain_analyses_basins, only: basins_analysis_type, basins_row
   use geartrain_analyses_bifurcation_diagram, only: bifurcation_diagram_analysis_type, bifurcation_diagram_row, &
      bifurcation_diagram_settings_type, bifurcation_diagram_type
   use geartrain_analyses_integration, only: integration_analysis_type, integration_row, sweep_type
   use geartrain_analyses_locus, only: locus_analysis_type, locus_row, locus_settings_type
   use geartrain_analyses_modes, only: modes_analysis_type, modes_row
   use geartrain_analyses_response, only: response_analysis_type, response_row
   use geartrain_analyses_run_up, only: run_up_analysis_type, run_up_row, run_up_settings_type
   use geartrain_analyses_stability_grid, only: stability_map_settings_type, stability_map_type
   use geartrain_analyses_stability_map, only: stability_map_analysis_type, stability_map_row
   use geartrain_curves_locus_result, only: locus_type
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_ramped_flow, only: run_up_type
   use geartrain_network_natural_modes, only: modes_type
   use geartrain_trace_branch, only: branch_type, response_settings_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: analyses, case_type, find_analysis, leave_out, number_of, results_type

   !> The analyses in the order in which they stand in a case file, run and are written.
   type(group_row_type), parameter :: analyses(*) = [modes_row, response_row, integration_row, attractors_row, basins_row, &
                                                     bifurcation_diagram_row, stability_map_row, run_up_row, locus_row]

   !> A case: a train and the analyses that one namelist file asks for.
   type :: case_type
      !> The train as described.
      type(train_type) :: train
      !> Whether the group &modes is present.
      logical :: modes = .false.
      !> Variables of each group; allocated when the group is present.
      type(response_settings_type), allocatable :: response
      type(integration_settings_type), allocatable :: integration
      type(attractors_settings_type), allocatable :: attractors
      type(basins_settings_type), allocatable :: basins
      type(bifurcation_diagram_settings_type), allocatable :: bifurcation_diagram
      type(stability_map_settings_type), allocatable :: stability_map
      type(run_up_settings_type), allocatable :: run_up
      type(locus_settings_type), allocatable :: locus
      !> Name of the results file as given in &output; empty: name of the case with .h5.
      character(:), allocatable :: output_file
   end type case_type

   !> The results of a case.
   type :: results_type
      !> Result of each analysis; allocated where the analysis has begun.
      type(modes_type), allocatable :: modes
      type(branch_type), allocatable :: response
      type(sweep_type), allocatable :: integration
      type(attractors_type), allocatable :: attractors
      type(basins_type), allocatable :: basins
      type(bifurcation_diagram_type), allocatable :: bifurcation_diagram
      type(stability_map_type), allocatable :: stability_map
      type(run_up_type), allocatable :: run_up
      type(locus_type), allocatable :: locus
      !> Further branches, each with its origin: branches that bifurcate from the response, then branches through attractors.
      type(branch_type), allocatable :: branches(:)
   end type results_type

contains

   !> Makes an analysis whose pointers `settings` and `result` point to components of a case and of results, where these exist.
   subroutine find_analysis(number, case, results, analysis, ask, begin)
      !> Number of the analysis in the list.
      integer, intent(in) :: number
      !> The case and the results: targets that must outlive `analysis`. They have no intent, so that without `ask` and `begin` the
      !> actual arguments may have intent(in).
      type(case_type), target :: case
      !> See `case`.
      type(results_type), target :: results
      class(analysis_type), allocatable, intent(out) :: analysis
      !> .true.: the case asks for the analysis from here on, with defaults if it did not; the results have the analysis from here
      !> on, empty if they did not.
      logical, intent(in), optional :: ask, begin
      logical :: asks, begins
      type(modes_analysis_type) :: modes
      type(response_analysis_type) :: response
      type(integration_analysis_type) :: integration
      type(attractors_analysis_type) :: attractors
      type(basins_analysis_type) :: basins
      type(bifurcation_diagram_analysis_type) :: bifurcation_diagram
      type(stability_map_analysis_type) :: stability_map
      type(run_up_analysis_type) :: run_up
      type(locus_analysis_type) :: locus

      asks = .false.
      if (present(ask)) asks = ask
      begins = .false.
      if (present(begin)) begins = begin
      select case (analyses(number)%name)
      case ('modes')
         if (asks) case%modes = .true.
         if (begins .and. .not. allocated(results%modes)) allocate (results%modes)
         modes%asked = case%modes
         modes%begun = allocated(results%modes)
         if (modes%begun) modes%result => results%modes
         allocate (analysis, source=modes)
      case ('response')
         if (asks .and. .not. allocated(case%response)) allocate (case%response)
         if (begins .and. .not. allocated(results%response)) allocate (results%response)
         response%asked = allocated(case%response)
         response%begun = allocated(results%response)
         if (response%asked) response%settings => case%response
         if (response%begun) response%result => results%response
         allocate (analysis, source=response)
      case ('integration')
         if (asks .and. .not. allocated(case%integration)) allocate (case%integration)
         if (begins .and. .not. allocated(results%integration)) allocate (results%integration)
         integration%asked = allocated(case%integration)
         integration%begun = allocated(results%integration)
         if (integration%asked) integration%settings => case%integration
         if (integration%begun) integration%result => results%integration
         allocate (analysis, source=integration)
      case ('attractors')
         if (asks .and. .not. allocated(case%attractors)) allocate (case%attractors)
         if (begins .and. .not. allocated(results%attractors)) allocate (results%attractors)
         attractors%asked = allocated(case%attractors)
         attractors%begun = allocated(results%attractors)
         if (attractors%asked) attractors%settings => case%attractors
         if (attractors%begun) attractors%result => results%attractors
         allocate (analysis, source=attractors)
      case ('basins')
         if (asks .and. .not. allocated(case%basins)) allocate (case%basins)
         if (begins .and. .not. allocated(results%basins)) allocate (results%basins)
         basins%asked = allocated(case%basins)
         basins%begun = allocated(results%basins)
         if (basins%asked) basins%settings => case%basins
         if (basins%begun) basins%result => results%basins
         allocate (analysis, source=basins)
      case ('bifurcation_diagram')
         if (asks .and. .not. allocated(case%bifurcation_diagram)) allocate (case%bifurcation_diagram)
         if (begins .and. .not. allocated(results%bifurcation_diagram)) allocate (results%bifurcation_diagram)
         bifurcation_diagram%asked = allocated(case%bifurcation_diagram)
         bifurcation_diagram%begun = allocated(results%bifurcation_diagram)
         if (bifurcation_diagram%asked) bifurcation_diagram%settings => case%bifurcation_diagram
         if (bifurcation_diagram%begun) bifurcation_diagram%result => results%bifurcation_diagram
         allocate (analysis, source=bifurcation_diagram)
      case ('stability_map')
         if (asks .and. .not. allocated(case%stability_map)) allocate (case%stability_map)
         if (begins .and. .not. allocated(results%stability_map)) allocate (results%stability_map)
         stability_map%asked = allocated(case%stability_map)
         stability_map%begun = allocated(results%stability_map)
         if (stability_map%asked) stability_map%settings => case%stability_map
         if (stability_map%begun) stability_map%result => results%stability_map
         allocate (analysis, source=stability_map)
      case ('run_up')
         if (asks .and. .not. allocated(case%run_up)) allocate (case%run_up)
         if (begins .and. .not. allocated(results%run_up)) allocate (results%run_up)
         run_up%asked = allocated(case%run_up)
         run_up%begun = allocated(results%run_up)
         if (run_up%asked) run_up%settings => case%run_up
         if (run_up%begun) run_up%result => results%run_up
         allocate (analysis, source=run_up)
      case ('locus')
         if (asks .and. .not. allocated(case%locus)) allocate (case%locus)
         if (begins .and. .not. allocated(results%locus)) allocate (results%locus)
         locus%asked = allocated(case%locus)
         locus%begun = allocated(results%locus)
         if (locus%asked) locus%settings => case%locus
         if (locus%begun) locus%result => results%locus
         if (allocated(case%response) .and. allocated(results%response)) then
            locus%response => results%response
            locus%response_settings => case%response
         end if
         allocate (analysis, source=locus)
      end select
   end subroutine find_analysis

   !> Removes the result of an analysis.
   subroutine leave_out(number, results)
      !> Number of the analysis in the list.
      integer, intent(in) :: number
      !> The results, which have no result of the analysis from here on.
      type(results_type), intent(inout) :: results
      type(results_type) :: none

      associate (name => analyses(number)%name)
         if (name == 'modes') call move_alloc(none%modes, results%modes)
         if (name == 'response') call move_alloc(none%response, results%response)
         if (name == 'integration') call move_alloc(none%integration, results%integration)
         if (name == 'attractors') call move_alloc(none%attractors, results%attractors)
         if (name == 'basins') call move_alloc(none%basins, results%basins)
         if (name == 'bifurcation_diagram') call move_alloc(none%bifurcation_diagram, results%bifurcation_diagram)
         if (name == 'stability_map') call move_alloc(none%stability_map, results%stability_map)
         if (name == 'run_up') call move_alloc(none%run_up, results%run_up)
         if (name == 'locus') call move_alloc(none%locus, results%locus)
      end associate
   end subroutine leave_out

   !> Number of an analysis in the list; 0: no such analysis.
   pure integer function number_of(name)
      !> Name of the analysis.
      character(*), intent(in) :: name

      number_of = findloc(analyses%name == name, .true., dim=1)
   end function number_of

end module geartrain_analyses_list
