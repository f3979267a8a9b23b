!> The one real kind of the library and the constants that go with it.
module geartrain_base_kinds
   use, intrinsic :: iso_fortran_env, only: dp => real64
   implicit none (type, external)
   private
   public :: dp, pi, version

   real(dp), parameter :: pi = 3.141592653589793238462643383279502884_dp
   !> Version of the program; fpm.toml, pyproject.toml and this line agree (scripts/lint checks).
   character(*), parameter :: version = '0.1.0'
end module geartrain_base_kinds
