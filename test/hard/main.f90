!> The hard cases of docs/hard-cases.md; the last line is `N passed, N failed`. Arguments: --table, the rows
!> of the document; --all, in a debug build too what takes minutes there.
program hard
   use hard_branches, only: branches_cases
   use hard_cases, only: cases_type
   use hard_closed_forms, only: closed_forms_cases
   use hard_figures, only: figures_cases
   use hard_grazing, only: grazing_cases
   use hard_motions, only: motions_cases
   use hard_random_trains, only: random_trains_cases
   use hard_scales, only: scales_cases
   use hard_settling, only: settling_cases
   use hard_speeds, only: speeds_cases
   implicit none (type, external)
   type(cases_type) :: cases

   call cases%open()
   call figures_cases(cases)
   call branches_cases(cases)
   call grazing_cases(cases)
   call scales_cases(cases)
   call speeds_cases(cases)
   call closed_forms_cases(cases)
   call motions_cases(cases)
   call settling_cases(cases)
   call random_trains_cases(cases)
   call cases%finish()
end program hard
