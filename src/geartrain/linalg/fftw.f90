!> Real Fourier transforms by FFTW, with plans that free themselves.
module geartrain_linalg_fftw
   use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_double_complex, c_null_ptr, c_associated, &
                                          c_size_t, c_f_pointer
   implicit none (type, external)
   private
   public :: transform_type

   integer(c_int), parameter :: fftw_estimate = 64

   !> Real transforms of one length, without scaling: `to_samples` sums coefficients, `to_coefficients` sums samples. Each direction
   !> is planned once, where it is first used: to plan takes FFTW as long as many transforms.
   type :: transform_type
      !> Number of samples; 0: not planned.
      integer :: samples = 0
      !> Samples, (samples); coefficients 0 .. samples/2, (samples/2 + 1).
      real(c_double), pointer, contiguous :: sample(:) => null()
      complex(c_double_complex), pointer, contiguous :: coefficient(:) => null()
      type(c_ptr), private :: forward = c_null_ptr, backward = c_null_ptr
      type(c_ptr), private :: sample_memory = c_null_ptr, coefficient_memory = c_null_ptr
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

      if (self%samples == samples) return
      call release(self)
      self%samples = samples
      !$omp critical (fftw_planner)
      self%sample_memory = fftw_malloc(int(8, c_size_t)*samples)
      self%coefficient_memory = fftw_malloc(int(16, c_size_t)*(samples/2 + 1))
      !$omp end critical (fftw_planner)
      call c_f_pointer(self%sample_memory, self%sample, [samples])
      call c_f_pointer(self%coefficient_memory, self%coefficient, [samples/2 + 1])
   end subroutine plan

   !> sample(q) = sum over k = -samples/2 .. samples/2 of coefficient(|k|) exp(2 pi i k (q-1)/samples); destroys
   !> the coefficients.
   subroutine to_samples(self)
      class(transform_type), intent(inout) :: self

      if (.not. c_associated(self%backward)) then
         ! A plan by estimates leaves the arrays as they are.
         !$omp critical (fftw_planner)
         self%backward = fftw_plan_dft_c2r_1d(int(self%samples, c_int), self%coefficient, self%sample, fftw_estimate)
         !$omp end critical (fftw_planner)
      end if
      call fftw_execute_dft_c2r(self%backward, self%coefficient, self%sample)
   end subroutine to_samples

   !> coefficient(k+1) = sum over q of sample(q) exp(-2 pi i k (q-1)/samples).
   subroutine to_coefficients(self)
      class(transform_type), intent(inout) :: self

      if (.not. c_associated(self%forward)) then
         !$omp critical (fftw_planner)
         self%forward = fftw_plan_dft_r2c_1d(int(self%samples, c_int), self%sample, self%coefficient, fftw_estimate)
         !$omp end critical (fftw_planner)
      end if
      call fftw_execute_dft_r2c(self%forward, self%sample, self%coefficient)
   end subroutine to_coefficients

   !> Frees plans and memory.
   subroutine release(self)
      class(transform_type), intent(inout) :: self

      !$omp critical (fftw_planner)
      if (c_associated(self%forward)) call fftw_destroy_plan(self%forward)
      if (c_associated(self%backward)) call fftw_destroy_plan(self%backward)
      if (c_associated(self%sample_memory)) call fftw_free(self%sample_memory)
      if (c_associated(self%coefficient_memory)) call fftw_free(self%coefficient_memory)
      !$omp end critical (fftw_planner)
      self%forward = c_null_ptr
      self%backward = c_null_ptr
      self%sample_memory = c_null_ptr
      self%coefficient_memory = c_null_ptr
      nullify (self%sample, self%coefficient)
      self%samples = 0
   end subroutine release

   !> Finalizer; a `transform_type` must not be copied by assignment, which would free plans and memory twice.
   subroutine destroy(self)
      type(transform_type), intent(inout) :: self

      call release(self)
   end subroutine destroy

end module geartrain_linalg_fftw
