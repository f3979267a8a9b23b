!> Motions in which equal branches move equally: the space that their permutations leave as it is, and the differences within it.
!>
!> On such a motion the Jacobian J of the balance leaves this space as it is, and maps differences onto differences: of N branches
!> that move equally there are N - 1 difference modes with one part D of J, so that det J = det(J in the space) det(D)**(N - 1).
!> Critical directions of both kinds are simple in their own part, though multipliers come N - 1 at a time.
!>
!> The equations of the mean are those of a tree and its loops, whose rows the permutations do not exchange. With the rows that the
!> train has where every mesh has its mean stiffness as divisor they do.
!>
!> A further symmetry has branches that move half a period later as others do (half_period.f90). Of the part of J that changes its
!> sign by this symmetry the determinant is one more factor. This part has the number after those of the groups.
module geartrain_balance_fixed_space
   use geartrain_balance_half_period, only: half_period_type
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_bordered, only: bordered_type
   use geartrain_linalg_elimination, only: determinant_sign, factor_matrix, solve_factored
   use geartrain_network_equal_branches, only: equal_branches_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: average_equal, fixed_space_type, mean_equations

   !> Largest difference of two branches that move equally, over the largest coefficient.
   real(dp), parameter :: same = 1e-7_dp
   !> Solution for a right side of the size of 1 beyond which a matrix of the size of 1 is singular to rounding, as along a branch
   !> that leaves vertically, where every combination of critical directions is a motion.
   real(dp), parameter :: singular = 1e10_dp
   !> Groups whose difference modes are watched: their signs are the bits of an integer.
   integer, parameter :: most_groups = 29

   !> Equal branches that move equally.
   type :: group_type
      !> Unknown number i of each branch, (unknown of a branch, branch).
      integer, allocatable :: unknown(:, :)
   end type group_type

   type :: fixed_space_type
      !> The groups; none: every branch moves by itself.
      type(group_type), allocatable :: group(:)
      !> Unknowns with the same number move equally, (unknown).
      integer, allocatable :: orbit(:)
      !> Equations of the mean where every mesh has its mean stiffness, (equation, unknown), and their inverse.
      real(dp), allocatable :: mean(:, :), inverse(:, :)
      !> Branches that move half a period later as others do.
      type(half_period_type) :: half_period
   contains
      procedure :: find
      procedure :: is_whole
      procedure :: joins
      procedure :: parts
      procedure :: modes_of
      procedure :: has_differences
      procedure :: project
      procedure :: project_at_once
      procedure :: keep_difference
      procedure :: as_right_side
      procedure :: direction
      procedure :: signs
      procedure :: restricted
   end type fixed_space_type

contains

   !> Finds which equal branches move equally, at once or half a period later.
   subroutine find(self, system, sets, u, tangent)
      class(fixed_space_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Its equal branches.
      type(equal_branches_type), intent(in) :: sets(:)
      !> A motion, and a direction in which it is to be followed: coefficients of the unknown meshes [1], (block, unknown).
      real(dp), intent(in) :: u(:, :), tangent(:, :)
      integer :: first, i, j
      logical, allocatable :: left(:)
      logical :: equally(maxval([0, (size(sets(i)%unknown, 2), i=1, size(sets))]))
      type(group_type) :: one

      if (allocated(self%group)) deallocate (self%group, self%orbit)
      allocate (self%group(0))
      self%orbit = [(i, i=1, size(u, 2))]
      do i = 1, size(sets)
         associate (unknown => sets(i)%unknown)
            left = [(.true., j=1, size(unknown, 2))]
            do while (any(left))
               first = findloc(left, .true., 1)
               do j = 1, size(left)
                  associate (a => unknown(:, first), b => unknown(:, j))
                     equally(j) = left(j) .and. maxval(abs(u(:, a) - u(:, b))) <= same*maxval(abs(u)) .and. &
                                  maxval(abs(tangent(:, a) - tangent(:, b))) <= same*maxval(abs(tangent))
                  end associate
               end do
               left = left .and. .not. equally(:size(left))
               if (count(equally(:size(left))) == 1 .or. size(self%group) == most_groups) cycle
               one%unknown = unknown(:, pack([(j, j=1, size(left))], equally(:size(left))))
               self%group = [self%group, one]
               call join(self%orbit, one%unknown)
            end do
         end associate
      end do
      call self%half_period%find(sets, u, tangent, same)
      if (.not. self%is_whole()) call find_mean(self, system)
   end subroutine find

   !> Lets the unknowns of each row move equally.
   pure subroutine join(orbit, unknown)
      integer, intent(inout) :: orbit(:)
      integer, intent(in) :: unknown(:, :)
      integer :: i, j, first, other

      do i = 1, size(unknown, 1)
         do j = 2, size(unknown, 2)
            first = orbit(unknown(i, 1))
            other = orbit(unknown(i, j))
            where (orbit == other) orbit = first
         end do
      end do
   end subroutine join

   !> Sets the equations of the mean where every mesh has its mean stiffness.
   subroutine find_mean(self, system)
      class(fixed_space_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: i

      call mean_equations(system, self%mean, self%inverse)
      if (allocated(self%inverse)) return
      ! No train has such equations; without groups everything is as in a train without equal branches.
      deallocate (self%group)
      if (allocated(self%half_period%later)) deallocate (self%half_period%later)
      allocate (self%group(0))
      self%orbit = [(i, i=1, size(self%orbit))]
   end subroutine find_mean

   !> Equations of the mean where every mesh has its mean stiffness.
   subroutine mean_equations(system, mean, inverse)
      type(system_type), intent(in) :: system
      !> The equations, (equation, unknown), and their inverse; not allocated where they are singular.
      real(dp), allocatable, intent(out) :: mean(:, :), inverse(:, :)
      real(dp), allocatable :: factors(:, :)
      integer, allocatable :: pivot(:)
      integer :: i, info

      associate (graph => system%cut%graph)
         allocate (mean(graph%nodes, graph%nodes), inverse(graph%nodes, graph%nodes), source=0.0_dp)
         allocate (pivot(graph%nodes))
         do i = 1, graph%nodes
            inverse(i, i) = 1
            associate (columns => graph%column(graph%row(i):graph%row(i + 1) - 1), &
                       entries => graph%entry(graph%row(i):graph%row(i + 1) - 1))
               mean(i, columns) = system%mean%force(entries) + system%mean%displacement(entries)
            end associate
         end do
         factors = mean
         call factor_matrix(graph%nodes, factors, pivot, info)
         if (info == 0) then
            call solve_factored(graph%nodes, graph%nodes, factors, pivot, inverse)
         else
            deallocate (inverse)
         end if
      end associate
   end subroutine mean_equations

   !> Whether the space is the space of all motions.
   pure logical function is_whole(self)
      class(fixed_space_type), intent(in) :: self

      is_whole = self%parts() == 0
   end function is_whole

   !> Whether some unknowns move equally at once.
   pure logical function joins(self)
      class(fixed_space_type), intent(in) :: self

      joins = .false.
      if (allocated(self%group)) joins = size(self%group) > 0
   end function joins

   !> Number of parts of the other motions: a difference mode of each group and, where there is one, the part that changes its sign
   !> half a period later.
   pure integer function parts(self)
      class(fixed_space_type), intent(in) :: self

      parts = 0
      if (allocated(self%group)) parts = size(self%group)
      if (allocated(self%half_period%later)) parts = parts + 1
   end function parts

   !> Number of equal modes that a part stands for: of N branches that move equally N - 1 difference modes.
   pure integer function modes_of(self, number)
      class(fixed_space_type), intent(in) :: self
      !> Number of the part.
      integer, intent(in) :: number

      modes_of = 1
      if (number <= size(self%group)) modes_of = size(self%group(number)%unknown, 2) - 1
   end function modes_of

   !> Whether a group has so many difference modes.
   pure logical function has_differences(self, modes)
      class(fixed_space_type), intent(in) :: self
      !> Number of modes.
      integer, intent(in) :: modes
      integer :: g

      has_differences = .false.
      if (self%is_whole()) return
      has_differences = any([(self%modes_of(g) == modes, g=1, size(self%group))])
   end function has_differences

   !> Takes the part of coefficients that is in the space.
   pure subroutine project(self, x)
      class(fixed_space_type), intent(in) :: self
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)

      call self%project_at_once(x)
      call self%half_period%keep(1, x)
   end subroutine project

   !> Takes the part of coefficients in which equal branches move equally at once, whatever they do half a period later.
   pure subroutine project_at_once(self, x)
      class(fixed_space_type), intent(in) :: self
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)

      if (.not. self%is_whole()) call average_equal(self%orbit, x)
   end subroutine project_at_once

   !> Gives unknowns that one stands for their mean.
   pure subroutine average_equal(orbit, x)
      !> Unknown that stands for each, (unknown).
      integer, intent(in) :: orbit(:)
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)
      integer :: i, j, l
      integer, allocatable :: member(:)

      do i = 1, size(x, 2)
         member = pack([(j, j=1, size(x, 2))], orbit == i)
         if (size(member) < 2) cycle
         do l = 1, size(x, 1)
            x(l, member) = sum(x(l, member))/size(member)
         end do
      end do
   end subroutine average_equal

   !> Takes a part of coefficients: a difference of the first two branches of a group, where the other branches get 0; or what
   !> changes its sign half a period later.
   pure subroutine keep_difference(self, number, x)
      class(fixed_space_type), intent(in) :: self
      !> Number of the part.
      integer, intent(in) :: number
      !> Coefficients [1], (block, unknown).
      real(dp), intent(inout) :: x(:, :)
      real(dp) :: half(size(x, 1), size(x, 2)), other(size(x, 1), size(x, 2))
      integer :: i, j
      integer, allocatable :: member(:)

      if (number > size(self%group)) then
         call self%project_at_once(x)
         call self%half_period%keep(-1, x)
         return
      end if
      associate (unknown => self%group(number)%unknown)
         other = x
         x = 0
         do i = 1, size(unknown, 1)
            member = pack([(j, j=1, size(unknown, 1))], self%orbit(unknown(:, 1)) == self%orbit(unknown(i, 1)))
            half(:, i) = sum(other(:, unknown(member, 1)) - other(:, unknown(member, 2)), 2)/(2*size(member))
         end do
         x(:, unknown(:, 1)) = half(:, :size(unknown, 1))
         x(:, unknown(:, 2)) = -half(:, :size(unknown, 1))
      end associate
   end subroutine keep_difference

   !> Makes coefficients a right side of the linearised balance that the permutations exchange as they exchange coefficients.
   pure subroutine as_right_side(self, x)
      class(fixed_space_type), intent(in) :: self
      !> Coefficients [1], (block, unknown); then the right side.
      real(dp), intent(inout) :: x(:, :)

      if (self%is_whole()) return
      x(1, :) = matmul(self%mean, x(1, :))
   end subroutine as_right_side

   !> Turns a critical difference of the first two branches of a group into a direction along which branches leave. Pattern k: the
   !> first k of n branches against all the others; after n/2 of these, at a period doubling, some branches against as many others,
   !> which move likewise half a period later.
   pure function direction(self, number, pattern, x) result(turned)
      class(fixed_space_type), intent(in) :: self
      !> Number of the group and of the pattern.
      integer, intent(in) :: number, pattern
      !> A difference of the first two branches [1], (block, unknown).
      real(dp), intent(in) :: x(:, :)
      real(dp) :: turned(size(x, 1), size(x, 2))
      integer :: share(size(self%group(number)%unknown, 2)), j, k, n

      n = size(share)
      k = pattern
      share = -k
      share(:min(k, n)) = n - k
      if (k > n/2) then
         k = k - n/2
         share = 0
         share(:k) = 1
         share(k + 1:2*k) = -1
      end if
      turned = 0
      associate (unknown => self%group(number)%unknown)
         do j = 1, n
            turned(:, unknown(:, j)) = share(j)*x(:, unknown(:, 1))
         end do
      end associate
   end function direction

   !> Signs of the determinants of the parts, as bits: bit g - 1 is 1 where that of part g is negative. -1: one of them is 0 to
   !> rounding.
   integer function signs(self, matrix)
      class(fixed_space_type), intent(in) :: self
      !> Jacobian of the balance, not factored, of a motion in this space.
      type(bordered_type), intent(in) :: matrix
      integer :: g

      signs = 0
      do g = 1, self%parts()
         select case (sign_of(self, matrix, g))
         case (-1)
            signs = ibset(signs, g - 1)
         case (0)
            signs = -1
            return
         end select
      end do
   end function signs

   !> Sign of the determinant of a part; 0: it is singular to rounding.
   integer function sign_of(self, matrix, number)
      class(fixed_space_type), intent(in) :: self
      type(bordered_type), intent(in) :: matrix
      integer, intent(in) :: number
      real(dp), allocatable :: mode(:, :), x(:)
      integer, allocatable :: first(:), image(:), pivot(:), sign(:), used(:)
      logical, allocatable :: paired(:)
      integer :: i, info, j, k, n
      logical :: as_first, as_image

      associate (block => matrix%block, orbit => self%orbit)
         ! Of unknowns that move equally one stands for all, and of two that change places half a period later one for both.
         if (number <= size(self%group)) then
            associate (unknown => self%group(number)%unknown)
               first = pack([(i, i=1, size(unknown, 1))], &
                            [(findloc(orbit(unknown(:, 1)), orbit(unknown(i, 1)), 1) == i, i=1, size(unknown, 1))])
               image = unknown(first, 2)
               first = unknown(first, 1)
            end associate
            sign = [(-1, i=1, block)]
         else
            associate (later => self%half_period%later)
               first = pack([(i, i=1, size(orbit))], [(orbit(i) == i .and. orbit(later(i)) >= i, i=1, size(orbit))])
               image = later(first)
            end associate
            sign = -self%half_period%sign(:block)
         end if
         paired = [(number <= size(self%group) .or. orbit(image(i)) /= orbit(first(i)), i=1, size(first))]
         n = block*size(first)
         allocate (mode(n, n), source=0.0_dp)
         do j = 1, size(first)
            do k = 1, size(orbit)
               as_first = moves(k, first(j))
               as_image = .false.
               if (paired(j)) as_image = moves(k, image(j))
               if (.not. (as_first .or. as_image)) cycle
               do i = 1, size(first)
                  associate (part => mode((i - 1)*block + 1:i*block, (j - 1)*block + 1:j*block))
                     if (as_first) call add(part, first(i), k, abs(sign))
                     if (as_image) call add(part, first(i), k, sign)
                  end associate
               end do
            end do
         end do
         ! An unknown that takes its own place half a period later has odd harmonics alone in this part.
         used = pack([(i, i=1, n)], [((paired(j) .or. sign(i) > 0, i=1, block), j=1, size(first))])
      end associate
      mode = mode(used, used)
      n = size(used)
      allocate (pivot(n))
      call factor_matrix(n, mode, pivot, info)
      sign_of = 0
      if (info /= 0) return
      x = [(cos(real(i, dp)), i=1, n)]
      call solve_factored(n, 1, mode, pivot, x)
      if (maxval(abs(x)) < singular) sign_of = determinant_sign(mode, pivot)

   contains

      !> Whether unknown k moves as unknown `as` does, in its own branch where the part is a difference of two branches.
      pure logical function moves(k, as)
         integer, intent(in) :: k, as

         moves = self%orbit(k) == self%orbit(as)
         if (moves .and. number <= size(self%group)) then
            associate (unknown => self%group(number)%unknown)
               moves = any(unknown(:, merge(1, 2, any(unknown(:, 1) == as))) == k)
            end associate
         end if
      end function moves

      !> Adds the block of a row and a column, each column of it with a sign.
      subroutine add(part, row, column, sense)
         real(dp), intent(inout) :: part(:, :)
         integer, intent(in) :: row, column, sense(:)
         integer :: c, entry, l, n

         entry = matrix%graph%entry_of(row, column)
         do c = 1, size(sense)
            if (entry > 0) part(2:, c) = part(2:, c) + sense(c)*matrix%entry(2:, c, entry)
         end do
         ! The rows that are coupled with the column.
         do n = matrix%graph%row(column), matrix%graph%row(column + 1) - 1
            l = matrix%graph%column(n)
            if (.not. abs(self%inverse(row, l)) > 0) cycle
            entry = matrix%graph%entry_of(l, column)
            part(1, :) = part(1, :) + sense*self%inverse(row, l)*matrix%entry(1, :, entry)
         end do
      end subroutine add

   end function sign_of

   !> Sign of the determinant in the space, from that of the whole matrix and the signs of the parts; 0: not known.
   pure integer function restricted(self, orientation, signs)
      class(fixed_space_type), intent(in) :: self
      !> Sign of the determinant of the whole matrix; signs of the parts as `signs` gives them.
      integer, intent(in) :: orientation, signs
      integer :: g

      restricted = orientation
      if (signs < 0) restricted = 0
      do g = 1, self%parts()
         if (btest(signs, g - 1) .and. mod(self%modes_of(g), 2) == 1) restricted = -restricted
      end do
   end function restricted

end module geartrain_balance_fixed_space
