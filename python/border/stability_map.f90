! The stability map, out and in.

! points, rows, meshes (0: the linear train), linear, complete; points 0: there is none.
subroutine map_sizes(handle, sizes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(5)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes = 0
   if (.not. allocated(box%results%stability_map)) return
   associate (map => box%results%stability_map)
      if (.not. allocated(map%frequency)) return
      sizes(1:2) = [size(map%frequency), size(map%parameter)]
      if (allocated(map%rms)) sizes(3) = size(map%rms, 1)
      sizes(4:5) = [merge(1, 0, map%linear), merge(1, 0, map%complete)]
   end associate
end subroutine map_sizes

! counts: motions, stable motions; marks: rows done, whole.
subroutine copy_map(handle, points, rows, meshes, frequency, parameter_, counts, multiplier, rms, marks)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: points, rows, meshes
   double precision, intent(out) :: frequency(points), parameter_(rows), multiplier(2, points, rows), rms(meshes, points, rows)
   integer, intent(out) :: counts(points, rows, 2), marks(rows, 2)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (map => box%results%stability_map)
      frequency = map%frequency
      parameter_ = map%parameter
      counts(:, :, 1) = map%motions
      counts(:, :, 2) = map%stable_motions
      multiplier(1, :, :) = real(map%multiplier)
      multiplier(2, :, :) = aimag(map%multiplier)
      if (meshes > 0) rms = map%rms
      marks(:, 1) = merge(1, 0, map%done)
      marks(:, 2) = merge(1, 0, map%whole)
   end associate
end subroutine copy_map

! The inverse of copy_map; flags: linear, complete.
subroutine put_map(handle, name, unit, ended, flags, frequency, parameter_, counts, multiplier, rms, marks, points, rows, meshes)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name, unit, ended
   integer, intent(in) :: points, rows, meshes, flags(2), counts(points, rows, 2), marks(rows, 2)
   double precision, intent(in) :: frequency(points), parameter_(rows), multiplier(2, points, rows), rms(meshes, points, rows)
   type(box_type), pointer :: box

   box => box_of(handle)
   allocate (box%results%stability_map)
   associate (map => box%results%stability_map)
      map%name = name
      map%unit = unit
      map%ended = ended
      map%linear = flags(1) == 1
      map%complete = flags(2) == 1
      map%frequency = frequency
      map%parameter = parameter_
      map%motions = counts(:, :, 1)
      map%stable_motions = counts(:, :, 2)
      map%multiplier = cmplx(multiplier(1, :, :), multiplier(2, :, :), kind(0d0))
      if (meshes > 0) map%rms = rms
      map%done = marks(:, 1) == 1
      map%whole = marks(:, 2) == 1
   end associate
end subroutine put_map
