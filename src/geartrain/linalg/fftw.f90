!> Real Fourier transforms by FFTW, with plans that free themselves.
module geartrain_linalg_fftw
   use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_double_complex, c_null_ptr, c_associated, &
                                          c_size_t, c_f_pointer
   implicit none (type, external)
   private
   public :: transform_type

   integer(c_int), parameter :: fftw_estimate = 64

   !> Other lengths whose plans are kept: to plan anew takes FFTW as long as several transforms.
   integer, parameter :: most_kept = 6

   !> Plans and memory of one length; 0: none.
   type :: plan_type
      integer :: samples = 0
      type(c_ptr) :: forward = c_null_ptr, backward = c_null_ptr
      type(c_ptr) :: sample_memory = c_null_ptr, coefficient_memory = c_null_ptr
   end type plan_type

   !> Real transforms of one length at a time, without scaling: `to_samples` sums coefficients, `to_coefficients` sums samples. Each
   !> direction is planned once, where it is first used.
   type :: transform_type
      !> Number of samples; 0: not planned.
      integer :: samples = 0
      !> Samples, (samples); coefficients 0 .. samples/2, (samples/2 + 1).
      real(c_double), pointer, contiguous :: sample(:) => null()
      complex(c_double_complex), pointer, contiguous :: coefficient(:) => null()
      !> The present length, and those before, the latest first.
      type(plan_type), private :: now, kept(most_kept)
   contains
      procedure :: plan
      procedure :: to_samples
      procedure :: to_coefficients
      final :: destroy
   end type transform_type

   interface
      type(c_ptr) function fftw_plan_dft_r2c_1d(n, input, output, flags) bind(c, name='fftw_plan_dft_r2c_1d')
         import :: c_ptr, c_int, c_double, c_double_complex
         implicit none (type, external)
         integer(c_int), value :: n, flags
         real(c_double), intent(inout) :: input(*)
         complex(c_double_complex), intent(inout) :: output(*)
      end function fftw_plan_dft_r2c_1d

      type(c_ptr) function fftw_plan_dft_c2r_1d(n, input, output, flags) bind(c, name='fftw_plan_dft_c2r_1d')
         import :: c_ptr, c_int, c_double, c_double_complex
         implicit none (type, external)
         integer(c_int), value :: n, flags
         complex(c_double_complex), intent(inout) :: input(*)
         real(c_double), intent(inout) :: output(*)
      end function fftw_plan_dft_c2r_1d

      subroutine fftw_execute_dft_r2c(p, input, output) bind(c, name='fftw_execute_dft_r2c')
         import :: c_ptr, c_double, c_double_complex
         implicit none (type, external)
         type(c_ptr), value :: p
         real(c_double), intent(inout) :: input(*)
         complex(c_double_complex), intent(inout) :: output(*)
      end subroutine fftw_execute_dft_r2c

      subroutine fftw_execute_dft_c2r(p, input, output) bind(c, name='fftw_execute_dft_c2r')
         import :: c_ptr, c_double, c_double_complex
         implicit none (type, external)
         type(c_ptr), value :: p
         complex(c_double_complex), intent(inout) :: input(*)
         real(c_double), intent(inout) :: output(*)
      end subroutine fftw_execute_dft_c2r

      subroutine fftw_destroy_plan(p) bind(c, name='fftw_destroy_plan')
         import :: c_ptr
         implicit none (type, external)
         type(c_ptr), value :: p
      end subroutine fftw_destroy_plan

      type(c_ptr) function fftw_malloc(n) bind(c, name='fftw_malloc')
         import :: c_ptr, c_size_t
         implicit none (type, external)
         integer(c_size_t), value :: n
      end function fftw_malloc

      subroutine fftw_free(p) bind(c, name='fftw_free')
         import :: c_ptr
         implicit none (type, external)
         type(c_ptr), value :: p
      end subroutine fftw_free
   end interface

contains

   !> Sets the number of samples, unless it is that already. FFTW's planner has global state, hence the critical sections.
   subroutine plan(self, samples)
      class(transform_type), intent(inout) :: self
      !> Number of samples, at least 1.
      integer, intent(in) :: samples
      type(plan_type) :: other
      integer :: place

      if (self%samples == samples) return
      place = findloc(self%kept%samples, samples, 1)
      if (place > 0) then
         other = self%kept(place)
      else
         place = most_kept
         call release(self%kept(place))
         other%samples = samples
         !$omp critical (fftw_planner)
         other%sample_memory = fftw_malloc(int(8, c_size_t)*samples)
         other%coefficient_memory = fftw_malloc(int(16, c_size_t)*(samples/2 + 1))
         !$omp end critical (fftw_planner)
      end if
      self%kept(2:place) = self%kept(:place - 1)
      self%kept(1) = self%now
      self%now = other
      self%samples = samples
      call c_f_pointer(other%sample_memory, self%sample, [samples])
      call c_f_pointer(other%coefficient_memory, self%coefficient, [samples/2 + 1])
   end subroutine plan

   !> sample(q) = sum over k = -samples/2 .. samples/2 of coefficient(|k|) exp(2 pi i k (q-1)/samples); destroys
   !> the coefficients.
   subroutine to_samples(self)
      class(transform_type), intent(inout) :: self

      if (.not. c_associated(self%now%backward)) then
         ! A plan by estimates leaves the arrays as they are.
         !$omp critical (fftw_planner)
         self%now%backward = fftw_plan_dft_c2r_1d(int(self%samples, c_int), self%coefficient, self%sample, fftw_estimate)
         !$omp end critical (fftw_planner)
      end if
      call fftw_execute_dft_c2r(self%now%backward, self%coefficient, self%sample)
   end subroutine to_samples

   !> coefficient(k+1) = sum over q of sample(q) exp(-2 pi i k (q-1)/samples).
   subroutine to_coefficients(self)
      class(transform_type), intent(inout) :: self

      if (.not. c_associated(self%now%forward)) then
         !$omp critical (fftw_planner)
         self%now%forward = fftw_plan_dft_r2c_1d(int(self%samples, c_int), self%sample, self%coefficient, fftw_estimate)
         !$omp end critical (fftw_planner)
      end if
      call fftw_execute_dft_r2c(self%now%forward, self%sample, self%coefficient)
   end subroutine to_coefficients

   !> Frees plans and memory of one length.
   subroutine release(plan)
      type(plan_type), intent(inout) :: plan

      if (plan%samples == 0) return
      !$omp critical (fftw_planner)
      if (c_associated(plan%forward)) call fftw_destroy_plan(plan%forward)
      if (c_associated(plan%backward)) call fftw_destroy_plan(plan%backward)
      call fftw_free(plan%sample_memory)
      call fftw_free(plan%coefficient_memory)
      !$omp end critical (fftw_planner)
      plan = plan_type()
   end subroutine release

   !> Finalizer; a `transform_type` must not be copied by assignment, which would free plans and memory twice.
   subroutine destroy(self)
      type(transform_type), intent(inout) :: self
      integer :: i

      call release(self%now)
      do i = 1, most_kept
         call release(self%kept(i))
      end do
      self%samples = 0
      nullify (self%sample, self%coefficient)
   end subroutine destroy

end module geartrain_linalg_fftw
