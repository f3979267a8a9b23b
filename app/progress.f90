!> Tells how far the work is, on a terminal in one line that is overwritten, elsewhere in a line a minute. Keeps the time of each
!> analysis.
module progress
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use geartrain, only: case_type, dp, observer_type, results_type
   use geartrain_analyses_analysis, only: spoken
   use geartrain_analyses_forecast, only: forecast_type
   use geartrain_analyses_list, only: analyses, number_of
   use geartrain_base_numbers, only: counted, integer_text, significant, text
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: hertz_per_lambda
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type
   use geartrain_train_train, only: train_type
   use terminal, only: complain
   implicit none (type, external)
   private
   public :: progress_type, begin_progress

   !> Most natural frequencies of the line on them.
   integer, parameter :: most_modes = 8

   type, extends(observer_type) :: progress_type
      !> Whether it is told; in one line that is overwritten.
      logical, private :: shown = .false., overwrites = .false.
      !> Clock counts: of the beginning, of the last line written, between two lines, of the last step.
      integer(int64), private :: begin = 0, last = 0, pause = 0, step = 0, rate = 1
      !> Clock count of the last point; points of the analysis under way.
      integer(int64), private :: point = 0
      integer, private :: points = 0
      !> How the frequencies of each analysis of the list are told, the first for what is none.
      type(frequency_text_type), private :: told(0:size(analyses))
      !> Time spent on each analysis of the list [s], a response with its refinement; on the further branches.
      real(dp) :: seconds(size(analyses)) = 0, branch_seconds = 0
      !> The case, and where its results come.
      type(case_type), private, pointer :: case => null()
      type(results_type), private, pointer :: results => null()
      !> Whether the natural frequencies have been told.
      logical, private :: modes_told = .false.
      !> How long each analysis takes.
      type(forecast_type) :: forecast
      !> Stands for results where none are watched.
      type(results_type), private :: none
   contains
      procedure :: on_step
      procedure :: on_trouble
      procedure :: clear
      procedure, private :: report_modes
      procedure, private :: report_forecast
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
   !> Time between two lines [s]: on a terminal, elsewhere.
   real(dp), parameter :: pause_on_terminal = 0.1_dp, pause_elsewhere = 60
   character(*), parameter :: to_line_start = achar(13)//achar(27)//'[K'

contains

   subroutine begin_progress(progress, case, shown, results, resumed)
      type(progress_type), intent(out) :: progress
      type(case_type), intent(in), target :: case
      !> Whether it is told.
      logical, intent(in) :: shown
      !> Results under way, whose natural frequencies are reported at once.
      type(results_type), intent(in), target, optional :: results
      !> Whether the run goes on from a checkpoint; absent: it does not.
      logical, intent(in), optional :: resumed
      logical :: goes_on

      goes_on = .false.
      if (present(resumed)) goes_on = resumed
      call progress%forecast%start(goes_on)
      progress%shown = shown
      progress%overwrites = shown .and. isatty(standard_error) == 1
      call system_clock(progress%begin, progress%rate)
      progress%last = progress%begin
      progress%step = progress%begin
      progress%point = progress%begin
      progress%pause = nint(progress%rate*merge(pause_on_terminal, pause_elsewhere, progress%overwrites), int64)
      progress%case => case
      if (present(results)) progress%results => results
      progress%told = frequency_text(case%train, 'Lambda', 0.0_dp)
      if (allocated(case%response)) call tell('response', case%response%unit)
      progress%told(0) = progress%told(number_of('response'))
      if (allocated(case%integration)) call tell('integration', case%integration%unit)
      if (allocated(case%attractors)) call tell('attractors', case%attractors%unit)
      if (allocated(case%bifurcation_diagram)) call tell('bifurcation_diagram', case%bifurcation_diagram%unit)
      if (allocated(case%basins)) call tell('basins', case%basins%unit)
      if (allocated(case%run_up)) call tell('run_up', case%run_up%unit)
      if (allocated(case%locus)) call tell('locus', case%locus%unit)
      where (progress%told%unit /= 'Lambda') progress%told%decimals = 2

   contains

      subroutine tell(name, unit)
         character(*), intent(in) :: name, unit

         progress%told(number_of(name)) = frequency_text(case%train, unit, 0.0_dp)
      end subroutine tell

   end subroutine begin_progress

   !> Writes what failed on the way, whether progress is shown or not.
   subroutine on_trouble(self, message)
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: message

      call self%clear()
      call complain('geartrain: warning: '//message)
   end subroutine on_trouble

   !> Writes after a pause only; of a motion that is settling only where its point takes long. Modes come first of all analyses and
   !> are there with the first step of another one.
   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      logical, intent(inout) :: keep_going
      integer(int64) :: now
      integer :: status, number
      character(max(13, len(analyses%steps))) :: steps
      character(:), allocatable :: line, place
      real(dp) :: seconds

      call system_clock(now)
      seconds = real(now - self%step, dp)/real(self%rate, dp)
      self%step = now
      number = number_of_spoken(analysis)
      if (number > 0) self%seconds(number) = self%seconds(number) + seconds
      if (analysis == 'branch') self%branch_seconds = self%branch_seconds + seconds
      if (.not. self%shown .or. .not. keep_going) return
      if (self%overwrites .or. now - self%begin > self%rate) call self%report_modes()
      call self%report_forecast(analysis, done, frequency_ratio)
      if (analysis == 'modes') return
      if (analysis == 'settling' .or. analysis == 'settling by time') then
         if (now - self%point < self%rate) return
      else
         self%point = now
         self%points = done
      end if
      if (now - self%last < self%pause) return
      self%last = now
      steps = 'points'
      if (number > 0) steps = analyses(number)%steps
      if (analysis == 'random starts') steps = 'starts'
      if (analysis == 'settling') steps = 'periods'
      if (analysis == 'settling by time') steps = 'mesh cycles'
      line = analysis//': '//counted(done, singular(steps), trim(steps))
      if (steps /= 'rows') then
         if (goes_over_parameter()) then
            place = trim(self%case%response%parameter)//' = '//text(frequency_ratio)
         else
            call self%told(number)%with_unit(self%told(number)%number(frequency_ratio), place)
         end if
         line = line//', '//place
      end if
      if (analysis == 'settling' .or. analysis == 'settling by time') &
         line = line//', '//counted(self%points, 'point', 'points')//' done'
      if (self%overwrites) then
         write (error_unit, '(2a)', advance='no', iostat=status) to_line_start, line
         flush (error_unit, iostat=status)
      else
         call complain(line//', after '//integer_text(int((now - self%begin)/self%rate))//' s')
      end if

   contains

      !> Whether the branch goes over a parameter, of which `frequency_ratio` is the value.
      logical function goes_over_parameter()
         goes_over_parameter = .false.
         if (.not. allocated(self%case%response)) return
         if (number == number_of('response') .or. analysis == 'branch') &
            goes_over_parameter = self%case%response%parameter /= ''
      end function goes_over_parameter

   end subroutine on_step

   !> Writes how long an analysis will take and what makes it long, once it is known.
   subroutine report_forecast(self, analysis, done, frequency_ratio)
      class(progress_type), intent(inout) :: self
      !> As an observer gets them.
      character(*), intent(in) :: analysis
      integer, intent(in) :: done
      real(dp), intent(in) :: frequency_ratio
      character(:), allocatable :: sentence

      if (associated(self%results)) then
         call self%forecast%look(analysis, done, frequency_ratio, self%case, self%results, sentence)
      else
         call self%forecast%look(analysis, done, frequency_ratio, self%case, self%none, sentence)
      end if
      if (sentence == '') return
      call self%report_modes()
      call self%clear()
      call complain(sentence)
   end subroutine report_forecast

   !> Writes the natural frequencies once, before what may take long.
   subroutine report_modes(self)
      class(progress_type), intent(inout) :: self
      type(train_type) :: plain
      character(:), allocatable :: line
      integer :: i

      if (self%modes_told .or. .not. associated(self%results)) return
      if (.not. allocated(self%results%modes)) return
      self%modes_told = .true.
      if (.not. allocated(self%results%modes%natural_frequency)) return
      call plain_train(self%case%train, plain)
      associate (natural => self%results%modes%natural_frequency)
         line = 'natural frequencies:'
         do i = 1, min(size(natural), most_modes)
            line = line//' '//significant(natural(i)*hertz_per_lambda(plain))
         end do
         if (size(natural) > most_modes) line = line//' ... '//significant(natural(size(natural))*hertz_per_lambda(plain))
         call self%clear()
         call complain(line//' Hz')
      end associate
   end subroutine report_modes

   !> Number in the list of the analysis that an observer is told of, 0 where it is none: settling is that of time integration.
   pure integer function number_of_spoken(analysis) result(number)
      character(*), intent(in) :: analysis

      select case (analysis)
      case ('refinement')
         number = number_of('response')
      case ('random starts')
         number = number_of('basins')
      case ('settling', 'settling by time')
         number = number_of('integration')
      case default
         do number = size(analyses), 1, -1
            if (spoken(analyses(number)%name) == analysis) return
         end do
      end select
   end function number_of_spoken

   !> A word without the s of the plural at its end.
   pure function singular(words) result(word)
      character(*), intent(in) :: words
      character(len_trim(words) - 1) :: word

      word = words
   end function singular

   subroutine clear(self)
      class(progress_type), intent(in) :: self
      integer :: status

      if (.not. self%overwrites) return
      write (error_unit, '(a)', advance='no', iostat=status) to_line_start
      flush (error_unit, iostat=status)
   end subroutine clear

end module progress
