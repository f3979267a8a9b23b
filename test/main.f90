!> Runs all tests.
program main
   use testing, only: tests_type
   use test_results, only: results_tests
   use test_results_run, only: results_run_tests
   implicit none (type, external)
   type(tests_type) :: tests

   call results_tests(tests)
   call results_run_tests(tests)
   call tests%finish()
end program main
