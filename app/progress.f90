!> Tells on a terminal how far the work is, in one line that is overwritten, and keeps the time of each analysis.
module progress
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use geartrain, only: dp, observer_type
   implicit none (type, external)
   private
   public :: progress_type, begin_progress

   type, extends(observer_type) :: progress_type
      logical, private :: shown = .false.
      !> Clock counts: of the last line written, between two lines, of the last step.
      integer(int64), private :: last = 0, pause = 0, step = 0, rate = 1
      !> Time spent on each analysis [s], a response with its refinement.
      real(dp) :: response_seconds = 0, branch_seconds = 0, integration_seconds = 0, attractors_seconds = 0, map_seconds = 0
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

   subroutine begin_progress(progress, shown)
      type(progress_type), intent(out) :: progress
      !> Whether it is told, given a terminal.
      logical, intent(in) :: shown

      progress%shown = shown .and. isatty(standard_error) == 1
      call system_clock(progress%last, progress%rate)
      progress%step = progress%last
      progress%pause = progress%rate/10
   end subroutine begin_progress

   !> Writes at most ten times a second.
   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going
      integer(int64) :: now
      integer :: status
      real(dp) :: seconds

      call system_clock(now)
      seconds = real(now - self%step, dp)/real(self%rate, dp)
      self%step = now
      select case (analysis)
      case ('response', 'refinement')
         self%response_seconds = self%response_seconds + seconds
      case ('branch')
         self%branch_seconds = self%branch_seconds + seconds
      case ('attractors')
         self%attractors_seconds = self%attractors_seconds + seconds
      case ('stability map')
         self%map_seconds = self%map_seconds + seconds
      case default
         self%integration_seconds = self%integration_seconds + seconds
      end select
      if (.not. self%shown .or. .not. keep_going .or. analysis == 'settling') return
      if (now - self%last < self%pause) return
      self%last = now
      if (analysis == 'stability map') then
         write (error_unit, '(3a, i0, a)', advance='no', iostat=status) to_line_start, analysis, ': ', done, ' rows'
      else
         write (error_unit, '(3a, i0, a, f8.4)', advance='no', iostat=status) to_line_start, analysis, ': ', done, &
            trim(merge(' starts, Lambda =', ' points, Lambda =', analysis == 'attractors')), frequency_ratio
      end if
      flush (error_unit, iostat=status)
   end subroutine on_step

   subroutine clear(self)
      class(progress_type), intent(in) :: self
      integer :: status

      if (.not. self%shown) return
      write (error_unit, '(a)', advance='no', iostat=status) to_line_start
      flush (error_unit, iostat=status)
   end subroutine clear

end module progress
