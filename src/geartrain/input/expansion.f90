!> Problems of the bodies and meshes for which a planetary set stands: a case file has the set only, so a message names the set.
module geartrain_input_expansion
   use geartrain_base_problems, only: problems_type
   use geartrain_drawing_planetary_expansion, only: expansion_type
   use geartrain_drawing_planetary_meshes, only: sun_meshes
   implicit none (type, external)
   private
   public :: name_sets

contains

   !> Makes problems of expanded bodies and meshes problems of their &planetary groups. Meshes of a kind have a problem in common,
   !> which is kept once.
   subroutine name_sets(expansion, problems)
      !> Where bodies and meshes come from.
      type(expansion_type), intent(in) :: expansion
      type(problems_type), intent(inout) :: problems
      integer :: i, kept, set

      kept = 0
      do i = 1, problems%count
         associate (problem => problems%list(i))
            set = 0
            if (problem%group == 'body' .and. problem%index <= size(expansion%set_of_body)) &
               set = expansion%set_of_body(problem%index)
            if (problem%group == 'mesh' .and. problem%index <= size(expansion%set_of_mesh)) &
               set = expansion%set_of_mesh(problem%index)
            if (set > 0) then
               if (problem%group == 'mesh' .and. problem%name == 'bore') then
                  ! Of all gears of a set the planets alone have a bore.
                  problem%name = 'planet_bore'
                  problem%text = 'planet_bore'//problem%text(index(problem%text, ' = '):)
               else if (problem%group == 'body') then
                  problem%text = 'planet: '//problem%text
                  if (problem%name == 'inertia') problem%name = 'planet_inertia'
               else if (expansion%kind_of_mesh(problem%index) == sun_meshes) then
                  problem%text = 'sun meshes: '//problem%text
               else
                  problem%text = 'ring meshes: '//problem%text
               end if
               problem%group = 'planetary'
               problem%index = set
               ! The place of a value in a list of two gears is not that in a list of three.
               problem%place = 0
            end if
         end associate
         if (is_told(i)) cycle
         kept = kept + 1
         if (kept < i) problems%list(kept) = problems%list(i)
      end do
      problems%count = kept

   contains

      !> Whether a problem of a set is among those before it.
      logical function is_told(i)
         integer, intent(in) :: i
         integer :: j

         is_told = .false.
         if (problems%list(i)%group /= 'planetary') return
         do j = 1, kept
            is_told = problems%list(j)%group == 'planetary' .and. problems%list(j)%index == problems%list(i)%index .and. &
                      problems%list(j)%text == problems%list(i)%text
            if (is_told) return
         end do
      end function is_told

   end subroutine name_sets

end module geartrain_input_expansion
