!> Runs every test; the last line is `N passed, N failed`.
program main
   use test_balance, only: balance_tests
   use test_branch_summary, only: branch_summary_tests
   use test_case_reader, only: case_reader_tests
   use test_case_text, only: case_text_tests
   use test_check, only: check_tests
   use test_contact, only: contact_tests
   use test_flow, only: flow_tests
   use test_paper_train, only: paper_train_tests
   use test_single_pair, only: single_pair_tests
   use test_whole_model, only: whole_model_tests
   use testing, only: tests_type
   implicit none (type, external)
   type(tests_type) :: tests

   call contact_tests(tests)
   call case_reader_tests(tests)
   call case_text_tests(tests)
   call check_tests(tests)
   call branch_summary_tests(tests)
   call balance_tests(tests)
   call flow_tests(tests)
   call paper_train_tests(tests)
   call single_pair_tests(tests)
   call whole_model_tests(tests)
   call tests%finish()
end program main
