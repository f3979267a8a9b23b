!> Units in which a frequency may be asked for: Lambda, the speed in rpm, or the frequency of the fundamental in Hz.
module geartrain_network_frequency_unit
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_variable, only: row => variable_type, visitor_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_train_kinematics, only: all_toothed
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_unit, lambda_of, lambda_per, speed_per_lambda, hertz_per_lambda, unit_length, visit_unit

   integer, parameter :: unit_length = 6

contains

   !> Leads a visitor over the variable `unit`.
   subroutine visit_unit(unit, v)
      !> The unit; set by a visitor that reads it.
      character(unit_length), intent(inout) :: unit
      !> The visitor.
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: word

      word = trim(unit)
      call v%on_text(row('unit', '', 'rpm only where every mesh has teeth', &
                         choices='Lambda rpm Hz'), word)
      unit = word
   end subroutine visit_unit

   !> Adds a problem where the train does not tell what the unit is.
   subroutine check_unit(train, unit, checker)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The unit.
      character(*), intent(in) :: unit
      class(checker_type), intent(inout) :: checker

      if (unit == 'Lambda' .or. checker%problems%of_train()) return
      if (lambda_per(train, unit) > 0) return
      if (unit == 'rpm' .and. .not. all_toothed(train)) then
         call checker%complain('unit', "'"//trim(unit)//"'", 'needs teeth of every mesh, which tell the speed: take Lambda or Hz')
      else
         call checker%complain('unit', "'"//trim(unit)//"'", 'the train as it stands does not tell how fast it turns')
      end if
   end subroutine check_unit

   !> Lambda per 1 of a unit; 0: not known.
   pure real(dp) function lambda_per(train, unit)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> 'Lambda', 'rpm' or 'Hz'.
      character(*), intent(in) :: unit
      type(train_type) :: plain

      lambda_per = 1
      if (unit == 'Lambda') return
      call plain_train(train, plain)
      lambda_per = lambda_of(plain, unit)
   end function lambda_per

   !> Lambda per 1 of a unit, of a plain train; 0: not known.
   pure real(dp) function lambda_of(plain, unit)
      !> The plain train.
      type(train_type), intent(in) :: plain
      !> 'Lambda', 'rpm' or 'Hz'.
      character(*), intent(in) :: unit

      lambda_of = merge(1, 0, unit == 'Lambda')
      if (unit == 'rpm' .and. plain%speed_ratio > 0) lambda_of = 1/speed_per_lambda(plain)
      if (unit == 'Hz' .and. plain%characteristic_frequency > 0) lambda_of = 1/hertz_per_lambda(plain)
   end function lambda_of

   !> Speed [rpm] at Lambda = 1; 0: not known.
   pure real(dp) function speed_per_lambda(plain)
      !> The plain train.
      type(train_type), intent(in) :: plain

      speed_per_lambda = 60*hertz_per_lambda(plain)*plain%speed_ratio
   end function speed_per_lambda

   !> Frequency of the fundamental [Hz] at Lambda = 1.
   pure real(dp) function hertz_per_lambda(plain)
      !> The plain train.
      type(train_type), intent(in) :: plain

      hertz_per_lambda = plain%characteristic_frequency/(2*pi)
   end function hertz_per_lambda

end module geartrain_network_frequency_unit
