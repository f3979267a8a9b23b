!> The damping of a train in numbers, each with its formula and source: coefficients of shafts and meshes, ratios of the modes.
module geartrain_report_explain_damping
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_network_modal_damping, only: find_modal_damping, modal_damping_type, resolve_damping
   use geartrain_report_damping_warnings, only: three_digits
   use geartrain_train_mesh, only: coupling_radius, is_given
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: damping_explanation_type

   type :: damping_explanation_type
      private
      !> The train as described, and modes of its plain train with damping coefficients.
      type(train_type) :: given
      type(modal_damping_type) :: found
   contains
      procedure :: setup
      procedure :: explain_modes
      procedure :: explain_element
   end type damping_explanation_type

contains

   !> Finds the damping.
   subroutine setup(self, given, plain)
      class(damping_explanation_type), intent(out) :: self
      !> The train as described; its plain train with mesh stiffnesses for its loads, before `resolve_damping`.
      type(train_type), intent(in) :: given, plain
      type(train_type) :: damped

      self%given = given
      damped = plain
      call resolve_damping(damped)
      call find_modal_damping(damped, self%found)
   end subroutine setup

   !> Adds natural frequencies and damping ratios of the modes.
   subroutine explain_modes(self, fields)
      class(damping_explanation_type), intent(in) :: self
      !> Gets the fields, in the group of the train.
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words
      real(dp), allocatable :: list(:)

      list = self%found%frequency/(2*pi)
      call carry(fields, field_type('natural_frequency', 'mode', 'Hz', 'of the undamped train at rest'), list)
      words = 'sum over shafts and meshes of the share of strain energy times omega c/(2 k): the diagonal of the modal damping &
         &matrix'
      if (is_given(self%given%modal_damping)) words = words//'; by modal_damping, least squares of the relative errors, c >= 0 &
         &(Lawson and Hanson, Solving Least Squares Problems, chapter 23)'
      list = self%found%ratio
      call carry(fields, field_type('mode_damping_ratio', 'mode', '1', words), list)
   end subroutine explain_modes

   !> Adds the damping coefficient of a shaft or mesh.
   subroutine explain_element(self, group, i, fields)
      class(damping_explanation_type), intent(in) :: self
      !> 'shaft', 'mesh' or 'coupling'.
      character(*), intent(in) :: group
      !> Its number; of a coupling among all meshes.
      integer, intent(in) :: i
      !> Gets the fields, in the group of the shaft or mesh.
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words
      real(dp) :: loss_factor, ratio, damping
      logical :: as_given
      integer :: n

      if (group == 'shaft') then
         n = findloc(self%found%shaft, i, 1)
         associate (shaft => self%given%shafts(i))
            loss_factor = shaft%loss_factor
            ratio = shaft%damping_ratio
            as_given = shaft%damping_given
         end associate
         damping = self%found%damping(n)*self%found%radius(n)**2
      else
         n = findloc(self%found%mesh, i, 1)
         associate (mesh => self%given%meshes(i))
            loss_factor = mesh%loss_factor
            ratio = mesh%damping_ratio
            as_given = mesh%damping_given
         end associate
         damping = self%found%damping(n)
         if (group == 'coupling') damping = damping*coupling_radius**2
      end if
      associate (mode => self%found%mode(n))
         if (as_given) then
            words = 'as given'
         else if (loss_factor > 0) then
            words = 'k loss_factor/omega, a damper with this loss factor at '// &
                    trim(three_digits(self%found%frequency(mode)/(2*pi)))//' Hz and in proportion to the frequency elsewhere: the &
                    &natural frequency of mode '//integer_text(mode)// &
                    ', of whose strain energy it has the share '//trim(three_digits(self%found%share(n, mode)))// &
                    ' (Rao, Mechanical Vibrations, hysteretic damping)'
         else if (ratio > 0) then
            words = '2 damping_ratio sqrt(k m) with m from the inertias at its two ends only'
         else if (is_given(self%given%modal_damping)) then
            words = 'by modal_damping'
         else
            words = 'none given'
         end if
      end associate
      call carry(fields, field_type('damping', '', trim(merge('N s/m    ', 'N m s/rad', group == 'mesh')), words), damping)
   end subroutine explain_element

end module geartrain_report_explain_damping
