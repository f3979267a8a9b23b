!> Checks of damping that follows from the modes: loss factors and damping ratios of modes.
module geartrain_network_check_damping
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, real_text
   use geartrain_train_mesh, only: is_given
   use geartrain_train_mesh_groups, only: group_name, group_number
   use geartrain_network_network, only: state_count
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_damping

contains

   !> Checks that damping has one source.
   subroutine check_damping(train, checker)
      !> The train, with any values.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      integer :: i, modes

      if (.not. (allocated(train%shafts) .and. allocated(train%meshes))) return
      do i = 1, size(train%shafts)
         associate (shaft => train%shafts(i))
            call check_element('shaft', i, shaft%loss_factor, shaft%damping_ratio, shaft%damping, shaft%damping_given)
            if (shaft%rigid .and. shaft%loss_factor > 0) call complain('shaft', i, 'loss_factor', shaft%loss_factor, &
                                                                       'contradicts rigid = .true.: leave out one of the two')
         end associate
      end do
      do i = 1, size(train%meshes)
         associate (mesh => train%meshes(i))
            call check_element(trim(group_name(train%meshes, i)), group_number(train%meshes, i), mesh%loss_factor, &
                               mesh%damping_ratio, mesh%damping, mesh%damping_given)
         end associate
      end do
      if (.not. is_given(train%modal_damping) .or. checker%problems%of_train()) return
      modes = state_count(train)/2
      if (size(train%modal_damping) > modes) then
         call complain('train', 1, 'modal_damping', train%modal_damping(modes + 1), 'is value '//integer_text(modes + 1)// &
                       ', but the train has '//integer_text(modes)//' elastic modes')
      else if (all(train%meshes%damping_ratio > 0 .or. train%meshes%damping > 0 .or. train%meshes%loss_factor > 0) .and. &
               all(train%shafts%damping_ratio > 0 .or. train%shafts%damping > 0 .or. train%shafts%loss_factor > 0 .or. &
                   train%shafts%rigid)) then
         call complain('train', 1, 'modal_damping', train%modal_damping(1), 'needs a shaft, mesh or coupling without damping of &
                       &its own: leave out damping_ratio, damping and loss_factor where modal_damping is to give the damping')
      end if

   contains

      subroutine check_element(group, index, loss_factor, ratio, damping, given)
         character(*), intent(in) :: group
         integer, intent(in) :: index
         real(dp), intent(in) :: loss_factor, ratio, damping
         logical, intent(in) :: given

         if (.not. loss_factor > 0) return
         if (ratio > 0) call complain(group, index, 'damping_ratio', ratio, 'contradicts loss_factor: leave out one of the two')
         if (given .or. damping > 0) call complain(group, index, 'damping', damping, &
                                                   'contradicts loss_factor: leave out one of the two')
      end subroutine check_element

      subroutine complain(group, index, name, value, what)
         character(*), intent(in) :: group, name, what
         integer, intent(in) :: index
         real(dp), intent(in) :: value

         call checker%enter(group, index)
         call checker%complain(name, real_text(value), what)
         call checker%leave()
      end subroutine complain

   end subroutine check_damping

end module geartrain_network_check_damping
