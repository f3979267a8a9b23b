!> Displacements of meshes as a report states them: true root mean square in um where the train has a unit of length, else the rms
!> of the paper over the characteristic length. The displacement of a coupling is 1 um for a twist of 1 mrad.
module geartrain_readings_length_text
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: significant
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: length_text, length_text_type

   type :: length_text_type
      !> Factors of an rms and of a displacement over the characteristic length [1 or um].
      real(dp) :: per_rms = 1, per_length = 1
      !> Whether the train has a unit of length.
      logical :: drawn = .false.
      !> The unit in brackets, blank without a unit of length; name of an rms, with the unit.
      character(11) :: unit = ''
      character(20) :: name = 'rms of the paper'
   contains
      procedure :: rms
   end type length_text_type

contains

   !> How a report states the displacements of a train.
   pure type(length_text_type) function length_text(train) result(lengths)
      !> The train as given.
      type(train_type), intent(in) :: train
      type(train_type) :: plain

      call plain_train(train, plain)
      lengths%drawn = abs(plain%characteristic_length - 1e-6_dp) < 1e-18_dp .or. abs(plain%characteristic_length - 1) < 1e-12_dp
      if (.not. lengths%drawn) return
      lengths%unit = '[um]'
      if (any(train%meshes%is_coupling)) lengths%unit = '[um, mrad]'
      if (any(train%meshes%is_coupling) .and. all(train%meshes%is_coupling)) lengths%unit = '[mrad]'
      lengths%name = 'true rms '//lengths%unit
      lengths%per_length = plain%characteristic_length/1e-6_dp
      ! The paper sums squared amplitudes; a true mean square is half of the sum.
      lengths%per_rms = lengths%per_length/sqrt(2.0_dp)
   end function length_text

   !> An rms as a number, with blanks at the end.
   pure function rms(self, value) result(text)
      class(length_text_type), intent(in) :: self
      !> rms of the paper over the characteristic length [1].
      real(dp), intent(in) :: value
      character(24) :: text

      text = significant(value*self%per_rms)
   end function rms

end module geartrain_readings_length_text
