!> All suites of tests; `runner` says which arguments choose among them. The last line is `N passed, N failed`.
program main
   use runner, only: run_suites
   use testing, only: suite_type
   use hard_branches, only: branches_cases
   use hard_closed_forms, only: closed_forms_cases
   use hard_figures, only: figures_cases
   use hard_grazing, only: grazing_cases
   use hard_motions, only: motions_cases
   use hard_random_trains, only: random_trains_cases
   use hard_scales, only: scales_cases
   use hard_settling, only: settling_cases
   use hard_slips, only: slips_at_random_tests
   use hard_speeds, only: speeds_cases
   use unit_balance, only: balance_tests
   use unit_branch_summary, only: branch_summary_tests
   use unit_case_reader, only: case_reader_tests
   use unit_case_text, only: case_text_tests
   use unit_check, only: check_tests
   use unit_contact, only: contact_tests
   use unit_eigenvalues, only: eigenvalues_tests
   use unit_elimination, only: elimination_tests
   use unit_flow, only: flow_tests
   use unit_long_period, only: long_period_tests
   use unit_basins, only: basins_tests
   use unit_report, only: report_tests
   use unit_section_map, only: section_map_tests
   use unit_drawing, only: drawing_tests
   use unit_mesh, only: mesh_tests
   use unit_planetary, only: planetary_tests
   use unit_rows, only: rows_tests
   use unit_network, only: network_checks
   use unit_results, only: results_tests
   use unit_results_run, only: results_run_tests
   use unit_robust, only: robust_tests
   use unit_scale, only: scale_tests
   use unit_slow_multipliers, only: slow_multipliers_tests
   use unit_slips, only: slips_tests
   use unit_time_constants, only: time_constants_tests
   use unit_winding, only: winding_tests
   use validation_shaft_torque, only: shaft_torque_tests
   use validation_audit, only: audit_tests
   use validation_bifurcations, only: bifurcations_tests
   use validation_claims_excitation, only: claims_excitation_tests
   use validation_claims_shafts, only: claims_shafts_tests
   use validation_claims_subharmonic, only: claims_subharmonic_tests
   use validation_doubling, only: doubling_tests
   use validation_errata, only: errata_tests
   use validation_error_estimate, only: error_estimate_tests
   use validation_excitations, only: excitations_tests
   use validation_figures, only: figures_tests
   use validation_gradient, only: gradient_tests
   use validation_gradient_special, only: gradient_special_tests
   use validation_ground, only: ground_tests
   use validation_jumps, only: jumps_tests
   use validation_mesh_law, only: mesh_law_tests
   use validation_mesh_load, only: mesh_load_tests
   use validation_network, only: network_tests
   use validation_hunting, only: hunting_tests
   use validation_orders, only: orders_tests
   use validation_paper_train, only: paper_train_tests
   use validation_parameter, only: parameter_tests
   use validation_random_networks, only: random_networks_tests
   use validation_refinement, only: refinement_tests
   use validation_run_up, only: run_up_tests
   use validation_settling, only: settling_tests
   use validation_single_pair, only: single_pair_tests
   use validation_stability_map, only: stability_map_tests
   use validation_whole_model, only: whole_model_tests
   implicit none (type, external)

   call run_suites([ &
                   suite_type('unit_contact', contact_tests), &
                   suite_type('unit_case_reader', case_reader_tests), &
                   suite_type('unit_case_text', case_text_tests), &
                   suite_type('unit_check', check_tests), &
                   suite_type('unit_branch_summary', branch_summary_tests), &
                   suite_type('unit_balance', balance_tests), &
                   suite_type('unit_eigenvalues', eigenvalues_tests), &
                   suite_type('unit_elimination', elimination_tests), &
                   suite_type('unit_flow', flow_tests), &
                   suite_type('unit_long_period', long_period_tests), &
                   suite_type('unit_report', report_tests), &
                   suite_type('unit_section_map', section_map_tests), &
                   suite_type('unit_basins', basins_tests), &
                   suite_type('unit_drawing', drawing_tests), &
                   suite_type('unit_mesh', mesh_tests), &
                   suite_type('unit_planetary', planetary_tests), &
                   suite_type('unit_rows', rows_tests), &
                   suite_type('unit_network', network_checks), &
                   suite_type('unit_results', results_tests), &
                   suite_type('unit_robust', robust_tests), &
                   suite_type('unit_scale', scale_tests), &
                   suite_type('unit_slow_multipliers', slow_multipliers_tests), &
                   suite_type('unit_slips', slips_tests), &
                   suite_type('unit_time_constants', time_constants_tests), &
                   suite_type('unit_winding', winding_tests), &
                   suite_type('unit_results_run', results_run_tests), &
                   suite_type('validation_shaft_torque', shaft_torque_tests), &
                   suite_type('validation_paper_train', paper_train_tests), &
                   suite_type('validation_network', network_tests), &
                   suite_type('validation_ground', ground_tests), &
                   suite_type('validation_parameter', parameter_tests), &
                   suite_type('validation_random_networks', random_networks_tests), &
                   suite_type('validation_orders', orders_tests), &
                   suite_type('validation_single_pair', single_pair_tests), &
                   suite_type('validation_whole_model', whole_model_tests), &
                   suite_type('validation_mesh_law', mesh_law_tests), &
                   suite_type('validation_mesh_load', mesh_load_tests), &
                   suite_type('validation_jumps', jumps_tests), &
                   suite_type('validation_bifurcations', bifurcations_tests), &
                   suite_type('validation_excitations', excitations_tests), &
                   suite_type('validation_figures', figures_tests), &
                   suite_type('validation_errata', errata_tests), &
                   suite_type('validation_error_estimate', error_estimate_tests), &
                   suite_type('validation_claims_shafts', claims_shafts_tests), &
                   suite_type('validation_claims_excitation', claims_excitation_tests), &
                   suite_type('validation_claims_subharmonic', claims_subharmonic_tests), &
                   suite_type('validation_stability_map', stability_map_tests), &
                   suite_type('validation_refinement', refinement_tests), &
                   suite_type('validation_run_up', run_up_tests), &
                   suite_type('validation_settling', settling_tests), &
                   suite_type('validation_audit', audit_tests), &
                   suite_type('validation_gradient', gradient_tests), &
                   suite_type('validation_gradient_special', gradient_special_tests), &
                   suite_type('validation_hunting', hunting_tests), &
                   suite_type('validation_doubling', doubling_tests), &
                   suite_type('hard_figures', figures_cases), &
                   suite_type('hard_branches', branches_cases), &
                   suite_type('hard_grazing', grazing_cases), &
                   suite_type('hard_scales', scales_cases), &
                   suite_type('hard_speeds', speeds_cases), &
                   suite_type('hard_closed_forms', closed_forms_cases), &
                   suite_type('hard_motions', motions_cases), &
                   suite_type('hard_settling', settling_cases), &
                   suite_type('hard_slips', slips_at_random_tests), &
                   suite_type('hard_random_trains', random_trains_cases)])
end program main
