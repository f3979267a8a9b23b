!> Test functions along the curve of a special point: each changes sign where a second condition is met.
module geartrain_curves_locus_tests
   use geartrain_base_kinds, only: dp
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_exact_normal_form, only: degenerate, doubling_coefficient
   use geartrain_floquet_critical_pair, only: pair_of
   implicit none (type, external)
   private
   public :: find_tests, grazing_name, most_tests, name_of, tests_type

   integer, parameter :: most_tests = 6
   character(*), parameter :: of_fold(*) = [character(24) :: 'cusp', 'isola centre', '1:1 resonance', 'fold-flip']
   character(*), parameter :: of_doubling(*) = [character(24) :: 'generalized doubling', '1:2 resonance', 'fold-flip']
   character(*), parameter :: of_torus(*) = [character(24) :: '1:1 resonance', '1:2 resonance', '1:3 resonance', '1:4 resonance', &
                                             'fold-neimark-sacker', 'flip-neimark-sacker']
   character(*), parameter :: of_onset(*) = [character(24) :: 'grazing on a fold', 'grazing on a doubling']

   type :: tests_type
      !> Values, (test); number of contact events in a period.
      real(dp) :: value(most_tests) = 0
      integer :: events = 0
   end type tests_type

contains

   !> Name of the point at which a test function changes sign; blank: there is none of this number.
   pure character(24) function name_of(kind, number)
      !> Kind of the special point whose curve it is.
      character(*), intent(in) :: kind
      !> Number of the test function.
      integer, intent(in) :: number

      name_of = ''
      select case (kind)
      case ('fold')
         if (number <= size(of_fold)) name_of = of_fold(number)
      case ('period doubling')
         if (number <= size(of_doubling)) name_of = of_doubling(number)
      case ('neimark-sacker')
         if (number <= size(of_torus)) name_of = of_torus(number)
      case ('branch point')
      case default
         if (number <= size(of_onset)) name_of = of_onset(number)
      end select
   end function name_of

   !> Name of the point at which the number of contact events changes.
   pure character(24) function grazing_name(kind)
      !> Kind of the special point whose curve it is.
      character(*), intent(in) :: kind

      grazing_name = 'grazing'
      if (kind == 'fold') grazing_name = of_onset(1)
      if (kind == 'period doubling') grazing_name = of_onset(2)
   end function grazing_name

   !> Evaluates the test functions.
   subroutine find_tests(augmented, point, tests)
      !> The system, with the flight of the latest solution.
      type(augmented_system_type), intent(inout) :: augmented
      !> That solution.
      type(augmented_point_type), intent(in) :: point
      !> The values.
      type(tests_type), intent(out) :: tests
      complex(dp) :: pair(2), others(size(point%multipliers) - 2)
      real(dp) :: total

      tests%events = point%events
      select case (augmented%kind)
      case ('fold')
         tests%value(:4) = [point%g(4), point%h(2), point%product_plus, beside(point, -1)]
      case ('period doubling')
         tests%value(:3) = [doubling_coefficient(augmented, point), point%product_minus, beside(point, 1)]
         if (abs(tests%value(1)) < degenerate) tests%value(1) = 0
      case ('neimark-sacker')
         pair = pair_of(point%multipliers, point%pair_sum)
         total = real(sum(pair), dp)
         ! The pair itself passes 1 and -1 at the first two resonances.
         others = without(point%multipliers, pair)
         tests%value = [total - 2, total + 2, total + 1, total, real(product(others - 1), dp), real(product(others + 1), dp)]
      case ('branch point')
      case default
         tests%value(:2) = [beside(point, 1), beside(point, -1)]
      end select
   end subroutine find_tests

   !> The multipliers but for two of them.
   pure function without(multipliers, pair) result(others)
      !> The multipliers, (state); two of them.
      complex(dp), intent(in) :: multipliers(:), pair(2)
      complex(dp) :: others(size(multipliers) - 2)
      logical :: left(size(multipliers))

      left = .true.
      left(minloc(abs(multipliers - pair(1)), 1)) = .false.
      left(minloc(abs(multipliers - pair(2)), 1, left)) = .false.
      others = pack(multipliers, left)
   end function without

   !> Product of the differences of the multipliers from 1 or -1: it changes sign where a real one passes that value alone.
   pure real(dp) function beside(point, value)
      type(augmented_point_type), intent(in) :: point
      integer, intent(in) :: value

      beside = real(product(point%multipliers - value), dp)
   end function beside

end module geartrain_curves_locus_tests
