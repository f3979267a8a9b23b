!> The fields of a stability map: the group /stability_map, while the map is under way with which rows are done.
module geartrain_analyses_stability_map_fields
   use geartrain_analyses_stability_map_settings, only: stability_map_settings_type, stability_map_type
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type, listing, reading
   use geartrain_base_kinds, only: dp
   use geartrain_flow_fields, only: about_frequency, about_mesh
   implicit none (type, external)
   private
   public :: visit_stability_map

   character(*), parameter :: home = '/stability_map', grid = 'parameter frequency'

contains

   subroutine visit_stability_map(map, settings, fields)
      type(stability_map_type), allocatable, intent(inout) :: map
      !> As asked for, to be taken back; not allocated: any map is.
      type(stability_map_settings_type), allocatable, intent(in) :: settings
      class(fields_type), intent(inout) :: fields
      type(stability_map_type) :: part

      if (.not. fields%enter(home, 'stability over frequency and one parameter of the train', allocated(map))) return
      if (.not. allocated(map)) allocate (map)
      if (allocated(map%rows) .and. fields%way /= reading) then
         part = map
         call part%gather()
         call visit_grid(part, fields)
      else
         call visit_grid(map, fields)
      end if
      if (fields%way == listing) return
      call visit_rows(map, fields)
      if (fields%way /= reading .or. allocated(fields%wrong) .or. .not. allocated(settings)) return
      call fields%check(map%linear .eqv. settings%linear, 'linear')
      if (allocated(map%frequency_ratio)) call fields%check(size(map%frequency_ratio) == settings%points, 'frequency')
      if (allocated(map%done)) call fields%check(size(map%done) == settings%parameter_points .or. .not. map%complete .and. &
                                                 .not. allocated(map%rows), 'row_done')
   end subroutine visit_stability_map

   subroutine visit_grid(map, fields)
      type(stability_map_type), intent(inout) :: map
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: radius(:, :)
      logical :: begun
      integer :: meshes

      call carry_text(fields, row('ended', '', '', 'why it ended, in words'), map%ended, 'not yet: these are the rows so far')
      call carry(fields, row('complete', '', '', '1: all rows are done, and the branch of each got through the range'), &
                 map%complete)
      begun = fields%has('parameter', allocated(map%parameter))
      call carry(fields, row('linear', '', '', '1: of the train without backlash', optional=.not. begun), map%linear)
      if (.not. begun) return
      call carry_text(fields, row('parameter_name', '', '', 'what varies from row to row'), map%name)
      call carry_text(fields, row('parameter_unit', '', '', 'its unit'), map%unit)
      call carry(fields, row('parameter', 'parameter', unit_of(map), 'the parameter, in its own unit'), map%parameter)
      call carry(fields, row('frequency', 'frequency', '1', about_frequency), map%frequency_ratio)
      call carry(fields, row('row_done', 'parameter', '1', '1 = the row is computed; rows that are not are left out'), map%done)
      call carry(fields, row('row_whole', 'parameter', '1', '1 = the branch of the row got through the range; 0 = not: motions may &
                             &be missing'), map%whole)
      call carry(fields, row('motions', grid, '1', 'motions of the mesh period on the branch of the row', least=0), map%motions)
      call carry(fields, row('stable_motions', grid, '1', 'how many of them are stable; 0: the train does something else, of a &
                             &longer period or of none', least=0), map%stable_motions)
      if (allocated(map%multiplier)) radius = abs(map%multiplier)
      if (fields%way /= reading) call carry(fields, row('spectral_radius', grid, '1', 'largest magnitude of a Floquet multiplier &
         &over a mesh period, of the motion that has it smallest: below 1 there is a stable motion; NaN: no motion'), radius)
      call carry(fields, row('multiplier', grid//' complex', '1', 'that multiplier: near +1 there is a fold or a resonance at a &
                             &natural frequency, near -1 the period doubles'), map%multiplier)
      if (.not. fields%has('rms', allocated(map%rms))) then
         call fields%check(map%linear, 'rms')
         return
      end if
      meshes = 0
      if (allocated(map%rms)) meshes = size(map%rms, 1)
      call fields%index_axis('mesh', meshes, about_mesh)
      call carry(fields, row('rms', grid//' mesh', '1', 'largest rms of the stable motions / characteristic_length, the rms of &
                             &/response; NaN: no stable motion', 'without `linear`'), map%rms)
   end subroutine visit_grid

   pure character(8) function unit_of(map)
      type(stability_map_type), intent(in) :: map

      unit_of = ''
      if (allocated(map%unit)) unit_of = map%unit
   end function unit_of

   !> Of a map under way: all values of the parameter, and which rows the grid holds.
   subroutine visit_rows(map, fields)
      type(stability_map_type), intent(inout) :: map
      class(fields_type), intent(inout) :: fields
      real(dp), allocatable :: parameter(:)
      logical, allocatable :: done(:)
      integer :: n

      if (.not. fields%enter(home//'/rows', 'which rows of a map under way are done', allocated(map%rows))) return
      n = 0
      if (allocated(map%rows)) n = size(map%rows)
      if (allocated(map%rows)) done = map%done
      if (allocated(map%rows)) parameter = map%parameter
      call fields%index_axis('row', n, 'row of the whole map')
      call carry(fields, row('value', 'row'), parameter)
      call carry(fields, row('done', 'row'), done)
      if (fields%way /= reading .or. allocated(fields%wrong)) return
      call fields%check(count(done) == size(map%parameter), 'done')
      if (allocated(fields%wrong)) return
      call scatter(map, parameter, done)
   end subroutine visit_rows

   !> The inverse of `gather`: the grid as rows by themselves, among those that are still to be done.
   subroutine scatter(map, parameter, done)
      type(stability_map_type), intent(inout) :: map
      real(dp), intent(in) :: parameter(:)
      logical, intent(in) :: done(:)
      integer :: i, n

      allocate (map%rows(size(done)))
      n = 0
      do i = 1, size(done)
         if (.not. done(i)) cycle
         n = n + 1
         map%rows(i)%motions = map%motions(:, n)
         map%rows(i)%stable_motions = map%stable_motions(:, n)
         map%rows(i)%multiplier = map%multiplier(:, n)
         if (allocated(map%rms)) map%rows(i)%rms = map%rms(:, :, n)
         map%rows(i)%whole = map%whole(n)
      end do
      map%whole = unpack(map%whole, done, .false.)
      map%done = done
      map%parameter = parameter
      deallocate (map%motions, map%stable_motions, map%multiplier)
      if (allocated(map%rms)) deallocate (map%rms)
   end subroutine scatter

end module geartrain_analyses_stability_map_fields
