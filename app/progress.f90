!> Tells on a terminal how far the work is, in one line that is overwritten, and keeps the time of each analysis.
module progress
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use geartrain, only: case_type, dp, observer_type
   use geartrain_analyses_analysis, only: spoken
   use geartrain_analyses_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_analyses_list, only: analyses, number_of
   implicit none (type, external)
   private
   public :: progress_type, begin_progress

   type, extends(observer_type) :: progress_type
      logical, private :: shown = .false.
      !> Clock counts: of the last line written, between two lines, of the last step.
      integer(int64), private :: last = 0, pause = 0, step = 0, rate = 1
      !> Clock count of the last point; points of the analysis under way.
      integer(int64), private :: point = 0
      integer, private :: points = 0
      !> How the frequencies of each analysis of the list are told, the first for what is none.
      type(frequency_text_type), private :: told(0:size(analyses))
      !> Time spent on each analysis of the list [s], a response with its refinement; on the further branches.
      real(dp) :: seconds(size(analyses)) = 0, branch_seconds = 0
   contains
      procedure :: on_step
      procedure :: clear
   end type progress_type

   interface
      !> POSIX: 1 where the file descriptor is a terminal.
      integer(c_int) function isatty(descriptor) bind(c, name='isatty')
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
      end function isatty
   end interface

   integer(c_int), parameter :: standard_error = 2
   character(*), parameter :: to_line_start = achar(13)//achar(27)//'[K'

contains

   subroutine begin_progress(progress, case, shown)
      type(progress_type), intent(out) :: progress
      type(case_type), intent(in) :: case
      !> Whether it is told, given a terminal.
      logical, intent(in) :: shown

      progress%shown = shown .and. isatty(standard_error) == 1
      call system_clock(progress%last, progress%rate)
      progress%step = progress%last
      progress%point = progress%last
      progress%pause = progress%rate/10
      progress%told = frequency_text(case%train, 'Lambda', 0.0_dp)
      if (allocated(case%response)) call tell('response', case%response%unit)
      progress%told(0) = progress%told(number_of('response'))
      if (allocated(case%integration)) call tell('integration', case%integration%unit)
      if (allocated(case%attractors)) call tell('attractors', case%attractors%unit)
      if (allocated(case%run_up)) call tell('run_up', case%run_up%unit)
      where (progress%told%unit /= 'Lambda') progress%told%decimals = 2

   contains

      subroutine tell(name, unit)
         character(*), intent(in) :: name, unit

         progress%told(number_of(name)) = frequency_text(case%train, unit, 0.0_dp)
      end subroutine tell

   end subroutine begin_progress

   !> Writes at most ten times a second; of a motion that is settling only where its point takes long.
   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going
      integer(int64) :: now
      integer :: status, number
      character(len(analyses%steps)) :: steps
      character(:), allocatable :: place
      real(dp) :: seconds

      call system_clock(now)
      seconds = real(now - self%step, dp)/real(self%rate, dp)
      self%step = now
      number = number_of_spoken(analysis)
      if (number > 0) self%seconds(number) = self%seconds(number) + seconds
      if (analysis == 'branch') self%branch_seconds = self%branch_seconds + seconds
      if (.not. self%shown .or. .not. keep_going) return
      if (analysis == 'settling') then
         if (now - self%point < self%rate) return
      else
         self%point = now
         self%points = done
      end if
      if (now - self%last < self%pause) return
      self%last = now
      steps = 'points'
      if (number > 0) steps = analyses(number)%steps
      if (analysis == 'settling') steps = 'periods'
      write (error_unit, '(3a, i0, 2a)', advance='no', iostat=status) to_line_start, analysis, ': ', done, ' ', trim(steps)
      if (steps /= 'rows') then
         call self%told(number)%with_unit(self%told(number)%number(frequency_ratio), place)
         write (error_unit, '(2a)', advance='no', iostat=status) ', ', place
      end if
      if (analysis == 'settling') write (error_unit, '(a, i0, a)', advance='no', iostat=status) ', ', self%points, ' points done'
      flush (error_unit, iostat=status)
   end subroutine on_step

   !> Number in the list of the analysis that an observer is told of, 0 where it is none: settling is that of time integration.
   pure integer function number_of_spoken(analysis) result(number)
      character(*), intent(in) :: analysis

      select case (analysis)
      case ('refinement')
         number = number_of('response')
      case ('settling')
         number = number_of('integration')
      case default
         do number = size(analyses), 1, -1
            if (spoken(analyses(number)%name) == analysis) return
         end do
      end select
   end function number_of_spoken

   subroutine clear(self)
      class(progress_type), intent(in) :: self
      integer :: status

      if (.not. self%shown) return
      write (error_unit, '(a)', advance='no', iostat=status) to_line_start
      flush (error_unit, iostat=status)
   end subroutine clear

end module progress
