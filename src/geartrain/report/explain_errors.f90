!> What the errors of a mesh are in numbers: its transmission error, and the errors of its gears.
module geartrain_report_explain_errors
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_field, only: field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, integer_text, ordinal
   use geartrain_drawing_error_phase, only: lacks_phase
   use geartrain_train_gear_error, only: gear_words, has_gear_error
   use geartrain_train_kinematics, only: greatest_divisor
   use geartrain_train_mesh, only: is_given, mesh_type
   implicit none (type, external)
   private
   public :: explain_errors, explain_series, explain_teeth

contains

   !> Adds the errors to the group of a mesh.
   subroutine explain_errors(mesh, plain, fields)
      !> The mesh as given.
      type(mesh_type), intent(in) :: mesh
      !> The mesh in plain numbers.
      type(mesh_type), intent(in) :: plain
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words
      real(dp) :: mean

      words = 'as given'
      if (is_given(mesh%error_table)) words = 'of error_table'
      if (lacks_phase(mesh, plain)) words = 'as given; its phase against the stiffness is open: with another sign or with &
         &error_sin forces and loss of contact differ'
      call explain_series('error', 'error_harmonic', 'm', words, plain%error_cos, plain%error_sin, fields)
      words = 'as given'
      if (is_given(mesh%gear_error(1)%pitch) .or. is_given(mesh%gear_error(2)%pitch) .or. is_given(mesh%error_table)) &
         words = 'with the means of tables and pitch errors'
      mean = plain%error_mean
      if (abs(mean) > 0) &
         call carry(fields, field_type('error_mean', '', 'm', words//'; the mean forces of loops follow from it'), mean)
      call explain_gear(plain, 1, fields)
      call explain_gear(plain, 2, fields)
   end subroutine explain_errors

   !> Adds the errors of a gear.
   subroutine explain_gear(plain, gear, fields)
      type(mesh_type), intent(in) :: plain
      integer, intent(in) :: gear
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: which, words
      integer :: order

      which = trim(gear_words(gear))
      associate (error => plain%gear_error(gear))
         if (.not. has_gear_error(error)) return
         order = error%order
         call carry(fields, field_type(which//'_revolution_order', '', '1', 'revolution of the '//which//' gear, on a carrier &
            &against it, over the fundamental'), order)
         words = 'all errors of the '//which//' gear, orders 1, 2, ... of its revolution'
         call explain_series(which//'_error', which//'_order', 'm', words, error%cosine, error%sine, fields)
      end associate
   end subroutine explain_gear

   !> Adds the amplitudes of a series, which have one axis: the shorter list ends with zeros.
   subroutine explain_series(name, dimension, unit, words, cosine, sine, fields)
      !> Name before '_cos' and '_sin', of the axis, unit and meaning.
      character(*), intent(in) :: name, dimension, unit, words
      !> Amplitudes, of which either may be absent.
      real(dp), allocatable, intent(in) :: cosine(:), sine(:)
      !> Gets the fields.
      class(fields_type), intent(inout) :: fields
      integer :: orders

      orders = 0
      if (is_given(cosine)) orders = size(cosine)
      if (is_given(sine)) orders = max(orders, size(sine))
      call add('_cos', cosine)
      call add('_sin', sine)

   contains

      subroutine add(ending, values)
         character(*), intent(in) :: ending
         real(dp), allocatable, intent(in) :: values(:)
         real(dp), allocatable :: list(:)

         if (.not. is_given(values)) return
         allocate (list(orders), source=0.0_dp)
         list(:size(values)) = values
         call carry(fields, field_type(name//ending, dimension, unit, words), list)
      end subroutine add

   end subroutine explain_series

   !> Adds how the teeth of a pair meet.
   subroutine explain_teeth(mesh, fields)
      !> The mesh as given, with teeth.
      type(mesh_type), intent(in) :: mesh
      !> Gets the field.
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words, about

      call tell_teeth(nint(mesh%teeth), words)
      about = 'the model has identical teeth: the motion repeats with the fundamental, before the same teeth meet again'
      if (any(has_gear_error(mesh%gear_error))) about = 'the teeth have errors: the motion repeats with the fundamental'
      call carry_text(fields, field_type('tooth_ratio', '', '', about), words)
   end subroutine explain_teeth

   !> How the teeth of a pair meet, in words.
   subroutine tell_teeth(teeth, words)
      integer, intent(in) :: teeth(2)
      character(:), allocatable, intent(out) :: words
      integer :: common

      common = int(greatest_divisor(int(teeth(1), int64), int(teeth(2), int64)))
      words = integer_text(teeth(1))//':'//integer_text(teeth(2))
      if (common == 1) then
         words = words//', hunting: no common divisor, every tooth meets every tooth of the mate'
      else
         words = words//', not hunting: common divisor '//integer_text(common)//', a tooth meets only every '//ordinal(common) &
                 //' tooth of the mate'
      end if
      words = words//'; two teeth meet again after '//counted(teeth(2)/common, 'turn', 'turns')//' of the driving gear'
   end subroutine tell_teeth

end module geartrain_report_explain_errors
