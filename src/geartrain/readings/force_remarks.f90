!> Remarks of a report on the largest force of a mesh: its estimated error, the slow sweep that does not reach it, and a larger
!> force where stability is lost.
module geartrain_readings_force_remarks
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: significant
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_readings_slow_sweeps, only: is_out_of_reach
   use geartrain_readings_stability_edges, only: with_edges
   use geartrain_trace_branch, only: branch_type
   use geartrain_mesh_law_law, only: law_type
   use geartrain_train_mesh, only: coupling_radius, put_law
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: add_edges, find_errors, find_sweeps

   !> Error up to which a force is as exact as the digits printed [1].
   real(dp), parameter :: negligible = 1e-3_dp

contains

   !> The error of the largest force of each mesh in words, 'error 0.5 %'; '' for a refined motion, which is exact.
   subroutine find_errors(branch, train, largest, words)
      type(branch_type), intent(in) :: branch
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Index of the point with the largest force of each mesh, (mesh).
      integer, intent(in) :: largest(:)
      !> The words, (mesh).
      type(text_type), intent(out) :: words(:)
      type(train_type) :: plain
      real(dp) :: error
      integer :: mesh

      call plain_train(train, plain)
      do mesh = 1, size(largest)
         words(mesh)%text = ''
         associate (i => largest(mesh))
            if (allocated(branch%correction)) then
               if (branch%correction(i) >= 0) cycle
            end if
            error = force_error(branch, plain, mesh, i)
            words(mesh)%text = 'error below '//significant(100*negligible)//' %'
            if (error > negligible) words(mesh)%text = 'error '//significant(100*two_digits(error))//' %'
            if (branch%estimate_doubtful(i)) words(mesh)%text = words(mesh)%text//', uncertain'
         end associate
      end do
   end subroutine find_errors

   !> Estimated error of the largest force of a mesh over this force [1]: the error of the waveform times the force of its rms in
   !> the stiffest stage, or times the largest force where this is larger. On 60 random trains refined motions differ by up to 2.3
   !> times this estimate, half of them by less than a fifth of it.
   pure real(dp) function force_error(branch, plain, mesh, i)
      type(branch_type), intent(in) :: branch
      !> The plain train.
      type(train_type), intent(in) :: plain
      integer, intent(in) :: mesh, i
      type(law_type) :: law

      call put_law(plain%meshes(mesh), plain%characteristic_length, law)
      associate (force => abs(branch%mesh_load(mesh, i)%force_maximum), &
                 vibration => maxval(law%stiffness)*plain%meshes(mesh)%stiffness*plain%characteristic_length*branch%rms(mesh, i) &
                              *merge(coupling_radius, 1.0_dp, plain%meshes(mesh)%is_coupling))
         force_error = branch%mesh_error_estimate(mesh, i)*max(1.0_dp, vibration/max(force, tiny(1.0_dp)))
      end associate
   end function force_error

   !> A number rounded up to two significant digits.
   pure real(dp) function two_digits(value)
      real(dp), intent(in) :: value
      real(dp) :: unit

      unit = 10.0_dp**(floor(log10(value)) - 1)
      two_digits = unit*ceiling(value/unit - 1e-9_dp)
   end function two_digits

   !> The slow sweep that does not reach the largest force of each mesh; '' where both reach it, or where it is not known.
   subroutine find_sweeps(branch, largest, words)
      !> The branch, with stability.
      type(branch_type), intent(in) :: branch
      !> Index of the stable point with the largest force of each mesh, (mesh).
      integer, intent(in) :: largest(:)
      !> The words, (mesh).
      type(text_type), intent(out) :: words(:)
      integer :: mesh

      do mesh = 1, size(largest)
         words(mesh)%text = ''
         associate (rising => .not. is_out_of_reach(branch, largest(mesh), 1), &
                    falling => .not. is_out_of_reach(branch, largest(mesh), -1))
            if (.not. rising) words(mesh)%text = 'not reached by a rising sweep'
            if (.not. falling) words(mesh)%text = 'not reached by a falling sweep'
            if (.not. (rising .or. falling)) words(mesh)%text = 'not reached by a slow sweep'
         end associate
      end do
   end subroutine find_sweeps

   !> Adds the force of each mesh where stability is lost, if it is larger than at the points.
   subroutine add_edges(branch, train, edges, largest, told, words)
      type(branch_type), intent(in) :: branch
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Special points where stability is lost, see `edges_of`.
      integer, intent(in) :: edges(:)
      !> Index of the stable point with the largest force of each mesh, (mesh).
      integer, intent(in) :: largest(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      !> The words, (mesh).
      type(text_type), intent(inout) :: words(:)
      real(dp) :: force(size(largest), branch%points + size(edges))
      character(:), allocatable :: place
      integer :: mesh, i

      if (size(edges) == 0) return
      force = with_edges(branch, edges, branch%mesh_load(:, :branch%points)%force_maximum)
      do mesh = 1, size(largest)
         i = maxloc(force(mesh, branch%points + 1:), 1)
         associate (edge => force(mesh, branch%points + i), special => branch%special_points(edges(i)))
            if (.not. edge > (1 + negligible)*force(mesh, largest(mesh))) cycle
            call told%with_unit(told%number(special%frequency_ratio), place)
            if (words(mesh)%text /= '') words(mesh)%text = words(mesh)%text//'; '
            words(mesh)%text = words(mesh)%text//'up to '//significant(edge)// &
                               merge(' N m', ' N  ', train%meshes(mesh)%is_coupling)
            words(mesh)%text = trim(words(mesh)%text)//' where stability is lost, at '//place
         end associate
      end do
   end subroutine add_edges

end module geartrain_readings_force_remarks
