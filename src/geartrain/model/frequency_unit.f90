!> Units in which a case gives frequencies.
module geartrain_model_frequency_unit
   use geartrain_base_kinds, only: dp, pi
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: frequency_ratio_of, unit_choices

   !> The units: of Lambda, and of the fundamental mesh frequency.
   character(*), parameter :: unit_choices = 'Lambda Hz'

contains

   !> Lambda [1] of a frequency.
   pure real(dp) function frequency_ratio_of(train, value, unit) result(frequency_ratio)
      !> The train.
      type(train_type), intent(in) :: train
      !> The frequency [unit].
      real(dp), intent(in) :: value
      !> One of `unit_choices`.
      character(*), intent(in) :: unit

      frequency_ratio = value
      if (unit == 'Hz') frequency_ratio = 2*pi*value/train%characteristic_frequency
   end function frequency_ratio_of

end module geartrain_model_frequency_unit
