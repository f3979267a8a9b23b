!> The hard cases of docs/hard-cases.md; the last line is `N passed, N failed`. Arguments: --all, with what takes minutes; --table, the
!> rows of the document.
program hard
   use hard_cases, only: cases_type
   use hard_figures, only: figures_cases
   implicit none (type, external)
   type(cases_type) :: cases

   call cases%open()
   call figures_cases(cases)
   call cases%finish()
end program hard
