!> Carries tangents of the motion along given contacts, for monodromy matrices: many columns, one accuracy, no events to find.
!>
!> The derivatives of the solution at the beginning of a step, weighted as `step_rule.f90` says, give its end. kappa within a step
!> is a short polynomial, made likewise.
module geartrain_floquet_propagator
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_step_rule, only: most_terms, step_rule_type
   use geartrain_network_system, only: shear, system_type
   implicit none (type, external)
   private
   public :: propagator_type

   !> Most columns that are carried together, a multiple of four (step.c): their derivatives stay in a cache.
   integer, parameter :: widest = 12

   type, extends(step_rule_type) :: propagator_type
      integer :: states = 0
      !> Columns of displacements, of all coordinates, then velocities over `band`, (column, 2*coordinates, block of columns).
      real(dp), allocatable, private :: x(:, :, :)
      integer, private :: coordinates = 0, elements = 0, width = 0
      !> Weights of the derivatives at the beginning of a step; for Leibniz' rule, the binomials (term, derivative), -W_nn times the
      !> derivatives of kappa (term, element) and how many of them there are.
      real(dp), allocatable, private :: weight(:), binomial(:, :), kappa_terms(:, :)
      integer, allocatable, private :: terms(:)
      !> Further arguments of `take_step` (element), and its work space.
      real(dp), allocatable, private :: spring(:), damper(:), work(:)
      !> Neighbours of each element, counted from 0 as in C, and W_nm/W_mm of each, between two zeros; chain = 1: they are the
      !> elements before and after it.
      integer, private :: chain = 0
      integer, allocatable, private :: first(:), neighbour(:)
      real(dp), allocatable, private :: factor(:)
      !> Displacements of the elements that close loops per coordinate, (coordinate, loop).
      real(dp), allocatable, private :: loop(:, :)
   contains
      procedure :: setup
      procedure :: start
      procedure :: advance
      procedure :: restart
      procedure :: pass_wall
      procedure :: spared
      procedure :: get
      procedure, private :: step
      procedure, private :: expand_kappa
   end type propagator_type

   !> In step.c, where its arguments are described.
   interface
      pure subroutine take_step(width, chain, coordinates, elements, degree, most_terms, terms, spring, damper, first, &
                                neighbour, factor, loop, &
                                binomial, kappa, weight, work, x) bind(c, name='geartrain_step')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: width, chain, coordinates, elements, degree, most_terms
         integer(c_int), intent(in), dimension(*) :: terms, first, neighbour
         real(c_double), intent(in), dimension(*) :: spring, damper, factor, loop, binomial, kappa, weight
         real(c_double), intent(inout), dimension(*) :: work, x
      end subroutine take_step
   end interface

contains

   subroutine setup(self, system)
      class(propagator_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      integer :: blocks, i, k, most

      call self%put_system(system)
      self%elements = system%elements
      self%coordinates = system%coordinates
      self%states = 2*system%coordinates
      ! Blocks of equal width.
      blocks = (self%states + widest - 1)/widest
      self%width = 4*((self%states + 4*blocks - 1)/(4*blocks))
      most = maxval(self%motion%degree)
      if (allocated(self%x)) deallocate (self%x, self%binomial, self%kappa_terms, self%weight, self%spring, self%damper, &
                                         self%work, self%terms)
      associate (w => self%width, m => self%elements)
         allocate (self%x(w, self%states, blocks), self%weight(0:most), self%binomial(0:most_terms - 1, 0:most), &
                   self%kappa_terms(0:most_terms - 1, m), self%spring(m), self%damper(m), &
                   self%work(w*m*(most + 3) + most_terms + 4), self%terms(m))
      end associate
      self%x = 0
      self%first = system%first - 1
      self%neighbour = system%neighbour - 1
      self%factor = [0.0_dp, system%coupling/system%own(system%neighbour), 0.0_dp]
      self%loop = transpose(system%network%loop)
      self%chain = merge(1, 0, all([(all(abs(system%neighbour(system%first(i):system%first(i + 1) - 1) - i) == 1), &
                                     i=1, system%elements)]))
      self%binomial = 0
      do k = 0, most
         self%binomial(0, k) = 1
         do i = 1, min(k, most_terms - 1)
            self%binomial(i, k) = self%binomial(i - 1, k)*(k - i + 1)/i
         end do
      end do
   end subroutine setup

   !> Begins with the identity at `frequency_ratio`; steps are shortened by `refinement`.
   subroutine start(self, frequency_ratio, refinement)
      class(propagator_type), intent(inout) :: self
      !> Lambda [1]; steps are shorter by this factor [1].
      real(dp), intent(in) :: frequency_ratio, refinement
      integer :: n

      call self%put_frequency(frequency_ratio, refinement)
      do n = 1, self%elements
         self%damper(n) = -self%system%own(n)*self%system%damping(n)/self%band
      end do
      call self%restart()
   end subroutine start

   !> Puts the identity in place of the columns.
   subroutine restart(self)
      class(propagator_type), intent(inout) :: self
      integer :: i

      self%x = 0
      do i = 1, self%states
         self%x(mod(i - 1, self%width) + 1, i, (i - 1)/self%width + 1) = 1
      end do
   end subroutine restart

   !> The columns as the transpose of a matrix (state, state), velocities in plain units.
   subroutine get(self, transposed)
      class(propagator_type), intent(in) :: self
      !> Transpose of the matrix, (state, state).
      real(dp), intent(out) :: transposed(:, :)
      integer :: first, last, n

      associate (m => self%coordinates)
         do first = 1, self%states, self%width
            last = min(first + self%width - 1, self%states)
            do n = 1, self%states
               transposed(first:last, n) = self%x(:last - first + 1, n, first/self%width + 1)
            end do
         end do
         transposed(:m, m + 1:) = transposed(:m, m + 1:)*self%band
         transposed(m + 1:, :m) = transposed(m + 1:, :m)/self%band
      end associate
   end subroutine get

   !> From one time to another along constant contacts (mesh), 0 for separation; less far where it is interrupted.
   subroutine advance(self, from, to, contact)
      class(propagator_type), intent(inout) :: self
      !> Times [1].
      real(dp), intent(in) :: from, to
      !> Region of its law in which each mesh is, 0 for separation, (mesh).
      integer, intent(in) :: contact(:)
      real(dp) :: h
      integer :: i, j, n, steps

      if (.not. to > from) return
      do n = 1, self%elements
         self%spring(n) = -self%system%own(n)*self%system%spring(n)/self%band**2
      end do
      self%terms = 0
      do j = 1, self%system%meshes
         associate (law => self%system%law(j), s => contact(j))
            n = self%system%mesh_element(j)
            self%terms(n) = merge(1, 0, law%varies(s))
            self%spring(n) = merge(0.0_dp, law%stiffness(s), law%varies(s))*self%spring(n)
            if (law%jumps) self%damper(n) = -self%system%own(n)*law%damping(s)/self%band
         end associate
      end do
      steps = self%steps(to - from, any(self%terms > 0))
      h = (to - from)/steps
      do i = 1, steps
         if (self%system%interrupt%raised()) return
         call self%step(from + (i - 1)*h, h, contact)
      end do
   end subroutine advance

   !> Takes the columns past an event of a mesh that goes from one region of its law to another.
   subroutine pass_wall(self, mesh, from, to, sheared)
      class(propagator_type), intent(inout) :: self
      !> The mesh; regions of its law before and after the event.
      integer, intent(in) :: mesh, from, to
      !> Becomes true where that changes them.
      logical, intent(inout) :: sheared
      integer :: i

      associate (law => self%system%law(mesh), e => self%coordinates)
         if (.not. law%jumps) return
         do i = 1, size(self%x, 3)
            call shear(self%system, self%system%mesh_element(mesh), (law%damping(to) - law%damping(from))/self%band, &
                       self%x(:, :e, i), self%x(:, e + 1:, i))
         end do
      end associate
      sheared = .true.
   end subroutine pass_wall

   !> By how much less than on all drive flanks the determinant decays with the given contacts (mesh) [1].
   pure real(dp) function spared(self, contact)
      class(propagator_type), intent(in) :: self
      !> Region of its law in which each mesh is, 0 for separation, (mesh).
      integer, intent(in) :: contact(:)
      integer :: j

      spared = 0
      do j = 1, size(contact)
         associate (law => self%system%law(j))
            if (law%jumps) spared = spared + self%system%own(self%system%mesh_element(j))*(law%damping(1) - law%damping(contact(j)))
         end associate
      end do
   end function spared

   subroutine step(self, time, h, contact)
      class(propagator_type), intent(inout) :: self
      real(dp), intent(in) :: time, h
      integer, intent(in) :: contact(:)
      real(dp) :: power
      integer :: series, degree, i, j, k

      series = self%motion%index_of(h*self%band)
      degree = self%motion%degree(series)
      power = 1
      do k = 0, degree
         self%weight(k) = self%motion%coefficient(k, series)*power
         power = power*h*self%band
      end do
      do j = 1, self%system%meshes
         if (self%terms(self%system%mesh_element(j)) > 0) call self%expand_kappa(j, contact(j), time, h)
      end do
      do i = 1, size(self%x, 3)
         call take_step(self%width, self%chain, self%coordinates, self%elements, degree, most_terms, self%terms, self%spring, &
                        self%damper, self%first, self%neighbour, self%factor(2:), self%loop, self%binomial, &
                        self%kappa_terms, self%weight, self%work, &
                        self%x(:, :, i))
      end do
   end subroutine step

   !> -W_nn times the derivatives of kappa at the beginning of a step: kappa as a polynomial about the middle of the step, shifted
   !> to its beginning.
   subroutine expand_kappa(self, mesh, region, time, h)
      class(propagator_type), intent(inout) :: self
      integer, intent(in) :: mesh, region
      real(dp), intent(in) :: time, h
      real(dp) :: polynomial(0:most_terms - 1), rate, power, factor
      complex(dp) :: phase
      integer :: i, l, last, n, series

      polynomial = 0
      last = 0
      associate (law => self%system%law(mesh))
         polynomial(0) = law%stiffness(region)
         do i = 1, size(law%amplitude, 1)
            rate = law%harmonic(i)*self%frequency_ratio
            series = self%kappa%index_of(rate*h/2)
            phase = law%amplitude(i, region)*cmplx(cos(rate*(time + h/2)), sin(rate*(time + h/2)), dp)
            power = 1
            last = max(last, self%kappa%degree(series))
            do l = 0, self%kappa%degree(series)
               polynomial(l) = polynomial(l) + self%kappa%coefficient(l, series)*power*phase%re
               phase = cmplx(-phase%im, phase%re, dp)
               power = power*rate
            end do
         end do
      end associate
      do i = 0, last - 1
         do l = last - 1, i, -1
            polynomial(l) = polynomial(l) - h/2*polynomial(l + 1)
         end do
      end do
      n = self%system%mesh_element(mesh)
      factor = -self%system%own(n)/self%band**2
      do l = 0, last
         polynomial(l) = factor*polynomial(l)
         factor = factor*(l + 1)/self%band
      end do
      self%kappa_terms(:, n) = polynomial
      self%terms(n) = last + 1
   end subroutine expand_kappa

end module geartrain_floquet_propagator
