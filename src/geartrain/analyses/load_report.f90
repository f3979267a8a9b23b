!> The table of largest mesh forces that the executable prints of a branch and of an integration.
module geartrain_analyses_load_report
   use geartrain_analyses_frequency_text, only: frequency_text_type, in_width
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_base_kinds, only: dp
   use geartrain_model_labels, only: label_length, mesh_labels
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: beyond, column_length, name_meshes, report_loads

   !> Said of a largest value at an end of the range.
   character(*), parameter :: beyond = '  at the end of the range: there may be more beyond', blank = repeat(' ', len(beyond))
   !> Length of the column of meshes.
   integer, parameter :: column_length = label_length + 24

contains

   !> The column of meshes in a table, to the right: its head, then each by its number, and by its bodies where they have names.
   subroutine name_meshes(train, column, first)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> The column, (0:mesh).
      character(column_length), intent(out) :: column(0:)
      !> Where the text of a column begins that is as wide as it needs to be.
      integer, intent(out) :: first
      character(label_length) :: labels(size(train%meshes))
      integer :: i

      labels = mesh_labels(train)
      column(0) = 'mesh'
      do i = 1, size(labels)
         write (column(i), '(i0)') i
         if (allocated(train%bodies)) column(i) = trim(column(i))//' ('//trim(labels(i))//')'
      end do
      first = column_length + 1 - max(8, 4 + maxval(len_trim(column)))
      column = adjustr(column)
   end subroutine name_meshes

   !> Writes the lines about the largest force of each mesh.
   subroutine report_loads(load, frequency_ratio, counts, at_end, told, column, note, unit)
      !> Loads, (mesh, motion).
      type(mesh_load_type), intent(in) :: load(:, :)
      !> Lambda of each motion [1], (motion).
      real(dp), intent(in) :: frequency_ratio(:)
      !> Whether a motion counts, at least one does; whether it lies at an end of the range, (motion).
      logical, intent(in) :: counts(:), at_end(:)
      !> How frequencies are told.
      type(frequency_text_type), intent(in) :: told
      !> Head of the column of meshes, and what each is called, (0:mesh).
      character(*), intent(in) :: column(0:)
      !> Said of the table.
      character(*), intent(in) :: note
      !> An open unit for formatted text.
      integer, intent(in) :: unit
      integer :: mesh, i

      write (unit, '(4a)') column(0), '  largest force [N]  dynamic factor', in_width('at '//told%unit, 11), note
      do mesh = 1, size(load, 1)
         i = maxloc(load(mesh, :)%force_maximum, 1, counts)
         write (unit, '(a, f19.1)', advance='no') column(mesh), load(mesh, i)%force_maximum
         if (load(mesh, i)%dynamic_factor < 0) write (unit, '(a16)', advance='no') '-'
         if (load(mesh, i)%dynamic_factor >= 0) write (unit, '(f16.3)', advance='no') load(mesh, i)%dynamic_factor
         write (unit, '(2a)') in_width(told%number(frequency_ratio(i)), 11), trim(merge(beyond, blank, at_end(i)))
      end do
   end subroutine report_loads

end module geartrain_analyses_load_report
