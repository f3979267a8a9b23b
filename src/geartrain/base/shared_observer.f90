!> One observer for work on several threads: passes on steps by one thread at a time, under one name and with one count of what is
!> done, however small the pieces of the work are that take notice of it.
module geartrain_base_shared_observer
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   implicit none (type, external)
   private
   public :: shared_observer_type

   type, extends(observer_type) :: shared_observer_type
      !> The observer; null: nobody watches.
      class(observer_type), pointer :: observer => null()
      !> Name under which the observer gets every step.
      character(:), allocatable :: name
      !> What is done so far, in the unit of the name; pieces of work that make one of it, and such pieces done.
      integer :: done = 0, pieces = 1, pieces_done = 0
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> .false. once the observer has ended the work.
      logical :: keep_going = .true.
   contains
      procedure :: on_step
      procedure :: add
   end type shared_observer_type

contains

   !> Passes on that work goes on; any thread may call it from within a piece of the work.
   subroutine on_step(self, analysis, done, frequency_ratio, keep_going)
      class(shared_observer_type), intent(inout) :: self
      !> Not used: the observer gets `name` and what is done of the whole.
      character(*), intent(in) :: analysis
      !> Not used.
      integer, intent(in) :: done
      !> Not used.
      real(dp), intent(in) :: frequency_ratio
      !> .false. where the observer has ended the work.
      logical, intent(inout) :: keep_going

      !$omp critical (geartrain_shared_observer)
      call pass_on(self)
      keep_going = self%keep_going
      !$omp end critical (geartrain_shared_observer)
   end subroutine on_step

   !> Counts a piece of the work as done and passes that on; any thread may call it.
   subroutine add(self)
      class(shared_observer_type), intent(inout) :: self

      !$omp critical (geartrain_shared_observer)
      self%pieces_done = self%pieces_done + 1
      call pass_on(self)
      !$omp end critical (geartrain_shared_observer)
   end subroutine add

   !> Whether the work goes on is asked until the observer has ended it.
   subroutine pass_on(self)
      class(shared_observer_type), intent(inout) :: self

      if (.not. (associated(self%observer) .and. self%keep_going)) return
      call self%observer%on_step(self%name, self%done + self%pieces_done/self%pieces, self%frequency_ratio, self%keep_going)
   end subroutine pass_on

end module geartrain_base_shared_observer
