!> The sentence of the report of a run-up on a force that changes its sign by damping alone.
module geartrain_analyses_run_up_pulling
   use geartrain_base_kinds, only: dp
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_flow_ramped_flow, only: run_up_type
   use geartrain_train_mesh_groups, only: mesh_word
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_pulling

   !> Force that is rounding, over the largest force of the mesh [1].
   real(dp), parameter :: rounding = 1e-9_dp

contains

   !> Finds the first mesh whose force changes its sign though its unloaded flanks do not touch, as far as the samples show.
   subroutine say_pulling(train, result, static_force, windows, sentence)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The run-up.
      type(run_up_type), intent(in) :: result
      !> Static force of each mesh before the run-up [1], (mesh).
      real(dp), intent(in) :: static_force(:)
      !> Number of windows, at least one.
      integer, intent(in) :: windows
      !> The sentence; '' where there is no such mesh.
      character(:), allocatable, intent(out) :: sentence
      type(train_type) :: plain
      character(:), allocatable :: note
      logical :: coasts
      integer :: i

      sentence = ''
      call plain_train(train, plain)
      do i = 1, size(plain%meshes)
         coasts = static_force(i) < 0
         associate (mesh => plain%meshes(i), p => result%displacement(i, :result%samples)*plain%characteristic_length)
            if (mesh%half_backlash <= 0 .or. mesh%axis > 0) cycle
            ! Where teeth are apart the force is 0 to rounding.
            associate (least => rounding*maxval(abs([result%force_minimum(i, :windows), result%force_maximum(i, :windows)])))
               if (.not. coasts .and. minval(result%force_minimum(i, :windows)) >= -least) cycle
               if (coasts .and. maxval(result%force_maximum(i, :windows)) <= least) cycle
            end associate
            if (.not. coasts .and. minval(p) < -mesh%half_backlash .or. coasts .and. maxval(p) > mesh%half_backlash) cycle
            note = ''
            if (mesh%damping_acts == 'always') note = " and while they are apart. With damping_acts = 'contact' in &"// &
                                                      trim(merge('coupling', 'mesh    ', mesh%is_coupling))// &
                                                      ' it acts in contact only'
         end associate
         sentence = 'The force of '//trim(mesh_word(train%meshes, i))//' changes its sign although the unloaded flanks do not &
                    &touch: its damping pulls while the teeth separate'//note//'.'
         return
      end do
   end subroutine say_pulling

end module geartrain_analyses_run_up_pulling
