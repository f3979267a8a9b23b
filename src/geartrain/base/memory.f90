!> Memory that is asked for before it is used. An `allocate` without `stat=` that fails stops the program, and Python with it; an
!> assignment that fails writes to address 0. Whatever grows with the settings or with a file therefore asks here first.
module geartrain_base_memory
   use, intrinsic :: iso_c_binding, only: c_associated, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int64
   use geartrain_base_error, only: error_type, fatal, status_memory
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   implicit none (type, external)
   private
   public :: c_free, c_malloc, can_begin, has_room, need

   !> What must remain beside the memory that is asked for: work arrays of usual trains, buffers of LAPACK, FFTW and HDF5 [bytes].
   integer(int64), parameter :: reserve = 33554432
   !> Memory that OpenBLAS takes for each call under way [bytes]. Where it does not get it, it asks for ever.
   integer(int64), parameter :: blas_buffer = 134217728
   !> Memory that a further thread takes beside: its stack and the arena of its `malloc` [bytes].
   integer(int64), parameter :: of_thread = 75497472

   interface
      !> Allocates memory; null where there is none.
      type(c_ptr) function c_malloc(bytes) bind(c, name='malloc')
         import :: c_ptr, c_size_t
         implicit none (type, external)
         !> Number of bytes.
         integer(c_size_t), value :: bytes
      end function c_malloc

      !> Frees memory.
      subroutine c_free(place) bind(c, name='free')
         import :: c_ptr
         implicit none (type, external)
         !> Address from `c_malloc`.
         type(c_ptr), value :: place
      end subroutine c_free
   end interface

contains

   !> Whether so much memory could be allocated now, beside the reserve. Nothing is kept, and no page is touched.
   logical function has_room(bytes)
      !> Number of bytes; a negative number, of a sum that overflowed, is never there.
      integer(int64), intent(in) :: bytes
      ! Volatile: the compiler could leave out an allocation of which nothing is used.
      type(c_ptr), volatile :: room

      has_room = bytes >= 0 .and. bytes < huge(bytes) - reserve
      if (.not. has_room) return
      room = c_malloc(int(bytes + reserve, c_size_t))
      has_room = c_associated(room)
      if (has_room) call c_free(room)
   end function has_room

   !> Makes it an error, with status_memory, if so much memory cannot be allocated now.
   subroutine need(bytes, what, cure, error)
      !> Number of bytes; a real number, since settings can ask for more than whole numbers count.
      real(dp), intent(in) :: bytes
      !> What the memory is for, as in 'basins: no memory for 10 times 10 starts'; what the user can do.
      character(*), intent(in) :: what, cure
      type(error_type), allocatable, intent(inout) :: error

      if (bytes < 1e18_dp) then
         if (has_room(int(bytes, int64))) return
      end if
      call fatal(error, what//' ('//text(bytes/1e9_dp)//' GB with the file of them): '//cure, status_memory)
   end subroutine need

   !> Whether there is memory for as many threads as there are to be, or for fewer, which are then taken.
   logical function can_begin()
      integer :: threads

      do threads = omp_get_max_threads(), 1, -1
         can_begin = has_room(threads*blas_buffer + (threads - 1)*of_thread)
         if (.not. can_begin) cycle
         if (threads < omp_get_max_threads()) call omp_set_num_threads(threads)
         return
      end do
   end function can_begin

end module geartrain_base_memory
