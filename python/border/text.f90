! Texts of a box, out.

! Number of bytes of a text of the box: 'message', 'case' (the resolved namelist), 'elements', 'integration', 'attractors' (why
! each ended), 'map' (why it ended), 'map name', 'map unit', 'directions', 'version'; 'kinds'
! of the motions at a place (which ones, as in motions.f90); of the branch at a place (0: the response,
! else a further one): 'branch' (why it ended), 'origin', 'special points', 'jump kinds', 'jump causes'; of the audit: 'audit' (its
! table), 'audit kinds', 'audit verdicts', 'exact verdicts', 'findings'. Lists have one item a line.
subroutine text_size(handle, name, place, bytes)
   use geartrain_python_box, only: box_of, box_text
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   integer, intent(in) :: place
   integer, intent(out) :: bytes
   character(:), allocatable :: whole

   call box_text(box_of(handle), name, place, whole)
   bytes = len(whole)
end subroutine text_size

subroutine copy_text(handle, name, place, bytes, text)
   use geartrain_python_box, only: box_of, box_text
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   integer, intent(in) :: place, bytes
   integer(1), intent(out) :: text(bytes)
   character(:), allocatable :: whole

   call box_text(box_of(handle), name, place, whole)
   text = transfer(whole, text)
end subroutine copy_text
