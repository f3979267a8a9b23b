!> Eigenvalues of W diag(factor), which the roots of stiffness and factor transform to a symmetric matrix, banded since the elements
!> are numbered along the train. Each element that closes a loop or has factor 0 adds an eigenvalue 0.
!>
!> Where not every eigenvalue is needed, they are counted: the eigenvalues above x are as many as the positive pivots of K - x I on
!> the nodes of the train, K with the stiffness of each element times its factor (Sylvester's law of inertia). On a tree a count
!> costs the number of nodes.
module geartrain_network_system_spectrum
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_band_eigenvalues, only: band_eigenvalues
   use geartrain_linalg_graph, only: graph_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: count_above, eigenvalues_of, eigenvalue_ranges, enclose, largest_eigenvalue, make_pencil, pencil_type

   !> Eigenvalues below this share of the largest diagonal element are 0 but for rounding.
   real(dp), parameter :: nothing = 1e-14_dp
   !> Relative distance of two numbers between which an eigenvalue lies: bounds need no more digits.
   real(dp), parameter :: enclosed = 1e-6_dp

   !> K and I on the nodes of a train.
   type :: pencil_type
      !> Nodes joined by elements.
      type(graph_type) :: graph
      !> K over the square of the characteristic frequency [kg m^2], (entry of the graph); inertia [kg m^2], (node).
      real(dp), allocatable :: stiffness(:), inertia(:)
      !> A number that no eigenvalue exceeds; one below which they are 0 but for rounding.
      real(dp) :: highest = 0, lowest = 0
   end type pencil_type

contains

   !> Finds the largest eigenvalues.
   pure subroutine eigenvalues_of(system, factor, values, info, vectors)
      type(system_type), intent(in) :: system
      !> Factors >= 0 of the elements, (element).
      real(dp), intent(in) :: factor(:)
      !> The largest eigenvalues [1], ascending, as many as there is room for, (value).
      real(dp), intent(out) :: values(:)
      !> 0: LAPACK converged.
      integer, intent(out) :: info
      !> Eigenvectors of the symmetric matrix [1], (element, value).
      real(dp), intent(out), optional :: vectors(:, :)
      real(dp), allocatable :: band(:, :), vector(:, :)
      real(dp) :: value(system%elements)
      integer :: below, i, n, width

      width = 0
      do n = 1, system%elements
         do i = system%first(n), system%first(n + 1) - 1
            width = max(width, n - system%neighbour(i))
         end do
      end do
      allocate (band(width + 1, system%elements), source=0.0_dp)
      do n = 1, system%elements
         band(width + 1, n) = system%own(n)*factor(n)
         do i = system%first(n), system%first(n + 1) - 1
            associate (m => system%neighbour(i))
               if (m < n) band(width + 1 - n + m, n) = system%coupling(i)*sqrt(system%stiffness(n)/system%stiffness(m)) &
                                                       *sqrt(factor(n)*factor(m))
            end associate
         end do
      end do
      below = system%elements - size(values)
      if (present(vectors)) then
         allocate (vector(system%elements, system%elements))
         call band_eigenvalues(band, value, info, vector)
         vectors = vector(:, below + 1:)
      else
         call band_eigenvalues(band, value, info)
      end if
      values = value(below + 1:)
   end subroutine eigenvalues_of

   !> A number next to the largest eigenvalue [1], which is not above it.
   pure real(dp) function largest_eigenvalue(system, factor)
      type(system_type), intent(in) :: system
      !> Factors >= 0 of the elements, (element).
      real(dp), intent(in) :: factor(:)
      type(pencil_type) :: pencil
      real(dp) :: below

      largest_eigenvalue = 0
      if (.not. any(factor > 0)) return
      call make_pencil(system, factor, pencil)
      call enclose(pencil, 1, pencil%lowest, pencil%highest, below, largest_eigenvalue)
   end function largest_eigenvalue

   !> Ranges that hold all eigenvalues > 0: the lowest and the highest eigenvalue of each range [1], (2, range). Within a range each
   !> eigenvalue is at most `ratio` times the next lower one.
   pure function eigenvalue_ranges(system, factor, ratio) result(ranges)
      type(system_type), intent(in) :: system
      !> Factors >= 0 of the elements, (element); ratio > 1 [1].
      real(dp), intent(in) :: factor(:), ratio
      real(dp), allocatable :: ranges(:, :)
      type(pencil_type) :: pencil
      real(dp) :: above, below, bottom, highest, top
      integer :: all, found, n

      allocate (ranges(2, 0))
      if (.not. any(factor > 0)) return
      call make_pencil(system, factor, pencil)
      all = count_above(pencil, pencil%lowest)
      found = 0
      above = pencil%highest
      do while (found < all)
         highest = above
         call enclose(pencil, found + 1, pencil%lowest, highest, bottom, above)
         top = above
         found = found + 1
         do
            below = max(bottom/ratio, pencil%lowest)
            n = count_above(pencil, below)
            if (n <= found) exit
            highest = above
            call enclose(pencil, n, below, highest, bottom, above)
            found = n
         end do
         ranges = reshape([ranges, bottom, top], [2, size(ranges, 2) + 1])
      end do
   end function eigenvalue_ranges

   !> Makes K and I.
   pure subroutine make_pencil(system, factor, pencil)
      type(system_type), intent(in) :: system
      !> Factors >= 0 of the elements, (element).
      real(dp), intent(in) :: factor(:)
      !> The matrices.
      type(pencil_type), intent(out) :: pencil
      real(dp) :: weight
      integer, allocatable :: pairs(:, :)
      integer :: i, j, n, slot

      associate (elements => system%network%elements)
         pencil%inertia = system%network%inertia
         allocate (pairs(2, sum([(size(elements(n)%node)*(size(elements(n)%node) - 1)/2, n=1, size(elements))])))
         slot = 0
         do n = 1, size(elements)
            do i = 2, size(elements(n)%node)
               do j = 1, i - 1
                  slot = slot + 1
                  pairs(:, slot) = elements(n)%node([i, j])
               end do
            end do
         end do
         call pencil%graph%setup(size(pencil%inertia), pairs)
         allocate (pencil%stiffness(pencil%graph%entries), source=0.0_dp)
         do n = 1, size(elements)
            weight = factor(n)*system%stiffness(n)/system%characteristic_frequency**2
            associate (node => elements(n)%node, entry => elements(n)%entry, k => pencil%stiffness)
               do i = 1, size(node)
                  k(node(i)) = k(node(i)) + weight*entry(i)**2
                  do j = 1, i - 1
                     slot = pencil%graph%entry_of(node(j), node(i))
                     if (slot > pencil%graph%nodes + pencil%graph%slots) slot = slot - pencil%graph%slots
                     k(slot) = k(slot) + weight*entry(i)*entry(j)
                  end do
               end do
            end associate
         end do
      end associate
      ! The trace of a matrix without negative eigenvalues, and room for its rounding.
      pencil%highest = 2*sum(system%own*factor)
      pencil%lowest = nothing*maxval(system%own*factor)
   end subroutine make_pencil

   !> Number of eigenvalues above x.
   pure integer function count_above(pencil, x)
      !> The matrices.
      type(pencil_type), intent(in) :: pencil
      !> A number > 0 [1].
      real(dp), intent(in) :: x
      real(dp) :: a(pencil%graph%entries), share
      integer :: i, k, n, s, t

      a = pencil%stiffness
      count_above = 0
      associate (graph => pencil%graph, upper => pencil%graph%nodes, lower => pencil%graph%nodes + pencil%graph%slots)
         do k = 1, graph%nodes
            i = graph%order(k)
            a(i) = a(i) - x*pencil%inertia(i)
            ! A pivot of 0 counts as a small negative one.
            if (.not. abs(a(i)) > 0) a(i) = -epsilon(x)*x*pencil%inertia(i)
            if (a(i) > 0) count_above = count_above + 1
            n = graph%update(k)
            do s = graph%first(k), graph%first(k + 1) - 1
               share = a(upper + s)/a(i)
               do t = graph%first(k), graph%first(k + 1) - 1
                  n = n + 1
                  if (graph%target(n) <= lower) a(graph%target(n)) = a(graph%target(n)) - share*a(upper + t)
               end do
            end do
         end do
      end associate
   end function count_above

   !> Two numbers as good as equal between which the n-th largest eigenvalue lies, by bisection.
   pure subroutine enclose(pencil, n, from, to, below, above)
      !> The matrices.
      type(pencil_type), intent(in) :: pencil
      !> Its number, 1 of the largest.
      integer, intent(in) :: n
      !> Numbers between which it lies.
      real(dp), intent(in) :: from, to
      !> The two numbers.
      real(dp), intent(out) :: below, above
      real(dp) :: middle

      below = from
      above = to
      do while (above > below*(1 + enclosed))
         middle = sqrt(below)*sqrt(above)
         if (count_above(pencil, middle) >= n) then
            below = middle
         else
            above = middle
         end if
      end do
   end subroutine enclose

end module geartrain_network_system_spectrum
