!> A special point of the exact motion, and the metric in which the lengths of curves of such points are measured.
module geartrain_exact_augmented_point
   use geartrain_base_kinds, only: dp
   use geartrain_network_units, only: units_of, units_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: add_tangent, augmented_point_type, metric_type, scale_tangent, trains_type

   !> A special point.
   type :: augmented_point_type
      !> Lambda [1]; the parameter, from its value at the beginning over `scale` [1]; states at the beginnings of the sections [1],
      !> (state, section).
      real(dp) :: frequency_ratio = 0, parameter = 0
      real(dp), allocatable :: states(:, :)
      !> Unit tangent of the curve in the metric.
      real(dp) :: tangent_frequency = 0, tangent_parameter = 0
      real(dp), allocatable :: tangent(:, :)
      !> Terms of second and of third order of the curve over the way along the tangent, (state, section, term) and (term); not
      !> allocated: not known.
      real(dp) :: bend_frequency(2) = 0, bend_parameter(2) = 0
      real(dp), allocatable :: bend(:, :, :)
      !> Multipliers, largest magnitude first, (state).
      complex(dp), allocatable :: multipliers(:)
      !> Of a Neimark-Sacker point the sum of its pair of multipliers, by which the pair is known; huge: not known.
      real(dp) :: pair_sum = huge(1.0_dp)
      !> Contact events in a period; smallest mesh speed at one of them [1].
      integer :: events = 0
      real(dp) :: slowest_event = 0
      !> Derivatives of h and g in the directions at the end of Newton's method.
      real(dp) :: h(4) = 0, g(4) = 0
      !> Product of the null vectors of M - I and of M + I, which is 0 where the eigenvalue 0 is double.
      real(dp) :: product_plus = 0, product_minus = 0
   end type augmented_point_type

   !> The trains of an augmented system, to which its flights point: of the latest value of the parameter, of a slightly larger
   !> value, of a displaced one.
   type :: trains_type
      type(system_type) :: here, above, beside
   end type trains_type

   type :: metric_type
      !> Units of Lambda and the states.
      type(units_type) :: units
      !> Of the states, (state, section).
      real(dp), allocatable, private :: weight(:, :)
   contains
      procedure :: setup
      procedure :: product_of
      procedure :: distance
      procedure :: find_bend
   end type metric_type

contains

   !> Multiplies the tangent by a factor; -1 turns it round.
   pure subroutine scale_tangent(point, factor)
      !> A point with a tangent.
      type(augmented_point_type), intent(inout) :: point
      !> 1 leaves it as it is.
      real(dp), intent(in) :: factor

      point%tangent = factor*point%tangent
      point%tangent_frequency = factor*point%tangent_frequency
      point%tangent_parameter = factor*point%tangent_parameter
   end subroutine scale_tangent

   !> Adds a multiple of the tangent of another point to the tangent.
   pure subroutine add_tangent(point, factor, other)
      !> A point with a tangent.
      type(augmented_point_type), intent(inout) :: point
      !> Of the other tangent.
      real(dp), intent(in) :: factor
      !> The other point.
      type(augmented_point_type), intent(in) :: other

      point%tangent = point%tangent + factor*other%tangent
      point%tangent_frequency = point%tangent_frequency + factor*other%tangent_frequency
      point%tangent_parameter = point%tangent_parameter + factor*other%tangent_parameter
   end subroutine add_tangent

   !> Prepares for orbits of a train.
   subroutine setup(self, system, sections)
      class(metric_type), intent(inout) :: self
      !> The train.
      type(system_type), intent(in) :: system
      !> Sections of the orbits.
      integer, intent(in) :: sections

      self%units = units_of(system)
      if (allocated(self%weight)) deallocate (self%weight)
      allocate (self%weight(system%states, sections))
      associate (n => system%displacements)
         self%weight(:n, :) = 1/(sections*self%units%length**2)
         self%weight(n + 1:, :) = 1/(sections*(self%units%length*self%units%frequency_ratio)**2)
      end associate
   end subroutine setup

   !> Product of two displacements in the metric.
   pure real(dp) function product_of(self, states, frequency_ratio, parameter, point)
      class(metric_type), intent(in) :: self
      !> Displacement: states, (state, section), Lambda, parameter.
      real(dp), intent(in) :: states(:, :), frequency_ratio, parameter
      !> Its tangent is the other one.
      type(augmented_point_type), intent(in) :: point

      product_of = sum(self%weight*states*point%tangent) + parameter*point%tangent_parameter &
                   + frequency_ratio*point%tangent_frequency/self%units%frequency_ratio**2
   end function product_of

   !> Distance of two points in the metric.
   pure real(dp) function distance(self, a, b)
      class(metric_type), intent(in) :: self
      !> The points.
      type(augmented_point_type), intent(in) :: a, b

      distance = sqrt(sum(self%weight*(a%states - b%states)**2) + (a%parameter - b%parameter)**2 &
                      + ((a%frequency_ratio - b%frequency_ratio)/self%units%frequency_ratio)**2)
   end function distance

   !> Finds the bend of the curve at a point: of the cubic through this point and the point before it with their tangents.
   pure subroutine find_bend(self, before, point)
      class(metric_type), intent(in) :: self
      !> The point before.
      type(augmented_point_type), intent(in) :: before
      !> The point, which gets its bend.
      type(augmented_point_type), intent(inout) :: point
      real(dp) :: way, cosine

      way = self%product_of(point%states - before%states, point%frequency_ratio - before%frequency_ratio, &
                            point%parameter - before%parameter, point)
      cosine = self%product_of(before%tangent, before%tangent_frequency, before%tangent_parameter, point)
      if (.not. allocated(point%bend)) allocate (point%bend(size(point%states, 1), size(point%states, 2), 2))
      call terms(point%states - before%states, point%tangent, before%tangent, point%bend(:, :, 1), point%bend(:, :, 2))
      call terms(point%frequency_ratio - before%frequency_ratio, point%tangent_frequency, before%tangent_frequency, &
                 point%bend_frequency(1), point%bend_frequency(2))
      call terms(point%parameter - before%parameter, point%tangent_parameter, before%tangent_parameter, &
                 point%bend_parameter(1), point%bend_parameter(2))

   contains

      elemental subroutine terms(chord, tangent, tangent_before, second, third)
         real(dp), intent(in) :: chord, tangent, tangent_before
         real(dp), intent(out) :: second, third
         real(dp) :: a, b

         a = (tangent - chord/way)/way
         b = (tangent - tangent_before/cosine)/way
         second = 3*a - b
         third = (2*a - b)/way
      end subroutine terms

   end subroutine find_bend

end module geartrain_exact_augmented_point
