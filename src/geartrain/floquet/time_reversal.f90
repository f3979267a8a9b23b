!> Monodromy matrix over an interval from the matrix over the second half of the interval.
!>
!> The matrices of the equations of motion M p'' + C p' + K(t) p = 0 are symmetric: M = D W^-1, C = D diag(gamma),
!> K = D diag(kappa), with the diagonal D that makes D W symmetric. Where kappa is even about an instant and x(t), z(t) are
!> solutions, z(-t)^T M x' + z'(-t)^T M x + z(-t)^T C x = (z, z')(-t)^T J (x, x')(t) is constant,
!> J = [C M; M 0]. With Phi from the middle to the end and Psi from the beginning to the middle therefore J Phi = Psi^T J, and
!> Phi Psi = Phi J^-1 Phi^T J.
module geartrain_floquet_time_reversal
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_elimination, only: factor_matrix, solve_factored
   use geartrain_linalg_lapack, only: dgemm
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: time_reversal_type

   !> How far from real a mirrored amplitude of kappa may be, relative, and J J^-1 from the identity.
   real(dp), parameter :: rounding = 1e-12_dp, regular = 1e-11_dp

   type :: time_reversal_type
      !> Phases Lambda t in [0, 2 pi) about which every kappa is even [rad].
      real(dp), allocatable :: centre(:)
      real(dp), allocatable, private :: j(:, :), inverse(:, :)
      !> Whether damping changes with the contacts, on which J then depends.
      logical, private :: jumps = .false.
      type(system_type), pointer, private :: system => null()
   contains
      procedure :: setup
      procedure, private :: damp
      procedure :: centre_near
      procedure :: complete
   end type time_reversal_type

contains

   !> Finds J and the centres of symmetry; no centre where J is singular.
   subroutine setup(self, system)
      class(time_reversal_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      real(dp), dimension(system%coordinates, system%coordinates) :: coupling, inertia, symmetric
      real(dp) :: scale(system%coordinates), product(2*system%coordinates, 2*system%coordinates)
      integer :: pivot(system%coordinates), i, info, m, n

      m = system%coordinates
      coupling = 0
      scale = system%stiffness(:m)/system%stiffness(1)
      inertia = 0
      do n = 1, m
         coupling(n, n) = system%own(n)
         do i = system%first(n), system%first(n + 1) - 1
            if (system%neighbour(i) <= m) coupling(n, system%neighbour(i)) = system%coupling(i)
         end do
         inertia(n, n) = 1
      end do
      ! W^-1, then D W^-1; the inverse of that is W D^-1.
      symmetric = coupling
      call factor_matrix(m, symmetric, pivot, info)
      if (info == 0) call solve_factored(m, m, symmetric, pivot, inertia)
      if (allocated(self%j)) deallocate (self%j, self%inverse)
      allocate (self%j(2*m, 2*m), self%inverse(2*m, 2*m), source=0.0_dp)
      self%system => system
      self%jumps = any(system%law%jumps)
      do n = 1, m
         self%j(n, m + 1:) = scale(n)*inertia(n, :)
         self%j(m + 1:, n) = self%j(n, m + 1:)
         self%inverse(:m, m + n) = coupling(:, n)/scale(n)
      end do
      self%inverse(m + 1:, :m) = transpose(self%inverse(:m, m + 1:))
      call self%damp(system%damping)
      product = matmul(self%j, self%inverse)
      do i = 1, 2*m
         product(i, i) = product(i, i) - 1
      end do
      if (info == 0 .and. maxval(abs(product)) < regular) then
         self%centre = centres(system)
      else
         self%centre = [real(dp) ::]
      end if
   end subroutine setup

   !> Puts the damping of all elements into J.
   pure subroutine damp(self, damping)
      class(time_reversal_type), intent(inout) :: self
      real(dp), intent(in) :: damping(:)
      integer :: i, m, n

      associate (stiffness => self%system%stiffness, loop => self%system%network%loop)
         m = self%system%coordinates
         self%j(:m, :m) = 0
         do n = 1, m
            self%j(n, n) = stiffness(n)/stiffness(1)*damping(n)
            do i = m + 1, size(damping)
               self%j(n, :m) = self%j(n, :m) + loop(i - m, n)*loop(i - m, :)*damping(i)*stiffness(i)/stiffness(1)
            end do
         end do
      end associate
      self%inverse(m + 1:, m + 1:) = -matmul(matmul(self%inverse(m + 1:, :m), self%j(:m, :m)), self%inverse(:m, m + 1:))
   end subroutine damp

   !> Where all amplitudes of kappa are real, counted from there; 0 where no kappa varies.
   pure function centres(system) result(centre)
      type(system_type), intent(in) :: system
      real(dp), allocatable :: centre(:)
      logical, allocatable :: even(:)
      complex(dp) :: amplitude
      integer :: h, i, k, n, s

      centre = [0.0_dp]
      even = [.true.]
      n = 0
      do k = 1, system%meshes
         associate (law => system%law(k))
            do s = law%highest, law%lowest, -1
               do h = 1, size(law%amplitude, 1)
                  amplitude = law%amplitude(h, s)
                  if (.not. abs(amplitude) > 0) cycle
                  if (n == 0) then
                     n = 2*law%harmonic(h)
                     centre = [(modulo(2*pi*i/n - atan2(amplitude%im, amplitude%re)*2/n, 2*pi), i=0, n - 1)]
                     even = [(.true., i=1, n)]
                  end if
                  do i = 1, n
                     amplitude = law%amplitude(h, s)*exp(cmplx(0, law%harmonic(h)*centre(i), dp))
                     even(i) = even(i) .and. abs(amplitude%im) <= rounding*law%harmonic(h)*abs(amplitude)
                  end do
               end do
            end do
         end associate
      end do
      centre = pack(centre, even)
   end function centres

   !> The instant nearest to `middle` about which every kappa is even; `middle` itself where none of a mesh in contact varies.
   !> Minus infinity, as good as: there is none.
   pure real(dp) function centre_near(self, contact, frequency_ratio, middle)
      class(time_reversal_type), intent(in) :: self
      !> Region of its law in which each mesh is, (mesh).
      integer, intent(in) :: contact(:)
      !> Lambda [1]; time [1].
      real(dp), intent(in) :: frequency_ratio, middle
      real(dp) :: offset, least
      integer :: i

      centre_near = -huge(1.0_dp)
      if (size(self%centre) == 0) return
      centre_near = middle
      do i = 1, size(contact)
         if (self%system%law(i)%varies(contact(i))) exit
      end do
      if (i > size(contact)) return
      least = huge(1.0_dp)
      do i = 1, size(self%centre)
         offset = middle*frequency_ratio - self%centre(i)
         offset = 2*pi*anint(offset/(2*pi)) - offset
         if (abs(offset) < abs(least)) least = offset
      end do
      centre_near = middle + least/frequency_ratio
   end function centre_near

   !> Transposed matrix of the whole interval from the transposed matrix of its second half: J Phi J^-1 Phi^T.
   subroutine complete(self, contact, half, whole, work)
      class(time_reversal_type), intent(inout) :: self
      !> Region of its law in which each mesh is throughout the interval, (mesh).
      integer, intent(in) :: contact(:)
      !> Matrix of the second half, transposed [1], (state, state).
      real(dp), intent(in) :: half(:, :)
      !> Matrix of the whole interval, transposed [1], (state, state); work space of this shape.
      real(dp), intent(inout) :: whole(:, :), work(:, :)
      real(dp) :: damping(merge(self%system%elements, 0, self%jumps))
      integer :: i, n

      if (self%jumps) then
         damping = self%system%damping
         do i = 1, size(contact)
            damping(self%system%mesh_element(i)) = self%system%law(i)%damping(contact(i))
         end do
         call self%damp(damping)
      end if
      n = size(half, 1)
      call dgemm('N', 'N', n, n, n, 1.0_dp, self%inverse, n, half, n, 0.0_dp, whole, n)
      call dgemm('T', 'N', n, n, n, 1.0_dp, half, n, whole, n, 0.0_dp, work, n)
      call dgemm('N', 'N', n, n, n, 1.0_dp, self%j, n, work, n, 0.0_dp, whole, n)
   end subroutine complete

end module geartrain_floquet_time_reversal
