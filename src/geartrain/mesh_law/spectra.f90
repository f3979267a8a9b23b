!> Two-sided Fourier coefficients of the four functions of time in the force of a mesh along a given motion,
!>    phi = stiffness p - offset + d/dt (damping p + impulse).
!> Each function is the sum over regions s of chi_s, which is 1 where the motion is in region s and else 0, times kappa_s,
!> kappa_s origin_s - offset_s, gamma_s or impulse_s of the law. Between events these are trigonometric polynomials: closed form.
!>
!> damping p + impulse is continuous, so the derivative of phi with respect to the motion is stiffness + d/dt damping, without terms
!> for the instants of the events, although the damping force may jump at an event.
module geartrain_mesh_law_spectra
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use geartrain_base_kinds, only: dp, pi
   use geartrain_linalg_scattered, only: scattered_coefficients
   use geartrain_mesh_law_law, only: law_type
   implicit none (type, external)
   private
   public :: spectra_type, find_spectra

   !> Neighbouring coefficients that are found side by side.
   integer, parameter :: strands = 8
   !> Events above which the coefficients are found by FFT, for which events and coefficients are not multiplied: those of hunting
   !> teeth, ten thousand of a hundred thousand each.
   integer, parameter :: many_events = 400

   type :: spectra_type
      !> Fourier coefficients [1], (0:highest). Damping and impulse are allocated only where the force jumps: else all regions have
      !> equal damping.
      complex(dp), allocatable :: stiffness(:), offset(:), damping(:), impulse(:)
   contains
      procedure :: reserve
      procedure :: mean_damping
   end type spectra_type

   interface
      pure subroutine add_powers(size, factor, real, imaginary, chi) bind(c, name='geartrain_add_jump')
         import :: c_double, c_double_complex, c_int
         implicit none (type, external)
         integer(c_int), value :: size
         real(c_double), value :: real, imaginary
         complex(c_double_complex), intent(in) :: factor(*)
         complex(c_double_complex), intent(inout) :: chi(*)
      end subroutine add_powers
   end interface

contains

   !> Makes room.
   pure subroutine reserve(self, law, highest)
      class(spectra_type), intent(inout) :: self
      !> Force law of the mesh.
      type(law_type), intent(in) :: law
      !> Highest index of the coefficients.
      integer, intent(in) :: highest

      if (allocated(self%stiffness)) then
         if (ubound(self%stiffness, 1) == highest .and. (allocated(self%damping) .eqv. law%jumps)) return
         deallocate (self%stiffness, self%offset)
         if (allocated(self%damping)) deallocate (self%damping, self%impulse)
      end if
      allocate (self%stiffness(0:highest), self%offset(0:highest))
      if (law%jumps) allocate (self%damping(0:highest), self%impulse(0:highest))
   end subroutine reserve

   !> Mean of gamma over the period of the motion [1].
   pure real(dp) function mean_damping(self, law)
      class(spectra_type), intent(in) :: self
      !> Force law of the mesh.
      type(law_type), intent(in) :: law

      mean_damping = law%damping(1)
      if (law%jumps) mean_damping = real(self%damping(0), dp)
   end function mean_damping

   !> Computes the coefficients in closed form.
   subroutine find_spectra(law, eta, first, instant, region, spectra, highest)
      !> Force law of the mesh.
      type(law_type), intent(in) :: law
      !> Sub-harmonic index, theta = Lambda t/eta; region at theta = 0.
      integer, intent(in) :: eta, first
      !> theta of the events in [0, 2 pi) [rad], ascending.
      real(dp), intent(in) :: instant(:)
      !> Region after each event.
      integer, intent(in) :: region(:)
      !> Spectra with room from `reserve`.
      type(spectra_type), intent(inout) :: spectra
      !> Highest index to compute; as far as the room reaches unless it is given.
      integer, intent(in), optional :: highest
      integer :: h, n

      n = ubound(spectra%stiffness, 1)
      if (present(highest)) n = highest
      spectra%stiffness(:n) = 0
      spectra%offset(:n) = 0
      if (law%jumps) then
         spectra%damping(:n) = 0
         spectra%impulse(:n) = 0
      end if
      if (size(instant) > 0) then
         call add_pieces(law, eta*law%harmonic, first, instant, region, n, spectra)
         return
      end if
      if (law%jumps) then
         spectra%damping(0) = law%damping(first)
         spectra%impulse(0) = law%impulse(first)
      end if
      if (.not. law%elastic(first)) return
      spectra%stiffness(0) = law%stiffness(first)
      do h = 1, size(law%harmonic)
         if (eta*law%harmonic(h) <= n) spectra%stiffness(eta*law%harmonic(h)) = law%amplitude(h, first)/2
      end do
      if (abs(law%origin(first)) > 0) spectra%offset(:n) = law%origin(first)*spectra%stiffness(:n)
      if (.not. allocated(law%offset)) return
      do h = 1, size(law%harmonic)
         if (eta*law%harmonic(h) <= n) spectra%offset(eta*law%harmonic(h)) = spectra%offset(eta*law%harmonic(h)) &
                                                                            - law%offset(h, first)/2
      end do
   end subroutine find_spectra

   !> Adds all regions: a jump of size J at theta adds J exp(-i k theta)/(2 pi i k) to coefficient k of chi, then chi is multiplied
   !> with the row of its region.
   subroutine add_pieces(law, harmonic, first, instant, region, n, spectra)
      type(law_type), intent(in) :: law
      !> Indices of the harmonics of kappa; region at theta = 0; highest index.
      integer, intent(in) :: harmonic(:), first, n
      real(dp), intent(in) :: instant(:)
      integer, intent(in) :: region(:)
      type(spectra_type), intent(inout) :: spectra
      !> Coefficients of chi, (index, region).
      complex(dp) :: chi(0:strands*((n + maxval([0, harmonic]) + strands - 1)/strands), law%lowest:law%highest), &
                     factor, kappa
      real(dp) :: last
      integer :: h, i, k, now, s

      do s = law%lowest, law%highest
         if (law%acts(s)) chi(:, s) = 0
      end do
      last = 0
      now = first
      do i = 1, size(instant)
         if (law%acts(now)) then
            chi(0, now) = chi(0, now) + (instant(i) - last)/(2*pi)
            if (size(instant) <= many_events) call add_jump(-1, instant(i), chi(1:, now))
         end if
         last = instant(i)
         now = region(i)
         if (law%acts(now) .and. size(instant) <= many_events) call add_jump(1, instant(i), chi(1:, now))
      end do
      if (size(instant) > many_events) then
         do s = law%lowest, law%highest
            if (law%acts(s)) call add_jumps(s, first, instant, region, chi(:, s))
         end do
      end if
      if (law%acts(now)) chi(0, now) = chi(0, now) + (2*pi - last)/(2*pi)
      do s = law%lowest, law%highest
         if (.not. law%acts(s)) cycle
         ! The motion is never in this region.
         if (.not. real(chi(0, s), dp) > 0) cycle
         do k = 1, ubound(chi, 1)
            chi(k, s) = chi(k, s)/k
         end do
         if (law%jumps) then
            spectra%damping(:n) = spectra%damping(:n) + law%damping(s)*chi(:n, s)
            spectra%impulse(:n) = spectra%impulse(:n) + law%impulse(s)*chi(:n, s)
         end if
         if (.not. law%elastic(s)) cycle
         do k = 0, n
            kappa = law%stiffness(s)*chi(k, s)
            do i = 1, size(harmonic)
               factor = law%amplitude(i, s)/2
               h = harmonic(i)
               if (k >= h) then
                  kappa = kappa + factor*chi(k - h, s) + conjg(factor)*chi(k + h, s)
               else
                  kappa = kappa + factor*conjg(chi(h - k, s)) + conjg(factor)*chi(k + h, s)
               end if
            end do
            spectra%stiffness(k) = spectra%stiffness(k) + kappa
            spectra%offset(k) = spectra%offset(k) + law%origin(s)*kappa
         end do
         if (allocated(law%offset)) call take_offset(harmonic, law%offset(:, s), chi(:, s), spectra%offset(:n))
      end do
   end subroutine add_pieces

   !> Subtracts the offset of a region, where the motion is in it, from the coefficients of the function that is subtracted.
   pure subroutine take_offset(harmonic, amplitude, chi, coefficient)
      !> Indices of the harmonics of the offset.
      integer, intent(in) :: harmonic(:)
      !> Their complex amplitudes; coefficients of chi, (0:).
      complex(dp), intent(in) :: amplitude(:), chi(0:)
      complex(dp), intent(inout) :: coefficient(0:)
      integer :: h, i, k

      do k = 0, ubound(coefficient, 1)
         do i = 1, size(harmonic)
            h = harmonic(i)
            if (k >= h) then
               coefficient(k) = coefficient(k) - amplitude(i)/2*chi(k - h)
            else
               coefficient(k) = coefficient(k) - amplitude(i)/2*conjg(chi(h - k))
            end if
            coefficient(k) = coefficient(k) - conjg(amplitude(i))/2*chi(k + h)
         end do
      end do
   end subroutine take_offset

   !> Adds all jumps of chi of region s as `add_jump` does, to coefficients from index 1 on.
   subroutine add_jumps(s, first, instant, region, chi)
      !> The region, and the region at theta = 0.
      integer, intent(in) :: s, first
      real(dp), intent(in) :: instant(:)
      integer, intent(in) :: region(:)
      !> Coefficients, (0:).
      complex(dp), intent(inout) :: chi(0:)
      complex(dp), allocatable :: total(:)
      real(dp), allocatable :: jump(:)

      jump = real(merge(1, 0, region == s) - merge(1, 0, [first, region(:size(region) - 1)] == s), dp)
      if (.not. any(abs(jump) > 0)) return
      allocate (total(0:ubound(chi, 1)))
      call scattered_coefficients(instant, jump, total)
      chi(1:) = chi(1:) + total(1:)*cmplx(0, -1/(2*pi), dp)
   end subroutine add_jumps

   !> Adds a jump of chi at theta, without the division of each coefficient by its index. Products of `strands` neighbours do not
   !> wait for each other.
   pure subroutine add_jump(jump, theta, chi)
      integer, intent(in) :: jump
      real(dp), intent(in) :: theta
      !> Coefficients from index 1 on; their number is a multiple of `strands`.
      complex(dp), contiguous, intent(inout) :: chi(:)
      complex(dp) :: factor(strands), z
      integer :: k

      z = cmplx(cos(theta), -sin(theta), dp)
      factor(1) = cmplx(0, -jump/(2*pi), dp)*z
      do k = 2, strands
         factor(k) = factor(k - 1)*z
      end do
      z = z**strands
      call add_powers(size(chi), factor, z%re, z%im, chi)
   end subroutine add_jump

end module geartrain_mesh_law_spectra
