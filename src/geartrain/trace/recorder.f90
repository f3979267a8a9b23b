!> Appends points to a branch: enlarges its arrays, derives values from the coefficients, assesses stability where asked for.
module geartrain_trace_recorder
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_balanced_torque, only: find_shaft_torques, mean_forces
   use geartrain_balance_error_estimate, only: error_estimate_type
   use geartrain_balance_mesh_load, only: force_reader_type, load_resolution
   use geartrain_balance_torus_extremes, only: find_torus_extremes
   use geartrain_balance_coupling_loss, only: find_coupling_losses
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_motion_contacts, only: motion_contacts_type
   use geartrain_floquet_multipliers, only: are_numbers, is_stable, power
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_trigonometric, only: extremes, fine_samples, rms, sample
   use geartrain_network_parameter_path, only: parameter_path_type
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: arrange_points, branch_type, multipliers_at, widen
   use geartrain_trace_corrector, only: solution_point_type
   use geartrain_trace_stability_assessment, only: assess, assess_growth, assessment_type
   implicit none (type, external)
   private
   public :: begin_branch, follow_branch_points, recorder_type

   !> Most points between a branch point and where a multiplier passes +1.
   integer, parameter :: reach = 8
   !> Rounding of equal multipliers, relative [1].
   real(dp), parameter :: rounding = 1e-7_dp

   type :: recorder_type
      !> Stability is assessed; torques of shafts are computed.
      logical :: stability = .false., shaft_torque = .false.
      !> Multipliers of a train of many states are wanted to their digits, not for the verdict alone.
      logical :: to_their_digits = .false.
      !> Work space; the monodromy matrix of the latest point.
      type(monodromy_type) :: monodromy
      !> Multipliers of the latest point over one repetition of its waveform, (branch%states).
      complex(dp), allocatable :: multipliers(:)
      type(transform_type) :: transform
      type(force_reader_type), private :: reader
   contains
      procedure :: setup
      procedure :: add
      procedure :: finish
   end type recorder_type

contains

   !> Prepares for the points of a balance.
   subroutine setup(self, balance, stability, branch, shaft_torque, multipliers)
      class(recorder_type), intent(inout) :: self
      !> The balance; more harmonics may follow.
      type(balance_type), intent(in) :: balance
      !> Stability is to be assessed.
      logical, intent(in) :: stability
      !> A new branch; then a branch without points.
      type(branch_type), intent(inout), target :: branch
      !> Torques of shafts are wanted; absent: they are not.
      logical, intent(in), optional :: shaft_torque
      !> Multipliers are wanted however long the period is; absent: they are not.
      logical, intent(in), optional :: multipliers
      logical :: whole

      self%stability = stability
      self%shaft_torque = .false.
      if (present(shaft_torque)) self%shaft_torque = shaft_torque
      call begin_branch(balance%system, balance%eta, balance%highest, self%shaft_torque, branch, balance%path)
      if (balance%chosen) branch%orders = [integer ::]
      allocate (branch%arclength(0), branch%free_slope(0), branch%rms_slope(0, 0), branch%reading_error_estimate(0))
      if (stability) then
         self%to_their_digits = .false.
         if (present(multipliers)) self%to_their_digits = multipliers
         call self%monodromy%setup(balance%system)
         whole = self%to_their_digits .or. self%monodromy%is_partial() .or. .not. balance%has_long_period()
         if (whole) branch%states = self%monodromy%given
         allocate (self%multipliers(branch%states), branch%stable(0))
         if (whole .and. balance%repeats > 1) allocate (branch%repetition_multipliers(branch%states, 0))
      end if
      call arrange_points(branch, [integer ::], 16)
   end subroutine setup

   !> Sets what a branch has before its first point.
   subroutine begin_branch(system, subharmonic, harmonics, shaft_torque, branch, path)
      type(system_type), intent(in) :: system
      !> Period of the motions [periods of the fundamental]; harmonics of Lambda/subharmonic.
      integer, intent(in) :: subharmonic, harmonics
      !> Torques of shafts are wanted.
      logical, intent(in) :: shaft_torque
      !> A new branch; then one that `arrange_points` can give points to.
      type(branch_type), intent(inout) :: branch
      !> The train over a parameter; not allocated: the branch is over Lambda.
      type(parameter_path_type), allocatable, intent(in) :: path
      integer :: k

      branch%points = 0
      branch%meshes = system%meshes
      branch%held = system%torque_paths%held
      branch%shafts = system%torque_paths%shafts
      branch%couplings = system%torque_paths%couplings
      branch%half_backlash = system%half_backlash
      if (allocated(path)) then
         branch%parameter = path%name
         branch%parameter_unit = path%unit
         branch%constant_frequency = path%frequency_ratio
         allocate (branch%half_backlash_at(0, 0))
      end if
      branch%subharmonic = subharmonic
      branch%harmonics = harmonics
      branch%orders = [(k, k=1, harmonics)]
      allocate (branch%special_points(0))
      if (shaft_torque) allocate (branch%shaft_torque_mean(0, 0))
      if (shaft_torque) branch%bearing_force%bearings = system%torque_paths%bearings
      if (shaft_torque .and. branch%couplings > 0) allocate (branch%coupling_energy_loss(0, 0))
      branch%planets = size(system%sharing%mesh)
      if (branch%planets > 0) allocate (branch%load_share(0, 0))
   end subroutine begin_branch

   !> Appends a point.
   subroutine add(self, balance, motion, solution, estimate, segment, branch)
      class(recorder_type), intent(inout) :: self
      !> The balance, last evaluated at `solution`.
      type(balance_type), intent(in) :: balance
      !> Contacts of the point over its period: the balance, unless it has those of a winding.
      class(motion_contacts_type), intent(in) :: motion
      !> The point.
      type(solution_point_type), intent(in) :: solution
      !> Error estimate of the point.
      type(error_estimate_type), intent(in) :: estimate
      !> Number of its segment.
      integer, intent(in) :: segment
      type(branch_type), intent(inout), target :: branch
      !> Coefficients of the displacements [1]; smallest and largest force by the law over k b_c [1], (end, mesh).
      real(dp) :: coefficients(balance%block, balance%system%meshes), ends(2, balance%system%meshes)
      type(assessment_type) :: assessment
      type(force_reader_type) :: fresh
      integer(int64) :: began, now, rate
      integer :: i, j, k, n

      if (branch%points == size(branch%frequency_ratio)) &
         call arrange_points(branch, [(k, k=1, branch%points)], 2*branch%points)
      if (balance%chosen) then
         call widen(branch, balance%harmonic)
      else if (balance%highest > branch%harmonics) then
         call widen(branch, [(k, k=1, balance%highest)])
      end if
      call balance%full_coefficients(solution%u, coefficients)
      n = branch%points + 1
      if (balance%varies) self%reader = fresh
      branch%frequency_ratio(n) = solution%frequency_ratio
      if (allocated(branch%half_backlash_at)) branch%half_backlash_at(:, n) = balance%system%half_backlash
      branch%coefficients(:, :, n) = 0
      branch%coefficients(1, :, n) = coefficients(1, :)
      i = 0
      do k = 1, size(branch%orders)
         if (i == size(balance%harmonic)) exit
         if (branch%orders(k) /= balance%harmonic(i + 1)) cycle
         i = i + 1
         branch%coefficients(2*k:2*k + 1, :, n) = coefficients(2*i:2*i + 1, :)
      end do
      branch%error_estimate(n) = estimate%relative
      branch%mesh_error_estimate(:, n) = estimate%mesh
      branch%reading_error_estimate(n) = estimate%missing
      branch%estimate_doubtful(n) = estimate%doubtful
      branch%point_harmonics(n) = balance%highest
      branch%segment(n) = segment
      do j = 1, branch%meshes
         branch%rms(j, n) = rms(coefficients(:, j))
         branch%mean(j, n) = coefficients(1, j)
         if (balance%is_wound()) call find_torus_extremes(balance%winding, coefficients(:, j), balance%harmonic, self%transform, &
                                                          branch%minimum(j, n), branch%maximum(j, n))
         call self%transform%plan(fine_samples(balance%winding%shortened(resolution_of(balance, j, coefficients(:, j)))))
         call self%reader%setup(balance%system, j, balance%eta, balance%winding, self%transform)
         ! The reader of forces uses the samples of p in self%transform.
         if (balance%is_wound()) then
            call sample(coefficients(:, j), balance%place, self%transform)
         else
            call extremes(coefficients(:, j), balance%harmonic, self%transform, branch%minimum(j, n), branch%maximum(j, n))
         end if
         associate (law => balance%system%law(j), load => branch%mesh_load(j, n), place => findloc(balance%mesh, j, 1))
            if (law%highest > law%lowest .and. any(balance%system%torque_paths%alone == j)) then
               call self%reader%read(balance%system, j, balance%frequency_ratio, coefficients(:, j), balance%harmonic, &
                                     self%transform, load, motion%contact(place), ends(:, j))
            else if (law%peaks) then
               call self%reader%read(balance%system, j, balance%frequency_ratio, coefficients(:, j), balance%harmonic, &
                                     self%transform, load, motion%contact(place))
            else
               call self%reader%read(balance%system, j, balance%frequency_ratio, coefficients(:, j), balance%harmonic, &
                                     self%transform, load)
            end if
         end associate
         branch%mesh_load(j, n)%separation = 0
         branch%mesh_load(j, n)%back_contact = 0
      end do
      do j = 1, balance%unknowns
         associate (load => branch%mesh_load(balance%mesh(j), n))
            call motion%contact(j)%shares(load%separation, load%back_contact)
         end associate
      end do
      if (self%shaft_torque) call put_torques(self, balance, n, ends, branch)
      if (allocated(branch%coupling_energy_loss)) &
         call find_coupling_losses(balance, coefficients, branch%coupling_energy_loss(:, n))
      if (branch%planets > 0) call share_load(balance, n, branch)
      if (self%stability) then
         call system_clock(began, rate)
         if (branch%states == 0) then
            call assess_growth(self%monodromy, balance, motion, solution%u, balance%frequency_ratio, estimate, assessment)
         else
            call self%monodromy%integrate(motion, balance%frequency_ratio, verdict=.not. self%to_their_digits)
            call self%monodromy%multipliers(self%multipliers)
            branch%multipliers(:, n) = self%multipliers
            if (balance%repeats > 1) then
               branch%repetition_multipliers(:, n) = self%multipliers
               branch%multipliers(:, n) = power(self%multipliers, balance%repeats)
            end if
            call assess(self%monodromy, balance, motion, solution%u, balance%frequency_ratio, estimate, self%multipliers, &
                        .not. self%to_their_digits, assessment)
         end if
         branch%growth_rate(n) = assessment%growth_rate*balance%system%characteristic_frequency
         branch%stable(n) = assessment%stable
         branch%undecided(n) = assessment%undecided
         branch%second_estimate(n) = assessment%second
         branch%count_undecided(n) = assessment%count_undecided
         call system_clock(now)
         branch%verdict_seconds = branch%verdict_seconds + real(now - began, dp)/real(rate, dp)
      end if
      branch%points = n
   end subroutine add

   !> Sets the torques of shafts and the forces of bearings at point n.
   subroutine put_torques(self, balance, n, ends, branch)
      class(recorder_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: n
      !> Smallest and largest force by the law over k b_c of a mesh that is not linear and whose force alone is one of these torques
      !> and forces [1], (end, mesh).
      real(dp), intent(in) :: ends(:, :)
      type(branch_type), intent(inout) :: branch
      real(dp), dimension(balance%system%torque_paths%rows) :: mean, low, high, ac
      integer :: j, s

      call find_shaft_torques(balance, self%transform, mean, low, high, ac)
      ! The law has no ripples at the kinks of the force, which the harmonics that the balance carries have.
      associate (system => balance%system, paths => balance%system%torque_paths)
         do s = 1, paths%rows
            j = paths%alone(s)
            if (j == 0) cycle
            if (system%law(j)%highest == system%law(j)%lowest) cycle
            associate (unit => paths%gain(paths%first(s))*system%stiffness(system%mesh_element(j))*system%characteristic_length)
               low(s) = minval(unit*ends(:, j))
               high(s) = maxval(unit*ends(:, j))
            end associate
         end do
      end associate
      associate (torques => balance%system%torque_paths%torques, force => branch%bearing_force)
         branch%shaft_torque_mean(:, n) = mean(:torques)
         branch%shaft_torque_minimum(:, n) = low(:torques)
         branch%shaft_torque_maximum(:, n) = high(:torques)
         if (force%bearings == 0) return
         force%mean(:, :, n) = reshape(mean(torques + 1:), [2, force%bearings])
         force%rms(:, :, n) = reshape(ac(torques + 1:), [2, force%bearings])
         force%minimum(:, :, n) = reshape(low(torques + 1:), [2, force%bearings])
         force%maximum(:, :, n) = reshape(high(torques + 1:), [2, force%bearings])
      end associate
   end subroutine put_torques

   !> Sets the load shares of the planets at point n, whose mesh loads are set.
   subroutine share_load(balance, n, branch)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: n
      type(branch_type), intent(inout) :: branch
      real(dp) :: force(balance%system%elements)

      call mean_forces(balance, force)
      associate (system => balance%system, sharing => balance%system%sharing, element => balance%system%mesh_element)
         force = system%stiffness*system%characteristic_length*force
         call sharing%find_shares(force(element(sharing%mesh)), branch%mesh_load(sharing%mesh, n)%force_maximum, &
                                  branch%load_share(:, n), branch%load_share_maximum(:, n))
      end associate
   end subroutine share_load

   !> The harmonic whose `fine_samples` show the extremes of a mesh.
   pure integer function resolution_of(balance, mesh, u)
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: mesh
      real(dp), intent(in) :: u(:)
      real(dp) :: force
      integer :: i

      resolution_of = balance%highest
      if (.not. balance%chosen) return
      ! A linear mesh has the force of its displacement.
      force = norm2(u(2:))
      i = findloc(balance%mesh, mesh, 1)
      if (i > 0) force = norm2(balance%force(2:, i))
      resolution_of = load_resolution(balance%system%law(mesh), balance%eta, balance%frequency_ratio, u, balance%harmonic, force)
   end function resolution_of

   !> Shrinks the arrays to the number of points.
   subroutine finish(self, branch)
      class(recorder_type), intent(in) :: self
      !> The branch, which is complete.
      type(branch_type), intent(inout), target :: branch
      integer :: i

      if (size(branch%frequency_ratio) > branch%points) &
         call arrange_points(branch, [(i, i=1, branch%points)], branch%points)
      if (.not. allocated(branch%undecided)) return
      call doubt_steep_growth(branch)
      if (allocated(branch%multipliers)) call follow_branch_points(branch)
   end subroutine finish

   !> Where another branch crosses, a real multiplier passes +1, of N equal branches N - 1 at once. The balance finds the crossing
   !> by its own matrix, more exactly than the multipliers of its motion tell: by an error of 2e-4 they passed +1 three points
   !> before. The points between such a passage and the crossing are on the side that the matrix says, and undecided.
   subroutine follow_branch_points(branch)
      !> A branch with stability and multipliers, complete.
      type(branch_type), intent(inout) :: branch
      integer, parameter :: unknown = -1
      integer, allocatable :: above(:), crossings(:)
      integer :: i, k, s, first, last

      if (.not. allocated(branch%special_points)) return
      if (.not. any(branch%special_points%kind == 'branch point')) return
      allocate (crossings(branch%points), source=0)
      allocate (above(branch%points), source=unknown)
      do i = 1, branch%points
         if (are_numbers(multipliers_at(branch, i))) above(i) = count(is_above(multipliers_at(branch, i)))
      end do
      do s = 1, size(branch%special_points)
         associate (special => branch%special_points(s))
            if (special%point < 1 .or. special%point > branch%points) cycle
            crossings(special%point) = crossings(special%point) + 1
            ! A fold is a point itself: the multiplier passes beside it.
            if (special%kind == 'fold' .and. special%point > 1) crossings(special%point - 1) = crossings(special%point - 1) + 1
         end associate
      end do
      do s = 1, size(branch%special_points)
         associate (special => branch%special_points(s), p => branch%special_points(s)%point)
            if (special%kind /= 'branch point' .or. p < 1 .or. p >= branch%points) cycle
            if (passes(p, special%multiplicity)) cycle
            do k = 1, reach
               ! The passage that belongs to the crossing, before it or after it.
               do i = p - k, p + k, 2*k
                  first = min(i, p) + 1
                  last = max(i, p)
                  if (first < 2 .or. last >= branch%points) cycle
                  if (any(branch%segment(first - 1:last + 1) /= branch%segment(p))) cycle
                  if (any(above(first - 1:last + 1) == unknown)) cycle
                  if (.not. passes(i, special%multiplicity)) cycle
                  if (crossings(i) > 0 .or. any(crossings(first:last - 1) > 0)) cycle
                  call take_side(first, last, merge(above(i), above(i + 1), i < p))
                  exit
               end do
               if (passes(p, special%multiplicity)) exit
            end do
         end associate
      end do

   contains

      !> Whether so many multipliers pass +1 after a point. Complex pairs that become real leave an odd number odd.
      pure logical function passes(point, multiplicity)
         integer, intent(in) :: point, multiplicity

         associate (change => abs(above(point + 1) - above(point)))
            passes = merge(mod(change, 2) == 1, change == multiplicity, mod(multiplicity, 2) == 1)
         end associate
      end function passes

      !> Takes points as on the other side: as many real multipliers are above +1 as there.
      subroutine take_side(first, last, there)
         integer, intent(in) :: first, last, there
         complex(dp) :: multipliers(branch%states)
         integer :: i

         do i = first, last
            multipliers = multipliers_at(branch, i)
            branch%undecided(i) = .true.
            branch%count_undecided(i) = .true.
            branch%stable(i) = .false.
            ! Without those that are above +1 by the error, the nearest.
            do while (count(is_above(multipliers)) > there)
               multipliers(minloc(abs(multipliers - 1), 1, is_above(multipliers))) = 0
            end do
            if (above(i) > there) branch%stable(i) = is_stable(multipliers)
            above(i) = there
         end do
      end subroutine take_side

   end subroutine follow_branch_points

   !> Whether a multiplier is real and above +1; equal ones are a complex pair by their rounding.
   elemental logical function is_above(multiplier)
      complex(dp), intent(in) :: multiplier

      is_above = abs(multiplier%im) <= rounding*abs(multiplier) .and. multiplier%re > 1
   end function is_above

   !> Takes as undecided where the growth rate changes so much from point to point that it may have another sign within the error of
   !> the motion. Where a branch of doubled periods is about to end, 4e-6 of Lambda is from a multiplier of 0.988 to one of 1.004.
   subroutine doubt_steep_growth(branch)
      type(branch_type), intent(inout) :: branch
      real(dp) :: apart
      integer :: i, j

      do i = 1, branch%points
         do j = max(1, i - 1), min(i + 1, branch%points)
            if (j == i .or. branch%segment(j) /= branch%segment(i) .or. branch%undecided(i)) cycle
            associate (here => branch%coefficients(:, :, i), there => branch%coefficients(:, :, j), &
                       value => branch%frequency_ratio([i, j]), rate => branch%growth_rate)
               if (.not. all(ieee_is_finite([rate(i), rate(j), branch%error_estimate(i)]))) cycle
               apart = hypot(norm2(here - there)/max(norm2(here), tiny(apart)), &
                             (value(1) - value(2))/max(maxval(abs(value)), tiny(apart)))
               if (abs(rate(i)) < abs(rate(i) - rate(j))*min(1.0_dp, branch%error_estimate(i)/max(apart, tiny(apart)))) then
                  branch%undecided(i) = .true.
                  branch%count_undecided(i) = .true.
               end if
            end associate
         end do
      end do
   end subroutine doubt_steep_growth

end module geartrain_trace_recorder
