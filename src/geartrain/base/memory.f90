!> Memory that is asked for before it is used. An `allocate` without `stat=` that fails stops the program, and Python with it; an
!> assignment that fails writes to address 0. Whatever grows with the settings or with a file therefore asks here first.
module geartrain_base_memory
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use geartrain_base_error, only: error_type, fatal, status_memory
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   implicit none (type, external)
   private
   public :: has_room

   !> What must remain beside the memory that is asked for: work arrays of usual trains, buffers of LAPACK, FFTW and HDF5 [bytes].
   integer(int64), parameter :: reserve = 32*2_int64**20

contains

   !> Whether so much memory could be allocated now, beside the reserve. Nothing is kept.
   logical function has_room(bytes)
      !> Number of bytes; a negative number, of a sum that overflowed, is never there.
      integer(int64), intent(in) :: bytes
      integer(int8), allocatable, volatile :: room(:)
      integer :: status

      has_room = bytes >= 0 .and. bytes < huge(bytes) - reserve
      if (.not. has_room) return
      allocate (room(bytes + reserve), stat=status)
      has_room = status == 0
      ! A write, so that the compiler cannot leave the allocation out.
      if (has_room) room(1) = 1
   end function has_room

   !> Makes it an error, with status_memory, if so much memory cannot be allocated now.
   subroutine need(bytes, what, cure, error)
      !> Number of bytes; a real number, since settings can ask for more than whole numbers count.
      real(dp), intent(in) :: bytes
      !> What the memory is for, as in 'basins: no memory for WHAT'; what the user can do.
      character(*), intent(in) :: what, cure
      type(error_type), allocatable, intent(inout) :: error

      if (bytes < 1e18_dp) then
         if (has_room(int(bytes, int64))) return
      end if
      call fatal(error, what//' ('//text(bytes/1e9_dp)//' GB): '//cure, status_memory)
   end subroutine need

end module geartrain_base_memory
