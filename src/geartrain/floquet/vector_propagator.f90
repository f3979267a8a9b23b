!> Carries a few tangent vectors of a large train along given contacts, for products of its monodromy matrix with them.
!>
!> Steps and series are those of a whole matrix (`step_rule.f90`), in another order: elements lie together, those with a varying
!> kappa first, so that a pair of vectors fills the registers of a processor (step.c). Elements that close loops are carried as
!> the others are. Every step expands the harmonics of kappa once, not mesh by mesh.
module geartrain_floquet_vector_propagator
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_step_rule, only: most_terms, step_rule_type
   use geartrain_network_system, only: system_type
   implicit none (type, external)
   private
   public :: vector_propagator_type

   !> Vectors that are carried together, and elements of a pair that a register holds (step.c).
   integer, parameter :: pair = 2, lanes = 4
   !> A diagonal of a matrix is taken as a whole where so large a part of it is there.
   real(dp), parameter :: dense = 0.3_dp

   type, extends(step_rule_type) :: vector_propagator_type
      !> Row of each element, (element); rows, and those before all others that have a varying kappa, rounded up.
      integer, allocatable, private :: row(:)
      integer, private :: rows = 0, varying = 0
      !> Displacements, then velocities over `band`, (vector of a pair, row, 2, pair).
      real(dp), allocatable, private :: x(:, :, :, :)
      !> -W_nn kappa where it is constant, -W_nn gamma, over the powers of `band`, (row).
      real(dp), allocatable, private :: spring(:), damper(:)
      !> W_nm/W_mm for neighbours: diagonals, and the rest, as step.c describes them.
      integer, allocatable, private :: offset(:), low(:), high(:), to(:), number(:), from(:)
      real(dp), allocatable, private :: share(:, :), factor(:)
      !> Harmonics of Lambda in any kappa, and the number of each harmonic of a mesh among them, (harmonic, mesh).
      integer, allocatable, private :: harmonic(:), place(:, :)
      !> Taylor's terms of each harmonic at the beginning of a step, real and imaginary part, (term, part, harmonic), and of kappa,
      !> times -W_nn, (row, term).
      real(dp), allocatable, private :: wave(:, :, :), kappa_terms(:, :)
      real(dp), allocatable, private :: weight(:), work(:)
   contains
      procedure :: setup
      procedure :: start
      procedure :: put_vectors
      procedure :: get_vectors
      procedure :: advance
      procedure :: pass_wall
      procedure, private :: number_rows
      procedure, private :: list_neighbours
      procedure, private :: list_harmonics
      procedure, private :: step
      procedure, private :: expand_kappa
   end type vector_propagator_type

   !> In step.c, where its arguments are described.
   interface
      pure subroutine take_step(rows, varying, degree, terms, spring, damper, kappa, diagonals, offset, low, high, share, rest, &
                                to, number, from, factor, weight, work, x) bind(c, name='geartrain_step_pair')
         import :: c_double, c_int
         implicit none (type, external)
         integer(c_int), value :: rows, varying, degree, terms, diagonals, rest
         integer(c_int), intent(in), dimension(*) :: offset, low, high, to, number, from
         real(c_double), intent(in), dimension(*) :: spring, damper, kappa, share, factor, weight
         real(c_double), intent(inout), dimension(*) :: work, x
      end subroutine take_step
   end interface

contains

   subroutine setup(self, system)
      class(vector_propagator_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system

      call self%put_system(system)
      call self%number_rows()
      call self%list_neighbours()
      call self%list_harmonics()
      associate (most => maxval(self%motion%degree))
         allocate (self%weight(0:most), self%work(pair*self%rows*(most + 4) + 32))
      end associate
      allocate (self%spring(self%rows), self%damper(self%rows), source=0.0_dp)
      allocate (self%kappa_terms(self%varying, 0:most_terms), source=0.0_dp)
   end subroutine setup

   !> Numbers the elements, those of a varying kappa first.
   subroutine number_rows(self)
      class(vector_propagator_type), intent(inout) :: self
      logical :: varies(self%system%elements)
      integer :: i, j, n

      varies = .false.
      do j = 1, self%system%meshes
         varies(self%system%mesh_element(j)) = any(self%system%law(j)%varies)
      end do
      allocate (self%row(self%system%elements))
      i = 0
      j = count(varies)
      self%varying = lanes*((j + lanes - 1)/lanes)
      self%rows = lanes*((self%system%elements + lanes - 1)/lanes)
      self%varying = min(self%varying, self%rows)
      do n = 1, self%system%elements
         if (varies(n)) i = i + 1
         if (.not. varies(n)) j = j + 1
         self%row(n) = merge(i, j, varies(n))
      end do
   end subroutine number_rows

   !> Sorts the elements of the matrix of shares into diagonals and others, row by row, rows with few others first.
   subroutine list_neighbours(self)
      class(vector_propagator_type), intent(inout) :: self
      integer :: number(1 - self%rows:self%rows - 1), low(1 - self%rows:self%rows - 1), high(1 - self%rows:self%rows - 1)
      logical :: whole(1 - self%rows:self%rows - 1)
      integer :: others(self%system%elements), d, i, k, m, n

      number = 0
      low = self%rows
      high = 0
      associate (system => self%system, row => self%row)
         do n = 1, system%elements
            do i = system%first(n), system%first(n + 1) - 1
               d = row(system%neighbour(i)) - row(n)
               number(d) = number(d) + 1
               low(d) = min(low(d), lanes*((row(n) - 1)/lanes))
               high(d) = max(high(d), lanes*((row(n) + lanes - 1)/lanes))
            end do
         end do
         whole = number > 0 .and. number >= dense*(high - low)
         self%offset = pack([(d, d=1 - self%rows, self%rows - 1)], whole)
         self%low = pair*pack(low, whole)
         self%high = pair*pack(high, whole)
         allocate (self%share(self%rows, size(self%offset)), source=0.0_dp)
         allocate (self%to(0), self%number(0), self%from(0), self%factor(0))
         others = 0
         do n = 1, system%elements
            do i = system%first(n), system%first(n + 1) - 1
               m = system%neighbour(i)
               d = row(m) - row(n)
               if (whole(d)) then
                  self%share(row(n), findloc(self%offset, d, 1)) = system%coupling(i)/system%own(m)
               else
                  others(n) = others(n) + 1
               end if
            end do
         end do
         do k = 1, maxval(others)
            do n = 1, system%elements
               if (others(n) /= k) cycle
               self%to = [self%to, pair*(row(n) - 1)]
               self%number = [self%number, k]
               do i = system%first(n), system%first(n + 1) - 1
                  m = system%neighbour(i)
                  if (whole(row(m) - row(n))) cycle
                  self%from = [self%from, pair*(row(m) - 1)]
                  self%factor = [self%factor, system%coupling(i)/system%own(m)]
               end do
            end do
         end do
      end associate
      self%offset = pair*self%offset
   end subroutine list_neighbours

   subroutine list_harmonics(self)
      class(vector_propagator_type), intent(inout) :: self
      integer :: h, i, j, most

      most = 0
      do j = 1, self%system%meshes
         most = max(most, size(self%system%law(j)%harmonic))
      end do
      allocate (self%harmonic(0), self%place(most, self%system%meshes))
      do j = 1, self%system%meshes
         do i = 1, size(self%system%law(j)%harmonic)
            h = self%system%law(j)%harmonic(i)
            if (all(self%harmonic /= h)) self%harmonic = [self%harmonic, h]
            self%place(i, j) = findloc(self%harmonic, h, 1)
         end do
      end do
      allocate (self%wave(0:most_terms - 1, 2, size(self%harmonic)))
   end subroutine list_harmonics

   !> Begins at `frequency_ratio`; steps are shortened by `refinement`.
   subroutine start(self, frequency_ratio, refinement)
      class(vector_propagator_type), intent(inout) :: self
      !> Lambda [1]; steps are shorter by this factor [1].
      real(dp), intent(in) :: frequency_ratio, refinement

      call self%put_frequency(frequency_ratio, refinement)
      self%damper(self%row) = -self%system%own*self%system%damping/self%band
   end subroutine start

   !> Takes vectors (state, vector), velocities in plain units.
   subroutine put_vectors(self, vectors)
      class(vector_propagator_type), intent(inout) :: self
      !> Displacements and velocities of all coordinates, an even number of vectors, (2*coordinates, vector).
      real(dp), intent(in) :: vectors(:, :)
      real(dp) :: given(self%system%elements)
      integer :: i, k

      if (allocated(self%x)) then
         if (size(self%x, 4) /= size(vectors, 2)/pair) deallocate (self%x)
      end if
      if (.not. allocated(self%x)) allocate (self%x(pair, self%rows, 2, size(vectors, 2)/pair), source=0.0_dp)
      associate (m => self%system%coordinates)
         do i = 1, size(vectors, 2)
            do k = 1, 2
               given(:m) = vectors((k - 1)*m + 1:k*m, i)
               if (k == 2) given(:m) = given(:m)/self%band
               given(m + 1:) = matmul(self%system%network%loop, given(:m))
               self%x(mod(i - 1, pair) + 1, self%row, k, (i - 1)/pair + 1) = given
            end do
         end do
      end associate
   end subroutine put_vectors

   !> Gives them back, but for the displacement that is no state.
   subroutine get_vectors(self, vectors)
      class(vector_propagator_type), intent(in) :: self
      !> Displacements and velocities of all coordinates, (2*coordinates, vector).
      real(dp), intent(out) :: vectors(:, :)
      integer :: i

      associate (m => self%system%coordinates)
         do i = 1, size(vectors, 2)
            associate (x => self%x(mod(i - 1, pair) + 1, :, :, (i - 1)/pair + 1))
               vectors(:m, i) = x(self%row(:m), 1)
               vectors(m + 1:, i) = x(self%row(:m), 2)*self%band
            end associate
         end do
         vectors(self%system%displacements + 1:m, :) = 0
      end associate
   end subroutine get_vectors

   !> From one time to another along constant contacts (mesh), 0 for separation; less far where it is interrupted.
   subroutine advance(self, from, to, contact)
      class(vector_propagator_type), intent(inout) :: self
      !> Times [1].
      real(dp), intent(in) :: from, to
      !> Region of its law in which each mesh is, 0 for separation, (mesh).
      integer, intent(in) :: contact(:)
      real(dp) :: h
      integer :: i, j, steps
      logical :: varies

      if (.not. to > from) return
      varies = .false.
      associate (system => self%system)
         self%spring(self%row) = -system%own*system%spring/self%band**2
         do j = 1, system%meshes
            associate (law => system%law(j), s => contact(j), n => system%mesh_element(j))
               associate (row => self%row(n))
                  self%spring(row) = merge(0.0_dp, law%stiffness(s), row <= self%varying)*self%spring(row)
                  varies = varies .or. law%varies(s)
                  if (law%jumps) self%damper(row) = -system%own(n)*law%damping(s)/self%band
               end associate
            end associate
         end do
      end associate
      steps = self%steps(to - from, varies)
      h = (to - from)/steps
      do i = 1, steps
         if (self%system%interrupt%raised()) return
         call self%step(from + (i - 1)*h, h, contact)
      end do
   end subroutine advance

   !> Takes the vectors past an event of a mesh that goes from one region of its law to another: where its damping jumps, velocities
   !> change by its column of W times its displacement.
   subroutine pass_wall(self, mesh, from, to)
      class(vector_propagator_type), intent(inout) :: self
      !> The mesh; regions of its law before and after the event.
      integer, intent(in) :: mesh, from, to
      real(dp) :: change(pair, size(self%x, 4))
      integer :: i, k, m

      associate (system => self%system, law => self%system%law(mesh), n => self%system%mesh_element(mesh))
         if (.not. law%jumps) return
         change = (law%damping(to) - law%damping(from))/self%band*self%x(:, self%row(n), 1, :)
         self%x(:, self%row(n), 2, :) = self%x(:, self%row(n), 2, :) - system%own(n)*change
         do i = system%first(n), system%first(n + 1) - 1
            m = system%neighbour(i)
            do k = system%first(m), system%first(m + 1) - 1
               if (system%neighbour(k) == n) self%x(:, self%row(m), 2, :) = self%x(:, self%row(m), 2, :) - system%coupling(k)*change
            end do
         end do
      end associate
   end subroutine pass_wall

   subroutine step(self, time, h, contact)
      class(vector_propagator_type), intent(inout) :: self
      real(dp), intent(in) :: time, h
      integer, intent(in) :: contact(:)
      real(dp) :: power
      integer :: series, degree, i, k, terms

      series = self%motion%index_of(h*self%band)
      degree = self%motion%degree(series)
      power = 1
      do k = 0, degree
         self%weight(k) = self%motion%coefficient(k, series)*power
         power = power*h*self%band*(k + 1)
      end do
      call self%expand_kappa(time, h, contact, terms)
      do i = 1, size(self%x, 4)
         call take_step(pair*self%rows, pair*self%varying, degree, terms, self%spring, self%damper, self%kappa_terms, &
                        size(self%offset), self%offset, self%low, self%high, self%share, size(self%to), self%to, self%number, &
                        self%from, self%factor, self%weight, self%work, self%x(:, :, :, i))
      end do
   end subroutine step

   !> -W_nn times Taylor's terms of kappa at the beginning of a step: each harmonic as a polynomial about the middle of the step,
   !> shifted to its beginning, and kappa of each mesh from these.
   subroutine expand_kappa(self, time, h, contact, terms)
      class(vector_propagator_type), intent(inout) :: self
      real(dp), intent(in) :: time, h
      integer, intent(in) :: contact(:)
      !> How many there are.
      integer, intent(out) :: terms
      real(dp) :: polynomial(0:most_terms - 1)
      complex(dp) :: phase
      integer :: i, j, k, l, last, series

      last = 0
      self%wave = 0
      do k = 1, size(self%harmonic)
         associate (rate => self%harmonic(k)*self%frequency_ratio, wave => self%wave(:, :, k))
            series = self%kappa%index_of(rate*h/2)
            last = max(last, self%kappa%degree(series))
            phase = exp(cmplx(0, rate*(time + h/2), dp))
            do l = 0, self%kappa%degree(series)
               wave(l + 1, 1) = self%kappa%coefficient(l, series)*phase%re
               wave(l + 1, 2) = self%kappa%coefficient(l, series)*phase%im
               phase = cmplx(-phase%im, phase%re, dp)*rate
            end do
            do i = 0, last - 1
               do l = last - 1, i, -1
                  wave(l + 1, :) = wave(l + 1, :) - h/2*wave(l + 2, :)
               end do
            end do
            do l = 0, last
               wave(l + 1, :) = wave(l + 1, :)/self%band**l
            end do
         end associate
      end do
      terms = last + 1
      do j = 1, self%system%meshes
         associate (law => self%system%law(j), s => contact(j), n => self%system%mesh_element(j))
            if (self%row(n) > self%varying) cycle
            polynomial(:last) = 0
            polynomial(0) = law%stiffness(s)
            if (law%varies(s)) then
               do i = 1, size(law%amplitude, 1)
                  associate (wave => self%wave(:, :, self%place(i, j)), amplitude => law%amplitude(i, s))
                     polynomial(:last) = polynomial(:last) + amplitude%re*wave(:last + 1, 1) - amplitude%im*wave(:last + 1, 2)
                  end associate
               end do
            end if
            self%kappa_terms(self%row(n), last + 1) = 0
            self%kappa_terms(self%row(n), :last) = -self%system%own(n)/self%band**2*polynomial(:last)
         end associate
      end do
   end subroutine expand_kappa

end module geartrain_floquet_vector_propagator
