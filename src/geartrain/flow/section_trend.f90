!> Whether the sections of a flight keep the size of their vibration, shrink as the flight settles, or grow.
!>
!> The measure is the energy of the difference of two sections that lie n periods apart, for n from 1 to 16. On a torus its average
!> is the same in every block of the flight, for each n. Where the flight settles on a motion of period n the average falls from
!> block to block as the square of the vibration that is left.
module geartrain_flow_section_trend
   use geartrain_base_kinds, only: dp
   use geartrain_flow_energy, only: energy_type
   use geartrain_flow_smooth_mean, only: weighted_mean
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: section_trend_type

   !> Most periods between the two sections of a difference.
   integer, parameter :: most_apart = 16
   !> Blocks of a flight, and fewest differences of a block: fewer do not show a beat of two vibrations.
   integer, parameter :: blocks = 6, fewest = 10
   !> Student's t at 95 % for the slope of a line through the blocks, which leaves blocks - 2 degrees of freedom.
   real(dp), parameter :: student = 2.78_dp

   type :: section_trend_type
      !> Number of the first section that counts.
      integer :: first = 1
      !> Periods of the fundamental that the changes span, but for a few.
      integer :: periods = 0
      !> Change of the logarithm of the energy of differences over `periods`, and its uncertainty at 95 % [1], for each number of
      !> periods between the sections; as many as the flight is long enough for.
      real(dp), allocatable :: change(:), error(:)
      type(energy_type), private :: energy
      !> Latest sections in energy coordinates, newest last, (state, most_apart).
      real(dp), allocatable, private :: latest(:, :)
      !> Energy of the differences [1], (periods apart, section).
      real(dp), allocatable, private :: difference(:, :)
      !> Number of sections.
      integer, private :: sections = 0
   contains
      procedure :: begin
      procedure :: add
      procedure :: measure
      procedure :: last
   end type section_trend_type

contains

   !> Begins a flight.
   subroutine begin(self, system)
      class(section_trend_type), intent(out) :: self
      type(system_type), intent(in) :: system

      call self%energy%setup(system)
      allocate (self%latest(system%states, most_apart), source=0.0_dp)
      allocate (self%difference(most_apart, 256))
   end subroutine begin

   !> Adds the next section.
   pure subroutine add(self, state)
      class(section_trend_type), intent(inout) :: self
      !> State at phase 0 [1], (state).
      real(dp), intent(in) :: state(:)
      real(dp), allocatable :: longer(:, :)
      real(dp) :: now(size(state))
      integer :: n

      now = self%energy%coordinates(state)
      self%sections = self%sections + 1
      if (self%sections > size(self%difference, 2)) then
         allocate (longer(most_apart, 2*size(self%difference, 2)))
         longer(:, :self%sections - 1) = self%difference
         call move_alloc(longer, self%difference)
      end if
      do n = 1, most_apart
         associate (before => modulo(self%sections - n - 1, most_apart) + 1)
            self%difference(n, self%sections) = sum((now - self%latest(:, before))**2)
         end associate
      end do
      self%latest(:, modulo(self%sections - 1, most_apart) + 1) = now
   end subroutine add

   !> Sets the changes over the sections from `first` on.
   pure subroutine measure(self)
      class(section_trend_type), intent(inout) :: self
      real(dp) :: level(blocks), place(blocks), slope
      integer :: i, n, length

      self%periods = self%sections - self%first + 1
      n = max(0, min(most_apart, self%periods - blocks*fewest))
      if (allocated(self%change)) deallocate (self%change, self%error)
      allocate (self%change(n), self%error(n))
      place = [(i - (blocks + 1)/2.0_dp, i=1, blocks)]/blocks
      do n = 1, size(self%change)
         length = (self%periods - n)/blocks
         associate (part => self%difference(n, self%sections - blocks*length + 1:self%sections))
            do i = 1, blocks
               level(i) = log(max(weighted_mean(part((i - 1)*length + 1:i*length)), tiny(1.0_dp)))
            end do
         end associate
         slope = sum(place*level)/sum(place**2)
         self%change(n) = slope
         self%error(n) = student*sqrt(sum((level - sum(level)/blocks - slope*place)**2)/((blocks - 2)*sum(place**2)))
      end do
   end subroutine measure

   !> The last state [1], (state).
   pure function last(self) result(state)
      class(section_trend_type), intent(in) :: self
      real(dp), allocatable :: state(:)

      state = self%energy%state(self%latest(:, modulo(self%sections - 1, most_apart) + 1))
   end function last

end module geartrain_flow_section_trend
