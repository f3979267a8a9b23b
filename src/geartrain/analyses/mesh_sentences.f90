!> The sentence of a report on each mesh: its largest force, where it occurs, and where the mesh loses contact.
module geartrain_analyses_mesh_sentences
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_base_field, only: text_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant
   use geartrain_base_sheet, only: in_result, sheet_type
   use geartrain_base_sorting, only: ascending
   use geartrain_readings_frequency_text, only: frequency_text_type
   implicit none (type, external)
   private
   public :: say_meshes

   !> Most meshes of a short report.
   integer, parameter :: most = 6

contains

   !> Adds a sentence for each mesh; in a short report of many meshes for those with the largest force over the mean.
   subroutine say_meshes(load, largest, at, at_end, error, sweep, contact, names, told, sheet)
      !> Loads, (mesh, motion).
      type(mesh_load_type), intent(in) :: load(:, :)
      !> Number of the motion with the largest force of each mesh, (mesh).
      integer, intent(in) :: largest(:)
      !> Lambda, or the parameter, of each motion, (motion).
      real(dp), intent(in) :: at(:)
      !> Whether a motion lies at an end of the range, (motion).
      logical, intent(in) :: at_end(:)
      !> Error of the largest force, sweep that does not reach it, and contact of each mesh; '' for nothing, (mesh).
      type(text_type), intent(in) :: error(:), sweep(:), contact(:)
      !> Name of each mesh, (mesh).
      character(*), intent(in) :: names(:)
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      !> The report.
      type(sheet_type), intent(inout) :: sheet
      character(:), allocatable :: words, place
      integer :: order(size(load, 1)), i, k
      logical :: shown(size(load, 1))

      ! Meshes without a mean force come last, those with the largest forces first.
      associate (strongest => maxval(load%force_maximum))
         order = ascending([(merge(-load(i, largest(i))%dynamic_factor, -load(i, largest(i))%force_maximum/strongest, &
                                   load(i, largest(i))%dynamic_factor >= 0), i=1, size(load, 1))])
      end associate
      shown = .true.
      if (.not. sheet%verbose) shown(order(most + 1:)) = .false.
      do i = 1, size(load, 1)
         if (.not. shown(i)) cycle
         k = largest(i)
         words = 'M'//trim(names(i)(2:))//': largest force '//significant(load(i, k)%force_maximum)//' N'
         if (index(names(i), 'bearing') == 1) words(1:1) = 'B'
         if (index(names(i), 'coupling') == 1) words = 'C'//trim(names(i)(2:))//': largest torque '// &
                                                       significant(load(i, k)%force_maximum)//' N m'
         if (error(i)%text /= '') words = words//' ('//error(i)%text//')'
         if (load(i, k)%dynamic_factor >= 0) words = words//', '//significant(load(i, k)%dynamic_factor)//' times the mean,'
         if (load(i, k)%dynamic_factor < 0) words = words//', without a mean force,'
         call told%with_unit(told%number(at(k)), place)
         words = words//' at '//place
         if (at_end(k)) words = words//', the end of the range'
         if (sweep(i)%text /= '') words = words//' ('//sweep(i)%text//')'
         if (contact(i)%text /= '') words = words//'; '//contact(i)%text
         call sheet%say(in_result, words//'.')
      end do
      if (all(shown)) return
      associate (next => order(most + 1))
         words = 'The other '//counted(count(.not. shown), 'mesh', 'meshes')//': largest force '// &
                 significant(maxval([(load(i, largest(i))%force_maximum, i=1, size(load, 1))], .not. shown))//' N'
         if (load(next, largest(next))%dynamic_factor >= 0) words = words//', at most '// &
            significant(load(next, largest(next))%dynamic_factor)//' times the mean'
      end associate
      k = count([(contact(i)%text /= '' .and. index(contact(i)%text, 'keeps contact') == 0, i=1, size(contact))] &
                .and. .not. shown)
      if (k > 0) words = words//'; '//counted(k, 'of them loses contact', 'of them lose contact')
      call sheet%say(in_result, words//'.')
   end subroutine say_meshes

end module geartrain_analyses_mesh_sentences
