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

   !> Most sentences of a short report.
   integer, parameter :: most = 6

contains

   !> Adds a sentence for each mesh, or for several with equal figures; in a short report for those with the largest force over the
   !> mean.
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
      type(sheet_type), intent(inout) :: sheet
      type(text_type) :: sentence(size(load, 1))
      character(:), allocatable :: words, meshes
      integer :: order(size(load, 1)), first(size(load, 1)), i, j, k
      logical :: shown(size(load, 1))

      ! Meshes without a mean force come last, those with the largest forces first.
      associate (strongest => maxval(load%force_maximum))
         order = ascending([(merge(-load(i, largest(i))%dynamic_factor, -load(i, largest(i))%force_maximum/strongest, &
                                   load(i, largest(i))%dynamic_factor >= 0), i=1, size(load, 1))])
      end associate
      do i = 1, size(load, 1)
         call say_mesh(load(i, largest(i)), told%number(at(largest(i))), i, words)
         sentence(i)%text = words
      end do
      ! Equal meshes, as those of equal planets, share a sentence.
      first = [(i, i=1, size(first))]
      do i = 2, size(first)
         do j = 1, i - 1
            if (sentence(j)%text == sentence(i)%text .and. index(names(i), 'bearing') /= 1) exit
         end do
         first(i) = j
      end do
      shown = .true.
      if (.not. sheet%verbose) then
         k = 0
         do i = 1, size(order)
            if (all(first(order(:i - 1)) /= first(order(i)))) k = k + 1
            if (k > most) exit
         end do
         shown(order(i:)) = .false.
         ! The largest force of all may be of a mesh whose mean is large as well.
         i = maxloc([(load(j, largest(j))%force_maximum, j=1, size(load, 1))], 1)
         where (first == first(i)) shown = .true.
         if (count(.not. shown) == 1) shown = .true.
      end if
      do i = 1, size(load, 1)
         if (.not. shown(i) .or. any(shown(:i - 1) .and. first(:i - 1) == first(i))) cycle
         words = 'M'//trim(names(i)(2:))
         if (index(names(i), 'bearing') == 1) words(1:1) = 'B'
         if (index(names(i), 'coupling') == 1) words(1:1) = 'C'
         meshes = ''
         do j = i + 1, size(load, 1)
            if (shown(j) .and. first(j) == first(i)) meshes = meshes//', '//trim(names(j)(index(names(j), ' ') + 1:))
         end do
         if (meshes /= '') words = trim(merge('Meshes   ', 'Couplings', index(names(i), 'mesh') == 1))// &
                                   trim(names(i)(index(names(i), ' '):))//meshes
         call sheet%say(in_result, words//sentence(i)%text//'.')
      end do
      if (all(shown)) return
      associate (factor => maxval([(load(i, largest(i))%dynamic_factor, i=1, size(load, 1))], .not. shown))
         words = 'The other '//counted(count(.not. shown), 'mesh', 'meshes')//': largest force '// &
                 significant(maxval([(load(i, largest(i))%force_maximum, i=1, size(load, 1))], .not. shown))//' N'
         if (factor >= 0) words = words//', at most '//significant(factor)//' times the mean'
      end associate
      k = count([(contact(i)%text /= '' .and. index(contact(i)%text, 'keeps contact') == 0, i=1, size(contact))] &
                .and. .not. shown)
      if (k > 0) words = words//'; '//counted(k, 'of them loses contact', 'of them lose contact')
      call sheet%say(in_result, words//'.')

   contains

      !> What is said of a mesh after its name.
      subroutine say_mesh(most_load, number, mesh, words)
         !> Its load where its force is largest, and Lambda there as text.
         type(mesh_load_type), intent(in) :: most_load
         character(*), intent(in) :: number
         integer, intent(in) :: mesh
         character(:), allocatable, intent(out) :: words
         character(:), allocatable :: place

         words = ': largest force '//significant(most_load%force_maximum)//' N'
         if (index(names(mesh), 'coupling') == 1) words = ': largest torque '//significant(most_load%force_maximum)//' N m'
         if (error(mesh)%text /= '') words = words//' ('//error(mesh)%text//')'
         if (most_load%dynamic_factor >= 0) words = words//', '//significant(most_load%dynamic_factor)//' times the mean,'
         if (most_load%dynamic_factor < 0) words = words//', without a mean force,'
         call told%with_unit(number, place)
         words = words//' at '//place
         if (at_end(largest(mesh))) words = words//', the end of the range'
         if (sweep(mesh)%text /= '') words = words//' ('//sweep(mesh)%text//')'
         if (contact(mesh)%text /= '') words = words//'; '//contact(mesh)%text
      end subroutine say_mesh

   end subroutine say_meshes

end module geartrain_analyses_mesh_sentences
