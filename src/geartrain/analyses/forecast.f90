!> How long an analysis takes and what makes it long, as a sentence, from the time of its first steps and the share that is done.
module geartrain_analyses_forecast
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_analyses_list, only: case_type, results_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, integer_text
   use geartrain_network_frequency_unit, only: lambda_per
   use geartrain_network_long_period, only: describe_period, long_period
   use geartrain_trace_branch, only: branch_type
   implicit none (type, external)
   private
   public :: forecast_type

   !> Most characters of a forecast.
   integer, parameter :: forecast_length = 400
   !> Shortest duration that is forecast [s]; time of an analysis before which nothing is forecast [s].
   real(dp), parameter :: worth_telling = 10, patience = 3
   !> Share of a curve that must be done, since its steps are small in the beginning, unless this has taken so long [s].
   real(dp), parameter :: least_share = 0.03_dp, too_long = 8
   !> Steps of a response before which nothing is forecast.
   integer, parameter :: least_points = 3
   !> Analyses of which the first motion takes longer than the others.
   character(*), parameter :: curves(*) = [character(8) :: 'response', 'run up', 'locus']
   !> Time of an analysis over its forecast above which it is forecast anew; share by which the new forecast exceeds that time.
   real(dp), parameter :: overdue = 2, ahead = 0.5_dp
   !> Share of the time above which a cost is named.
   real(dp), parameter :: most_of_it = 0.5_dp

   !> Watches the steps of a run as an observer does, and forecasts each analysis once.
   type :: forecast_type
      private
      !> Whether options are written as keywords of Python.
      logical, public :: in_python = .false.
      !> Rows of an audit, which no case tells.
      integer, public :: audit_rows = 0
      !> Whether the first analysis goes on from a checkpoint.
      logical :: resumed = .false.
      !> The analysis under way; whether its forecast has been given.
      character(24) :: analysis = ''
      logical :: given = .false.
      !> Duration of the analysis that was forecast last [s].
      real(dp) :: expected = 0
      !> Clock count of the latest step, and clock count at which the share of the analysis was `share_before`.
      integer(int64) :: latest = 0, begin = 0
      !> Time of the analysis before `begin`, which says nothing of its steps [s].
      real(dp) :: lead = 0
      !> Shares done [1].
      real(dp) :: share_before = 0, share = 0
      !> Steps so far, and value that an observer got at the first step of the analysis.
      integer :: steps = 0
      real(dp) :: first = 0
      !> Time spent on stability before `begin` [s].
      real(dp) :: verdicts_before = 0
   contains
      procedure :: start
      procedure :: look
      procedure, private :: renew
      procedure, private :: share_done
      procedure, private :: causes
   end type forecast_type

contains

   !> Begins to count the time.
   subroutine start(self, resumed)
      class(forecast_type), intent(inout) :: self
      !> Whether the run goes on from a checkpoint.
      logical, intent(in) :: resumed

      call system_clock(self%latest)
      self%resumed = resumed
   end subroutine start

   !> Takes notice of a step of an observer.
   subroutine look(self, analysis, done, value, case, results, sentence)
      class(forecast_type), intent(inout) :: self
      !> Name of the analysis, as an observer gets it.
      character(*), intent(in) :: analysis
      !> Steps done so far.
      integer, intent(in) :: done
      !> Lambda or parameter of the step.
      real(dp), intent(in) :: value
      type(case_type), intent(in) :: case
      !> The results under way.
      type(results_type), intent(in) :: results
      !> 'response: about 3 min expected: ...' where the forecast is known now and worth telling, else ''.
      character(:), allocatable, intent(out) :: sentence
      integer(int64) :: now, rate
      real(dp) :: elapsed, rest, whole

      sentence = ''
      call system_clock(now, rate)
      if (self%given .and. (analysis == self%analysis .or. analysis(:min(8, len(analysis))) == 'settling')) &
         call self%renew(real(now - self%begin, dp)/real(rate, dp), case, sentence)
      ! The motions that settle are parts of a step.
      if (sentence /= '' .or. analysis == 'settling' .or. analysis == 'settling by time') return
      if (analysis /= self%analysis) then
         self%analysis = analysis
         self%given = .false.
         self%begin = self%latest
         self%lead = 0
         self%first = value
         self%steps = 0
         self%share = 0
         self%share_before = 0
         self%verdicts_before = 0
         ! What was done before the checkpoint took no time of this run; the first motion of a curve is not found as the others are.
         if (self%resumed .and. analysis /= 'modes' .or. any(analysis == curves)) then
            if (.not. self%resumed) self%lead = real(now - self%latest, dp)/real(rate, dp)
            self%resumed = self%resumed .and. analysis == 'modes'
            self%begin = now
            self%steps = -1
            self%share_before = self%share_done(done, value, case, results)
            if (allocated(results%response)) self%verdicts_before = results%response%verdict_seconds
         end if
      end if
      self%latest = now
      self%steps = self%steps + 1
      self%share = max(self%share, self%share_done(done, value, case, results))
      if (self%given) return
      elapsed = real(now - self%begin, dp)/real(rate, dp)
      if (.not. (elapsed > patience .and. self%share > self%share_before)) return
      if (analysis == 'response' .and. self%steps < least_points) return
      if (any(analysis == curves) .and. elapsed < too_long .and. self%share - self%share_before < least_share) return
      rest = elapsed*(1 - self%share)/(self%share - self%share_before)
      whole = self%lead + elapsed + rest
      if (.not. (whole >= worth_telling .and. rest >= worth_telling/2)) return
      self%given = .true.
      self%expected = whole
      call self%causes(whole, elapsed, case, results, sentence)
      sentence = analysis//': about '//trim(duration_text(whole))//' expected'//sentence
      if (len(sentence) > forecast_length) sentence = sentence(:forecast_length)
   end subroutine look

   !> Forecasts an analysis anew that takes much longer than it was forecast, also within a step.
   subroutine renew(self, elapsed, case, sentence)
      class(forecast_type), intent(inout) :: self
      !> Time since `begin` [s].
      real(dp), intent(in) :: elapsed
      type(case_type), intent(in) :: case
      !> 'integration: about 5 min expected, not 40 s', or ''.
      character(:), allocatable, intent(inout) :: sentence
      real(dp) :: whole

      if (self%lead + elapsed < overdue*self%expected) return
      ! What is done of the present step is not known.
      whole = self%lead + max((1 + ahead)*elapsed, elapsed*(1 - self%share_before)/max(self%share - self%share_before, 1e-3_dp))
      sentence = trim(self%analysis)//': about '//trim(duration_text(whole))//' expected, not '// &
                 trim(duration_text(self%expected))
      self%expected = whole
      if (self%analysis /= 'integration' .or. .not. allocated(case%integration)) return
      if (case%integration%window == 0) sentence = sentence//': a motion repeats itself slowly or not at all; window = 100 of &
         &&integration takes the figures from 100 cycles of the slowest mesh'
   end subroutine renew

   !> Share of the analysis that is done [1]; 0 where nothing tells.
   real(dp) function share_done(self, done, value, case, results) result(share)
      class(forecast_type), intent(in) :: self
      integer, intent(in) :: done
      real(dp), intent(in) :: value
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      integer :: all, i

      all = all_steps(self%analysis, case)
      share = 0
      select case (self%analysis)
      case ('response')
         if (allocated(case%response)) share = share_of_range()
      case ('run up')
         ! A window takes as long at any speed, and time goes with the square of the speed.
         if (allocated(case%run_up)) then
            associate (from => case%run_up%start**2, to => case%run_up%stop**2, &
                       at => (value/lambda_per(case%train, case%run_up%unit))**2)
               if (abs(to - from) > 0) share = (at - from)/(to - from)
            end associate
         end if
      case ('refinement')
         all = 0
         if (allocated(results%response)) all = steps_to_refine(results%response)
         if (allocated(results%branches)) then
            do i = 1, size(results%branches)
               all = all + steps_to_refine(results%branches(i))
            end do
         end if
      case ('audit')
         all = self%audit_rows
      case ('locus')
         if (allocated(results%locus)) share = minval(results%locus%covered)
      end select
      if (all > 0) share = done/real(all, dp)
      share = min(1.0_dp, share)

   contains

      !> How far the branch has come from the end of the range at which it began; 0 where it has come back there. Points are closer
      !> at low speeds, where high harmonics are in resonance: of real gearboxes not as close as the logarithm would have them.
      real(dp) function share_of_range()
         real(dp) :: ends(2), far

         ends = [case%response%start, case%response%stop]
         if (case%response%parameter == '') ends = ends*lambda_per(case%train, case%response%unit)
         far = ends(merge(2, 1, abs(ends(2) - self%first) > abs(ends(1) - self%first)))
         share_of_range = 0
         if (abs(far - self%first) > 0) share_of_range = (value - self%first)/(far - self%first)
         if (case%response%parameter == '' .and. share_of_range > 0) &
            share_of_range = (share_of_range + log(value/self%first)/log(far/self%first))/2
      end function share_of_range

   end function share_done

   !> Steps of the refinement of a branch.
   pure integer function steps_to_refine(branch)
      type(branch_type), intent(in) :: branch

      steps_to_refine = branch%points
      if (allocated(branch%special_points)) steps_to_refine = steps_to_refine + size(branch%special_points)
   end function steps_to_refine

   !> Steps of an analysis by the variables of the case; 0: they do not tell.
   pure integer function all_steps(analysis, case) result(all)
      character(*), intent(in) :: analysis
      type(case_type), intent(in) :: case

      all = 0
      select case (analysis)
      case ('integration')
         if (allocated(case%integration)) all = case%integration%points*merge(2, 1, case%integration%direction == 'both')
      case ('attractors')
         if (allocated(case%attractors)) all = case%attractors%starts
      case ('random starts')
         if (allocated(case%basins)) all = case%basins%starts
      case ('basins')
         if (allocated(case%basins)) all = case%basins%velocity_points
      case ('bifurcation diagram')
         if (allocated(case%bifurcation_diagram)) &
            all = case%bifurcation_diagram%points*merge(2, 1, case%bifurcation_diagram%direction == 'both')
      case ('stability map')
         if (allocated(case%stability_map)) all = case%stability_map%parameter_points
      end select
   end function all_steps

   !> What makes an analysis long, in words that follow its duration.
   subroutine causes(self, whole, elapsed, case, results, words)
      class(forecast_type), intent(in) :: self
      !> Time of the whole analysis, and time so far [s].
      real(dp), intent(in) :: whole, elapsed
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      character(:), allocatable, intent(out) :: words
      character(:), allocatable :: period
      character(5) :: steps
      real(dp) :: share
      integer :: cycles, all

      words = ''
      call describe_period(case%train, 1, cycles, period)
      if (cycles > long_period) words = '; '//period
      all = max(all_steps(self%analysis, case), merge(self%audit_rows, 0, self%analysis == 'audit'))
      if (all > 0) then
         steps = merge('row  ', 'point', self%analysis == 'basins' .or. self%analysis == 'stability map' .or. &
                       self%analysis == 'audit')
         words = words//'; '//counted(all, trim(steps), trim(steps)//'s')//' of '//trim(duration_text(whole/all))
      end if
      if (self%analysis == 'response' .and. allocated(results%response)) then
         share = min(1.0_dp, (results%response%verdict_seconds - self%verdicts_before)/elapsed)
         if (share > most_of_it) then
            words = words//'; verdicts take '//integer_text(nint(100*share))//' % of the time: '//trim(off('stability'))// &
                    ' takes about '//trim(duration_text(whole*(1 - share)))
            if (cycles > long_period .and. case%response%multipliers) &
               words = words//', and '//trim(off('multipliers'))//' takes growth rates over a part of the period'
         else
            words = words//'; a point takes '//trim(duration_text(elapsed/self%steps))
         end if
      end if
      if (len(words) > 0) words(1:1) = ':'

   contains

      !> 'stability = .false.', or as a keyword, with blanks at the end.
      pure character(32) function off(name)
         character(*), intent(in) :: name

         off = name//' = .false.'
         if (self%in_python) off = name//'=False'
      end function off

   end subroutine causes

   !> A duration in words with blanks at the end: '0.3 s', '27 s', '3 min', '5 h', '2 days'.
   pure character(24) function duration_text(seconds) result(text)
      !> The duration [s], >= 0.
      real(dp), intent(in) :: seconds
      character(16) :: number

      if (seconds < 0.0995_dp) then
         text = integer_text(max(1, nint(1000*seconds)))//' ms'
      else if (seconds < 9.95_dp) then
         write (number, '(f4.1)') seconds
         text = trim(adjustl(number))//' s'
      else if (seconds < 99.5_dp) then
         text = integer_text(nint(seconds))//' s'
      else if (seconds < 5970) then
         text = integer_text(nint(seconds/60))//' min'
      else if (seconds < 48*3600) then
         text = integer_text(nint(seconds/3600))//' h'
      else
         text = integer_text(nint(min(1e9_dp, seconds/86400)))//' days'
      end if
   end function duration_text

end module geartrain_analyses_forecast
