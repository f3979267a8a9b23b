!> Exactly where along a branch a mesh begins or ceases to separate, or its back flanks to collide: by solving the balance there.
module geartrain_continuation_contact_edges
   use geartrain_balance_motion, only: motion_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_observer, only: observer_type
   use geartrain_continuation_branch, only: branch_type, contact_edge_type, response_settings_type
   use geartrain_continuation_contact_ranges, only: depth_below
   use geartrain_continuation_corrector, only: solution_point_type
   use geartrain_continuation_decided, only: joined
   use geartrain_continuation_start, only: begin_trace, solution_of
   use geartrain_continuation_tracer, only: tracer_type
   use geartrain_linalg_bracket, only: between, shrink
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: extremes, fine_samples
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: locate_contact_edges

   !> Edges that are located, of a train with many meshes the first ones along the branch; the others are interpolated.
   integer, parameter :: most_edges = 1000
   integer, parameter :: most_steps = 20
   !> How exactly on the polynomial; what the last step may be, squared, over the length of the piece: about what it is wrong by.
   real(dp), parameter :: located = 1e-7_dp, nearly = 1e-10_dp
   !> A point nearer to the next one than this share of the piece is no node of the polynomial.
   real(dp), parameter :: nearest = 0.03_dp

   !> A piece of a branch between two points, the first two nodes, and those before and after it: solution points are told by the
   !> way from the first point.
   type :: piece_type
      real(dp) :: length = 0
      integer :: nodes = 0
      type(solution_point_type) :: node(4)
      real(dp) :: at(4) = 0
   end type piece_type

contains

   !> Fills branch%contact_edges.
   subroutine locate_contact_edges(train, settings, branch, observer)
      type(train_type), intent(in) :: train
      !> Those that the branch was traced with.
      type(response_settings_type), intent(in) :: settings
      type(branch_type), intent(inout), target :: branch
      class(observer_type), intent(inout), optional :: observer
      type(tracer_type) :: tracer
      type(transform_type) :: transform
      type(contact_edge_type), allocatable :: edges(:)
      type(piece_type) :: piece
      type(solution_point_type) :: solution
      real(dp) :: first, last
      integer :: i, j, k, n
      logical :: ready, success, keep_going, back

      if (allocated(branch%contact_edges)) deallocate (branch%contact_edges)
      if (branch%points < 2 .or. .not. allocated(branch%half_backlash)) return
      if (.not. any(branch%half_backlash > 0)) return
      allocate (edges(most_edges))
      n = 0
      call begin_trace(train, settings, tracer)
      tracer%corrector%local_control = .false.
      do i = 1, branch%points - 1
         if (.not. joined(branch, i)) cycle
         ready = .false.
         do j = 1, branch%meshes
            if (.not. branch%half_backlash(j) > 0) cycle
            do k = 1, 2
               back = k == 2
               first = depth_below(branch%minimum(j, i), branch%maximum(j, i), branch%half_backlash(j), back)
               last = depth_below(branch%minimum(j, i + 1), branch%maximum(j, i + 1), branch%half_backlash(j), back)
               if (first*last >= 0 .or. n == most_edges) cycle
               if (.not. ready) call prepare_piece(i)
               ready = .true.
               n = n + 1
               edges(n)%point = i
               edges(n)%mesh = j
               edges(n)%back = back
               call locate(j, back, first, last, edges(n)%frequency_ratio, success)
               if (.not. success) n = n - 1
            end do
         end do
         if (.not. (ready .and. present(observer))) cycle
         keep_going = .true.
         call observer%on_step('response', branch%points, branch%frequency_ratio(i), keep_going)
         if (.not. keep_going) exit
      end do
      branch%contact_edges = edges(:n)

   contains

      !> The piece of the branch between the points i and i + 1.
      subroutine prepare_piece(i)
         integer, intent(in) :: i
         integer :: m

         associate (highest => maxval(branch%point_harmonics(i:i + 1)))
            if (highest /= tracer%corrector%balance%highest) call tracer%prepare(highest)
         end associate
         call transform%plan(fine_samples(tracer%corrector%balance%highest))
         piece%nodes = 2
         call place_on(i, piece%node(1))
         call place_on(i + 1, piece%node(2))
         piece%length = chord(piece%node(1), piece%node(2))
         piece%at(:2) = [0.0_dp, piece%length]
         solution = piece%node(1)
         do m = i - 1, i + 2, 3
            if (m < 1 .or. m > branch%points) cycle
            if (.not. joined(branch, merge(m, m - 1, m < i))) cycle
            associate (n => piece%nodes)
               call place_on(m, piece%node(n + 1))
               piece%at(n + 1) = chord(piece%node(n + 1), piece%node(merge(1, 2, m < i)))
               ! The interpolation would divide rounding by it.
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

      subroutine place_on(i, solution)
         integer, intent(in) :: i
         type(solution_point_type), intent(out) :: solution
         type(motion_type) :: motion

         motion%period = branch%subharmonic
         motion%frequency_ratio = branch%frequency_ratio(i)
         motion%coefficients = branch%coefficients(:, :, i)
         solution = solution_of(tracer, motion)
         allocate (solution%tangent, mold=solution%u)
      end subroutine place_on

      !> Where the depth of mesh j is zero: first on the polynomial, which is nearly the branch.
      subroutine locate(j, back, first, last, frequency_ratio, success)
         integer, intent(in) :: j
         logical, intent(in) :: back
         real(dp), intent(in) :: first, last
         real(dp), intent(out) :: frequency_ratio
         logical, intent(out) :: success
         type(solution_point_type) :: guess
         real(dp) :: a, b, fa, fb, f, s, slope, way
         integer :: kept, step

         a = 0
         b = piece%length
         fa = first
         fb = last
         kept = 0
         do step = 1, most_steps
            s = between(a, b, fa, fb)
            call go_along(piece, s, solution)
            f = depth_at(solution, j, back)
            if (abs(f) < located*branch%half_backlash(j)) exit
            call shrink(a, b, fa, fb, s, f, kept)
         end do
         a = 1e-4_dp*piece%length
         call go_along(piece, s + a, solution)
         slope = depth_at(solution, j, back)
         call go_along(piece, s - a, solution)
         slope = (slope - depth_at(solution, j, back))/(2*a)
         call go_along(piece, s, solution)
         do step = 1, most_steps
            guess = solution
            call tracer%corrector%correct(solution, success)
            if (.not. success) return
            f = depth_at(solution, j, back)
            way = step_to_zero(piece, s, f, slope)
            frequency_ratio = solution%frequency_ratio + solution%tangent_frequency*way
            if (way**2 < nearly*piece%length) return
            ! The branch is as far from the polynomial a little further on.
            guess%u = solution%u - guess%u
            guess%frequency_ratio = solution%frequency_ratio - guess%frequency_ratio
            s = s + way
            if (.not. abs(s - piece%length/2) < piece%length) exit
            call go_along(piece, s, solution)
            solution%u = solution%u + guess%u
            solution%frequency_ratio = solution%frequency_ratio + guess%frequency_ratio
         end do
         success = .false.
      end subroutine locate

      real(dp) function depth_at(solution, j, back)
         type(solution_point_type), intent(in) :: solution
         integer, intent(in) :: j
         logical, intent(in) :: back
         real(dp) :: coefficients(1 + 2*tracer%corrector%balance%highest, branch%meshes), smallest, largest
         integer :: k

         call tracer%corrector%balance%full_coefficients(solution%u, solution%frequency_ratio, coefficients)
         call extremes(coefficients(:, j), [(k, k=1, tracer%corrector%balance%highest)], transform, smallest, largest)
         depth_at = depth_below(smallest, largest, branch%half_backlash(j), back)
      end function depth_at

   end subroutine locate_contact_edges

   !> The way from s to where a depth is zero that is f at s, on the branch, and grows as `slope` on the polynomial: what the
   !> polynomial lacks goes as the product of the ways to its nodes, and is nothing at a node.
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

   !> The solution point at the way s along a piece, with its tangent: on the polynomial through its nodes.
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

end module geartrain_continuation_contact_edges
