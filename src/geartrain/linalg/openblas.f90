!> OpenBLAS where it hinders: a program that computes with this library calls `blas_kernels` and `blas_threads(1)` first.
module geartrain_linalg_openblas
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none (type, external)
   private
   public :: blas_kernels, blas_threads

   interface
      !> Sets the number of threads of OpenBLAS (openblas.c); the result is the number before, 0 without OpenBLAS.
      integer(c_int) function blas_threads(number) bind(c, name='geartrain_blas_threads')
         import :: c_int
         implicit none (type, external)
         !> Number of threads.
         integer(c_int), intent(in), value :: number
      end function blas_threads

      !> Lets OpenBLAS take kernels for a processor that it does not know (openblas.c), unless OPENBLAS_CORETYPE is set. To be
      !> called while nothing else uses BLAS.
      subroutine blas_kernels() bind(c, name='geartrain_blas_kernels')
         implicit none (type, external)
      end subroutine blas_kernels
   end interface

end module geartrain_linalg_openblas
