!> Contact edges of a branch: where a mesh begins or ceases to separate, its back flanks to collide, or a coupling to reach a
!> stage. The balance is solved there.
module geartrain_readings_contact_edges
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: extremes, fine_samples
   use geartrain_mesh_law_law, only: depth_below
   use geartrain_network_check_coupling, only: has_friction
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, carried_by, contact_edge_type, gap_along, response_settings_type
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_decided, only: joined
   use geartrain_trace_points, only: motion_of
   use geartrain_trace_special_points, only: rms_of
   use geartrain_trace_stages, only: depth_of_stage, no_stage, stages_of
   use geartrain_trace_start, only: begin_trace, solution_of
   use geartrain_trace_tracer, only: tracer_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: locate_contact_edges

   !> Edges that are located at most, the first ones along the branch; further edges are interpolated where they are needed.
   integer, parameter :: most_edges = 1000
   integer, parameter :: most_steps = 20
   !> Depth at an edge on the polynomial, over half the backlash [1]; square of the last step on the branch over the length of the
   !> piece, about the error of the edge [units_type].
   real(dp), parameter :: located = 1e-7_dp, nearly = 1e-13_dp
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
      type(transform_type) :: transform
      type(contact_edge_type), allocatable :: edges(:)
      type(piece_type) :: piece
      type(solution_point_type) :: solution
      real(dp), allocatable :: gap(:, :), ends(:, :)
      integer, allocatable :: stages(:)
      integer :: i, j, k, n, stage, before
      logical, allocatable :: staged(:)
      logical :: shot, ready, keep_going, back

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
      call begin_trace(train, settings, systems, tracer, branch)
      ! Over a parameter the walls may move.
      allocate (staged(branch%meshes), source=.false.)
      if (.not. allocated(branch%parameter)) staged = [(size(stages_of(tracer%system, j)) > 0, j=1, branch%meshes)]
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         ready = .false.
         before = n
         do j = 1, branch%meshes
            stages = [integer ::]
            if (staged(j)) stages = stages_of(tracer%system, j)
            do k = 1, 2 + size(stages)
               if (k <= 2 .and. .not. all(gap(i:i + 1, j) > 0)) cycle
               back = k == 2
               stage = no_stage
               if (k > 2) stage = stages(k - 2)
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

      !> Adds the edge of mesh j in the piece from point i to the next, where the piece has one.
      subroutine add_edge(j)
         integer, intent(in) :: j
         real(dp) :: first, last
         integer :: same

         first = depth(j, branch%minimum(j, i), branch%maximum(j, i), gap(i, j), back)
         last = depth(j, branch%minimum(j, i + 1), branch%maximum(j, i + 1), gap(i + 1, j), back)
         if (first*last >= 0 .or. n == most_edges) return
         if (.not. (ready .or. shot)) call prepare_piece(i)
         ready = .true.
         n = n + 1
         ends(:, n) = [first, last]
         associate (edge => edges(n), share => first/(first - last), at => branch%frequency_ratio(i:i + 1), &
                    rms => branch%rms(:, i:i + 1))
            edge%point = i
            edge%mesh = j
            edge%back = back
            edge%stage = stage
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
               call locate(j, back, first, last, edge%frequency_ratio, edge%interpolated)
               edge%rms = rms_of(tracer%corrector, solution)
            end if
         end associate
      end subroutine add_edge

      !> Number of an edge of this piece that is located already, of a mesh with the depths of mesh j at both ends; 0: none.
      pure integer function edge_alike(j)
         integer, intent(in) :: j

         do edge_alike = n - 1, before + 1, -1
            associate (edge => edges(edge_alike))
               if ((edge%back .neqv. back) .or. edge%stage /= stage .or. stage /= no_stage) cycle
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
         allocate (solution%tangent, mold=solution%u)
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

      !> Lambda at which the depth of mesh j is zero: found on the polynomial, then on the branch by solving the balance; on
      !> the polynomial where the balance has no solution nearby.
      subroutine locate(j, back, first, last, frequency_ratio, interpolated)
         integer, intent(in) :: j
         logical, intent(in) :: back
         !> Depths at the two ends of the piece, of different signs.
         real(dp), intent(in) :: first, last
         real(dp), intent(out) :: frequency_ratio
         !> Whether it lies on the polynomial.
         logical, intent(out) :: interpolated
         type(solution_point_type) :: guess
         real(dp) :: a, b, fa, fb, f, s, slope, way, root
         integer :: kept, step
         logical :: success

         a = 0
         b = piece%length
         fa = first
         fb = last
         kept = 0
         interpolated = .false.
         do step = 1, most_steps
            s = between(a, b, fa, fb)
            call go_along(piece, s, solution)
            f = depth_at(solution, j, back)
            if (abs(f) < located*scale_at(solution, j)) exit
            call shrink(a, b, fa, fb, s, f, kept)
         end do
         root = s
         a = 1e-4_dp*piece%length
         call go_along(piece, s + a, solution)
         slope = depth_at(solution, j, back)
         call go_along(piece, s - a, solution)
         slope = (slope - depth_at(solution, j, back))/(2*a)
         call go_along(piece, s, solution)
         do step = 1, most_steps
            guess = solution
            call tracer%corrector%correct(solution, success)
            if (.not. success) exit
            f = depth_at(solution, j, back)
            way = step_to_zero(piece, s, f, slope)
            frequency_ratio = solution%frequency_ratio + solution%tangent_frequency*way
            if (way**2 < nearly*piece%length) return
            ! A short step further the difference between branch and polynomial is about the present one.
            guess%u = solution%u - guess%u
            guess%frequency_ratio = solution%frequency_ratio - guess%frequency_ratio
            s = s + way
            if (.not. abs(s - piece%length/2) < piece%length) exit
            call go_along(piece, s, solution)
            solution%u = solution%u + guess%u
            solution%frequency_ratio = solution%frequency_ratio + guess%frequency_ratio
         end do
         interpolated = .true.
         call go_along(piece, root, solution)
         frequency_ratio = solution%frequency_ratio
      end subroutine locate

      !> Depth of mesh j at a solution point, see depth_below.
      real(dp) function depth_at(solution, j, back)
         type(solution_point_type), intent(in) :: solution
         integer, intent(in) :: j
         logical, intent(in) :: back
         real(dp) :: smallest, largest

         ! A mesh with backlash or stages is an unknown of the balance.
         associate (balance => tracer%corrector%balance)
            call extremes(solution%u(:, findloc(balance%mesh, j, 1)), balance%harmonic, transform, smallest, largest)
         end associate
         depth_at = depth(j, smallest, largest, gap_at(solution, j), back)
      end function depth_at

      !> Depth by the extremes of the displacement of mesh j.
      pure real(dp) function depth(j, smallest, largest, gap, back)
         integer, intent(in) :: j
         real(dp), intent(in) :: smallest, largest, gap
         logical, intent(in) :: back

         if (stage == no_stage) then
            depth = depth_below(smallest, largest, gap, back)
         else
            depth = depth_of_stage(tracer%system, j, stage, smallest, largest)
         end if
      end function depth

      !> Displacement beside which a depth is small [1].
      real(dp) function scale_at(solution, j)
         type(solution_point_type), intent(in) :: solution
         integer, intent(in) :: j

         scale_at = gap_at(solution, j)
         if (stage /= no_stage) scale_at = maxval(abs(tracer%system%law(j)%wall))
      end function scale_at

      !> Half backlash of mesh j at a solution point of the piece: along a path in a parameter between those of its ends, which is
      !> exact unless the backlash follows from a drawing.
      real(dp) function gap_at(solution, j)
         type(solution_point_type), intent(in) :: solution
         integer, intent(in) :: j
         real(dp) :: share

         share = 0
         if (abs(gap(i + 1, j) - gap(i, j)) > 0) share = (solution%frequency_ratio - piece%node(1)%frequency_ratio) &
                                                         /(piece%node(2)%frequency_ratio - piece%node(1)%frequency_ratio)
         gap_at = gap(i, j) + share*(gap(i + 1, j) - gap(i, j))
      end function gap_at

   end subroutine locate_contact_edges

   !> Newton step from s to the zero of a depth on the branch, which is f at s. Its derivative is `slope` on the polynomial; the
   !> difference between branch and polynomial, about f, is proportional to the product of the distances to the nodes.
   pure real(dp) function step_to_zero(piece, s, f, slope)
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: s, f, slope
      real(dp) :: to_nodes(piece%nodes), rate

      to_nodes = s - piece%at(:piece%nodes)
      rate = slope
      if (minval(abs(to_nodes)) > 1e-9_dp*piece%length) rate = rate + f*sum(1/to_nodes)
      step_to_zero = 0
      if (abs(f) > 0) step_to_zero = -f/sign(max(abs(rate), 1e-30_dp), rate)
   end function step_to_zero

   !> Solution point and tangent of the polynomial at the distance s from the first node.
   pure subroutine go_along(piece, s, solution)
      type(piece_type), intent(in) :: piece
      real(dp), intent(in) :: s
      type(solution_point_type), intent(inout) :: solution
      real(dp) :: weight, slope
      integer :: i, k

      solution%u = 0
      solution%frequency_ratio = 0
      solution%tangent = 0
      solution%tangent_frequency = 0
      do i = 1, piece%nodes
         weight = 1
         slope = 0
         do k = 1, piece%nodes
            if (k == i) cycle
            slope = (slope*(s - piece%at(k)) + weight)/(piece%at(i) - piece%at(k))
            weight = weight*(s - piece%at(k))/(piece%at(i) - piece%at(k))
         end do
         solution%u = solution%u + weight*piece%node(i)%u
         solution%frequency_ratio = solution%frequency_ratio + weight*piece%node(i)%frequency_ratio
         solution%tangent = solution%tangent + slope*piece%node(i)%u
         solution%tangent_frequency = solution%tangent_frequency + slope*piece%node(i)%frequency_ratio
      end do
   end subroutine go_along

end module geartrain_readings_contact_edges
