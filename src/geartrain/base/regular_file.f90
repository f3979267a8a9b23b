!> Whether a path leads to a regular file, found without opening the file.
module geartrain_base_regular_file
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   implicit none (type, external)
   private
   public :: is_regular_file

   !> In regular_file.c.
   interface
      integer(c_int) function c_is_regular_file(path) bind(c, name='geartrain_is_regular_file')
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
      end function c_is_regular_file
   end interface

contains

   !> Whether a file can be read from its beginning to its end: no folder, device, pipe or socket.
   logical function is_regular_file(path)
      !> Any path; links are followed.
      character(*), intent(in) :: path

      is_regular_file = c_is_regular_file(path//c_null_char) == 1
   end function is_regular_file

end module geartrain_base_regular_file
