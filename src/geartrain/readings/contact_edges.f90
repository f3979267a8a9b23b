!> Contact edges of a branch: where a mesh begins or ceases to separate, its back flanks to collide, or a coupling to reach a
!> stage. The balance is solved there.
module geartrain_readings_contact_edges
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: extremes, fine_samples
   use geartrain_mesh_law_law, only: depth_below
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, carried_by, contact_edge_type, gap_along, response_settings_type
   use geartrain_trace_condition, only: condition_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_decided, only: joined
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_special_points, only: rms_of
   use geartrain_trace_stages, only: depth_of_stage, no_stage, rest_of, stages_of
   use geartrain_trace_start, only: begin_trace, solution_of
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: locate_contact_edges

   !> Edges that are located at most, the first ones along the branch; further edges are interpolated where they are needed.
   integer, parameter :: most_edges = 1000
   integer, parameter :: most_steps = 20
   !> Depth at an edge on the polynomial, and at a point of the branch that counts as an edge, over half the backlash [1].
   real(dp), parameter :: located = 1e-7_dp, solved = 1e-11_dp
   !> A point closer to its neighbour than this share of the piece is no node of the polynomial [1].
   real(dp), parameter :: nearest = 0.03_dp
   !> Difference of the depths of meshes that move alike, as those of equal planets, over half the backlash [1]: rounding.
   real(dp), parameter :: alike = 1e-10_dp

   !> A piece of a branch between neighbouring points, with a polynomial through up to four points.
   type :: piece_type
      !> Distance of the two ends in the metric of the branch [units_type].
      real(dp) :: length = 0
      integer :: nodes = 0
      !> Nodes of the polynomial: the two ends of the piece, then the points before and after the piece, where they serve.
      type(solution_point_type) :: node(4)
      !> Signed distance of each node from the first one [units_type].
      real(dp) :: at(4) = 0
   end type piece_type

   !> That the depth of a mesh is 0, see depth_below.
   type, extends(condition_type) :: edge_condition_type
      type(system_type), pointer :: system => null()
      type(transform_type), pointer :: transform => null()
      integer :: mesh = 0, stage = no_stage
      logical :: back = .false.
      !> Half backlash of the mesh at Lambda = 0 and its derivative [1]: along a path in a parameter on the chord of the piece,
      !> which is exact unless the backlash follows from a drawing.
      real(dp) :: gap = 0, gap_rate = 0
   contains
      procedure :: evaluate
      procedure :: depth
      procedure :: is_maximum
   end type edge_condition_type

contains

   !> Fills branch%contact_edges.
   subroutine locate_contact_edges(train, settings, branch, observer)
      !> The train as described.
      type(train_type), intent(in) :: train
      !> Settings that `branch` was traced with.
      type(response_settings_type), intent(in) :: settings
      !> A branch whose points are complete. A target: an observer may read it through a pointer.
      type(branch_type), intent(inout), target :: branch
      !> Is told of each piece with an edge; if it cancels, the edges so far are kept.
      class(observer_type), intent(inout), optional :: observer
      type(system_type), target :: systems(2)
      type(tracer_type) :: tracer
      type(transform_type), target :: transform
      type(contact_edge_type), allocatable :: edges(:)
      type(piece_type) :: piece
      type(solution_point_type) :: solution
      type(edge_condition_type) :: condition
      real(dp), allocatable :: gap(:, :), ends(:, :)
      integer, allocatable :: stages(:)
      integer :: i, j, k, n, before
      logical, allocatable :: staged(:)
      logical :: shot, prepared, ready, keep_going

      if (allocated(branch%contact_edges)) deallocate (branch%contact_edges)
      if (branch%points < 2) return
      allocate (gap(branch%points, branch%meshes))
      do j = 1, branch%meshes
         gap(:, j) = gap_along(branch, j)
      end do
      if (.not. (any(gap > 0) .or. any(train%meshes%is_coupling))) return
      allocate (edges(most_edges), ends(2, most_edges))
      n = 0
      shot = has_friction(train)
      condition%transform => transform
      condition%varies = .true.
      prepared = .false.
      ! Only couplings have stages. Over a parameter the walls may move.
      allocate (staged(branch%meshes), source=.false.)
      if (any(train%meshes%is_coupling)) call prepare()
      if (prepared .and. .not. allocated(branch%parameter)) &
         staged = [(size(stages_of(tracer%system, j)) > 0, j=1, branch%meshes)]
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         ready = .false.
         before = n
         do j = 1, branch%meshes
            stages = [integer ::]
            if (staged(j)) stages = stages_of(tracer%system, j)
            do k = 1, 2 + size(stages)
               if (k <= 2 .and. .not. all(gap(i:i + 1, j) > 0)) cycle
               condition%back = k == 2
               condition%stage = no_stage
               if (k > 2) condition%stage = stages(k - 2)
               call add_edge(j)
            end do
         end do
         if (.not. (ready .and. present(observer))) cycle
         keep_going = .true.
         call observer%on_step('response', branch%points, branch%frequency_ratio(i), keep_going)
         if (.not. keep_going) exit
      end do
      branch%contact_edges = edges(:n)

   contains

      !> Prepares to solve the balance, which takes longer than a point of a large train.
      subroutine prepare()

         prepared = .true.
         call begin_trace(train, settings, systems, tracer, branch)
         condition%system => tracer%system
      end subroutine prepare

      !> Adds the edge of mesh j in the piece from point i to the next, where the piece has one.
      subroutine add_edge(j)
         integer, intent(in) :: j
         real(dp) :: first, last
         integer :: same

         condition%mesh = j
         first = condition%depth(branch%minimum(j, i), branch%maximum(j, i), gap(i, j))
         last = condition%depth(branch%minimum(j, i + 1), branch%maximum(j, i + 1), gap(i + 1, j))
         if (first*last >= 0 .or. n == most_edges) return
         if (.not. (prepared .or. shot)) call prepare()
         if (.not. (ready .or. shot)) call prepare_piece(i)
         ready = .true.
         n = n + 1
         ends(:, n) = [first, last]
         associate (edge => edges(n), share => first/(first - last), at => branch%frequency_ratio(i:i + 1), &
                    rms => branch%rms(:, i:i + 1))
            edge%point = i
            edge%mesh = j
            edge%back = condition%back
            edge%stage = condition%stage
            same = edge_alike(j)
            if (same > 0) then
               edge%interpolated = edges(same)%interpolated
               edge%frequency_ratio = edges(same)%frequency_ratio
               edge%rms = edges(same)%rms
            else if (shot) then
               ! Without a balance to solve, on the chord between the points.
               edge%interpolated = .true.
               edge%frequency_ratio = at(1) + share*(at(2) - at(1))
               edge%rms = rms(:, 1) + share*(rms(:, 2) - rms(:, 1))
            else
               call locate(first, last, edge%interpolated)
               edge%frequency_ratio = solution%frequency_ratio
               edge%rms = rms_of(tracer%corrector, solution)
            end if
         end associate
      end subroutine add_edge

      !> Number of an edge of this piece that is located already, of a mesh with the depths of mesh j at both ends; 0: none.
      pure integer function edge_alike(j)
         integer, intent(in) :: j

         do edge_alike = n - 1, before + 1, -1
            associate (edge => edges(edge_alike))
               if ((edge%back .neqv. condition%back) .or. edge%stage /= no_stage .or. condition%stage /= no_stage) cycle
               if (all(abs(gap(i:i + 1, edge%mesh) - gap(i:i + 1, j)) <= alike*gap(i:i + 1, j)) .and. &
                   all(abs(ends(:, edge_alike) - ends(:, n)) <= alike*gap(i:i + 1, j))) return
            end associate
         end do
         edge_alike = 0
      end function edge_alike

      !> Makes `piece` the piece of the branch between the points i and i + 1.
      subroutine prepare_piece(i)
         integer, intent(in) :: i
         integer :: m

         associate (highest => maxval(branch%point_harmonics(i:i + 1)))
            if (highest /= tracer%corrector%balance%highest .or. tracer%chooses_sets) &
               call tracer%prepare(highest, carried_by(branch, i, i + 1))
         end associate
         call transform%plan(fine_samples(tracer%corrector%balance%highest))
         piece%nodes = 2
         piece%node(1) = solution_of(tracer, motion_of(branch, i))
         piece%node(2) = solution_of(tracer, motion_of(branch, i + 1))
         piece%length = chord(piece%node(1), piece%node(2))
         piece%at(:2) = [0.0_dp, piece%length]
         solution = piece%node(1)
         ! Across the chord; the tangent of each point where the balance was solved there.
         solution%tangent = (piece%node(2)%u - piece%node(1)%u)/piece%length
         solution%tangent_frequency = (piece%node(2)%frequency_ratio - piece%node(1)%frequency_ratio)/piece%length
         do m = i - 1, i + 2, 3
            if (m < 1 .or. m > branch%points) cycle
            if (.not. joined(branch, merge(m, m - 1, m < i))) cycle
            associate (n => piece%nodes)
               piece%node(n + 1) = solution_of(tracer, motion_of(branch, m))
               piece%at(n + 1) = chord(piece%node(n + 1), piece%node(merge(1, 2, m < i)))
               ! The interpolation would divide rounding by this small distance.
               if (piece%at(n + 1) < nearest*piece%length) cycle
               piece%at(n + 1) = merge(-piece%at(n + 1), piece%length + piece%at(n + 1), m < i)
               n = n + 1
            end associate
         end do
      end subroutine prepare_piece

      real(dp) function chord(from, to)
         type(solution_point_type), intent(in) :: from, to

         chord = tracer%corrector%length_of(to%u - from%u, to%frequency_ratio - from%frequency_ratio)
      end function chord

      !> Makes `solution` the point at which the depth is zero: found on the polynomial, then on the branch by Newton's method.
      !> Where that fails, as where another extreme becomes the lowest beside the edge, it begins again at points of the branch
      !> nearer and nearer to the edge. The point on the polynomial where the balance has no solution nearby.
      subroutine locate(first, last, interpolated)
         !> Depths at the two ends of the piece, of different signs.
         real(dp), intent(in) :: first, last
         !> Whether it lies on the polynomial.
         logical, intent(out) :: interpolated
         type(solution_point_type) :: guess
         real(dp) :: a, b, fa, fb, s, scale
         integer :: kept, step, attempt
         logical :: success

         condition%gap = gap(i, condition%mesh)
         condition%gap_rate = 0
         if (abs(gap(i + 1, condition%mesh) - condition%gap) > 0) then
            condition%gap_rate = (gap(i + 1, condition%mesh) - condition%gap) &
                                 /(piece%node(2)%frequency_ratio - piece%node(1)%frequency_ratio)
            condition%gap = condition%gap - condition%gap_rate*piece%node(1)%frequency_ratio
         end if
         scale = gap(i, condition%mesh)
         if (condition%stage /= no_stage) scale = maxval(abs(tracer%system%law(condition%mesh)%wall))
         success = .false.
         do attempt = 1, 2
            a = 0
            b = piece%length
            fa = first
            fb = last
            kept = 0
            do step = 1, most_steps
               s = between(a, b, fa, fb)
               call go_along(piece, s, solution)
               if (attempt == 2) call tracer%corrector%correct(solution, success)
               if (attempt == 2 .and. .not. success) exit
               call condition%evaluate(tracer%corrector%balance, solution%u, solution%frequency_ratio)
               success = attempt == 2 .and. abs(condition%value) < solved*scale
               if (success .or. attempt == 1 .and. abs(condition%value) < located*scale) exit
               call shrink(a, b, fa, fb, s, condition%value, kept)
               if (attempt == 2) call solve(success)
               if (success) exit
            end do
            if (attempt == 1) then
               guess = solution
               call solve(success)
            end if
            if (success) exit
         end do
         interpolated = .not. success
         if (interpolated) solution = guess
      end subroutine locate

      !> Solves from `solution` on; leaves it as it is where that fails.
      subroutine solve(success)
         logical, intent(out) :: success
         type(solution_point_type) :: start

         start = solution
         call tracer%corrector%newton(solution, condition, piece%length, success)
         if (success) success = chord(start, solution) < piece%length
         if (.not. success) solution = start
      end subroutine solve

   end subroutine locate_contact_edges

   !> Finds the depth and its gradient. The depth follows from an extreme of the displacement, at whose angle the displacement is
   !> differentiated by its coefficients.
   subroutine evaluate(self, balance, u, frequency_ratio)
      class(edge_condition_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :), frequency_ratio
      real(dp) :: smallest, largest, at(2), gap, sense
      integer :: unknown, k

      if (allocated(self%row)) then
         if (any(shape(self%row) /= shape(u))) deallocate (self%row)
      end if
      if (.not. allocated(self%row)) allocate (self%row, mold=u)
      self%row = 0
      ! A mesh with backlash or stages is an unknown of the balance.
      unknown = findloc(balance%mesh, self%mesh, 1)
      call extremes(u(:, unknown), balance%harmonic, self%transform, smallest, largest, at)
      gap = self%gap + self%gap_rate*frequency_ratio
      self%value = self%depth(smallest, largest, gap)
      self%row_frequency = 0
      if (self%stage == no_stage) self%row_frequency = merge(1, -1, self%back)*self%gap_rate
      associate (upper => self%is_maximum(smallest, largest))
         sense = merge(-1, 1, upper)
         self%row(1, unknown) = sense
         do k = 1, size(balance%harmonic)
            self%row(2*k:2*k + 1, unknown) = sense*[cos(balance%harmonic(k)*merge(at(2), at(1), upper)), &
                                                    sin(balance%harmonic(k)*merge(at(2), at(1), upper))]
         end do
      end associate
   end subroutine evaluate

   !> Depth by the extremes of the displacement.
   pure real(dp) function depth(self, smallest, largest, gap)
      class(edge_condition_type), intent(in) :: self
      !> Extremes over characteristic length and half backlash [1].
      real(dp), intent(in) :: smallest, largest, gap

      if (self%stage == no_stage) then
         depth = depth_below(smallest, largest, gap, self%back)
      else
         depth = depth_of_stage(self%system, self%mesh, self%stage, smallest, largest)
      end if
   end function depth

   !> Whether the depth falls as the maximum of the displacement rises; else it rises as the minimum does.
   pure logical function is_maximum(self, smallest, largest)
      class(edge_condition_type), intent(in) :: self
      !> Extremes over characteristic length [1].
      real(dp), intent(in) :: smallest, largest

      if (self%stage == no_stage) then
         is_maximum = .not. self%back .and. -largest > smallest
      else
         is_maximum = self%stage > rest_of(self%system, self%mesh)
      end if
   end function is_maximum

   !> Solution point of the polynomial at the distance s from the first node.
   pure subroutine go_along(piece, s, solution)
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: s
      type(solution_point_type), intent(inout) :: solution
      real(dp) :: weight
      integer :: i, k

      solution%u = 0
      solution%frequency_ratio = 0
      do i = 1, piece%nodes
         weight = 1
         do k = 1, piece%nodes
            if (k == i) cycle
            weight = weight*(s - piece%at(k))/(piece%at(i) - piece%at(k))
         end do
         solution%u = solution%u + weight*piece%node(i)%u
         solution%frequency_ratio = solution%frequency_ratio + weight*piece%node(i)%frequency_ratio
      end do
   end subroutine go_along

end module geartrain_readings_contact_edges
