!> Runs every test, or with the word unit the unit tests alone; the last line is `N passed, N failed`.
program main
   use testing, only: tests_type
   use unit_balance, only: balance_tests
   use unit_branch_summary, only: branch_summary_tests
   use unit_case_reader, only: case_reader_tests
   use unit_case_text, only: case_text_tests
   use unit_check, only: check_tests
   use unit_contact, only: contact_tests
   use unit_eigenvalues, only: eigenvalues_tests
   use unit_elimination, only: elimination_tests
   use unit_flow, only: flow_tests
   use unit_results, only: results_tests
   use unit_results_run, only: results_run_tests
   use unit_robust, only: robust_tests
   use unit_scale, only: scale_tests
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
   use validation_jumps, only: jumps_tests
   use validation_mesh_load, only: mesh_load_tests
   use validation_orders, only: orders_tests
   use validation_paper_train, only: paper_train_tests
   use validation_refinement, only: refinement_tests
   use validation_settling, only: settling_tests
   use validation_single_pair, only: single_pair_tests
   use validation_stability_map, only: stability_map_tests
   use validation_whole_model, only: whole_model_tests
   implicit none (type, external)
   type(tests_type) :: tests
   character(4) :: which

   call get_command_argument(1, which)
   call contact_tests(tests)
   call case_reader_tests(tests)
   call case_text_tests(tests)
   call check_tests(tests)
   call branch_summary_tests(tests)
   call balance_tests(tests)
   call eigenvalues_tests(tests)
   call elimination_tests(tests)
   call flow_tests(tests)
   call results_tests(tests)
   call robust_tests(tests)
   call scale_tests(tests)
   call results_run_tests(tests)
   if (which == 'unit') then
      call tests%finish()
      stop
   end if
   call paper_train_tests(tests)
   call orders_tests(tests)
   call single_pair_tests(tests)
   call whole_model_tests(tests)
   call mesh_load_tests(tests)
   call jumps_tests(tests)
   call doubling_tests(tests)
   call bifurcations_tests(tests)
   call excitations_tests(tests)
   call figures_tests(tests)
   call errata_tests(tests)
   call error_estimate_tests(tests)
   call claims_shafts_tests(tests)
   call claims_excitation_tests(tests)
   call claims_subharmonic_tests(tests)
   call stability_map_tests(tests)
   call refinement_tests(tests)
   call settling_tests(tests)
   call audit_tests(tests)
   call tests%finish()
end program main
