!> Speeds of the bodies of a train whose meshes all have teeth, as ratios of whole numbers, and the orders of the fundamental that
!> follow.
!>
!> The fundamental is the greatest common divisor of all mesh frequencies, of the speeds of bodies with a torque of their own
!> revolution and of those of gears with errors: the frequency at which all repeats.
module geartrain_train_kinematics
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   use geartrain_train_nearby_orders, only: find_nearby_orders
   use geartrain_train_bodies, only: body_count, find_carriers, find_ends
   use geartrain_train_body, only: has_table_of_torque, pulses
   use geartrain_train_gear_error, only: has_gear_error
   use geartrain_train_mesh, only: is_given, mesh_type
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: find_turning, turning_type
   implicit none (type, external)
   private
   public :: kinematics_type, all_toothed, find_kinematics, greatest_divisor

   !> Largest whole number of a ratio: the product of two such numbers and a number of teeth does not overflow.
   integer(int64), parameter :: most = 2_int64**22
   !> Cycles of the fastest mesh up to which speeds that are no such ratios are tried for a common period, and cycles of which
   !> frequencies without one are taken as multiples.
   integer, parameter :: fewest_cycles = 1000, fine_cycles = 10**9
   !> Relative difference of a frequency from a multiple of the fundamental that is rounding, and that a ratio has which is given
   !> with eight digits [1].
   real(dp), parameter :: rounding = 1e-11_dp, given_ratio = 1e-7_dp

   type :: kinematics_type
      !> Whether orders and speeds were found; .false. also where a number exceeds 2^22.
      logical :: known = .false.
      !> How the bodies turn.
      type(turning_type) :: turning
      !> Turns per turn of the body whose revolutions are the speed, as numerator >= 0 and denominator, (2, body); turns of this
      !> body per period of the fundamental are fundamental(2)/fundamental(1). They are 0 where speeds are no such ratios.
      integer(int64), allocatable :: rate(:, :)
      integer(int64) :: fundamental(2) = [1_int64, 1_int64]
      !> Mesh frequency and revolution of a body as multiples of the fundamental, (mesh) and (body); order is 0 of a mesh whose
      !> gears turn as one with their carrier; revolution_order is 0 where the body has no torque of its own revolution, and the
      !> order of two revolutions where its torque repeats itself so. A planet revolves against its carrier: so its teeth and its
      !> bearing pass.
      integer, allocatable :: order(:), revolution_order(:)
      !> The mesh frequencies are not quite those of the teeth, so that their period has fewer cycles: order of each mesh by
      !> the teeth, 0 where they have no common period, (mesh), and largest relative error of a frequency [1]; not allocated and
      !> 0 where they are exact.
      integer, allocatable :: exact_order(:)
      real(dp) :: order_error = 0
      !> Number of the body whose revolutions are the speed, 0: no body has the name; its turns per period of the fundamental [1].
      integer :: speed_body = 1
      real(dp) :: speed_ratio = 0
   end type kinematics_type

contains

   !> Whether every gear pair has the numbers of teeth of both gears; so it is where there are none.
   pure logical function all_toothed(train)
      !> The train; its meshes are allocated.
      type(train_type), intent(in) :: train
      integer :: i

      all_toothed = size(train%meshes) > 0
      do i = 1, size(train%meshes)
         if (.not. all_toothed) return
         if (.not. train%meshes(i)%is_pair()) cycle
         all_toothed = is_given(train%meshes(i)%teeth)
         if (all_toothed) all_toothed = size(train%meshes(i)%teeth) == 2
         if (all_toothed) all_toothed = all(train%meshes(i)%teeth >= 1 .and. train%meshes(i)%teeth <= 1e5_dp)
      end do
   end function all_toothed

   !> Finds speeds and orders; not `known` where a mesh has no teeth, a name is unknown, or speeds are not determined.
   pure subroutine find_kinematics(train, found)
      !> The train; its shafts and meshes are allocated, with M shafts and M - 1 meshes in a chain.
      type(train_type), intent(in) :: train
      !> Speeds and orders.
      type(kinematics_type), intent(out) :: found
      integer, allocatable :: shaft_ends(:, :), mesh_ends(:, :)
      integer :: carrier(size(train%meshes))

      allocate (found%rate(2, body_count(train)), source=0_int64)
      allocate (found%order(size(train%meshes)), found%revolution_order(body_count(train)), source=0)
      if (.not. all_toothed(train)) return
      call find_ends(train, shaft_ends, mesh_ends)
      call find_carriers(train, carrier)
      if (any(shaft_ends == 0) .or. any(mesh_ends == 0) .or. any(carrier < 0)) return
      call find_turning(train, found%turning)
      found%speed_body = found%turning%reference
      if (.not. found%turning%determined) return
      call find_exact_orders(train, mesh_ends, carrier, found)
      if (.not. found%known) call find_orders_of_speeds(train, found)
   end subroutine find_kinematics

   !> Finds the orders of speeds that are ratios of whole numbers up to 2^22; else not `known`.
   pure subroutine find_exact_orders(train, mesh_ends, carrier, found)
      type(train_type), intent(in) :: train
      !> Bodies of each mesh, (2, mesh), and its carrier, 0: none, (mesh).
      integer, intent(in) :: mesh_ends(:, :), carrier(:)
      type(kinematics_type), intent(inout) :: found
      integer :: i, j
      !> Mesh frequencies, and revolutions of bodies with a torque of their own, per turn of the speed, (2, mesh or body).
      integer(int64) :: engaging(2, size(train%meshes)), signed(2, body_count(train)), &
         revolving(2, body_count(train))
      type(planetary_set_type), allocatable :: sets(:)
      !> The fundamental.
      integer(int64) :: divisor, common

      do i = 1, size(signed, 2)
         signed(:, i) = ratio_of(found%turning%speed(i))
      end do
      if (any(signed(2, :) == 0)) return
      do i = 1, size(train%meshes)
         engaging(:, i) = [0, 1]
         if (.not. train%meshes(i)%is_pair()) cycle
         engaging(:, i) = engaged(i, 1)
         ! Both gears of a pair engage as often, an external pair in opposite senses.
         if (any(engaging(:, i) /= engaged(i, 2)*[merge(1_int64, -1_int64, train%meshes(i)%internal), 1_int64])) return
         engaging(1, i) = abs(engaging(1, i))
      end do
      revolving = abs(signed)
      call find_sets(train, sets)
      do j = 1, size(sets)
         do i = 1, size(sets(j)%planets)
            associate (planet => sets(j)%planets(i))
               revolving(:, planet) = abs(difference(signed(:, planet), signed(:, sets(j)%carrier)))
            end associate
         end do
      end do
      if (allocated(train%bodies)) then
         do i = 1, size(train%bodies)
            if (.not. has_table_of_torque(train%bodies(i))) cycle
            ! So often the table is gone through.
            revolving(2, i) = revolving(2, i)*train%bodies(i)%torque_revolutions
            revolving(:, i) = revolving(:, i)/greatest_divisor(revolving(1, i), revolving(2, i))
         end do
      end if
      if (any(engaging > most)) return
      divisor = 0
      common = 1
      do i = 1, size(engaging, 2)
         call include(engaging(:, i), divisor, common)
         do j = 1, 2
            if (has_gear_error(train%meshes(i)%gear_error(j))) call include(revolution(i, j), divisor, common)
         end do
      end do
      do i = 1, size(signed, 2)
         if (turns(train, i)) call include(revolving(:, i), divisor, common)
      end do
      if (common > most) return
      ! Without gears and torques of revolutions: a turn.
      if (divisor == 0) divisor = 1
      do i = 1, size(engaging, 2)
         if (multiple(engaging(:, i)) > most) return
         found%order(i) = int(multiple(engaging(:, i)))
      end do
      do i = 1, size(signed, 2)
         if (.not. turns(train, i)) cycle
         if (multiple(revolving(:, i)) > most) return
         found%revolution_order(i) = int(multiple(revolving(:, i)))
      end do
      found%rate = abs(signed)
      found%fundamental = [divisor, common]
      found%speed_ratio = real(common, dp)/real(divisor, dp)
      found%known = .true.
      call go_nearby(found, [(cycles_of_errors(train%meshes(i)), i=1, size(train%meshes))])

   contains

      !> Revolution of a gear of a mesh, on a carrier against it.
      pure function revolution(mesh, gear) result(frequency)
         integer, intent(in) :: mesh, gear
         integer(int64) :: frequency(2)

         frequency = [engaging(1, mesh), engaging(2, mesh)*nint(train%meshes(mesh)%teeth(gear), int64)]
         frequency = frequency/greatest_divisor(frequency(1), frequency(2))
      end function revolution

      pure integer(int64) function multiple(frequency)
         integer(int64), intent(in) :: frequency(2)

         multiple = (frequency(1)/divisor)*(common/frequency(2))
      end function multiple

      !> Teeth of a gear of a mesh that engage per turn of the speed: those of its speed against the carrier.
      pure function engaged(mesh, gear) result(frequency)
         integer, intent(in) :: mesh, gear
         integer(int64) :: frequency(2)

         frequency = signed(:, mesh_ends(gear, mesh))
         if (carrier(mesh) > 0) frequency = difference(frequency, signed(:, carrier(mesh)))
         frequency(1) = frequency(1)*int(train%meshes(mesh)%teeth(gear), int64)
         frequency = frequency/greatest_divisor(abs(frequency(1)), frequency(2))
      end function engaged

   end subroutine find_exact_orders

   !> Finds the orders of speeds that are no ratios of small whole numbers, as by a measured `speed_ratio`: those of the fewest
   !> cycles in which all repeats itself to the digits of such a ratio, else nearby ones.
   pure subroutine find_orders_of_speeds(train, found)
      type(train_type), intent(in) :: train
      type(kinematics_type), intent(inout) :: found
      real(dp) :: engaging(size(train%meshes)), revolving(body_count(train)), fastest
      type(planetary_set_type), allocatable :: sets(:)
      integer :: multiple(size(train%meshes)), i, j, cycles

      engaging = 0
      revolving = abs(found%turning%speed)
      call find_sets(train, sets)
      do j = 1, size(sets)
         revolving(sets(j)%planets) = abs(found%turning%speed(sets(j)%planets) - found%turning%speed(sets(j)%carrier))
      end do
      do i = 1, size(train%meshes)
         if (train%meshes(i)%is_pair()) engaging(i) = abs(found%turning%relative(i))*train%meshes(i)%teeth(1)
         multiple(i) = cycles_of_errors(train%meshes(i))
      end do
      do i = 1, size(revolving)
         if (.not. turns(train, i)) revolving(i) = 0
         if (.not. revolving(i) > 0) cycle
         if (has_table_of_torque(train%bodies(i))) revolving(i) = revolving(i)/train%bodies(i)%torque_revolutions
      end do
      fastest = maxval([engaging, revolving])
      found%known = .true.
      found%fundamental = 0
      found%speed_ratio = 1
      if (.not. fastest > 0) return
      do cycles = 1, fewest_cycles
         if (maxval(off_whole([engaging/multiple, revolving]*(cycles/fastest))) < given_ratio) exit
      end do
      if (cycles > fewest_cycles) cycles = fine_cycles
      found%order = nint(engaging*(cycles/fastest))
      found%revolution_order = nint(revolving*(cycles/fastest))
      found%speed_ratio = cycles/fastest
      if (cycles < fine_cycles) then
         found%order_error = maxval(off_whole([engaging, revolving]*(cycles/fastest)))
         if (found%order_error < rounding) found%order_error = 0
         if (found%order_error > 0) allocate (found%exact_order(size(found%order)))
      else
         call go_nearby(found, multiple)
         found%known = allocated(found%exact_order)
         ! That of the frequencies themselves, not of their fine multiples.
         found%order_error = max(maxval(off(found%order, engaging*found%speed_ratio)), &
                                 maxval(off(found%revolution_order, revolving*found%speed_ratio)))
      end if
      if (allocated(found%exact_order)) found%exact_order = 0
   end subroutine find_orders_of_speeds

   !> Relative difference of an order from what it stands for; 0 where that is 0.
   elemental real(dp) function off(order, frequency)
      integer, intent(in) :: order
      !> Multiple of the fundamental [1].
      real(dp), intent(in) :: frequency

      off = 0
      if (frequency > 0) off = abs(order/frequency - 1)
   end function off

   !> Relative difference of an order from a whole number above 0; 0 where it is 0 itself.
   elemental real(dp) function off_whole(order)
      real(dp), intent(in) :: order

      off_whole = 0
      if (order > 0) off_whole = abs(order - max(1, nint(order)))/order
   end function off_whole

   !> Mesh cycles in which the gears with errors make whole revolutions.
   pure integer function cycles_of_errors(mesh) result(cycles)
      type(mesh_type), intent(in) :: mesh
      integer :: gear

      cycles = 1
      do gear = 1, 2
         if (.not. has_gear_error(mesh%gear_error(gear))) cycle
         associate (teeth => nint(mesh%teeth(gear)))
            cycles = cycles*(teeth/int(greatest_divisor(int(cycles, int64), int(teeth, int64))))
         end associate
      end do
   end function cycles_of_errors

   !> Takes nearby orders where those of the teeth are too high.
   pure subroutine go_nearby(found, multiple)
      type(kinematics_type), intent(inout) :: found
      !> Of which number the order of each mesh must be a multiple, (mesh).
      integer, intent(in) :: multiple(:)
      integer, allocatable :: order(:), nearby(:)
      logical :: engages(size(found%order)), revolves(size(found%revolution_order))
      real(dp) :: scale
      integer :: i

      ! Couplings, and bodies without a torque of their revolution, have no order.
      engages = found%order > 0
      revolves = found%revolution_order > 0
      order = [pack(found%order, engages), pack(found%revolution_order, revolves)]
      allocate (nearby(size(order)))
      call find_nearby_orders(order, nearby, scale, found%order_error, [pack(multiple, engages), [(1, i=1, count(revolves))]])
      if (.not. found%order_error > 0) return
      found%exact_order = found%order
      found%order = unpack(nearby(:count(engages)), engages, 0)
      found%revolution_order = unpack(nearby(count(engages) + 1:), revolves, 0)
      found%speed_ratio = found%speed_ratio*scale
   end subroutine go_nearby

   !> Makes a frequency a multiple of divisor/common.
   pure subroutine include(frequency, divisor, common)
      !> Numerator and denominator.
      integer(int64), intent(in) :: frequency(2)
      integer(int64), intent(inout) :: divisor, common

      if (frequency(1) == 0 .or. common > most) return
      divisor = greatest_divisor(divisor, frequency(1))
      common = common*(frequency(2)/greatest_divisor(common, frequency(2)))
   end subroutine include

   !> Whether a body has a torque of its own revolution.
   pure logical function turns(train, body)
      type(train_type), intent(in) :: train
      !> Number of the body.
      integer, intent(in) :: body

      turns = .false.
      if (allocated(train%bodies)) turns = pulses(train%bodies(body))
   end function turns

   !> A number as a ratio of whole numbers of at most 2^22, by its continued fraction; 0/0 where it is none. Two such ratios are
   !> further apart than rounding.
   pure function ratio_of(number) result(ratio)
      real(dp), intent(in) :: number
      integer(int64) :: ratio(2), before(2), next(2)
      real(dp) :: rest
      integer :: i

      before = [0, 1]
      ratio = [1, 0]
      rest = abs(number)
      do i = 1, 64
         if (rest > most) exit
         next = int(rest, int64)*ratio + before
         if (any(next > most)) exit
         before = ratio
         ratio = next
         if (abs(real(ratio(1), dp) - abs(number)*real(ratio(2), dp)) <= 5e-14_dp*real(max(1_int64, ratio(1)), dp)) then
            if (number < 0) ratio(1) = -ratio(1)
            return
         end if
         rest = 1/(rest - int(rest, int64))
      end do
      ratio = 0
   end function ratio_of

   !> Difference of two ratios, in lowest terms.
   pure function difference(one, other) result(ratio)
      integer(int64), intent(in) :: one(2), other(2)
      integer(int64) :: ratio(2)

      ratio = [one(1)*other(2) - other(1)*one(2), one(2)*other(2)]
      ratio = ratio/greatest_divisor(abs(ratio(1)), ratio(2))
   end function difference

   !> Greatest common divisor of two numbers >= 0, of which one may be 0.
   elemental integer(int64) function greatest_divisor(a, b) result(divisor)
      !> The numbers.
      integer(int64), intent(in) :: a, b
      integer(int64) :: x, y, rest

      x = a
      y = b
      do while (y /= 0)
         rest = mod(x, y)
         x = y
         y = rest
      end do
      divisor = x
   end function greatest_divisor

end module geartrain_train_kinematics
