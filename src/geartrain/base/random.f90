!> Random numbers that are equal on every machine: Park and Miller's minimal standard generator.
module geartrain_base_random
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: generator_type, begin_random

   type :: generator_type
      integer(int64), private :: last = 1
   contains
      procedure :: uniform
      procedure :: one_of
   end type generator_type

contains

   !> A generator at its first number.
   type(generator_type) function begin_random(seed, stream) result(generator)
      !> Seed, and number of the stream: a seed has many streams with different numbers.
      integer, intent(in) :: seed, stream
      real(dp) :: dropped
      integer :: i

      generator%last = 1 + abs(mod(int(seed, int64)*1000003_int64 + int(stream, int64)*7919_int64, 2147483646_int64))
      ! The first numbers of neighbouring streams are alike.
      do i = 1, 10
         dropped = generator%uniform()
      end do
   end function begin_random

   !> The next random number, uniform in (0, 1).
   real(dp) function uniform(self)
      class(generator_type), intent(inout) :: self

      self%last = mod(48271_int64*self%last, 2147483647_int64)
      uniform = real(self%last, dp)/2147483647.0_dp
   end function uniform

   !> The next random whole number, uniform in 1 .. n.
   integer function one_of(self, n)
      class(generator_type), intent(inout) :: self
      !> Largest number, at least 1.
      integer, intent(in) :: n

      one_of = min(n, 1 + int(n*self%uniform()))
   end function one_of

end module geartrain_base_random
