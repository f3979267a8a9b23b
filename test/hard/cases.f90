!> Checks that are rows of docs/hard-cases.md at the same time: what is hard, what it is checked against, how far off it is and how
!> far it may be. With --table the program prints them.
module hard_cases
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: compiler_options, output_unit
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, solutions_at, train_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: cases_type, solve, solution

   type, extends(tests_type) :: cases_type
      !> Print the rows.
      logical :: table = .false.
      !> A debug build, which takes ten times as long: the longest cases are left to the others, unless --all asks for them.
      logical :: slow_build = .false.
      integer :: rows = 0
   contains
      procedure :: open
      procedure :: heading
      procedure :: measured
      procedure :: holds
   end type cases_type

contains

   !> Takes the arguments of the program: --all, --table.
   subroutine open (self)
      class(cases_type), intent(inout) :: self
      character(16) :: argument
      integer :: i

      self%slow_build = index(compiler_options(), '-fcheck') > 0
      do i = 1, command_argument_count()
         call get_command_argument(i, argument)
         if (argument == '--all') self%slow_build = .false.
         if (argument == '--table') self%table = .true.
      end do
   end subroutine open

   !> Begins a group of cases.
   subroutine heading(self, title)
      class(cases_type), intent(inout) :: self
      character(*), intent(in) :: title

      call self%begin(title)
      if (self%table) write (output_unit, '(/a//a/a)') '### '//title, '| hard case | checked against | off by | allowed |', &
         '|---|---|---|---|'
   end subroutine heading

   !> A case whose difference from the second method is measured.
   subroutine measured(self, what, against, difference, allowed)
      class(cases_type), intent(inout) :: self
      character(*), intent(in) :: what, against
      real(dp), intent(in) :: difference, allowed
      character(12) :: is, may

      call self%is_close(difference, 0.0_dp, allowed, what//', '//against)
      self%rows = self%rows + 1
      if (.not. self%table) return
      write (is, '(es8.1)') difference
      write (may, '(es8.0)') allowed
      write (output_unit, '(9a)') '| ', what, ' | ', against, ' | ', trim(adjustl(is)), ' | ', trim(adjustl(may)), ' |'
   end subroutine measured

   !> A case that holds or does not.
   subroutine holds(self, what, against, claim)
      class(cases_type), intent(inout) :: self
      character(*), intent(in) :: what, against
      logical, intent(in) :: claim

      call self%is_true(claim, what//', '//against)
      self%rows = self%rows + 1
      if (self%table) write (output_unit, '(5a)') '| ', what, ' | ', against, ' | '//merge('holds', 'FAILS', claim)//' | |'
   end subroutine holds

   !> The response of a train; empty where the input was refused.
   function solve(train, settings) result(branch)
      type(train_type), intent(in) :: train
      type(response_settings_type), intent(in) :: settings
      type(branch_type) :: branch
      type(error_type), allocatable :: error

      call response(train, settings, branch, error)
   end function solve

   !> The only motion of a train at a frequency, by the balance; its rms is NaN, which no tolerance allows, where there is not
   !> exactly one.
   function solution(train, settings) result(motion)
      type(train_type), intent(in) :: train
      !> A short range that begins at the frequency.
      type(response_settings_type), intent(in) :: settings
      type(motion_type) :: motion
      type(branch_type) :: branch
      type(motion_type), allocatable :: motions(:)
      type(error_type), allocatable :: error

      allocate (motions(0))
      branch = solve(train, settings)
      if (branch%points > 0) call solutions_at(train, settings, branch, settings%start, motions, error)
      if (size(motions) == 1) then
         motion = motions(1)
      else
         allocate (motion%rms(size(train%meshes)), source=ieee_value(1.0_dp, ieee_quiet_nan))
         motion%mean = motion%rms
      end if
   end function solution

end module hard_cases
