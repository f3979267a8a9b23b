!> The force of a mesh, piecewise linear in its displacement p: a row of numbers for each region of p. In region s
!>    phi = kappa_s(theta) (p - origin_s) + offset_s(theta) + gamma_s p',
!>    kappa_s = stiffness_s + sum over h of Re(amplitude_hs exp(i harmonic_h theta)), offset_s likewise without a mean.
!> The elastic force is continuous at the walls between regions. The damping force may jump at a wall; it is the time derivative of
!> gamma_s p + impulse_s, which is continuous.
!>
!> Region 1 is the drive flank. A mesh with backlash has the region 0, the gap, and the region -1, the back flank. A law with more
!> regions has more rows: all computations go over regions and walls.
module geartrain_mesh_law_law
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type, wave_value
   implicit none (type, external)
   private
   public :: law_type, depth_below

   type :: law_type
      !> Frequency of the mesh over Lambda [1].
      real(dp) :: order = 1
      !> First and last region.
      integer :: lowest = 1, highest = 1
      !> Displacement over b_c between regions s and s + 1 [1], ascending, (lowest:highest - 1).
      real(dp), allocatable :: wall(:)
      !> Mean stiffness over the mean stiffness of the mesh [1], p at which the elastic force is 0 [1], damping gamma [1], and the
      !> impulse [1] that makes gamma p + impulse continuous, (lowest:highest).
      real(dp), allocatable :: stiffness(:), origin(:), damping(:), impulse(:)
      !> Harmonics of Lambda in kappa, ascending, (harmonic), and their complex amplitudes [1], (harmonic, lowest:highest).
      integer, allocatable :: harmonic(:)
      complex(dp), allocatable :: amplitude(:, :)
      !> Complex amplitudes of the offset [1], (harmonic, lowest:highest), of a law whose stages vary over the cycle; not allocated:
      !> none.
      complex(dp), allocatable :: offset(:, :)
      !> Whether kappa of the region changes with time; whether the region has a stiffness; whether it has a row in the spectra: it
      !> has a stiffness, or the force jumps, (lowest:highest).
      logical, allocatable :: varies(:), elastic(:), acts(:)
      !> The force jumps at a wall, because the damping differs between regions; it may be largest at a wall, as where it jumps or
      !> the law becomes softer.
      logical :: jumps = .false., peaks = .false.
   contains
      procedure :: begin
      procedure :: complete
      procedure :: join
      procedure :: region_at
      procedure :: bearing
      procedure :: rest
      procedure :: stiffest
      procedure :: variation
      procedure :: stiffness_at
      procedure :: offset_at
      procedure :: force
      procedure :: along
   end type law_type

contains

   !> Makes room for the regions, all without force.
   pure subroutine begin(self, lowest, walls, harmonic)
      class(law_type), intent(inout) :: self
      !> Number of the first region; harmonics of Lambda in kappa, ascending.
      integer, intent(in) :: lowest, harmonic(:)
      !> Displacements between the regions over b_c [1], ascending, further apart than rounding: contact events at one instant have
      !> no order.
      real(dp), intent(in) :: walls(:)

      self%lowest = lowest
      self%highest = lowest + size(walls)
      associate (first => self%lowest, last => self%highest)
         allocate (self%wall(first:last - 1), self%varies(first:last), self%elastic(first:last), &
                   self%acts(first:last))
         allocate (self%stiffness(first:last), self%origin(first:last), self%damping(first:last), self%impulse(first:last), &
                   source=0.0_dp)
         allocate (self%amplitude(size(harmonic), first:last), source=(0.0_dp, 0.0_dp))
      end associate
      self%wall(:) = walls
      self%harmonic = harmonic
   end subroutine begin

   !> Makes the damping of the rows, until now relative to the damping of the mesh, absolute, and derives impulse, varies, acts,
   !> jumps, peaks.
   pure subroutine complete(self, damping)
      class(law_type), intent(inout) :: self
      !> gamma of the mesh [1].
      real(dp), intent(in) :: damping
      integer :: s, middle

      self%damping = damping*self%damping
      middle = self%region_at(0.0_dp)
      self%impulse(middle) = 0
      do s = middle, self%highest - 1
         self%impulse(s + 1) = self%impulse(s) + (self%damping(s) - self%damping(s + 1))*self%wall(s)
      end do
      do s = middle - 1, self%lowest, -1
         self%impulse(s) = self%impulse(s + 1) + (self%damping(s + 1) - self%damping(s))*self%wall(s)
      end do
      self%varies(:) = [(any(abs(self%amplitude(:, s)) > 0), s=self%lowest, self%highest)]
      self%jumps = any(abs(self%damping - self%damping(1)) > 0)
      self%peaks = self%jumps .or. self%highest > 1 .or. self%lowest < -1
      self%elastic(:) = self%stiffness > 0
      self%acts(:) = self%elastic .or. self%jumps
   end subroutine complete

   !> Derives origins and offsets of the stages beyond regions 1 and -1, so that the elastic force is continuous at every instant.
   pure subroutine join(self)
      class(law_type), intent(inout) :: self
      integer :: s

      allocate (self%offset(size(self%harmonic), self%lowest:self%highest), source=(0.0_dp, 0.0_dp))
      do s = 1, self%highest - 1
         call continue_at(self, self%wall(s), s, s + 1)
      end do
      do s = -1, self%lowest + 1, -1
         call continue_at(self, self%wall(s - 1), s, s - 1)
      end do
   end subroutine join

   !> Gives region `to` the force of region `from` at their wall.
   pure subroutine continue_at(self, wall, from, to)
      class(law_type), intent(inout) :: self
      real(dp), intent(in) :: wall
      integer, intent(in) :: from, to

      self%origin(to) = wall - self%stiffness(from)/self%stiffness(to)*(wall - self%origin(from))
      self%offset(:, to) = self%offset(:, from) + self%amplitude(:, from)*(wall - self%origin(from)) &
                           - self%amplitude(:, to)*(wall - self%origin(to))
   end subroutine continue_at

   !> Region of a displacement. On a wall: the region into which the velocity points; without velocity the region nearer to 0.
   pure integer function region_at(self, p, velocity) result(region)
      class(law_type), intent(in) :: self
      !> Displacement over b_c [1].
      real(dp), intent(in) :: p
      !> Velocity of p [1].
      real(dp), intent(in), optional :: velocity
      integer :: s

      region = self%lowest
      do s = self%lowest, self%highest - 1
         if (p < self%wall(s)) return
         if (.not. p > self%wall(s)) then
            if (present(velocity)) then
               if (velocity > 0) region = s + 1
               if (abs(velocity) > 0) return
            end if
            if (self%wall(s) <= 0) region = s + 1
            return
         end if
         region = s + 1
      end do
   end function region_at

   !> Region in which a mean force is in equilibrium.
   pure integer function bearing(self, load)
      class(law_type), intent(in) :: self
      !> Mean force over k b_c [1].
      real(dp), intent(in) :: load

      bearing = 1
      if (load < 0 .and. self%lowest < 0) then
         do bearing = -1, self%lowest + 1, -1
            if (self%origin(bearing) + load/self%stiffness(bearing) >= self%wall(bearing - 1)) return
         end do
      else
         do bearing = 1, self%highest - 1
            if (self%origin(bearing) + load/self%stiffness(bearing) <= self%wall(bearing)) return
         end do
      end if
   end function bearing

   !> Displacement over b_c at rest under a mean force [1].
   pure real(dp) function rest(self, load)
      class(law_type), intent(in) :: self
      !> Mean force over k b_c [1].
      real(dp), intent(in) :: load
      integer :: s

      s = self%bearing(load)
      rest = self%origin(s) + load/self%stiffness(s)
   end function rest

   !> Upper bound of kappa in all regions [1].
   pure real(dp) function stiffest(self)
      class(law_type), intent(in) :: self
      integer :: s

      stiffest = maxval([(self%stiffness(s) + sum(abs(self%amplitude(:, s))), s=self%lowest, self%highest)])
   end function stiffest

   !> The harmonics of kappa, each with its largest amplitude in any region.
   pure function variation(self) result(series)
      class(law_type), intent(in) :: self
      type(series_type) :: series

      series%harmonic = self%harmonic
      series%amplitude = cmplx(maxval(abs(self%amplitude), 2), 0, dp)
   end function variation

   !> kappa of a region [1].
   pure real(dp) function stiffness_at(self, s, phase)
      class(law_type), intent(in) :: self
      !> Region.
      integer, intent(in) :: s
      !> Phase Lambda t [rad].
      real(dp), intent(in) :: phase

      stiffness_at = self%stiffness(s) + wave_value(self%harmonic, self%amplitude(:, s), phase)
   end function stiffness_at

   !> Offset of a region [1].
   pure real(dp) function offset_at(self, s, phase)
      class(law_type), intent(in) :: self
      !> Region.
      integer, intent(in) :: s
      !> Phase Lambda t [rad].
      real(dp), intent(in) :: phase

      offset_at = 0
      if (allocated(self%offset)) offset_at = wave_value(self%harmonic, self%offset(:, s), phase)
   end function offset_at

   !> Mesh force phi over k b_c [1].
   pure real(dp) function force(self, phase, p, velocity)
      class(law_type), intent(in) :: self
      !> Phase Lambda t [rad]; displacement over b_c [1]; derivative of the displacement with respect to time [1].
      real(dp), intent(in) :: phase, p, velocity
      integer :: s

      s = self%region_at(p)
      force = self%damping(s)*velocity
      if (self%stiffness(s) > 0) force = force + self%stiffness_at(s, phase)*(p - self%origin(s))
      if (allocated(self%offset)) force = force + self%offset_at(s, phase)
   end function force

   !> phi and its first two derivatives with respect to theta by the row of region s, wherever p is.
   pure subroutine along(self, s, eta, theta, frequency_ratio, p, phi)
      class(law_type), intent(in) :: self
      !> Region; sub-harmonic index.
      integer, intent(in) :: s, eta
      !> theta = Lambda t/eta [rad]; Lambda [1].
      real(dp), intent(in) :: theta, frequency_ratio
      !> Displacement over b_c and its first three derivatives with respect to theta [1].
      real(dp), intent(in) :: p(0:3)
      !> phi and its first two derivatives with respect to theta [1].
      real(dp), intent(out) :: phi(0:2)
      complex(dp) :: term
      real(dp) :: g, kappa(0:2)
      integer :: h, k

      kappa = [self%stiffness(s), 0.0_dp, 0.0_dp]
      do h = 1, size(self%amplitude, 1)
         k = self%harmonic(h)*eta
         term = self%amplitude(h, s)*exp(cmplx(0, k*theta, dp))
         kappa(0) = kappa(0) + term%re
         kappa(1) = kappa(1) - k*term%im
         kappa(2) = kappa(2) - real(k, dp)**2*term%re
      end do
      g = p(0) - self%origin(s)
      phi(0) = kappa(0)*g
      phi(1) = kappa(1)*g + kappa(0)*p(1)
      phi(2) = kappa(2)*g + 2*kappa(1)*p(1) + kappa(0)*p(2)
      phi = phi + self%damping(s)*frequency_ratio/eta*p(1:3)
      if (.not. allocated(self%offset)) return
      do h = 1, size(self%offset, 1)
         k = self%harmonic(h)*eta
         term = self%offset(h, s)*exp(cmplx(0, k*theta, dp))
         phi = phi + [term%re, -k*term%im, -real(k, dp)**2*term%re]
      end do
   end subroutine along

   !> Least distance of the displacement of a mesh from separation, or from a collision of the back flanks, over characteristic
   !> length [1]; negative where the mesh separates, or the back flanks collide.
   elemental real(dp) function depth_below(smallest, largest, half_backlash, back)
      !> Extremes of the displacement and half of the backlash, over characteristic length [1].
      real(dp), intent(in) :: smallest, largest, half_backlash
      !> Collision of the back flanks; else separation.
      logical, intent(in) :: back

      depth_below = max(smallest - half_backlash, -half_backlash - largest)
      if (back) depth_below = smallest + half_backlash
   end function depth_below

end module geartrain_mesh_law_law
