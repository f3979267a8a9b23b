!> Error estimate of a balance: the harmonics above its highest, the tail, and their effect on the carried harmonics.
module geartrain_balance_error_estimate
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_bordered_system, only: bordered_system_type
   use geartrain_balance_tail_equations, only: tail_equations_type
   use geartrain_balance_tail_harmonics, only: busiest, far, near, tail_harmonics
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_least_residual, only: least_residual_type
   use geartrain_linalg_trigonometric, only: evaluate, fine_samples, own_resolution, sample
   use geartrain_network_excitation, only: excited_harmonics
   use geartrain_network_receptance, only: linear_displacements
   implicit none (type, external)
   private
   public :: error_estimate_type, find_error_estimate, harmonics_for

   !> The estimate is doubtful beyond these values: 2 bend y/slope**2 (1: the fold lies at Lambda of the point); relative error;
   !> distance of an extreme from a wall below this share of the error [1].
   real(dp), parameter :: near_fold = 0.7_dp, large = 0.1_dp, grazing = 0.3_dp
   !> Least dLambda along the branch, over the unit of Lambda, for which a number of harmonics must hold a tolerance: at a fold the
   !> error at constant Lambda falls only with the root of the shift of the fold.
   real(dp), parameter :: steepest = 0.05_dp

   !> Share of the tail of a chosen set that is left out, by root sum squares [1]: where hunting teeth part, a tail of 600,000
   !> amplitudes keeps a thousand.
   real(dp), parameter :: negligible = 1e-3_dp
   !> The same of the forces of the tail, before the displacements are known, which a resonance may make a hundred times larger.
   real(dp), parameter :: negligible_force = 1e-5_dp
   !> Residual to which the harmonics of a tail are coupled, relative to the tail without [1]; highest number of vectors for it, and
   !> of the amplitudes of a vector.
   real(dp), parameter :: coupled = 0.3_dp
   integer, parameter :: most_vectors = 24, most_coupled = 20000

   !> Relative accuracy of iterative solutions for the estimate [1]; least amplitude of a mesh to which its error is relative, over
   !> that of all meshes [1].
   real(dp), parameter :: accuracy = 1e-3_dp, least_share = 1e-6_dp

   type :: error_estimate_type
      !> Ranges of natural frequencies of the train in contact over characteristic frequency [1], the lowest and the highest one of
      !> each, (2, range), neighbours in a range by at most `resonance_ratio` (geartrain_balance_tail_harmonics) apart; set by the
      !> caller before `find_error_estimate`; not allocated: no harmonics near natural frequencies are added to the tail.
      real(dp), allocatable :: resonance(:, :)
      !> Relative error of the waveform [1], to first order: difference from the exact motion at equal Lambda or, where the exact
      !> branch turns before this Lambda, from the motion at its fold.
      real(dp) :: relative = 0
      !> `relative` with dLambda along the branch not below `steepest` [1]: the number of harmonics is chosen by it.
      real(dp) :: limited = 0
      !> Error of the waveform of each mesh over the amplitude of this mesh [1], (mesh): above `relative` for a mesh of small
      !> amplitude. `relative` for a linear mesh.
      real(dp), allocatable :: mesh(:)
      !> The first order may not hold: a fold is nearer than its own error, a contact may begin or end within the error, the error
      !> is not small, or neglected harmonics excite each other more than is found.
      logical :: doubtful = .false.
      !> Root of the sum of squares of the amplitudes above harmonic r of all unknown meshes [1], (0:near*highest).
      real(dp), allocatable :: remainder(:)
      !> Number of harmonics in the tail.
      integer :: count = 0
      !> Harmonics of Lambda/eta in the tail; their amplitudes [1], (tail, unknown).
      integer, allocatable :: harmonic(:)
      complex(dp), allocatable :: tail(:, :)
      !> Forces of the unknown meshes at the tail [1], (tail, unknown).
      complex(dp), allocatable :: force(:, :)
      !> What the tail has in the reading of which it is the largest part, over that reading [1], see `weigh`.
      real(dp) :: missing = 0
      !> Amplitudes at the carried harmonics and at the tail as the readings feel them, see `weigh`; amplitude of the motion [1].
      real(dp), allocatable :: felt(:), felt_tail(:)
      real(dp), private :: scale = 0
      !> Error of the carried coefficients with the sign of a first-order correction [1], (block, unknown).
      real(dp), allocatable, private :: error(:, :)
      type(tail_equations_type), private :: equations
   contains
      procedure :: waveform_error
      procedure :: sample_error
      procedure :: felt_at
      procedure :: square_of
      procedure :: weigh
      procedure, private :: reserve
   end type error_estimate_type

contains

   !> Estimates the error of a solution. The tail follows from the force at its harmonics; its effect on the carried harmonics costs
   !> one solve with the bordered matrix. The border row of the matrix lets Lambda change by y; a move s along the branch takes
   !> Lambda back: with Lambda = slope s + bend s**2/2 along the branch, s is the nearer root of y + slope s + bend s**2/2 = 0, or
   !> the vertex.
   subroutine find_error_estimate(balance, u, frequency_ratio, tangent, slope, bend, unit, matrix, estimate, residual)
      !> The balance, evaluated at the solution.
      type(balance_type), intent(inout) :: balance
      !> Solution [1], (block, unknown); Lambda [1]; unit tangent [1], (block, unknown); Lambda part of the tangent and its
      !> derivative along the branch.
      real(dp), intent(in) :: u(:, :), frequency_ratio, tangent(:, :), slope, bend
      !> Unit of Lambda, for `steepest` [1].
      real(dp), intent(in) :: unit
      !> Matrix of the balance, factored at this solution with any border row.
      type(bordered_system_type), intent(inout) :: matrix
      !> The estimate.
      type(error_estimate_type), intent(inout) :: estimate
      !> What the solution leaves of the balance [1], (block, unknown), where it solves another one, of sampled coefficients, whose
      !> matrix `matrix` is.
      real(dp), intent(in), optional :: residual(:, :)
      real(dp) :: correction(balance%block, balance%unknowns), error(balance%block, balance%unknowns), y, way, scale, own
      integer :: i, m
      !> Few harmonics of the tail matter; they are coupled as far as they need.
      logical :: sparse, settled

      estimate%relative = 0
      estimate%limited = 0
      estimate%doubtful = .false.
      estimate%mesh = [(0.0_dp, i=1, balance%system%meshes)]
      estimate%missing = 0
      if (allocated(estimate%felt)) deallocate (estimate%felt, estimate%felt_tail)
      call estimate%reserve(balance)
      ! Handed on as it is, an array that is not allocated would be one of no size.
      if (allocated(estimate%resonance)) then
         call put(tail_harmonics(balance, frequency_ratio, estimate%resonance))
      else
         call put(tail_harmonics(balance, frequency_ratio))
      end if
      estimate%error = 0*u
      estimate%force = estimate%tail(:estimate%count, :)
      if (estimate%count == 0) call find_remainder(balance, u, estimate)
      if (estimate%count == 0) return
      if (balance%unknowns == 0) then
         call find_remainder(balance, u, estimate)
         estimate%relative = condensed_error(balance, u, frequency_ratio, estimate)
         estimate%limited = estimate%relative
         estimate%mesh = estimate%relative
         estimate%doubtful = estimate%relative > large
         return
      end if
      sparse = balance%chosen .and. balance%parts() .and. .not. matrix%solves_in_time()
      call estimate%equations%take(balance, frequency_ratio, estimate%harmonic(:estimate%count))
      call estimate%equations%driven_forces(balance, u, estimate%tail(:estimate%count, :))
      if (sparse) call keep(negligible_force, balance%eta*excited_harmonics(balance%system))
      call estimate%equations%prepare(balance, .not. matrix%solves_in_time())
      estimate%force = estimate%tail(:estimate%count, :)
      call estimate%equations%displacements(balance, .true., estimate%tail(:estimate%count, :))
      if (sparse) call keep(negligible, balance%left_out)
      associate (n => estimate%count, tail => estimate%tail(:estimate%count, :), harmonic => estimate%harmonic)
         settled = .true.
         if (matrix%solves_in_time()) then
            call matrix%solve_tail(balance, harmonic(:n), tail, correction, y)
         else
            call carry(tail, .true.)
            if (sparse) call couple(tail)
         end if
         do concurrent (i=1:balance%unknowns, m=1:n)
            estimate%force(m, i) = estimate%force(m, i) + balance%mean_stiffness(i, harmonic(m))*tail(m, i)
         end do
         call find_remainder(balance, u, estimate)
         scale = sqrt(max(sum(u(2:, :)**2), tiny(1.0_dp)))
         way = -y/sign(max(abs(slope), steepest*unit), slope)
         error = correction + way*tangent
         estimate%limited = sqrt(sum(tail%re**2 + tail%im**2) + 2*sum(error(1, :)**2) + sum(error(2:, :)**2))/scale
         error = correction + way_back(y, slope, bend)*tangent
         estimate%relative = sqrt(sum(tail%re**2 + tail%im**2) + 2*sum(error(1, :)**2) + sum(error(2:, :)**2))/scale
         estimate%error = error
         ! Harmonics left out may excite linear meshes.
         if (size(balance%left_out) > 0 .and. balance%unknowns < balance%system%meshes) then
            way = condensed_error(balance, u, frequency_ratio, estimate)
            estimate%relative = max(estimate%relative, way)
            estimate%limited = max(estimate%limited, way)
         end if
         estimate%doubtful = .not. settled .or. estimate%relative > large .or. abs(2*bend*y) > near_fold*slope**2
         estimate%mesh = estimate%relative
         do i = 1, balance%unknowns
            own = sqrt(sum(tail(:, i)%re**2 + tail(:, i)%im**2) + 2*error(1, i)**2 + sum(error(2:, i)**2))
            if (balance%contact(i)%clearance() < grazing*own) estimate%doubtful = .true.
            estimate%mesh(balance%mesh(i)) = own/max(sqrt(sum(u(2:, i)**2)), least_share*scale)
         end do
      end associate

   contains

      !> Leaves the many small amplitudes of a tail out.
      subroutine keep(share, excited)
         !> Share that is left out, by root sum squares [1].
         real(dp), intent(in) :: share
         !> Harmonics that stay because they are excited.
         integer, intent(in) :: excited(:)
         real(dp) :: square(estimate%count)
         logical :: kept(estimate%count)
         integer, allocatable :: rows(:)
         integer :: m, n

         n = estimate%count
         square = sum(estimate%tail(:n, :)%re**2 + estimate%tail(:n, :)%im**2, 2)
         kept = busiest(square, share**2*sum(square), n)
         kept = kept .or. [(any(excited == estimate%harmonic(m)), m=1, n)]
         rows = pack([(m, m=1, n)], kept)
         if (size(rows) == 0) return
         call estimate%equations%keep(balance, rows)
         estimate%tail(:size(rows), :) = estimate%tail(rows, :)
         estimate%force = estimate%force(rows, :)
         call put(estimate%harmonic(rows))
      end subroutine keep

      !> Correction of the carried harmonics by a tail.
      subroutine carry(tail, whole)
         complex(dp), intent(in) :: tail(:, :)
         !> Whether the residual counts too.
         logical, intent(in) :: whole

         call estimate%equations%shift(balance, tail, correction)
         if (whole .and. present(residual)) correction = correction - residual
         y = 0
         call matrix%solve(balance, correction, y, accuracy)
      end subroutine carry

      !> Lets the harmonics of the tail act on each other and the corrections of the carried ones on them, by GMRES: between chosen
      !> harmonics lie neglected ones near which one tooth frequency beats with another, and a shift of contact carries one to the
      !> other, with a gain that may be above 1.
      subroutine couple(tail)
         complex(dp), intent(inout) :: tail(:, :)
         type(least_residual_type) :: least
         complex(dp), allocatable :: v(:, :, :)
         real(dp) :: h(most_vectors), length, rest, residual
         integer :: j, k

         length = sqrt(sum(tail%re**2 + tail%im**2))
         if (.not. length > 0) return
         settled = size(tail) <= most_coupled
         if (.not. settled) return
         allocate (v(size(tail, 1), size(tail, 2), most_vectors + 1))
         v(:, :, 1) = tail/length
         call least%begin(most_vectors, length)
         do k = 1, most_vectors
            call image(v(:, :, k), v(:, :, k + 1))
            settled = .false.
            if (balance%system%interrupt%raised()) return
            do j = 1, k
               h(j) = sum(v(:, :, j)%re*v(:, :, k + 1)%re + v(:, :, j)%im*v(:, :, k + 1)%im)
               v(:, :, k + 1) = v(:, :, k + 1) - h(j)*v(:, :, j)
            end do
            rest = sqrt(sum(v(:, :, k + 1)%re**2 + v(:, :, k + 1)%im**2))
            if (rest > 0) v(:, :, k + 1) = v(:, :, k + 1)/rest
            call least%add(h(:k), rest, residual)
            settled = residual >= 0 .and. residual < coupled*length
            if (settled .or. residual < 0) exit
         end do
         h(:least%count) = least%weights()
         tail = 0
         do j = 1, least%count
            tail = tail + h(j)*v(:, :, j)
         end do
         call carry(tail, .true.)
      end subroutine couple

      !> The tail less the tail that it and its effect on the carried harmonics make.
      subroutine image(tail, left)
         complex(dp), intent(in) :: tail(:, :)
         complex(dp), intent(out) :: left(:, :)

         call carry(tail, .false.)
         error = correction - y/sign(max(abs(slope), steepest*unit), slope)*tangent
         call estimate%equations%own_forces(balance, error, tail, left)
         call estimate%equations%displacements(balance, .false., left)
         left = tail - left
      end subroutine image

      subroutine put(harmonic)
         integer, intent(in) :: harmonic(:)

         estimate%count = size(harmonic)
         estimate%harmonic(:size(harmonic)) = harmonic
      end subroutine put

   end subroutine find_error_estimate

   !> Makes room for the longest tail.
   pure subroutine reserve(self, balance)
      class(error_estimate_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      integer :: longest, last

      associate (winding => balance%winding, left_out => balance%left_out)
         longest = max(winding%last_place(far*balance%highest), far*maxval([1, balance%place]))
         last = max(longest, winding%last_place(maxval([1, left_out]))) + winding%last_place(balance%highest)
         longest = longest + count(left_out > far*balance%highest)
      end associate
      if (allocated(self%remainder)) then
         if (.not. (ubound(self%remainder, 1) == near*balance%highest .and. size(self%tail, 1) == longest .and. &
                    size(self%tail, 2) == balance%unknowns)) deallocate (self%remainder, self%harmonic, self%tail)
      end if
      if (.not. allocated(self%remainder)) &
         allocate (self%remainder(0:near*balance%highest), self%harmonic(longest), self%tail(longest, balance%unknowns))
      call self%equations%reserve(balance, last)
   end subroutine reserve

   !> Displacements of linear meshes at the excited harmonics that the balance leaves out, relative to their waveforms [1].
   real(dp) function condensed_error(balance, u, frequency_ratio, estimate)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> Has the tail and the forces there.
      type(error_estimate_type), intent(in) :: estimate
      complex(dp) :: p(balance%system%elements)
      real(dp) :: coefficients(balance%block, balance%system%meshes), missing
      logical :: is_linear(balance%system%meshes)
      integer :: i, m

      missing = 0
      is_linear = .true.
      is_linear(balance%mesh) = .false.
      do m = 1, estimate%count
         if (.not. any(balance%left_out == estimate%harmonic(m))) cycle
         call linear_displacements(balance%system, frequency_ratio, estimate%harmonic(m), balance%eta, estimate%force(m, :), p)
         missing = missing + sum(abs(p(pack(balance%system%mesh_element, is_linear)))**2)
      end do
      call balance%full_coefficients(u, coefficients)
      condensed_error = 0
      do i = 1, balance%system%meshes
         if (is_linear(i)) condensed_error = condensed_error + sum(coefficients(2:, i)**2)
      end do
      condensed_error = sqrt(missing/max(condensed_error, tiny(1.0_dp)))
   end function condensed_error

   !> Lets harmonics count as what is read off the motion feels them: a harmonic that hardly moves a mesh may be in resonance with a
   !> shaft. So the set of harmonics and its size are chosen by what the readings miss, too.
   subroutine weigh(self, balance, u, felt, felt_tail, missing)
      class(error_estimate_type), intent(inout) :: self
      !> The balance of the estimate.
      type(balance_type), intent(in) :: balance
      !> The motion [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Part that each carried harmonic, each of the tail, and all of the tail have in the reading where it is largest [1].
      real(dp), intent(in) :: felt(:), felt_tail(:), missing

      self%scale = norm2(u(2:, :))
      self%felt = self%scale*felt
      self%felt_tail = self%scale*felt_tail
      self%limited = max(self%limited, missing)
      call find_remainder(balance, u, self)
   end subroutine weigh

   !> Part that a harmonic of the tail has, as of `weigh` [1]; 1: not known.
   pure real(dp) function felt_at(self, harmonic)
      class(error_estimate_type), intent(in) :: self
      !> Number of the harmonic of Lambda/eta.
      integer, intent(in) :: harmonic
      integer :: m

      felt_at = 1
      if (.not. allocated(self%felt_tail)) return
      m = findloc(self%harmonic(:self%count), harmonic, 1)
      if (m > 0 .and. self%scale > 0) felt_at = self%felt_tail(m)/self%scale
   end function felt_at

   !> Estimated difference of the exact displacement over b_c from the displacement of the balance, at an instant [1].
   pure real(dp) function waveform_error(self, balance, i, theta)
      class(error_estimate_type), intent(in) :: self
      !> The balance of the estimate.
      type(balance_type), intent(in) :: balance
      !> Number of the unknown mesh.
      integer, intent(in) :: i
      !> theta = Lambda t/eta [rad].
      real(dp), intent(in) :: theta
      real(dp) :: tail(1 + 2*self%count), missing, slope, curvature

      tail(1) = 0
      tail(2::2) = self%tail(:self%count, i)%re
      tail(3::2) = -self%tail(:self%count, i)%im
      call evaluate(self%error(:, i), balance%harmonic, theta, waveform_error, slope, curvature)
      call evaluate(tail, self%harmonic(:self%count), theta, missing, slope, curvature)
      waveform_error = waveform_error + missing
   end function waveform_error

   !> `waveform_error` at equally spaced instants of the period, beginning at theta = 0, as many as its amplitudes need.
   subroutine sample_error(self, balance, i, transform)
      class(error_estimate_type), intent(in) :: self
      !> The balance of the estimate.
      type(balance_type), intent(in) :: balance
      !> Number of the unknown mesh.
      integer, intent(in) :: i
      !> Its samples get the errors [1].
      type(transform_type), intent(inout) :: transform
      real(dp) :: tail(2*self%count)
      integer, allocatable :: harmonic(:)

      tail(1::2) = self%tail(:self%count, i)%re
      tail(2::2) = -self%tail(:self%count, i)%im
      harmonic = [balance%harmonic, self%harmonic(:self%count)]
      call transform%plan(fine_samples(own_resolution([self%error(:, i), tail], harmonic)))
      call sample([self%error(:, i), tail], harmonic, transform)
   end subroutine sample_error

   !> The nearer root s of y + slope s + bend s**2/2 = 0; where there is no root, the vertex.
   pure real(dp) function way_back(y, slope, bend)
      real(dp), intent(in) :: y, slope, bend
      real(dp) :: inside

      inside = slope**2 - 2*bend*y
      if (inside < 0) then
         way_back = -slope/bend
      else
         way_back = -2*y/sign(max(abs(slope) + sqrt(inside), tiny(1.0_dp)), slope)
      end if
   end function way_back

   !> Least number of harmonics for which the error falls to `share` of the present error, by the decay of the harmonics; at most
   !> twice the present number, because not more of the tail is known.
   pure integer function harmonics_for(estimate, share) result(highest)
      !> The estimate for the present number of harmonics.
      type(error_estimate_type), intent(in) :: estimate
      !> Wanted error over present error [1].
      real(dp), intent(in) :: share
      integer :: now

      now = ubound(estimate%remainder, 1)/near
      do highest = 1, 2*now - 1
         if (estimate%remainder(highest) <= share*estimate%remainder(now)) return
      end do
   end function harmonics_for

   !> Sets `remainder`; harmonics beyond its last index count at all indices.
   pure subroutine find_remainder(balance, u, estimate)
      type(balance_type), intent(in) :: balance
      real(dp), intent(in) :: u(:, :)
      type(error_estimate_type), intent(inout) :: estimate
      integer :: k, m

      associate (remainder => estimate%remainder)
         remainder = 0
         do k = 1, size(balance%harmonic)
            associate (square => remainder(balance%harmonic(k) - 1))
               square = sum(u(2*k:2*k + 1, :)**2)
               if (allocated(estimate%felt)) square = max(square, estimate%felt(k)**2)
            end associate
         end do
         do m = 1, estimate%count
            k = min(estimate%harmonic(m) - 1, ubound(remainder, 1))
            remainder(k) = remainder(k) + estimate%square_of(m)
         end do
         do k = ubound(remainder, 1) - 1, 0, -1
            remainder(k) = remainder(k) + remainder(k + 1)
         end do
         remainder = sqrt(remainder)
      end associate
   end subroutine find_remainder

   !> Squared amplitude of a harmonic of the tail, as it counts [1].
   pure real(dp) function square_of(self, m)
      class(error_estimate_type), intent(in) :: self
      !> Its number.
      integer, intent(in) :: m

      square_of = sum(self%tail(m, :)%re**2 + self%tail(m, :)%im**2)
      if (allocated(self%felt_tail)) square_of = max(square_of, self%felt_tail(m)**2)
   end function square_of

end module geartrain_balance_error_estimate
