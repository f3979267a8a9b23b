!> Trains whose motions repeat themselves only after hundreds of cycles of a mesh, as those of hunting teeth do. What flies over
!> whole periods takes minutes to days there. Such work is refused before it begins, with the reason, unless the user insists.
module geartrain_network_long_period
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_checker, only: checker_type
   use geartrain_base_error, only: error_type, fatal, status_input
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_train_kinematics, only: find_kinematics, kinematics_type
   use geartrain_network_limits, only: in_order
   use geartrain_network_system, only: put_excitation, system_type
   use geartrain_train_train, only: train_type
   use geartrain_base_variable, only: row => variable_type, visitor_type
   implicit none (type, external)
   private
   public :: check_long_period, check_variable, describe_period, long_period, refuse_long_period, visit_long_period

   !> Cycles of the fastest mesh in a period above which the period is long.
   integer, parameter :: long_period = 500
   !> What is computed in place of what is refused.
   character(*), parameter :: instead = ': use &integration, or numbers of teeth with common factors'

contains

   !> Leads a visitor over the variable `long_period` of an analysis that flies over whole periods.
   subroutine visit_long_period(insists, v)
      !> The value; set by a visitor that reads it.
      logical, intent(inout) :: insists
      !> The visitor.
      class(visitor_type), intent(inout) :: v

      call v%on_logical(row('long_period', '', 'allow periods of more than 500 mesh cycles; takes minutes to days'), insists)
   end subroutine visit_long_period

   !> Adds a problem of the whole group where the period is long and the user does not insist; nothing for a train not `in_order`.
   subroutine check_long_period(train, group, why, insists, checker)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Group of the analysis; what it does over whole periods, as in 'every start flies over many periods'.
      character(*), intent(in) :: group, why
      !> Value of its variable `long_period`.
      logical, intent(in) :: insists
      class(checker_type), intent(inout) :: checker
      character(:), allocatable :: words

      if (insists) return
      call find_words(train, 1, checker, words)
      if (words /= '') call checker%problems%add(words//', and '//why//instead//', or insist with long_period = .true.', group, 1)
   end subroutine check_long_period

   !> Adds a problem of a variable of &response that needs the multipliers of whole periods, where the period is long and the user
   !> does not ask for them; nothing for a train not `in_order`.
   subroutine check_variable(train, periods, name, value, why, insists, checker)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Period of the motions [periods of the fundamental].
      integer, intent(in) :: periods
      !> The variable, its value, and what it needs.
      character(*), intent(in) :: name, value, why
      !> Whether the case asks for the multipliers.
      logical, intent(in) :: insists
      class(checker_type), intent(inout) :: checker
      character(:), allocatable :: words

      if (insists) return
      call find_words(train, periods, checker, words)
      if (words /= '') call checker%complain(name, value, why//', and '//words//instead//', or insist with stability = .true. and &
                                             &multipliers = .true.')
   end subroutine check_variable

   !> Makes it an error where the period of the fundamental is long and the user does not insist.
   subroutine refuse_long_period(train, what, way, insists, error)
      !> A train that check_train accepts.
      type(train_type), intent(in) :: train
      !> What needs whole periods, as in 'audit: solves anew over whole periods'; what to do about it.
      character(*), intent(in) :: what, way
      !> Nothing is refused.
      logical, intent(in) :: insists
      !> Bad input.
      type(error_type), allocatable, intent(inout) :: error
      character(:), allocatable :: words
      integer :: cycles

      if (insists) return
      call describe_period(train, 1, cycles, words)
      if (cycles > long_period) call fatal(error, what//', and '//words//': '//way, status_input)
   end subroutine refuse_long_period

   !> The period in words where it is long, else ''.
   subroutine find_words(train, periods, checker, words)
      type(train_type), intent(in) :: train
      integer, intent(in) :: periods
      class(checker_type), intent(in) :: checker
      character(:), allocatable, intent(out) :: words
      type(train_type) :: plain
      integer :: cycles

      words = ''
      call plain_train(train, plain)
      if (.not. in_order(plain, checker)) return
      call describe_period(train, periods, cycles, words)
      if (cycles <= long_period) words = ''
   end subroutine find_words

   !> How long a period is: 'the period is 328 turns of generator, 7216 mesh cycles'.
   subroutine describe_period(train, periods, cycles, words)
      !> A train in order, as given.
      type(train_type), intent(in) :: train
      !> Period of the motions [periods of the fundamental].
      integer, intent(in) :: periods
      !> Cycles of the fastest mesh in a period; of a motion of period 1 in its waveform, which may repeat itself in the period.
      integer, intent(out) :: cycles
      !> The period in words.
      character(:), allocatable, intent(out) :: words
      type(train_type) :: plain
      type(system_type) :: system
      type(kinematics_type) :: kinematics
      real(dp) :: turns
      integer :: repeats

      call plain_train(train, plain)
      call put_excitation(plain, system)
      repeats = 1
      if (periods == 1) repeats = max(1, system%excitation_order)
      cycles = int(min(int(huge(1), int64), int(periods, int64)*maxval([1, plain%meshes%order])/repeats))
      words = 'the period is '
      turns = plain%speed_ratio*periods/repeats
      if (turns > 0) then
         if (abs(turns - anint(turns)) > 1e-6_dp*turns) words = words//'about '
         words = words//counted(nint(turns), 'turn', 'turns')//' of '
         call find_kinematics(train, kinematics)
         if (allocated(train%bodies) .and. kinematics%speed_body > 0) then
            words = words//train%bodies(kinematics%speed_body)%name
         else
            words = words//'the driving end'
         end if
         words = words//', '
      end if
      words = words//counted(cycles, 'mesh cycle', 'mesh cycles')
   end subroutine describe_period

end module geartrain_network_long_period
