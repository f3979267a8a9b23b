!> Warnings of a drawing: where a formula is used outside the range that its source gives, and where teeth are cut or meet as no
!> involute.
module geartrain_model_drawing_warnings
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: integer_text, short => text
   use geartrain_model_drawing, only: has_geometry, has_stiffness, pair_of, plain_train, reduce_light_loads
   use geartrain_model_gear_pair, only: find_geometry, light_load, pair_geometry_type
   use geartrain_model_mesh, only: is_given, mesh_type
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: find_warnings, warnings_text

   !> Largest line load of ISO 6336-1, method B [N/m].
   real(dp), parameter :: heavy_load = 1.6e6_dp

contains

   !> The warnings as text, a line each.
   subroutine warnings_text(train, text)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> Lines; '' without warnings.
      character(:), allocatable, intent(out) :: text
      type(text_type), allocatable :: warnings(:)
      integer :: i

      call find_warnings(train, warnings)
      text = ''
      do i = 1, size(warnings)
         text = text//warnings(i)%text//new_line('a')
      end do
   end subroutine warnings_text

   !> Lists where a formula is used outside the range that its source gives, and where teeth are cut or meet as no involute.
   subroutine find_warnings(train, warnings)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> A sentence each.
      type(text_type), allocatable, intent(out) :: warnings(:)
      type(train_type) :: plain
      type(system_type) :: system
      real(dp), allocatable :: light(:)
      integer :: i

      allocate (warnings(0))
      if (.not. any([(has_geometry(train%meshes(i)), i=1, size(train%meshes))])) return
      call plain_train(train, plain)
      call reduce_light_loads(plain, light)
      call build_system(train, system)
      do i = 1, size(train%meshes)
         if (has_geometry(train%meshes(i))) call warn_of_mesh(train%meshes(i), i, system, light(i), warnings)
      end do
   end subroutine find_warnings

   subroutine warn_of_mesh(mesh, i, system, light, warnings)
      type(mesh_type), intent(in) :: mesh
      integer, intent(in) :: i
      type(system_type), intent(in) :: system
      !> Factor of the mesh stiffness by a light load [1].
      real(dp), intent(in) :: light
      type(text_type), allocatable, intent(inout) :: warnings(:)
      type(pair_geometry_type) :: geometry
      real(dp) :: shift(2), line_load
      integer :: k, n

      n = system%mesh_element(i)
      associate (g => geometry)
         call find_geometry(pair_of(mesh), geometry)
         do k = 1, 2
            if (g%undercut(k) > 0) call add('the gear of '//integer_text(nint(mesh%teeth(k)))//' teeth is undercut: its profile &
               &shift is '//short(g%undercut(k))//' below the least without undercut; contact ratio and stiffness hold for whole &
               &involutes')
         end do
         if (g%clear_of_base < 0) call add('the tip of a gear reaches '//short(-g%clear_of_base)//' m beyond the base circle of &
            &its mate along the line of action: the flanks interfere')
         if (.not. has_stiffness(mesh)) return
         shift = 0
         if (is_given(mesh%profile_shift)) shift = mesh%profile_shift
         if (mesh%teeth(1) > mesh%teeth(2)) shift = shift([2, 1])
         if (shift(1) < shift(2)) call add('the stiffness by ISO 6336-1 is for a profile shift of the pinion not below that of the &
            &wheel, and they are '//short(shift(1))//' and '//short(shift(2)))
         if (sum(shift) < -0.5_dp .or. sum(shift) > 2) call add('the stiffness by ISO 6336-1 is for profile shifts with a sum from &
            &-0.5 to 2, and it is '//short(sum(shift)))
         if (abs(mesh%helix_angle) > 30) call add('the mesh stiffness by ISO 6336-1 is for helix angles up to 30 degrees, and it &
                                                  &is '//short(mesh%helix_angle))
         if (g%contact_ratio < 1.2_dp) call add('the mesh stiffness by ISO 6336-1 is for contact ratios from 1.2 on, and it is '// &
                                                short(g%contact_ratio))
         line_load = abs(system%static_force(n)*system%stiffness(n)*system%characteristic_length)*cos(g%transverse_angle) &
                     /mesh%face_width
         if (line_load > heavy_load) call add('the stiffness by ISO 6336-1 is for line loads up to 1600 N/mm, and it is '// &
                                              short(line_load/1000)//' N/mm')
         if (.not. line_load > 0) then
            call add('it bears no load, for which ISO 6336-1 has no stiffness: that of a line load of 100 N/mm is taken; stiffness &
               &[N/m] gives another, or a torque of drag on the unloaded body the load')
         else if (line_load < 0.01_dp*light_load) then
            call add('its line load is '//short(line_load/1000)//' N/mm, far below the loads that ISO 6336-1 is for: the &
               &stiffness by its rule for light loads, (load/100 N/mm)^0.25 = '//short(light)// &
               ' of the full one, is a guess; stiffness [N/m] gives another')
         end if
      end associate

   contains

      subroutine add(sentence)
         character(*), intent(in) :: sentence
         type(text_type) :: warning

         warning%text = '&mesh '//integer_text(i)//': '//sentence
         warnings = [warnings, warning]
      end subroutine add

   end subroutine warn_of_mesh

end module geartrain_model_drawing_warnings
