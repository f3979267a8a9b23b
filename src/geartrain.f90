!> The public module of geartrain: everything that a Fortran caller needs, re-exported.
module geartrain
   use geartrain_analyses_attractor_branches, only: follow_attractors
   use geartrain_analyses_attractors, only: attractors, attractors_settings_type, attractors_type
   use geartrain_analyses_basin_grid, only: basins_settings_type, basins_type
   use geartrain_analyses_basins, only: basins
   use geartrain_analyses_bifurcation_diagram, only: bifurcation_diagram, bifurcation_diagram_settings_type, &
      bifurcation_diagram_type
   use geartrain_analyses_dependencies, only: locate_edges, name_parameter
   use geartrain_analyses_integration, only: integrate, sweep, sweep_type
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_analyses_response_branch, only: response
   use geartrain_analyses_run_up, only: run_up, run_up_settings_type
   use geartrain_analyses_stability_grid, only: stability_map_settings_type, stability_map_type
   use geartrain_analyses_stability_map, only: stability_map
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_error, only: error_type, status_ended_early, status_file, status_input
   use geartrain_base_interrupt, only: interrupt_by, interrupt_type
   use geartrain_base_kinds, only: dp, version
   use geartrain_base_observer, only: observer_type
   use geartrain_bifurcation_bifurcations, only: follow_bifurcations
   use geartrain_bifurcation_switching, only: period_doubled
   use geartrain_curves_locus_result, only: double_point_type, locus_type
   use geartrain_curves_locus_trace, only: trace_locus
   use geartrain_derivatives_motion_gradient, only: motion_gradient
   use geartrain_derivatives_special_gradient, only: special_gradient
   use geartrain_drawing_planetary_expansion, only: expand_planetaries
   use geartrain_exact_audit, only: audit_branch
   use geartrain_exact_audit_result, only: audit_row_type, audit_type
   use geartrain_exact_exact_point, only: exact_point_type, find_exact_point, onsets_of, refine_special_points
   use geartrain_exact_refinement, only: refine_branch, refine_motions
   use geartrain_flow_integration_settings, only: integration_settings_type
   use geartrain_flow_ramped_flow, only: run_up_type
   use geartrain_flow_shooting, only: refine
   use geartrain_flow_simulator, only: simulator_type
   use geartrain_flow_waveform, only: waveform
   use geartrain_input_reader, only: read_case, read_case_text
   use geartrain_input_template, only: template_text
   use geartrain_input_text, only: case_text
   use geartrain_linalg_openblas, only: blas_kernels, blas_threads
   use geartrain_network_check_train, only: check_train
   use geartrain_network_gradient, only: frequency_gradient, gradient_type
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_readings_contact_edges, only: locate_contact_edges
   use geartrain_readings_contact_ranges, only: back_collision_ranges, separation_ranges
   use geartrain_readings_jumps, only: jump_type, jumps
   use geartrain_readings_solutions, only: solutions_at
   use geartrain_readings_summary, only: band_type, bands_without_stability, folds, peak_type, peaks
   use geartrain_report_audit_text, only: audit_text
   use geartrain_report_drawing_warnings, only: warnings_text
   use geartrain_report_explain, only: explain_train, explanation_text, speed_text
   use geartrain_run_read_results, only: read_results
   use geartrain_run_results, only: write_results
   use geartrain_run_run_case, only: run_case
   use geartrain_trace_branch, only: branch_type, response_settings_type, special_point_type
   use geartrain_train_body, only: body_type
   use geartrain_train_mesh, only: mesh_type, new_bearing, new_coupling
   use geartrain_train_planetary, only: planetary_type
   use geartrain_train_shaft, only: shaft_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   public
end module geartrain
