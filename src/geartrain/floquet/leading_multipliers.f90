!> The multipliers of largest magnitude of a large train by Arnoldi's method, from products of its monodromy matrix with a few
!> vectors. No determinant checks the steps: the leading vector is carried again with steps of half the length instead.
module geartrain_floquet_leading_multipliers
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_slow_multipliers, only: slow_multipliers_type
   use geartrain_floquet_vector_propagator, only: vector_propagator_type
   use geartrain_linalg_arnoldi, only: arnoldi_type
   use geartrain_network_alike, only: share_alike
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: leading, leading_multipliers_type

   !> So many multipliers are found, with residuals below `residual_limit` (the multipliers of a propagator good to 1e-9), in a
   !> space of at most this share of the states.
   integer, parameter :: leading = 16
   real(dp), parameter :: residual_limit = 1e-9_dp, largest_share = 0.7_dp
   !> Where only a verdict is wanted: residual of the first multiplier over its distance from the unit circle, and residual of the
   !> others, at which multipliers inside the circle count as found.
   real(dp), parameter :: surely = 0.02_dp, roughly = 1e-3_dp
   !> Vectors that are carried together: a larger block makes a larger space, but finds more copies of a multiplier.
   integer, parameter :: two = 2, four = 4
   !> The space begins with vectors that have been carried over so many periods times the root of the states: what dies out
   !> needs no dimension; four vectors half as often. Less often where their length grows or falls by more than this: the smaller
   !> multipliers would drown.
   real(dp), parameter :: periods = 1, largest_change = 1e3_dp
   !> Periods times the root of the states over which the vectors of a branch are carried in all where only verdicts are wanted, a
   !> few at each point: mean modes, and with them what dies out, hardly change along a branch.
   real(dp), parameter :: most_periods = 6
   integer, parameter :: few = 8
   !> First look at the residuals, in dimensions over the root of the states, with two vectors and with four. Copies show earlier.
   real(dp), parameter :: first_look(2) = [3.5_dp, 4.5_dp]
   !> First look where only a verdict is wanted, over the dimension that sufficed at the point before; the next over the latest.
   real(dp), parameter :: nearly = 0.9_dp, a_little = 1.12_dp
   !> Largest dimension for the next look over that of the latest: a look costs as much as some products.
   real(dp), parameter :: largest_growth = 1.5_dp
   !> Relative distance of multipliers that may be copies of each other, as of equal branches.
   real(dp), parameter :: equal = 1e-6_dp
   !> Share of the elements that lie alike with two others, above which four vectors are carried from the beginning.
   real(dp), parameter :: most_alike = 0.5_dp
   !> Largest difference that steps of half the length may make to the leading vector; how often steps are tried.
   real(dp), parameter :: largest_defect = 1e-7_dp
   integer, parameter :: most_attempts = 3

   !> Work space of one branch.
   type :: leading_multipliers_type
      private
      !> Only a verdict is wanted: multipliers inside the unit circle need not be found to their digits.
      logical :: verdict = .false.
      type(system_type), pointer :: system => null()
      !> Multipliers of motions whose damping outweighs the variation of their stiffness.
      type(slow_multipliers_type) :: slow
      !> Set up at the first motion that needs a flight.
      type(vector_propagator_type) :: propagator
      type(arnoldi_type) :: space
      integer :: states = 0
      !> Whether so many elements lie alike that two vectors would hardly find every copy of a multiplier.
      logical :: branches = .false.
      !> Time over which vectors are carried; contact events in order of time, the mesh and the contact after each, (event).
      real(dp) :: period = 0
      real(dp), allocatable :: instant(:)
      integer, allocatable :: mesh(:), contact(:)
      !> Contact of each mesh at the beginning and now, (mesh).
      integer, allocatable :: first_contact(:), now(:)
      !> Vectors carried over the periods of points of the branch, (state, vector); over how many; dimension that sufficed last.
      real(dp), allocatable :: carried(:, :)
      integer :: periods_carried = 0, sufficed = 0
   contains
      procedure :: setup
      procedure :: find
      procedure, private :: find_with
      procedure, private :: begin
      procedure, private :: carry
   end type leading_multipliers_type

contains

   subroutine setup(self, system)
      class(leading_multipliers_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system

      self%states = 2*system%coordinates
      call self%slow%setup(system)
      self%system => system
      allocate (self%first_contact(system%meshes), self%now(system%meshes))
   end subroutine setup

   !> The leading multipliers over a period. No success: the space would become almost the whole; or a multiplier was found as often
   !> as the space can hold it, and may be there more often.
   subroutine find(self, motion, frequency_ratio, period, instant, mesh, contact, verdict, values, success)
      class(leading_multipliers_type), intent(inout) :: self
      !> The motion, whose contacts at the beginning of the period are used.
      class(motion_contacts_type), intent(in) :: motion
      !> Lambda [1]; time over which vectors are carried [1].
      real(dp), intent(in) :: frequency_ratio, period
      !> Contact events in order of time [1], (event).
      real(dp), intent(in) :: instant(:)
      !> Mesh of each event, and region of its law after the event, (event).
      integer, intent(in) :: mesh(:), contact(:)
      !> Multipliers that are all inside the unit circle need not be found to their digits.
      logical, intent(in) :: verdict
      !> Largest magnitude first, (leading).
      complex(dp), intent(out) :: values(:)
      !> The values are the leading multipliers.
      logical, intent(out) :: success
      integer :: i

      self%verdict = verdict
      self%period = period
      self%instant = instant
      self%mesh = mesh
      self%contact = contact
      self%first_contact = 1
      do i = 1, motion%unknowns
         self%first_contact(motion%mesh(i)) = motion%contact(i)%first_contact
      end do
      success = .false.
      if (verdict .and. size(instant) == 0) call self%slow%find(self%first_contact, frequency_ratio, period, values, success)
      if (success) return
      if (.not. associated(self%propagator%system)) then
         call self%propagator%setup(self%system)
         self%branches = share_alike(self%system, two) > most_alike
      end if
      if (.not. self%branches) call self%find_with(two, frequency_ratio, values, success)
      if (.not. success) call self%find_with(four, frequency_ratio, values, success)
   end subroutine find

   !> `find` with a block of so many vectors.
   subroutine find_with(self, block, frequency_ratio, values, success)
      class(leading_multipliers_type), intent(inout) :: self
      integer, intent(in) :: block
      real(dp), intent(in) :: frequency_ratio
      complex(dp), intent(out) :: values(:)
      logical, intent(out) :: success
      real(dp), dimension(self%states, block) :: vectors, products
      real(dp) :: residuals(size(values))
      integer :: attempt, check, most
      logical :: independent, sure

      most = block*int(largest_share*self%states/block)
      success = .false.
      do attempt = 0, most_attempts - 1
         call self%propagator%start(frequency_ratio, 2.0_dp**attempt)
         call self%begin(block, most)
         check = block*nint(first_look(block/two)*sqrt(real(self%states, dp))/block)
         if (self%verdict .and. self%sufficed > 0) check = block*nint(nearly*self%sufficed/block)
         check = min(most, check)
         residuals = huge(1.0_dp)
         sure = .false.
         do while (self%space%dimension < most .and. .not. self%propagator%system%interrupt%raised())
            call self%space%latest(vectors)
            call self%carry(vectors, products)
            call self%space%extend(products, independent)
            if (.not. independent) return
            if (self%space%dimension < check) cycle
            call self%space%ritz(values, residuals)
            sure = self%verdict .and. residuals(1) <= surely*(1 - abs(values(1))) .and. maxval(residuals) <= roughly
            if (maxval(residuals) <= residual_limit .or. sure) exit
            if (most_copies(pack(values, residuals <= residual_limit)) >= block) return
            check = min(most, next_check(self%space%dimension, maxval(residuals), block))
            if (self%verdict) check = min(check, block*ceiling(a_little*self%space%dimension/block))
         end do
         if (.not. sure) then
            if (.not. maxval(residuals) <= residual_limit .or. most_copies(values) >= block) return
         end if
         if (self%verdict) self%sufficed = self%space%dimension
         call self%space%leading_vector(vectors(:, :two))
         call self%propagator%start(frequency_ratio, 2.0_dp**(attempt + 1))
         call self%carry(vectors(:, :two), products(:, :two))
         products(:, 1) = products(:, 1) - values(1)%re*vectors(:, 1) + abs(values(1)%im)*vectors(:, 2)
         products(:, 2) = products(:, 2) - values(1)%re*vectors(:, 2) - abs(values(1)%im)*vectors(:, 1)
         success = norm2(products(:, :two)) < merge(surely*(1 - abs(values(1))), largest_defect, sure)
         if (success) exit
      end do
   end subroutine find_with

   !> Begins the space with vectors that have been carried over some periods.
   subroutine begin(self, block, most)
      class(leading_multipliers_type), intent(inout) :: self
      integer, intent(in) :: block, most
      real(dp), dimension(self%states, block) :: vectors, products
      real(dp) :: length, least, greatest
      integer :: i, number
      logical :: goes_on

      number = nint(periods*two/block*sqrt(real(self%states, dp)))
      call self%space%begin(self%states, most, block)
      call self%space%latest(products)
      goes_on = self%verdict .and. allocated(self%carried)
      if (goes_on) goes_on = size(self%carried, 2) == block
      if (goes_on) then
         products = self%carried
         number = few
      end if
      least = huge(1.0_dp)
      greatest = 0
      do i = 1, number
         if (self%propagator%system%interrupt%raised()) return
         vectors = products
         call self%carry(vectors, products)
         length = norm2(products)
         least = min(least, length)
         greatest = max(greatest, length)
         if (greatest > largest_change*least) exit
      end do
      if (.not. goes_on) self%periods_carried = 0
      if (self%verdict .and. self%periods_carried + number <= most_periods*sqrt(real(self%states, dp)) .and. &
          greatest <= largest_change*least) then
         self%carried = products/greatest
         self%periods_carried = self%periods_carried + number
      end if
      call self%space%begin_with(products)
   end subroutine begin

   !> The dimension at which the residual should be small enough: its logarithm grows as the third to fourth power of the dimension.
   pure integer function next_check(dimension, residual, block) result(check)
      integer, intent(in) :: dimension, block
      real(dp), intent(in) :: residual
      real(dp) :: growth

      growth = (log(0.1_dp*residual_limit)/min(log(residual), -0.5_dp))**(1/3.0_dp)
      check = block*ceiling(dimension*max(1.05_dp, min(largest_growth, growth))/block)
   end function next_check

   !> How often the multiplier that is there most often is among them.
   pure integer function most_copies(values)
      complex(dp), intent(in) :: values(:)
      integer :: i

      most_copies = 0
      if (size(values) > 0) most_copies = maxval([(count(abs(values - values(i)) <= equal*abs(values(i))), i=1, size(values))])
   end function most_copies

   !> Products of the monodromy matrix with vectors, (2*coordinates, vector).
   subroutine carry(self, vectors, products)
      class(leading_multipliers_type), intent(inout) :: self
      real(dp), intent(in) :: vectors(:, :)
      real(dp), intent(out) :: products(:, :)
      real(dp) :: time
      integer :: i

      call self%propagator%put_vectors(vectors)
      self%now = self%first_contact
      time = 0
      do i = 1, size(self%instant)
         call self%propagator%advance(time, self%instant(i), self%now)
         time = self%instant(i)
         associate (mesh => self%mesh(i))
            call self%propagator%pass_wall(mesh, self%now(mesh), self%contact(i))
            self%now(mesh) = self%contact(i)
         end associate
      end do
      call self%propagator%advance(time, self%period, self%now)
      call self%propagator%get_vectors(products)
   end subroutine carry

end module geartrain_floquet_leading_multipliers
