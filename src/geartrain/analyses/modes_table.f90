!> The natural modes in a report: frequency, damping ratio and where the mode deflects most.
module geartrain_analyses_modes_table
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_sheet, only: in_modes, sheet_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: hertz_per_lambda
   use geartrain_network_modal_damping, only: asked_ratios
   use geartrain_network_natural_modes, only: modes_type
   use geartrain_readings_frequency_text, only: frequency_text, frequency_text_type, in_width
   use geartrain_train_mesh, only: is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: put_modes

   !> Most modes of a short report.
   integer, parameter :: most = 8
   !> Relative deviation from `modal_damping` from which on a mode is marked [1]; rounding of a damping ratio [1].
   real(dp), parameter :: worth_telling = 0.05_dp, rounding = 1e-9_dp

contains

   !> Adds the table of modes.
   subroutine put_modes(modes, train, sheet)
      type(modes_type), intent(in) :: modes
      !> The train as given.
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(train_type) :: plain
      type(frequency_text_type) :: told
      character(:), allocatable :: line
      real(dp), allocatable :: asked(:)
      logical, allocatable :: missed(:)
      integer :: i, n, largest

      if (.not. allocated(modes%natural_frequency)) return
      call plain_train(train, plain)
      told = frequency_text(train, 'Lambda', 0.0_dp)
      n = size(modes%natural_frequency)
      if (.not. sheet%verbose) n = min(n, most)
      if (n == size(modes%natural_frequency) - 1) n = n + 1
      allocate (missed(size(modes%natural_frequency)), source=.false.)
      if (is_given(train%modal_damping)) then
         asked = asked_ratios(train, size(missed))
         missed = abs(modes%damping_ratio - asked) > worth_telling*asked + rounding
      end if
      line = 'mode'
      if (told%unit == 'Lambda') line = line//'    Lambda'
      call sheet%add(in_modes, line//'          Hz  damping ratio [%]  deflects most')
      associate (hertz => hertz_per_lambda(plain))
         do i = 1, n
            line = in_width(text(i), 4)
            if (told%unit == 'Lambda') line = line//in_width(significant(modes%natural_frequency(i)), 10)
            largest = maxloc(abs(modes%shape(:, i)), 1)
            ! A radian of a coupling is no length: where there is one, the energies are compared. So they are beside
            ! bearings, which move as far as their meshes deflect.
            if (any(index(modes%element, 'coupling') == 1 .or. index(modes%element, 'bearing') == 1)) &
               largest = maxloc(modes%energy(:, i), 1)
            line = line//in_width(significant(modes%natural_frequency(i)*hertz), 12)// &
                   in_width(significant(100*modes%damping_ratio(i)), 19)//'  '//trim(modes%element(largest))
            if (modes%element_label(largest) /= modes%element(largest)) line = line//' ('//trim(modes%element_label(largest))//')'
            if (allocated(modes%kind)) line = line//'; '//trim(modes%kind(i))
            if (missed(i)) line = line//'; modal_damping asks for '//significant(100*asked(i))//' %'
            call sheet%add(in_modes, line)
         end do
         if (n == size(modes%natural_frequency)) return
         line = 'and '//counted(size(modes%natural_frequency) - n, 'mode', 'modes')//' up to '// &
                significant(hertz*modes%natural_frequency(size(modes%natural_frequency)))//' Hz'
         if (any(missed(n + 1:))) line = line//', '//text(count(missed(n + 1:)))//' of them without the damping that &
                                         &modal_damping asks for'
         call sheet%say(in_modes, line)
      end associate
   end subroutine put_modes

end module geartrain_analyses_modes_table
