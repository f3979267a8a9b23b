!> Watches over one flight that may go to any of some known attracting orbits: which of them it goes to is decided by the fall of
!> their Lyapunov functions along the flight (geartrain_flow_attraction), long before the flight is there.
!>
!> A flight far from all orbits may come nearer to one of several for some sections by chance: of 1080 flights between three motions
!> two were caught by a wrong one after three periods, and none where a catch takes at least six.
!>
!> The flow may meet an orbit of several periods of the fundamental at any of its sections, so that such an orbit has a watch for
!> each of them.
module geartrain_flow_approach
   use geartrain_base_kinds, only: dp
   use geartrain_flow_attraction, only: attraction_type
   implicit none (type, external)
   private
   public :: approach_type

   !> Fewest periods of an orbit over which a flight is watched before it is caught, where several orbits are known.
   integer, parameter :: least_watched = 6

   type :: approach_type
      !> Watches, and the orbit and the section of it that each is for, (watch).
      type(attraction_type), allocatable, private :: watch(:)
      integer, allocatable, private :: orbit(:), section(:)
   contains
      procedure :: add
      procedure :: look
   end type approach_type

contains

   !> Adds the watches of an orbit.
   pure subroutine add(self, orbit, number)
      class(approach_type), intent(inout) :: self
      !> An orbit that attracts, of which nothing has been followed yet.
      type(attraction_type), intent(in) :: orbit
      !> Its number.
      integer, intent(in) :: number
      integer :: i

      if (.not. allocated(self%watch)) allocate (self%watch(0), self%orbit(0), self%section(0))
      self%watch = [self%watch, (orbit, i=1, orbit%period)]
      self%orbit = [self%orbit, (number, i=1, orbit%period)]
      self%section = [self%section, (i, i=0, orbit%period - 1)]
      if (any(self%orbit /= number)) self%watch%least_watched = least_watched
   end subroutine add

   !> Takes the next section of the flight.
   subroutine look(self, state, k, tolerance, orbit)
      class(approach_type), intent(inout) :: self
      !> State of the flight at phase 0 [1], (state).
      real(dp), intent(in) :: state(:)
      !> Periods of the fundamental flown so far.
      integer, intent(in) :: k
      !> Relative distance at which the flight is at an orbit [1].
      real(dp), intent(in) :: tolerance
      !> Number of the orbit that the flight goes to; 0: not known yet.
      integer, intent(out) :: orbit
      logical :: caught
      integer :: i

      orbit = 0
      if (.not. allocated(self%watch)) return
      do i = 1, size(self%watch)
         if (mod(k, self%watch(i)%period) /= self%section(i)) cycle
         call self%watch(i)%follow(state, tolerance, caught)
         if (.not. caught) cycle
         orbit = self%orbit(i)
         return
      end do
   end subroutine look

end module geartrain_flow_approach
