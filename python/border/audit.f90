! The audit of a branch, out.

! Audits the box's branch: `points` of its points, which `random_seed` draws, and all special points.
subroutine audit_points(handle, points, random_seed, progress, status)
   use geartrain, only: audit_branch, error_type
   use geartrain_python_box, only: begin_watch, box_type, box_of, close_with, watch_type
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: points, random_seed
   double precision, intent(inout), target :: progress(3)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   allocate (box%audit)
   call audit_branch(box%case%train, box%results%response, points, random_seed, box%audit, error, watch)
   status = close_with(box, error)
end subroutine audit_points

! rows; points, as estimated, doubtful, special points, confirmed, wrong verdicts, ok.
subroutine audit_sizes(handle, rows, counts)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: rows, counts(7)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (audit => box%audit)
      rows = size(audit%rows)
      counts = [audit%points, audit%as_estimated, audit%doubtful, audit%special_points, audit%confirmed, audit%wrong_verdicts, &
                merge(1, 0, audit%ok)]
   end associate
end subroutine audit_sizes

! numbers: frequency, exact frequency, estimate, error, ratio; marks: point, doubtful, estimate wrong, verdict wrong.
subroutine copy_audit(handle, rows, numbers, marks)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: rows
   double precision, intent(out) :: numbers(rows, 5)
   integer, intent(out) :: marks(rows, 4)
   type(box_type), pointer :: box

   box => box_of(handle)
   associate (found => box%audit%rows)
      numbers(:, 1) = found%frequency
      numbers(:, 2) = found%exact_frequency
      numbers(:, 3) = found%estimate
      numbers(:, 4) = found%error
      numbers(:, 5) = found%ratio()
      marks(:, 1) = found%point
      marks(:, 2) = merge(1, 0, found%doubtful)
      marks(:, 3) = merge(1, 0, found%estimate_wrong)
      marks(:, 4) = merge(1, 0, found%verdict_wrong)
   end associate
end subroutine copy_audit
