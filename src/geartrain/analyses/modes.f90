!> The analysis &modes: natural frequencies, damping ratios and mode shapes of the mean system.
module geartrain_analyses_modes
   use geartrain_analyses_analysis, only: analysis_type, group_row_type
   use geartrain_analyses_modes_table, only: put_modes
   use geartrain_analyses_torque_table, only: torque_table_type
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_carry, only: carry
   use geartrain_base_error, only: error_type
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_base_sheet, only: sheet_type
   use geartrain_base_variable, only: visitor_type
   use geartrain_base_words, only: words_type
   use geartrain_network_natural_modes, only: modes_type, natural_modes
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: modes_analysis_type, modes_row

   type(group_row_type), parameter :: modes_row = group_row_type('modes', &
      'Asks for natural frequencies, damping ratios and mode shapes of the linear train.')

   type, extends(analysis_type) :: modes_analysis_type
      type(modes_type), pointer :: result => null()
   contains
      procedure :: visit_variables
      procedure :: run
      procedure :: tell_end
      procedure :: visit_fields
      procedure :: report
   end type modes_analysis_type

contains

   !> The group has no variables.
   subroutine visit_variables(self, v)
      class(modes_analysis_type), intent(inout) :: self
      class(visitor_type), intent(inout) :: v

      call v%enter('modes', 1)
      call v%leave()
   end subroutine visit_variables

   !> Modes take no time: those of an earlier run are replaced.
   subroutine run(self, train, error, observer, start)
      class(modes_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      type(error_type), allocatable, intent(out) :: error
      class(observer_type), intent(inout) :: observer
      type(motion_type), intent(in), optional :: start

      logical :: keep_going

      call natural_modes(train, self%result, error)
      if (allocated(error)) return
      ! The observer may show them at once: what follows may take long.
      keep_going = .true.
      call observer%on_step('modes', size(self%result%natural_frequency), 0.0_dp, keep_going)
   end subroutine run

   subroutine tell_end(self, early)
      class(modes_analysis_type), intent(in) :: self
      type(words_type), allocatable, intent(out) :: early

      if (.not. associated(self%result)) early = words_type('')
   end subroutine tell_end

   subroutine visit_fields(self, train, fields, summary)
      class(modes_analysis_type), intent(inout) :: self
      type(train_type), intent(in) :: train
      class(fields_type), intent(inout) :: fields
      logical, intent(in) :: summary
      integer :: n

      associate (modes => self%result)
         if (.not. fields%enter('/modes', 'natural modes of the linear train: mean mesh stiffness, all teeth in contact', .true.)) &
            return
         call fields%describe('coordinates', 'element_label')
         n = 0
         if (allocated(modes%natural_frequency)) n = size(modes%natural_frequency)
         call fields%index_axis('mode', n, 'elastic mode, by frequency; a rigid mode is left out')
         call carry(fields, row('element', 'element', '', 'elastic element in the order of the case: `shaft 1`, `mesh 1`, ...'), &
                    modes%element)
         call carry(fields, row('element_label', 'element', '', 'names of the two bodies of the element, such as `pinion - wheel`; &
                                &in a chain as `element`'), modes%element_label)
         call carry(fields, row('natural_frequency', 'mode', '1', &
                                'undamped natural frequency / characteristic_frequency'), &
                    modes%natural_frequency)
         call carry(fields, row('damped_frequency', 'mode', '1', &
                                'damped natural frequency / characteristic_frequency; 0 = overdamped'), &
                    modes%damped_frequency)
         call carry(fields, row('damping_ratio', 'mode', '1', 'damping ratio of the mode: -Re/|eigenvalue| of the damped mean &
                                &system'), modes%damping_ratio)
         call carry(fields, row('shape', 'mode element', '1', 'displacement of each element, largest 1; mesh: along the line of &
                                &action, shaft: twist times base radius'), modes%shape)
         if (fields%has('state', allocated(modes%state))) &
            call carry(fields, row('state', 'state', '', 'values of a state, as time integration gives it: `mesh 1`, displacement &
                                   &of this element; `rate of mesh 1`, its velocity', optional=.true.), modes%state)
         if (.not. fields%has('body', allocated(modes%body))) return
         call carry(fields, row('body', 'body', '', 'name of each body; in a chain `driving end`, `driving gear 1`, `driven gear &
                                &1`, ..., `driven end`', optional=.true.), modes%body)
         call carry(fields, row('rotation', 'mode body', '1', 'rotation of each body without the rotation of the whole train, &
                                &positive in its running sense, largest 1', optional=.true.), modes%rotation)
         call carry(fields, row('energy', 'mode element', 'N m', 'stiffness times squared displacement of each element in the &
                                &motion with this rotation, in rad', optional=.true.), modes%energy)
         if (fields%has('kind', allocated(modes%kind))) &
            call carry(fields, row('kind', 'mode', '', '`torsional`: the planets of each set move alike; `planets of NAME`: sun, &
                                   &ring and carrier stand still; else `mixed`', 'with planetary sets', optional=.true.), &
                       modes%kind)
         n = 0
         if (allocated(modes%rigid)) n = size(modes%rigid, 2)
         if (.not. fields%has('rigid_rotation', n > 0)) return
         call fields%index_axis('motion', n, 'independent motion that deflects no element')
         call carry(fields, row('rigid_rotation', 'motion body', '1', 'rotation of each body in the motions that deflect no &
                                &element, positive in its running sense, largest 1; none where springs to ground hold the train', &
                                optional=.true.), modes%rigid)
      end associate
   end subroutine visit_fields

   subroutine report(self, train, sheet, torques)
      class(modes_analysis_type), intent(in) :: self
      type(train_type), intent(in) :: train
      type(sheet_type), intent(inout) :: sheet
      type(torque_table_type), intent(inout) :: torques

      call put_modes(self%result, train, sheet)
   end subroutine report

end module geartrain_analyses_modes
