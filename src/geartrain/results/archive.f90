!> Values as bytes and back, bit by bit: one routine that carries the components of a type both writes and reads them.
module geartrain_results_archive
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: archive_type

   !> Writes unless `reading`. What is read is checked for its size alone: `broken` tells that the bytes are not what was written.
   type :: archive_type
      logical :: reading = .false., broken = .false.
      integer(int8), allocatable :: bytes(:)
      integer(int64), private :: at = 0
   contains
      generic :: carry => carry_integer, carry_logical, carry_real, carry_text, carry_integers, carry_integers_2, carry_logicals, &
         carry_reals_1, carry_reals_2, carry_reals_3
      procedure :: has
      procedure :: finish
      procedure :: at_end
      procedure, private :: carry_integer, carry_logical, carry_real, carry_text, carry_integers, carry_logicals
      procedure, private :: carry_integers_2
      procedure, private :: carry_reals_1, carry_reals_2, carry_reals_3, carry_bytes, carry_extents, carry_block
   end type archive_type

contains

   !> Carries whether something is there; a reader makes what is.
   logical function has(self, there)
      class(archive_type), intent(inout) :: self
      logical, intent(in) :: there

      has = there
      call self%carry(has)
   end function has

   !> Gives spare room back.
   subroutine finish(self)
      class(archive_type), intent(inout) :: self

      self%bytes = self%bytes(:self%at)
   end subroutine finish

   !> Whether nothing is left to be read.
   pure logical function at_end(self)
      class(archive_type), intent(in) :: self

      at_end = self%at == size(self%bytes, kind=int64)
   end function at_end

   subroutine carry_integer(self, value)
      class(archive_type), intent(inout) :: self
      integer, intent(inout) :: value
      integer(int8) :: bytes(storage_size(value)/8)

      bytes = transfer(value, bytes)
      call self%carry_bytes(bytes)
      if (self%reading) value = transfer(bytes, value)
   end subroutine carry_integer

   subroutine carry_logical(self, value)
      class(archive_type), intent(inout) :: self
      logical, intent(inout) :: value
      integer :: number

      number = merge(1, 0, value)
      call self%carry(number)
      value = number == 1
   end subroutine carry_logical

   subroutine carry_real(self, value)
      class(archive_type), intent(inout) :: self
      real(dp), intent(inout) :: value
      real(dp) :: one(1)

      one = value
      call self%carry_block(one, 1_int64)
      value = one(1)
   end subroutine carry_real

   subroutine carry_text(self, value)
      class(archive_type), intent(inout) :: self
      character(:), allocatable, intent(inout) :: value
      integer(int8), allocatable :: bytes(:)
      integer :: n(1)

      n = -1
      if (allocated(value)) n = len(value)
      call self%carry_extents(n, 1)
      if (n(1) < 0) return
      if (self%reading) then
         allocate (bytes(n(1)))
      else
         bytes = transfer(value, bytes, n(1))
      end if
      call self%carry_bytes(bytes)
      if (self%reading) value = transfer(bytes, repeat(' ', n(1)))
   end subroutine carry_text

   subroutine carry_integers(self, value, used)
      class(archive_type), intent(inout) :: self
      integer, allocatable, intent(inout) :: value(:)
      !> How many are in use; all unless told. Others are not kept. Likewise below, of the last dimension.
      integer, intent(in), optional :: used
      integer :: n(1), i

      n = -1
      if (allocated(value)) n = size(value)
      if (present(used) .and. allocated(value) .and. .not. self%reading) n = used
      call self%carry_extents(n, 4)
      if (n(1) < 0) return
      if (self%reading) allocate (value(n(1)), source=0)
      do i = 1, n(1)
         call self%carry(value(i))
      end do
   end subroutine carry_integers

   subroutine carry_integers_2(self, value)
      class(archive_type), intent(inout) :: self
      integer, allocatable, intent(inout) :: value(:, :)
      integer :: n(2), i, j

      n = -1
      if (allocated(value)) n = shape(value)
      call self%carry_extents(n, 4)
      if (any(n < 0)) return
      if (self%reading) allocate (value(n(1), n(2)), source=0)
      do j = 1, n(2)
         do i = 1, n(1)
            call self%carry(value(i, j))
         end do
      end do
   end subroutine carry_integers_2

   subroutine carry_logicals(self, value, used)
      class(archive_type), intent(inout) :: self
      logical, allocatable, intent(inout) :: value(:)
      integer, intent(in), optional :: used
      integer, allocatable :: numbers(:)
      integer :: n

      if (allocated(value) .and. .not. self%reading) then
         n = size(value)
         if (present(used)) n = used
         numbers = merge(1, 0, value(:n))
      end if
      call self%carry(numbers)
      if (self%reading .and. allocated(numbers)) value = numbers == 1
   end subroutine carry_logicals

   subroutine carry_reals_1(self, value, used)
      class(archive_type), intent(inout) :: self
      real(dp), allocatable, intent(inout) :: value(:)
      integer, intent(in), optional :: used
      integer :: n(1)

      n = -1
      if (allocated(value)) n = shape(value)
      if (present(used) .and. allocated(value) .and. .not. self%reading) n(1) = used
      call self%carry_extents(n, 8)
      if (any(n < 0)) return
      if (self%reading) allocate (value(n(1)))
      call self%carry_block(value, product(int(n, int64)))
   end subroutine carry_reals_1

   subroutine carry_reals_2(self, value, used)
      class(archive_type), intent(inout) :: self
      real(dp), allocatable, intent(inout) :: value(:, :)
      integer, intent(in), optional :: used
      integer :: n(2)

      n = -1
      if (allocated(value)) n = shape(value)
      if (present(used) .and. allocated(value) .and. .not. self%reading) n(2) = used
      call self%carry_extents(n, 8)
      if (any(n < 0)) return
      if (self%reading) allocate (value(n(1), n(2)))
      call self%carry_block(value, product(int(n, int64)))
   end subroutine carry_reals_2

   subroutine carry_reals_3(self, value, used)
      class(archive_type), intent(inout) :: self
      real(dp), allocatable, intent(inout) :: value(:, :, :)
      integer, intent(in), optional :: used
      integer :: n(3)

      n = -1
      if (allocated(value)) n = shape(value)
      if (present(used) .and. allocated(value) .and. .not. self%reading) n(3) = used
      call self%carry_extents(n, 8)
      if (any(n < 0)) return
      if (self%reading) allocate (value(n(1), n(2), n(3)))
      call self%carry_block(value, product(int(n, int64)))
   end subroutine carry_reals_3

   !> Carries the extents of an array, -1 where it is not allocated; as read they fit what is left of the bytes.
   subroutine carry_extents(self, n, bytes_each)
      class(archive_type), intent(inout) :: self
      integer, intent(inout) :: n(:)
      integer, intent(in) :: bytes_each
      real(dp) :: wanted
      integer :: i

      do i = 1, size(n)
         call self%carry(n(i))
      end do
      if (.not. self%reading) return
      wanted = product(real(n, dp))*bytes_each
      if (self%broken .or. any(n < -1) .or. (all(n >= 0) .and. wanted > real(size(self%bytes, kind=int64) - self%at, dp))) then
         self%broken = .true.
         n = -1
      end if
   end subroutine carry_extents

   !> n numbers in the order of memory.
   subroutine carry_block(self, value, n)
      class(archive_type), intent(inout) :: self
      integer(int64), intent(in) :: n
      real(dp), intent(inout) :: value(n)
      integer(int8), allocatable :: bytes(:)

      allocate (bytes(8*n))
      if (.not. self%reading) bytes = transfer(value, bytes, 8*n)
      call self%carry_bytes(bytes)
      if (self%reading .and. .not. self%broken) value = transfer(bytes, value, n)
   end subroutine carry_block

   !> The one place where bytes come and go.
   subroutine carry_bytes(self, bytes)
      class(archive_type), intent(inout) :: self
      integer(int8), intent(inout) :: bytes(:)
      integer(int8), allocatable :: longer(:)
      integer(int64) :: n

      n = size(bytes, kind=int64)
      if (self%reading) then
         if (.not. self%broken) self%broken = .not. allocated(self%bytes)
         if (.not. self%broken) self%broken = self%at + n > size(self%bytes, kind=int64)
         bytes = 0
         if (self%broken) return
         bytes = self%bytes(self%at + 1:self%at + n)
      else
         if (.not. allocated(self%bytes)) allocate (self%bytes(65536))
         if (self%at + n > size(self%bytes, kind=int64)) then
            allocate (longer(2*(self%at + n)))
            longer(:self%at) = self%bytes(:self%at)
            call move_alloc(longer, self%bytes)
         end if
         self%bytes(self%at + 1:self%at + n) = bytes
      end if
      self%at = self%at + n
   end subroutine carry_bytes

end module geartrain_results_archive
