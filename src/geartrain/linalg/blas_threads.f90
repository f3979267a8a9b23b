!> The threads of OpenBLAS, which gain nothing here: a program that computes with this library calls `blas_threads(1)` first.
module geartrain_linalg_blas_threads
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none (type, external)
   private
   public :: blas_threads

   interface
      !> Sets the number of threads of OpenBLAS (blas_threads.c); the result is the number before, 0 without OpenBLAS.
      integer(c_int) function blas_threads(number) bind(c, name='geartrain_blas_threads')
         import :: c_int
         implicit none (type, external)
         !> Number of threads.
         integer(c_int), intent(in), value :: number
      end function blas_threads
   end interface

end module geartrain_linalg_blas_threads
