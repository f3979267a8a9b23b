!> Forces and displacements at the harmonics of a tail, those that a balance neglects, to first order in them.
module geartrain_balance_tail_equations
   use geartrain_balance_balance, only: balance_type
   use geartrain_balance_products, only: driven, multiply, tail_force, transform_tail
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_fftw, only: transform_type
   use geartrain_linalg_graph, only: factor_scalars, solve_scalars
   use geartrain_linalg_trigonometric, only: sample, transform_length
   use geartrain_mesh_law_spectra, only: spectra_type
   use geartrain_network_receptance, only: find_receptance, receptance_type
   implicit none (type, external)
   private
   public :: tail_equations_type

   !> Terms of a sum for each sample of an FFT up to which a product of spectra is found by sums [1].
   real(dp), parameter :: sums_for_sample = 60

   type :: tail_equations_type
      private
      integer :: longest = -1, reach = 0
      !> Products are sums, not found by FFT; each mesh has its mean stiffness in contact at the tail; the equations of the
      !> displacements are there.
      logical :: direct = .true., stiff = .true., prepared = .false.
      real(dp) :: frequency_ratio = 0
      !> Harmonics of Lambda/eta in the tail, and their places in the winding of the balance.
      integer, allocatable :: harmonic(:), place(:)
      !> Spectra of contact, (unknown).
      type(spectra_type), allocatable :: spectra(:)
      !> Receptance and factors of the matrix of displacements with mean stiffness, (entry, tail); displacements by the excitation
      !> without the meshes, (unknown, tail).
      complex(dp), allocatable :: h(:, :), factors(:, :), excitation(:, :)
      !> Plan for products of the tail with the spectra, where the balance works by FFT.
      type(transform_type) :: wide
   contains
      procedure :: reserve
      procedure :: take
      procedure :: prepare
      procedure :: keep
      procedure :: driven_forces
      procedure :: own_forces
      procedure :: displacements
      procedure :: shift
   end type tail_equations_type

contains

   !> Makes room for spectra up to a harmonic.
   pure subroutine reserve(self, balance, last)
      class(tail_equations_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Highest harmonic of a tail plus the highest carried one.
      integer, intent(in) :: last
      integer :: i

      if (allocated(self%spectra)) then
         if (self%longest /= last .or. size(self%spectra) /= balance%unknowns) deallocate (self%spectra)
      end if
      self%longest = last
      if (.not. allocated(self%spectra)) allocate (self%spectra(balance%unknowns))
      do i = 1, balance%unknowns
         call self%spectra(i)%reserve(balance%contact(i)%law, last)
      end do
   end subroutine reserve

   !> Takes a tail at a motion.
   subroutine take(self, balance, frequency_ratio, harmonic)
      class(tail_equations_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> Harmonics of Lambda/eta in the tail, at least one, ascending.
      integer, intent(in) :: harmonic(:)
      integer :: i

      self%frequency_ratio = frequency_ratio
      self%harmonic = harmonic
      self%place = balance%winding%place_of(harmonic)
      self%prepared = .false.
      self%reach = maxval(self%place) + maxval(balance%place)
      do i = 1, balance%unknowns
         call balance%contact(i)%extend(self%spectra(i), self%reach)
      end do
      self%direct = sums_are_less(self, balance, size(balance%harmonic))
      ! Room for the product of the spectra with the motion or the tail without aliases.
      if (.not. self%direct) call self%wide%plan(transform_length(2*self%reach + 1))
   end subroutine take

   !> Prepares the equations of the displacements at the tail.
   subroutine prepare(self, balance, stiff)
      class(tail_equations_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Each harmonic with the meshes coupled and with their mean stiffness, because a harmonic near a natural frequency resonates;
      !> or as if the meshes had no stiffness besides the forces.
      logical, intent(in) :: stiff
      type(receptance_type) :: local
      integer :: m, n

      n = size(self%harmonic)
      self%stiff = stiff
      self%prepared = .true.
      associate (graph => balance%system%cut%graph)
         if (allocated(self%h)) then
            if (size(self%h, 1) /= graph%entries .or. size(self%h, 2) < n) deallocate (self%h, self%factors, self%excitation)
         end if
         if (.not. allocated(self%h)) &
            allocate (self%h(graph%entries, n), self%factors(graph%entries, n), self%excitation(balance%unknowns, n))
         do m = 1, n
            call find_receptance(balance%system, self%frequency_ratio, self%harmonic(m), balance%eta, local, derivatives=.false.)
            self%h(:, m) = local%h
            self%excitation(:, m) = local%a
            if (.not. stiff) cycle
            ! The diagonal is near 1 except at a resonance.
            call balance%mean_matrix(self%harmonic(m), local, self%factors(:, m))
            call factor_scalars(graph, self%factors(:, m))
         end do
      end associate
   end subroutine prepare

   !> Leaves all but some harmonics of the tail out.
   pure subroutine keep(self, balance, rows)
      class(tail_equations_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      !> Numbers of the harmonics that stay, ascending, at least one.
      integer, intent(in) :: rows(:)
      integer :: m

      self%harmonic = self%harmonic(rows)
      self%place = self%place(rows)
      ! No row is overwritten before it has moved.
      do m = 1, merge(size(rows), 0, self%prepared)
         self%h(:, m) = self%h(:, rows(m))
         self%factors(:, m) = self%factors(:, rows(m))
         self%excitation(:, m) = self%excitation(:, rows(m))
      end do
      self%direct = sums_are_less(self, balance, size(balance%harmonic))
   end subroutine keep

   !> Whether products with functions of this many harmonics cost less as sums than by FFT.
   pure logical function sums_are_less(self, balance, harmonics)
      class(tail_equations_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      integer, intent(in) :: harmonics

      sums_are_less = balance%is_direct() .and. real(size(self%harmonic), dp)*harmonics < sums_for_sample*self%reach
   end function sums_are_less

   !> Forces at the tail by the carried harmonics [1], (tail, unknown).
   subroutine driven_forces(self, balance, u, force)
      class(tail_equations_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> The motion [1], (block, unknown).
      real(dp), intent(in) :: u(:, :)
      !> Complex amplitudes [1], (tail, unknown).
      complex(dp), intent(out) :: force(:, :)
      complex(dp) :: integral(size(self%harmonic))
      integer :: i

      do i = 1, balance%unknowns
         associate (spectra => self%spectra(i))
            call at_tail(spectra%stiffness(:self%reach), force(:, i))
            force(:, i) = force(:, i) - 2*spectra%offset(self%place)
            if (.not. balance%contact(i)%law%jumps) cycle
            call at_tail(spectra%damping(:self%reach), integral)
            force(:, i) = force(:, i) + cmplx(0, self%frequency_ratio/balance%eta, dp)*self%harmonic &
                          *(integral + 2*spectra%impulse(self%place))
         end associate
      end do

   contains

      !> Product of a function, given by its coefficients w, with the motion of unknown mesh i, at the tail.
      subroutine at_tail(w, product)
         complex(dp), intent(in) :: w(0:)
         complex(dp), intent(out) :: product(:)

         if (self%direct) then
            call driven(balance%place, self%place, w, u(:, i), product)
            product = product + 2*u(1, i)*w(self%place)
         else
            call sample(u(:, i), balance%place, self%wide)
            call multiply(self%wide, w)
            product = 2*self%wide%coefficient(self%place + 1)
         end if
      end subroutine at_tail

   end subroutine driven_forces

   !> Forces at the tail that follow from a change of the carried harmonics and from the displacements of the tail. The part by the
   !> mean stiffness is left out, because `displacements` has it in its matrix.
   subroutine own_forces(self, balance, change, tail, force)
      class(tail_equations_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Change of the carried coefficients [1], (block, unknown).
      real(dp), intent(in) :: change(:, :)
      !> Displacements at the tail [1], (tail, unknown).
      complex(dp), intent(in) :: tail(:, :)
      !> Complex amplitudes [1], (tail, unknown).
      complex(dp), intent(out) :: force(:, :)
      real(dp) :: coefficients(1 + 2*size(tail, 1))
      complex(dp) :: product(size(tail, 1))
      integer :: i

      coefficients(1) = 0
      do i = 1, balance%unknowns
         associate (spectra => self%spectra(i), harmonic => self%harmonic)
            coefficients(2::2) = tail(:, i)%re
            coefficients(3::2) = -tail(:, i)%im
            call at_tail(spectra%stiffness(:self%reach), force(:, i))
            force(:, i) = force(:, i) - real(spectra%stiffness(0), dp)*tail(:, i)
            if (.not. balance%contact(i)%law%jumps) cycle
            call at_tail(spectra%damping(:self%reach), product)
            force(:, i) = force(:, i) + cmplx(0, self%frequency_ratio/balance%eta, dp)*harmonic &
                          *(product - real(spectra%damping(0), dp)*tail(:, i))
         end associate
      end do

   contains

      !> Product of a function, given by its coefficients w, with the change and the tail of unknown mesh i, at the tail.
      subroutine at_tail(w, product)
         complex(dp), intent(in) :: w(0:)
         complex(dp), intent(out) :: product(:)
         complex(dp) :: by_change(size(product))
         real(dp), allocatable :: wave(:)

         associate (place => self%place)
            if (sums_are_less(self, balance, size(place) + size(balance%harmonic))) then
               call driven(place, place, w, coefficients, product)
               call driven(balance%place, place, w, change(:, i), by_change)
               product = product + by_change + 2*change(1, i)*w(place)
            else
               call self%wide%plan(transform_length(2*self%reach + 1))
               call sample(change(:, i), balance%place, self%wide)
               wave = self%wide%sample
               call sample(coefficients, place, self%wide)
               self%wide%sample = self%wide%sample + wave
               call multiply(self%wide, w)
               product = 2*self%wide%coefficient(place + 1)
            end if
         end associate
      end subroutine at_tail

   end subroutine own_forces

   !> Replaces forces at the tail by the displacements of the tail, (tail, unknown).
   pure subroutine displacements(self, balance, excited, tail)
      class(tail_equations_type), intent(in) :: self
      type(balance_type), intent(in) :: balance
      !> Whether the excitation of the train moves it too.
      logical, intent(in) :: excited
      !> Complex amplitudes [1], (tail, unknown).
      complex(dp), intent(inout) :: tail(:, :)
      complex(dp) :: force(balance%unknowns), p(balance%unknowns)
      integer :: i, m, n

      associate (graph => balance%system%cut%graph)
         do m = 1, size(self%harmonic)
            force = tail(m, :)
            p = 0
            if (excited) p = self%excitation(:, m)
            do i = 1, balance%unknowns
               do n = graph%row(i), graph%row(i + 1) - 1
                  p(i) = p(i) - self%h(graph%entry(n), m)*force(graph%column(n))
               end do
            end do
            if (self%stiff) call solve_scalars(graph, self%factors(:, m), p)
            tail(m, :) = p
         end do
      end associate
   end subroutine displacements

   !> Change of the residual at the carried harmonics by the forces of the tail, with opposite sign [1], (block, unknown).
   subroutine shift(self, balance, tail, correction)
      class(tail_equations_type), intent(inout) :: self
      !> The balance, evaluated at the motion.
      type(balance_type), intent(in) :: balance
      !> Displacements at the tail [1], (tail, unknown).
      complex(dp), intent(in) :: tail(:, :)
      !> The change.
      real(dp), intent(out) :: correction(:, :)
      real(dp) :: d_phi(balance%block, balance%unknowns), integral(balance%block)
      integer :: i, k

      do i = 1, balance%unknowns
         call at_kept(self%spectra(i)%stiffness(:self%reach), d_phi(:, i))
         if (.not. balance%contact(i)%law%jumps) cycle
         call at_kept(self%spectra(i)%damping(:self%reach), integral)
         do k = 1, size(balance%harmonic)
            associate (rate => self%frequency_ratio*balance%harmonic(k)/balance%eta)
               d_phi(2*k, i) = d_phi(2*k, i) + rate*integral(2*k + 1)
               d_phi(2*k + 1, i) = d_phi(2*k + 1, i) - rate*integral(2*k)
            end associate
         end do
      end do
      call balance%residual_change(0*d_phi, d_phi, correction)
      correction = -correction

   contains

      !> Product of a function, given by its coefficients w, with the tail of unknown mesh i, at the carried harmonics.
      subroutine at_kept(w, product)
         complex(dp), intent(in) :: w(0:)
         real(dp), intent(out) :: product(:)

         if (self%direct) then
            call tail_force(balance%place, self%place, w, tail(:, i), product)
         else
            call transform_tail(balance%place, self%place, w, tail(:, i), self%wide, product)
         end if
      end subroutine at_kept

   end subroutine shift

end module geartrain_balance_tail_equations
