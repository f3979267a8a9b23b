!> Rows of elements p = B q: which rows are independent, the rigid motions that they leave free (the null space of B), and how the
!> other rows follow from the independent ones.
!>
!> Rotations are written as combinations of displacements of rows and of free amplitudes. At first each rotation is an amplitude of
!> its own; each independent row takes the place of one amplitude. Without loops no term is subtracted from another: a stiff element
!> beside a soft one loses no digits.
module geartrain_linalg_rows
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: row_type, rows_type

   !> Sum of terms over the sum of their magnitudes below which it is 0: ratios of teeth and of radii agree to this [1].
   real(dp), parameter :: rounding = 1e-9_dp
   !> Coefficients of a loop below this share of their terms are rounding [1].
   real(dp), parameter :: nothing = 1e-12_dp
   !> An amplitude whose term is below this share of the largest term is not replaced [1].
   real(dp), parameter :: least_pivot = 0.1_dp

   !> The displacement of an element: the sum of entry(i) times the rotation of node(i).
   type :: row_type
      !> Nodes, and the displacement per rotation [m], (entry).
      integer, allocatable :: node(:)
      real(dp), allocatable :: entry(:)
   contains
      procedure :: entry_at
   end type row_type

   !> Rows that have been added, and what follows from them.
   type :: rows_type
      !> Rotation of each node per free amplitude, (node, amplitude); amplitudes that are left.
      real(dp), allocatable :: motion(:, :)
      logical, allocatable :: free(:)
      !> Rotation of each node per displacement of each independent row, (row, node); only if `setup` has room for them.
      real(dp), allocatable :: share(:, :)
      !> Number of independent rows.
      integer :: rank = 0
      !> Amplitudes that turn each node, few of many: number(node) of them, (place, node); number of nodes that each one turns.
      integer, allocatable, private :: number(:), amplitude(:, :), turns(:)
   contains
      procedure, private :: change
      procedure :: setup
      procedure :: add
      procedure :: follow
   end type rows_type

contains

   !> Displacement per rotation of a node [m].
   pure real(dp) function entry_at(self, node)
      class(row_type), intent(in) :: self
      !> Number of the node.
      integer, intent(in) :: node

      entry_at = sum(self%entry, self%node == node)
   end function entry_at

   !> Begins without rows.
   pure subroutine setup(self, nodes, rows)
      class(rows_type), intent(inout) :: self
      !> Number of nodes; number of independent rows, 0: their shares are not wanted.
      integer, intent(in) :: nodes, rows
      integer :: i

      if (allocated(self%motion)) deallocate (self%motion, self%free, self%share, self%number, self%amplitude, self%turns)
      allocate (self%motion(nodes, nodes), self%share(rows, nodes), source=0.0_dp)
      allocate (self%free(nodes), source=.true.)
      allocate (self%number(nodes), self%turns(nodes), self%amplitude(4, nodes), source=0)
      do i = 1, nodes
         call self%change(i, i, 1.0_dp)
      end do
      self%rank = 0
   end subroutine setup

   !> Adds a row; does nothing where it depends on the rows before it.
   pure subroutine add(self, row, independent)
      class(rows_type), intent(inout) :: self
      !> The row.
      type(row_type), intent(in) :: row
      !> The row is independent, and one amplitude less is free.
      logical, intent(out) :: independent
      real(dp) :: value(size(self%free)), height(size(self%free)), share(size(self%share, 1)), factor, term, largest
      !> Amplitudes that move the row.
      integer :: moving(size(self%free))
      integer :: f, i, k, n, movers, pivot

      value = 0
      height = 0
      movers = 0
      do i = 1, size(row%node)
         do k = 1, self%number(row%node(i))
            f = self%amplitude(k, row%node(i))
            term = row%entry(i)*self%motion(row%node(i), f)
            if (all(moving(:movers) /= f)) then
               movers = movers + 1
               moving(movers) = f
            end if
            value(f) = value(f) + term
            height(f) = height(f) + abs(term)
         end do
      end do
      n = 0
      do k = 1, movers
         f = moving(k)
         if (.not. abs(value(f)) > rounding*height(f)) cycle
         n = n + 1
         moving(n) = f
      end do
      movers = n
      independent = movers > 0
      if (.not. independent) return
      ! The amplitude that turns the fewest nodes, of these the last one: what was written before changes least.
      largest = maxval(abs(value(moving(:movers))))
      pivot = 0
      do k = 1, movers
         f = moving(k)
         if (abs(value(f)) < least_pivot*largest) cycle
         if (pivot > 0) then
            if (self%turns(f) > self%turns(pivot) .or. self%turns(f) == self%turns(pivot) .and. f < pivot) cycle
         end if
         pivot = f
      end do
      self%rank = self%rank + 1
      share = 0
      if (size(share) > 0) share = shares_of(self, row)
      do i = 1, size(self%motion, 1)
         if (.not. abs(self%motion(i, pivot)) > 0) cycle
         factor = self%motion(i, pivot)/value(pivot)
         if (size(share) > 0) then
            self%share(:, i) = self%share(:, i) - factor*share
            self%share(self%rank, i) = self%share(self%rank, i) + factor
         end if
         do k = 1, movers
            f = moving(k)
            term = factor*value(f)
            associate (entry => self%motion(i, f))
               ! Terms that cancel leave nothing: their rounding would count as a motion.
               if (f /= pivot .and. abs(entry - term) > nothing*(abs(entry) + abs(term))) then
                  call self%change(i, f, entry - term)
               else
                  call self%change(i, f, 0.0_dp)
               end if
            end associate
         end do
      end do
      self%free(pivot) = .false.
   end subroutine add

   !> Sets the rotation of a node by an amplitude.
   pure subroutine change(self, node, amplitude, entry)
      class(rows_type), intent(inout) :: self
      integer, intent(in) :: node, amplitude
      real(dp), intent(in) :: entry
      integer, allocatable :: longer(:, :)
      integer :: k

      associate (n => self%number(node), was => abs(self%motion(node, amplitude)) > 0, is => abs(entry) > 0)
         if (is .and. .not. was) then
            if (n == size(self%amplitude, 1)) then
               allocate (longer(2*n, size(self%number)), source=0)
               longer(:n, :) = self%amplitude
               call move_alloc(longer, self%amplitude)
            end if
            n = n + 1
            self%amplitude(n, node) = amplitude
            self%turns(amplitude) = self%turns(amplitude) + 1
         else if (was .and. .not. is) then
            k = findloc(self%amplitude(:n, node), amplitude, 1)
            self%amplitude(k, node) = self%amplitude(n, node)
            n = n - 1
            self%turns(amplitude) = self%turns(amplitude) - 1
         end if
      end associate
      self%motion(node, amplitude) = entry
   end subroutine change

   !> Displacement of a dependent row per displacement of each independent row [1], (row).
   pure function follow(self, row) result(share)
      class(rows_type), intent(in) :: self
      !> A row that depends on those that were added.
      type(row_type), intent(in) :: row
      real(dp) :: share(size(self%share, 1))

      share = shares_of(self, row)
   end function follow

   !> What the displacements of the independent rows make of a row; 0 where the terms cancel.
   pure function shares_of(self, row) result(share)
      type(rows_type), intent(in) :: self
      type(row_type), intent(in) :: row
      real(dp) :: share(size(self%share, 1)), height(size(self%share, 1))
      integer :: i

      share = 0
      height = 0
      do i = 1, size(row%node)
         share = share + row%entry(i)*self%share(:, row%node(i))
         height = height + abs(row%entry(i)*self%share(:, row%node(i)))
      end do
      where (abs(share) <= nothing*height) share = 0
   end function shares_of

end module geartrain_linalg_rows
