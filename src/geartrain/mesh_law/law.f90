!> The force of a mesh, piecewise linear in its displacement p: rows of numbers, one for each region of p. In region s
!>    phi = kappa_s(theta) (p - origin_s) + gamma_s p',
!>    kappa_s = stiffness_s + sum over h of Re(amplitude_hs exp(i h order theta)).
!> The elastic force is continuous at the walls between regions; the damping force need not be, but it is the derivative of
!> gamma_s p + impulse_s with respect to time, which is.
!>
!> Region 1 is the drive flank. A mesh with backlash has 0, the gap, and -1, the back flank, besides. A law with more regions has
!> more rows: all that computes goes over regions and walls.
module geartrain_mesh_law_law
   use geartrain_base_kinds, only: dp
   use geartrain_base_series, only: series_type, wave_value
   implicit none (type, external)
   private
   public :: law_type

   type :: law_type
      !> kappa has harmonics of this order of Lambda.
      integer :: order = 1
      integer :: lowest = 1, highest = 1
      !> Displacement over b_c between regions s and s + 1, ascending, (lowest:highest - 1).
      real(dp), allocatable :: wall(:)
      !> Mean stiffness over that of the mesh [1], p at which the elastic force is 0 [1], damping over the mesh's stiffness [1], and
      !> what makes its integral continuous, (lowest:highest).
      real(dp), allocatable :: stiffness(:), origin(:), damping(:), impulse(:)
      !> (harmonic, lowest:highest)
      complex(dp), allocatable :: amplitude(:, :)
      !> Whether kappa of a region changes with time, and whether there is a force in it that is not everywhere, (lowest:highest);
      !> whether the force jumps at a wall, since damping does.
      logical, allocatable :: varies(:), acts(:)
      logical :: jumps = .false.
   contains
      procedure :: begin
      procedure :: complete
      procedure :: region_at
      procedure :: bearing
      procedure :: rest
      procedure :: stiffest
      procedure :: variation
      procedure :: stiffness_at
      procedure :: force
      procedure :: along
   end type law_type

contains

   !> Makes room for the regions between `walls`, all of them without a force.
   pure subroutine begin(self, order, lowest, walls, harmonics)
      class(law_type), intent(inout) :: self
      integer, intent(in) :: order, lowest, harmonics
      real(dp), intent(in) :: walls(:)

      self%order = order
      self%lowest = lowest
      self%highest = lowest + size(walls)
      associate (first => self%lowest, last => self%highest)
         allocate (self%wall(first:last - 1), self%varies(first:last), self%acts(first:last))
         allocate (self%stiffness(first:last), self%origin(first:last), self%damping(first:last), self%impulse(first:last), &
                   source=0.0_dp)
         allocate (self%amplitude(harmonics, first:last), source=(0.0_dp, 0.0_dp))
      end associate
      self%wall(:) = walls
   end subroutine begin

   !> Derives what follows from the rows, in which damping is given over that of the mesh, whose own is gamma = `damping`.
   pure subroutine complete(self, damping)
      class(law_type), intent(inout) :: self
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
      self%acts(:) = self%stiffness > 0 .or. self%jumps
   end subroutine complete

   !> Region of the displacement p; on a wall itself the nearer to 0, unless a velocity says where p goes.
   pure integer function region_at(self, p, velocity) result(region)
      class(law_type), intent(in) :: self
      real(dp), intent(in) :: p
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
            if (self%wall(s) < 0) region = s + 1
            return
         end if
         region = s + 1
      end do
   end function region_at

   !> Region whose flank bears a mean force over k b_c.
   pure integer function bearing(self, load)
      class(law_type), intent(in) :: self
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

   !> Displacement at rest under a mean force over k b_c.
   pure real(dp) function rest(self, load)
      class(law_type), intent(in) :: self
      real(dp), intent(in) :: load
      integer :: s

      s = self%bearing(load)
      rest = self%origin(s) + load/self%stiffness(s)
   end function rest

   !> No kappa is larger.
   pure real(dp) function stiffest(self)
      class(law_type), intent(in) :: self
      integer :: s

      stiffest = maxval([(self%stiffness(s) + sum(abs(self%amplitude(:, s))), s=self%lowest, self%highest)])
   end function stiffest

   !> The harmonics by which any kappa varies: their largest amplitudes.
   pure function variation(self) result(series)
      class(law_type), intent(in) :: self
      type(series_type) :: series

      series%order = self%order
      series%amplitude = cmplx(maxval(abs(self%amplitude), 2), 0, dp)
   end function variation

   !> kappa of region s at the phase `phase` = Lambda t [rad].
   pure real(dp) function stiffness_at(self, s, phase)
      class(law_type), intent(in) :: self
      integer, intent(in) :: s
      real(dp), intent(in) :: phase

      stiffness_at = self%stiffness(s) + wave_value(self%amplitude(:, s), self%order*phase)
   end function stiffness_at

   !> phi at the phase Lambda t [rad] of the displacement p and its derivative with respect to time.
   pure real(dp) function force(self, phase, p, velocity)
      class(law_type), intent(in) :: self
      real(dp), intent(in) :: phase, p, velocity
      integer :: s

      s = self%region_at(p)
      force = self%damping(s)*velocity
      if (self%stiffness(s) > 0) force = force + self%stiffness_at(s, phase)*(p - self%origin(s))
   end function force

   !> phi and its first two derivatives with respect to theta as it is in region s, be p there or not.
   pure subroutine along(self, s, eta, theta, frequency_ratio, p, phi)
      class(law_type), intent(in) :: self
      integer, intent(in) :: s, eta
      !> theta = Lambda t/eta, and Lambda.
      real(dp), intent(in) :: theta, frequency_ratio
      !> Displacement and its first three derivatives with respect to theta.
      real(dp), intent(in) :: p(0:3)
      real(dp), intent(out) :: phi(0:2)
      complex(dp) :: term
      real(dp) :: g, kappa(0:2)
      integer :: h, k

      kappa = [self%stiffness(s), 0.0_dp, 0.0_dp]
      do h = 1, size(self%amplitude, 1)
         k = h*self%order*eta
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
   end subroutine along

end module geartrain_mesh_law_law
