!> The response curve of the paper's train, read from a case file: fpm run --profile release --example response_curve
program response_curve
   use geartrain, only: branch_type, case_type, error_type, read_case, response
   implicit none (type, external)
   type(case_type) :: case
   type(branch_type) :: branch
   type(error_type), allocatable :: error
   integer :: i

   call read_case('namelists/fig03.nml', case, error)
   if (.not. allocated(error)) call response(case%train, case%response, branch, error)
   if (allocated(error)) then
      print '(a)', error%message
      error stop
   end if

   print '(2a)', 'The branch ', branch%ended%text
   print '(a, 2f8.4)', 'Largest rms of the meshes:', maxval(branch%rms, dim=2)
   do i = 1, size(branch%special_points)
      associate (special => branch%special_points(i))
         print '(a16, a, f7.4)', special%kind, 'at Lambda = ', special%frequency_ratio
      end associate
   end do
end program response_curve

! It prints:
! The branch reached Lambda = 2.6
! Largest rms of the meshes:  0.8605  3.0460
! fold            at Lambda =  0.4621
!   (six more folds)
! fold            at Lambda =  1.5473
! period doubling at Lambda =  1.7492
! period doubling at Lambda =  2.0439
