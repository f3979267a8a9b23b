!> The augmented system of a special point of the exact motion: an orbit, by shooting in sections, at which a test function is 0.
!> Its unknowns are the states, Lambda and, along a curve in two parameters, the value of a parameter of the train.
!>
!> Newton's method is reduced to three unknowns (orbit_directions.f90). All states follow from the changes l of Lambda, m of the
!> parameter and s along the null vector of M - I, and what remains is
!>    h + h_l l + h_m m + h_s s = 0, the orbit closes; g + g_l l + g_m m + g_s s = 0, the test function; the step along the curve.
!> Test functions g: of a fold and a doubling the last unknown of M - I and M + I, bordered; of a Neimark-Sacker point the product
!> of the pair of multipliers less 1; of a contact onset the distance of an extreme displacement from the wall. Derivatives of g
!> are differences along the four directions, whose errors slow Newton's method, and do not move its result.
!> A branch point has the test function of a fold. There h and its derivatives are 0 by the symmetry of the train, as the null
!> vector breaks the symmetry and the orbit does not. In place of the first equation stands that the orbit has no share of the
!> symmetry that breaks at the first point (broken_symmetry.f90), or s = 0 where there is no such symmetry.
module geartrain_exact_augmented_system
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type, metric_type, scale_tangent, trains_type
   use geartrain_exact_broken_symmetry, only: broken_symmetry_type
   use geartrain_exact_orbit_depth, only: depth_of
   use geartrain_exact_orbit_directions, only: along_lambda, along_parameter, find_directions, rest
   use geartrain_exact_orbit_tests, only: back_contact, is_onset
   use geartrain_floquet_critical_pair, only: pair_of
   use geartrain_floquet_multipliers, only: multipliers_of
   use geartrain_flow_multiple_shooting, only: has_converged, most_parts
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_border, only: border_type
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: augmented_system_type

   integer, parameter :: max_iterations = 12
   !> Length of a displacement for differences of the test function, usually and at least, and over the parameter [metric].
   real(dp), parameter :: small = 1e-6_dp, smallest = 1e-9_dp, small_parameter = 1e-6_dp
   !> Length of a Newton step, over the largest state, below which the derivatives of the point before it do for those after it.
   real(dp), parameter :: nearby = 1e-3_dp
   !> Gap of a branch point, over the largest state, that may be left.
   real(dp), parameter :: closed = 1e-9_dp
   !> Length of the step, over the largest state, that may be left along a curve.
   real(dp), parameter :: left_over = 1e-11_dp
   !> Length of the last step, over the largest state, or else value of the test function that may be left.
   real(dp), parameter :: left_over_test = 1e-9_dp
   !> Largest change of Lambda and of the parameter by one solution, in the units of the metric.
   real(dp), parameter :: farthest = 0.5_dp
   !> Distance between the ends of a step over its length beyond which Newton's method has gone to another curve.
   real(dp), parameter :: aside = 1.5_dp
   !> Gap of an orbit, in the units of the metric, whose effect on the test function is left to the next iteration.
   real(dp), parameter :: negligible = 1e-10_dp
   character(*), parameter :: branch_point = 'branch point'

   type :: augmented_system_type
      !> Kind of the special point; of a contact onset the number of the mesh.
      character(16) :: kind = ''
      integer :: mesh = 0
      !> Period of the orbit [periods of the fundamental].
      integer :: period = 1
      !> The metric; unit of the parameter in it, and its value where `parameter` of a point is 0 [unit of the parameter].
      type(metric_type) :: metric
      real(dp) :: scale = 1, origin = 0
      !> The train with variable parameter; not allocated: the train is as it is.
      type(parameter_path_type), allocatable :: path
      !> The train of the latest value, `here` of `trains`, and this value [1].
      type(system_type), pointer :: system => null()
      type(trains_type), pointer, private :: trains => null()
      real(dp), private :: latest = huge(1.0_dp)
      !> Value at which the parameter was last varied [1].
      real(dp), private :: varied = huge(1.0_dp)
      !> Flights with and without derivatives with respect to Lambda and the parameter.
      type(sections_type) :: moving, probe
      !> Flight of the train with another value of the parameter.
      type(sections_type), private :: aside
      !> Of M - I, and of M + I; whether their borders are null vectors of a nearby orbit.
      type(border_type) :: plus, minus
      logical, private :: has_borders = .false.
      !> Whether the latest solution is no orbit: at a branch point where the parameter breaks the symmetry.
      logical :: open = .false.
      !> At a branch point the symmetry that breaks there; whether the first point is symmetric.
      type(broken_symmetry_type), private :: symmetry
      logical :: is_symmetric = .false.
      !> Sum of the pair of multipliers of the latest flight, by which the pair is known.
      real(dp), private :: pair_sum = huge(1.0_dp)
   contains
      procedure :: setup
      procedure :: continue_from
      procedure :: solve
      procedure :: advance
      procedure :: find_borders
      procedure :: stand_at
      procedure, private :: test_value
   end type augmented_system_type

contains

   !> Prepares for special points of one kind.
   subroutine setup(self, trains, system, period, kind, mesh, path, origin)
      class(augmented_system_type), intent(inout) :: self
      !> Room for the trains of this augmented system.
      type(trains_type), pointer, intent(in) :: trains
      !> The train.
      type(system_type), intent(in) :: system
      !> Period of the orbits [periods of the fundamental].
      integer, intent(in) :: period
      !> Kind of the special points.
      character(*), intent(in) :: kind
      !> Of contact onsets the number of the mesh.
      integer, intent(in) :: mesh
      !> The train with variable parameter.
      type(parameter_path_type), intent(in), optional :: path
      !> The value of the parameter that counts as 0 [unit of the parameter].
      real(dp), intent(in), optional :: origin

      self%kind = kind
      self%mesh = mesh
      self%period = period
      trains%here = system
      self%trains => trains
      self%system => trains%here
      self%latest = huge(1.0_dp)
      self%varied = huge(1.0_dp)
      if (present(path)) then
         self%path = path
         self%origin = origin
         self%scale = path%length
      end if
      call self%metric%setup(system, period*most_parts(system, period))
      call self%plus%begin(system%states)
      call self%minus%begin(system%states)
   end subroutine setup

   !> Goes to the special point that another augmented system was solved for, with the borders and the symmetry found there.
   subroutine continue_from(self, other, point)
      class(augmented_system_type), intent(inout) :: self
      !> The other one.
      type(augmented_system_type), intent(in) :: other
      !> The special point.
      type(augmented_point_type), intent(in) :: point

      self%plus = other%plus
      self%minus = other%minus
      self%has_borders = other%has_borders
      self%symmetry = other%symmetry
      self%is_symmetric = other%is_symmetric
      self%pair_sum = other%pair_sum
      call self%stand_at(point%parameter, .false.)
      call self%moving%fly(point%frequency_ratio, point%states)
   end subroutine continue_from

   !> Takes the train with a value of the parameter, and varies the parameter there.
   subroutine stand_at(self, parameter, again)
      class(augmented_system_type), intent(inout) :: self
      !> The value [1].
      real(dp), intent(in) :: parameter
      !> Whether the derivatives of before will do.
      logical, intent(in) :: again

      if (abs(parameter - self%latest) <= 0 .and. (again .or. abs(parameter - self%varied) <= 0)) return
      self%latest = parameter
      if (allocated(self%path)) call self%path%system_at(self%origin + self%scale*parameter, self%system)
      if (.not. again) self%varied = parameter
      if (allocated(self%path) .and. .not. again) then
         call self%path%system_at(self%origin + self%scale*(parameter + small_parameter), self%trains%above)
         call self%moving%vary(self%trains%above, small_parameter)
      end if
      associate (parts => most_parts(self%system, self%period))
         call self%moving%setup(self%system, self%period, parts, moves=.true.)
         call self%probe%setup(self%system, self%period, parts, moves=.false.)
      end associate
   end subroutine stand_at

   !> Newton's method from a guess to a special point: at constant value of the parameter, or in the plane normal to the tangent of
   !> the guess. The tangent keeps its sense.
   subroutine solve(self, point, along, success, roughly)
      class(augmented_system_type), intent(inout) :: self
      !> The guess, with a tangent if `along`; then the special point with its tangent where there is a parameter.
      type(augmented_point_type), intent(inout) :: point
      !> Whether the step is normal to the tangent; else the parameter is constant.
      logical, intent(in) :: along
      !> Whether Newton's method has converged.
      logical, intent(out) :: success
      !> Whether the tangent, and the derivatives of h and g, may be those of the first iterations; the point is as exact. Default
      !> no.
      logical, intent(in), optional :: roughly
      type(augmented_point_type) :: guess
      real(dp) :: matrix(3, 3), right(3, 2), value, length, before, gap, scale, norm, missed
      real(dp) :: step(size(point%states, 1), size(point%states, 2), 4)
      integer :: pivot(3), d, i, info
      logical :: again, rough

      guess = point
      self%pair_sum = point%pair_sum
      success = .false.
      self%open = .false.
      before = huge(1.0_dp)
      again = .false.
      rough = .false.
      if (present(roughly)) rough = roughly
      if (.not. self%has_borders) then
         call self%find_borders(point, info)
         if (info /= 0) return
      end if
      do i = 1, max_iterations
         call self%stand_at(point%parameter, again)
         call self%moving%fly(point%frequency_ratio, point%states, again)
         if (self%moving%interrupted()) return
         call find_directions(self%moving, self%plus, allocated(self%path), step, point%h, info)
         if (info /= 0) return
         missed = point%h(1)/self%metric%units%length
         if (self%kind == branch_point) then
            point%h = [0, 0, 0, 1]
            if (self%is_symmetric) then
               do d = 1, 4
                  point%h(d) = self%symmetry%share_of(step(:, :, d))
               end do
               point%h(1) = point%h(1) + self%symmetry%share_of(point%states)
            end if
         end if
         call self%test_value(point, value, info)
         if (info /= 0) return
         call differentiate(self, point, step, value, again, rough, point%g)
         matrix(1, :) = point%h(2:)
         matrix(2, :) = point%g(2:)
         matrix(3, :) = [0.0_dp, 1.0_dp, 0.0_dp]
         right(:, 1) = [-point%h(1), -value - point%g(1), 0.0_dp]
         if (along) then
            matrix(3, :) = [self%metric%product_of(step(:, :, 2), 1.0_dp, 0.0_dp, guess), &
                            self%metric%product_of(step(:, :, 3), 0.0_dp, 1.0_dp, guess), &
                            self%metric%product_of(step(:, :, 4), 0.0_dp, 0.0_dp, guess)]
            right(3, 1) = -self%metric%product_of(step(:, :, 1), 0.0_dp, 0.0_dp, guess) &
                          - self%metric%product_of(point%states - guess%states, point%frequency_ratio - guess%frequency_ratio, &
                                            point%parameter - guess%parameter, guess)
         end if
         right(:, 2) = [0, 0, 1]
         call factor_matrix(3, matrix, pivot, info)
         if (info /= 0) return
         call solve_factored(3, 2, matrix, pivot, right)
         step(:, :, 1) = step(:, :, 1) + right(1, 1)*step(:, :, 2) + right(2, 1)*step(:, :, 3) + right(3, 1)*step(:, :, 4)
         scale = self%moving%size_of(point%states)
         gap = self%moving%size_of(self%moving%missed)/scale
         length = maxval([self%moving%size_of(step(:, :, 1))/scale, abs(right(:2, 1))/[self%metric%units%frequency_ratio, 1.0_dp]])
         if (.not. length < 10) return
         point%states = point%states + step(:, :, 1)
         point%frequency_ratio = point%frequency_ratio + right(1, 1)
         point%parameter = point%parameter + right(2, 1)
         if (.not. point%frequency_ratio > 0) return
         if (abs(point%frequency_ratio - guess%frequency_ratio) > farthest*self%metric%units%frequency_ratio) return
         if (abs(point%parameter - guess%parameter) > farthest) return
         ! With derivatives of before the steps shrink by a constant factor: what is left is the next step. Steps that stay long
         ! although the orbit is closed are rounding only where the test function is 0 as well.
         success = has_converged(length, before, gap) .and. (length < left_over_test .or. abs(value) < left_over_test) .or. &
                   again .and. self%kind /= branch_point .and. length**2 < left_over*before
         if (success) exit
         ! Where the steps do not become much shorter the derivatives are not those here.
         again = rough .and. length < nearby .and. length < 0.1_dp*before
         before = length
      end do
      ! The equation that the symmetry has taken the place of.
      self%open = success .and. self%kind == branch_point .and. self%is_symmetric .and. abs(missed) > closed*scale
      success = success .and. .not. self%open
      if (.not. success) return
      point%events = self%moving%events
      point%slowest_event = self%moving%slowest_event
      call take_borders(self, info)
      if (info /= 0) success = .false.
      point%multipliers = multipliers_of(self%moving%monodromy)
      point%pair_sum = self%pair_sum
      point%product_plus = self%plus%product
      point%product_minus = self%minus%product
      if (.not. allocated(self%path)) return
      ! The direction of the curve: the null vector of the first two rows.
      if (.not. along) right(:, 2) = [point%h(3)*point%g(4) - point%h(4)*point%g(3), &
                                      point%h(4)*point%g(2) - point%h(2)*point%g(4), &
                                      point%h(2)*point%g(3) - point%h(3)*point%g(2)]
      point%tangent = right(1, 2)*step(:, :, 2) + right(2, 2)*step(:, :, 3) + right(3, 2)*step(:, :, 4)
      point%tangent_frequency = right(1, 2)
      point%tangent_parameter = right(2, 2)
      norm = sqrt(self%metric%product_of(point%tangent, point%tangent_frequency, point%tangent_parameter, point))
      if (.not. along .and. allocated(guess%tangent)) then
         if (self%metric%product_of(point%tangent, point%tangent_frequency, point%tangent_parameter, guess) < 0) norm = -norm
      end if
      call scale_tangent(point, 1/norm)
   end subroutine solve

   !> Step along the curve: predictor and Newton's method.
   subroutine advance(self, from, h, to, success, roughly)
      class(augmented_system_type), intent(inout) :: self
      !> A special point with its tangent.
      type(augmented_point_type), intent(in) :: from
      !> Length of the step in the metric.
      real(dp), intent(in) :: h
      !> The next special point, another variable than `from`; its bend is not known.
      type(augmented_point_type), intent(inout) :: to
      !> Whether Newton's method has converged, and to a point of this curve: nearby, with a tangent of nearly the same direction.
      logical, intent(out) :: success
      !> As of `solve`.
      logical, intent(in), optional :: roughly

      to = from
      to%states = from%states + h*from%tangent
      to%frequency_ratio = from%frequency_ratio + h*from%tangent_frequency
      to%parameter = from%parameter + h*from%tangent_parameter
      if (allocated(from%bend)) then
         to%states = to%states + h**2*(from%bend(:, :, 1) + h*from%bend(:, :, 2))
         to%frequency_ratio = to%frequency_ratio + h**2*(from%bend_frequency(1) + h*from%bend_frequency(2))
         to%parameter = to%parameter + h**2*(from%bend_parameter(1) + h*from%bend_parameter(2))
         deallocate (to%bend)
      end if
      success = to%frequency_ratio > 0
      if (success) call self%solve(to, .true., success, roughly)
      if (success) success = self%metric%distance(to, from) < aside*abs(h) .and. &
                             self%metric%product_of(to%tangent, to%tangent_frequency, to%tangent_parameter, from) > 0.8_dp
   end subroutine advance

   !> Finds the borders at a point.
   subroutine find_borders(self, point, info)
      class(augmented_system_type), intent(inout) :: self
      !> A point at or near a special point; a branch point becomes symmetric if it can.
      type(augmented_point_type), intent(inout) :: point
      !> 0: they are found.
      integer, intent(out) :: info

      call self%stand_at(point%parameter, .false.)
      call self%moving%fly(point%frequency_ratio, point%states)
      call take_borders(self, info)
      if (info == 0) call take_borders(self, info)
      self%has_borders = info == 0
      if (info == 0 .and. self%kind == branch_point) &
         call self%symmetry%find(self%plus, self%moving, point%frequency_ratio, point%states, self%is_symmetric)
   end subroutine find_borders

   !> Takes the null vectors of M - I and M + I of the latest flight as the next borders.
   subroutine take_borders(self, info)
      class(augmented_system_type), intent(inout) :: self
      integer, intent(out) :: info

      call self%plus%find(self%moving%monodromy, -1.0_dp, info)
      if (info /= 0) return
      call self%minus%find(self%moving%monodromy, 1.0_dp, info)
      if (info /= 0) return
      call self%plus%renew()
      call self%minus%renew()
   end subroutine take_borders

   !> Value of the test function at the orbit of the latest flight.
   subroutine test_value(self, point, value, info)
      class(augmented_system_type), intent(inout) :: self
      type(augmented_point_type), intent(in) :: point
      real(dp), intent(out) :: value
      integer, intent(out) :: info
      complex(dp) :: pair(2)

      info = 0
      select case (self%kind)
      case ('fold', branch_point)
         call self%plus%find(self%moving%monodromy, -1.0_dp, info)
         value = self%plus%value
      case ('period doubling')
         call self%minus%find(self%moving%monodromy, 1.0_dp, info)
         value = self%minus%value
      case ('neimark-sacker')
         pair = pair_of(multipliers_of(self%moving%monodromy), self%pair_sum)
         value = real(product(pair), dp) - 1
         self%pair_sum = real(sum(pair), dp)
      case default
         value = depth_of(self%probe, point%frequency_ratio, point%states, self%mesh, self%system%half_backlash(self%mesh), &
                          self%kind == back_contact)
      end select
   end subroutine test_value

   !> Derivatives of the test function in the directions, whose steps of all states are given.
   subroutine differentiate(self, point, step, value, again, roughly, g)
      class(augmented_system_type), intent(inout) :: self
      type(augmented_point_type), intent(in) :: point
      real(dp), intent(in) :: step(:, :, :), value
      !> Whether those in the directions other than `rest` will do as they are.
      logical, intent(in) :: again
      !> Whether g may be off by 1e-6: what M does to a vector differs by rounding from flight to flight.
      logical, intent(in) :: roughly
      real(dp), intent(inout) :: g(4)
      type(augmented_point_type) :: moved
      type(border_type) :: border
      real(dp) :: vectors(size(point%states, 1), 1), reference(size(point%states, 1), 1), norm, h, length
      integer :: d, side, events
      logical :: quick

      g(rest) = 0
      if (again .and. self%moving%size_of(step(:, :, rest)) < negligible) return
      quick = self%kind == 'fold' .or. self%kind == branch_point .or. self%kind == 'period doubling'
      if (quick) border = self%plus
      if (self%kind == 'period doubling') border = self%minus
      if (quick) then
         reference(:, 1) = border%right
         if (roughly) then
            reference(:, 1) = matmul(self%moving%monodromy, border%right)
         else
            call self%probe%carry_vectors(point%frequency_ratio, point%states, reference)
         end if
      end if
      if (.not. again) g = 0
      ! Where an event has hardly any speed the mesh is hardly beyond the wall, by the square of the speed.
      associate (units => self%metric%units)
         length = max(smallest, min(small, 0.05_dp*(self%moving%slowest_event/(units%length*units%frequency_ratio))**2))
      end associate
      do d = 1, merge(1, 4, again)
         if (d == along_parameter .and. .not. allocated(self%path)) cycle
         norm = self%moving%size_of(step(:, :, d))
         if (d == along_lambda) norm = max(norm, 1/self%metric%units%frequency_ratio)
         if (d == along_parameter) norm = max(norm, 1.0_dp)
         ! Of the remaining error the second order is left to the next step.
         if (d == rest .and. norm < negligible) cycle
         do side = 1, -1, -2
            h = side*length/norm
            moved%states = point%states + h*step(:, :, d)
            moved%frequency_ratio = point%frequency_ratio
            if (d == along_lambda) moved%frequency_ratio = moved%frequency_ratio + h
            if (d == along_parameter) then
               call self%path%system_at(self%origin + self%scale*(point%parameter + h), self%trains%beside)
               call self%aside%setup(self%trains%beside, self%period, self%probe%sections/self%period, moves=.false.)
               call take(self%aside, self%trains%beside%half_backlash)
            else
               call take(self%probe, self%system%half_backlash)
            end if
            ! Beyond a grazing M changes as a square root does: there the difference is taken to the other side.
            if (is_onset(self%kind) .or. events == self%moving%events) exit
         end do
      end do

   contains

      !> Takes the difference by a flight of this or another train.
      subroutine take(flight, half_backlash)
         type(sections_type), intent(inout) :: flight
         real(dp), intent(in) :: half_backlash(:)

         if (quick) then
            vectors(:, 1) = border%right
            call flight%carry_vectors(moved%frequency_ratio, moved%states, vectors)
            g(d) = -dot_product(border%left, vectors(:, 1) - reference(:, 1))/h
         else if (is_onset(self%kind)) then
            g(d) = (depth_of(flight, moved%frequency_ratio, moved%states, self%mesh, half_backlash(self%mesh), &
                             self%kind == back_contact) - value)/h
         else
            call flight%fly(moved%frequency_ratio, moved%states)
            g(d) = (real(product(pair_of(multipliers_of(flight%monodromy), self%pair_sum)), dp) - 1 - value)/h
         end if
         events = flight%events
      end subroutine take

   end subroutine differentiate

end module geartrain_exact_augmented_system
