!> The name that a misspelt name probably stands for.
module geartrain_base_nearest
   implicit none (type, external)
   private
   public :: nearest_name

contains

   !> Index of the candidate with the fewest edits from `name`, at most one edit for three letters; 0: none.
   pure integer function nearest_name(name, candidates)
      !> The misspelt name, and the names it may stand for, which may have blanks at the end.
      character(*), intent(in) :: name, candidates(:)
      integer :: i, distance, least

      nearest_name = 0
      ! A text of this length is no misspelt name.
      if (len(name) > 60) return
      least = max(1, len(name)/3) + 1
      do i = 1, size(candidates)
         distance = edits(name, trim(candidates(i)))
         if (distance < least) then
            least = distance
            nearest_name = i
         end if
      end do
   end function nearest_name

   !> Number of letters to change, insert, delete or swap with their neighbour (optimal string alignment distance).
   pure integer function edits(a, b)
      character(*), intent(in) :: a, b
      integer :: table(0:len(a), 0:len(b)), i, j

      table(:, 0) = [(i, i = 0, len(a))]
      table(0, :) = [(j, j = 0, len(b))]
      do j = 1, len(b)
         do i = 1, len(a)
            table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, table(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
            if (i > 1 .and. j > 1) then
               if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) &
                  table(i, j) = min(table(i, j), table(max(i - 2, 0), max(j - 2, 0)) + 1)
            end if
         end do
      end do
      edits = table(len(a), len(b))
   end function edits

end module geartrain_base_nearest
