!> Reads the values of an attribute or a dataset of an HDF5 file. Texts, whose lengths only HDF5 finds, get a bound of their bytes.
module geartrain_results_hdf5_values
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_int64_t, c_loc, &
      c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int64
   use hdf5, only: h5aread_f, h5dread_f, h5p_dataset_xfer_f, h5pclose_f, h5pcreate_f, hid_t
   use geartrain_base_field, only: text_type
   use geartrain_base_memory, only: c_free, c_malloc
   use geartrain_base_plain_text, only: escaped_lines
   implicit none (type, external)
   private
   public :: fetch, fetch_texts

   !> The texts that HDF5 has allocated for one array, as a chain, so that all can be freed even if reading fails half-way.
   type, bind(c) :: texts_type
      !> Bytes that further texts may take.
      integer(c_int64_t) :: left
      !> The text allocated last; before each text stands the address of the one before.
      type(c_ptr) :: last
   end type texts_type

   !> Bytes before a text for the address of the text before, with room for the alignment of malloc.
   integer(c_size_t), parameter :: before_text = 16

   !> HDF5's C library, as its Fortran module lacks these routines, and C's memory.
   interface
      !> Sets who allocates and frees texts of variable length.
      integer(c_int) function h5pset_vlen_mem_manager(list, take, of_take, give, of_give) bind(c, name='H5Pset_vlen_mem_manager')
         import :: c_funptr, c_int, c_int64_t, c_ptr
         implicit none (type, external)
         integer(c_int64_t), value :: list
         type(c_funptr), value :: take, give
         type(c_ptr), value :: of_take, of_give
      end function h5pset_vlen_mem_manager

      integer(c_int) function h5dvlen_reclaim(kind, space, transfer, buffer) bind(c, name='H5Dvlen_reclaim')
         import :: c_int, c_int64_t, c_ptr
         implicit none (type, external)
         integer(c_int64_t), value :: kind, space, transfer
         type(c_ptr), value :: buffer
      end function h5dvlen_reclaim

      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: text
      end function c_strlen
   end interface

contains

   !> Reads the values of an attribute or a dataset, as `kind` in memory.
   subroutine fetch(id, attribute, kind, values, status)
      !> The attribute or dataset; type of the values in memory.
      integer(hid_t), intent(in) :: id, kind
      !> Whether it is an attribute.
      logical, intent(in) :: attribute
      !> Address of room for all values.
      type(c_ptr), intent(in) :: values
      !> Negative: they cannot be read.
      integer, intent(out) :: status
      type(c_ptr) :: address

      address = values
      if (attribute) call h5aread_f(id, kind, address, status)
      if (.not. attribute) call h5dread_f(id, kind, address, status)
   end subroutine fetch

   !> Reads texts of variable length.
   subroutine fetch_texts(id, attribute, kind, space, texts, left, failed, status)
      !> The attribute or dataset; its type and its space.
      integer(hid_t), intent(in) :: id, kind, space
      !> Whether it is an attribute.
      logical, intent(in) :: attribute
      !> The texts, as many as the space has places.
      type(text_type), intent(inout) :: texts(:)
      !> Bytes that the texts can have, and those that remain after them; negative: they have more.
      integer(int64), intent(inout) :: left
      !> Not 0: there is no memory for the texts; negative: they cannot be read.
      integer, intent(out) :: failed, status
      type(c_ptr), allocatable, target :: items(:)
      type(texts_type), target :: chain
      character(kind=c_char), pointer :: bytes(:)
      type(c_ptr) :: address
      integer(hid_t) :: transfer_list
      integer :: i, k, ignored

      status = 0
      allocate (items(size(texts)), stat=failed)
      if (failed /= 0) return
      chain = texts_type(left, c_null_ptr)
      if (attribute) then
         ! A single text, which HDF5 allocates.
         call fetch(id, attribute, kind, c_loc(items), status)
      else
         call h5pcreate_f(h5p_dataset_xfer_f, transfer_list, status)
         ignored = h5pset_vlen_mem_manager(int(transfer_list, c_int64_t), c_funloc(take_text), c_loc(chain), &
                                           c_funloc(leave_text), c_loc(chain))
         address = c_loc(items)
         call h5dread_f(id, kind, address, status, xfer_prp=transfer_list)
         call h5pclose_f(transfer_list, ignored)
      end if
      left = chain%left
      do i = 1, merge(size(items), 0, status >= 0)
         k = 0
         if (c_associated(items(i))) then
            call c_f_pointer(items(i), bytes, [c_strlen(items(i))])
            k = size(bytes)
            if (attribute) left = left - k
         end if
         allocate (character(k) :: texts(i)%text, stat=failed)
         if (failed /= 0) exit
         do k = 1, k
            texts(i)%text(k:k) = bytes(k)
         end do
         ! Tables, plots and reports show these texts; the title in the file may be older than the rules for titles.
         texts(i)%text = escaped_lines(texts(i)%text)
      end do
      if (attribute .and. status >= 0) &
         ignored = h5dvlen_reclaim(int(kind, c_int64_t), int(space, c_int64_t), 0_c_int64_t, c_loc(items))
      call free_texts(chain)
   end subroutine fetch_texts

   !> HDF5 asks here for the memory of a text; without it HDF5 ends reading.
   type(c_ptr) function take_text(bytes, information) bind(c)
      integer(c_size_t), value :: bytes
      !> A `texts_type`.
      type(c_ptr), value :: information
      type(texts_type), pointer :: chain
      type(c_ptr), pointer :: before
      character(kind=c_char), pointer :: place(:)

      take_text = c_null_ptr
      call c_f_pointer(information, chain)
      if (bytes < 0 .or. chain%left < 0) return
      ! The null character at the end does not stand in the file.
      chain%left = chain%left - bytes + 1
      if (chain%left < 0) return
      take_text = c_malloc(bytes + before_text)
      if (.not. c_associated(take_text)) return
      call c_f_pointer(take_text, before)
      before = chain%last
      chain%last = take_text
      call c_f_pointer(take_text, place, [before_text + 1])
      take_text = c_loc(place(before_text + 1))
   end function take_text

   !> HDF5 gives a text back here; all texts are freed together, by `free_texts`.
   subroutine leave_text(place, information) bind(c)
      type(c_ptr), value :: place, information
   end subroutine leave_text

   !> Frees the texts of a chain.
   subroutine free_texts(chain)
      type(texts_type), intent(inout) :: chain
      type(c_ptr), pointer :: before
      type(c_ptr) :: place

      do while (c_associated(chain%last))
         place = chain%last
         call c_f_pointer(place, before)
         chain%last = before
         call c_free(place)
      end do
   end subroutine free_texts

end module geartrain_results_hdf5_values
