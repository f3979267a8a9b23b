!> Plain text: UTF-8 without characters that act on the line or the terminal that shows them. Escapes all other text.
module geartrain_base_plain_text
   implicit none (type, external)
   private
   public :: escaped, escaped_lines, is_plain, is_utf_8, not_plain

   !> First and last code points of the characters that are not plain: the control characters C0 and C1; separators of lines and
   !> paragraphs, embeddings and overrides of direction; isolates of direction and the deprecated formats behind the isolates; the
   !> byte order mark; annotations; tags. `plain` in python/geartrain/errors.py has the same list. Marks of direction, joiners and
   !> soft hyphens are plain: names in Hebrew, Persian or German need them, and they act on their neighbours only.
   integer, parameter :: acting(2, 7) = reshape([ &
      int(z'00'), int(z'1F'), int(z'7F'), int(z'9F'), int(z'2028'), int(z'202E'), int(z'2066'), int(z'206F'), &
      int(z'FEFF'), int(z'FEFF'), int(z'FFF9'), int(z'FFFB'), int(z'E0000'), int(z'E007F')], [2, 7])

   integer, parameter :: newline = 10

contains

   !> Length of the escaped text.
   pure integer function escaped_length(text, lines) result(length)
      character(*), intent(in) :: text
      logical, intent(in) :: lines
      integer :: i, code, bytes

      length = 0
      i = 1
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         if (stays(code, lines)) then
            length = length + bytes
         else
            length = length + code_length(code)
         end if
         i = i + bytes
      end do
   end function escaped_length

   !> Whether a text is UTF-8, as all texts for HDF5 and Python must be.
   pure logical function is_utf_8(text)
      !> Any bytes.
      character(*), intent(in) :: text
      integer :: i, code, bytes

      is_utf_8 = .false.
      i = 1
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         if (code < 0) return
         i = i + bytes
      end do
      is_utf_8 = .true.
   end function is_utf_8

   !> Whether a text is one line of UTF-8 that shows as it is: no character of it moves, hides or reorders what stands around it.
   pure logical function is_plain(text)
      !> Any bytes.
      character(*), intent(in) :: text
      integer :: place, bytes

      call find_acting(text, place, bytes)
      is_plain = place == 0
   end function is_plain

   !> What a message expects of a text that is not plain, with the first character that is not. To be trimmed.
   pure function not_plain(text) result(expectation)
      !> Any bytes.
      character(*), intent(in) :: text
      character(80) :: expectation
      integer :: place, bytes

      expectation = 'must be one line of UTF-8 text without control characters'
      call find_acting(text, place, bytes)
      if (place > 0) expectation = trim(expectation)//', not '//escaped(text(place:place + bytes - 1))
   end function not_plain

   !> Finds the first character that is not plain.
   pure subroutine find_acting(text, place, bytes)
      character(*), intent(in) :: text
      !> Its first byte, 0 where all characters are plain; the number of its bytes.
      integer, intent(out) :: place, bytes
      integer :: i, code

      place = 0
      bytes = 0
      i = 1
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         if (acts(code)) then
            place = i
            return
         end if
         i = i + bytes
      end do
   end subroutine find_acting

   !> The text with every character that is not plain as its code: '\x1b', '\u202e', '\U000e0001'; a byte that is not UTF-8 as
   !> '\x' and two digits. Plain text stays as it is, so that a text may be escaped twice.
   pure function escaped(text) result(plain)
      !> Any bytes.
      character(*), intent(in) :: text
      character(escaped_length(text, .false.)) :: plain

      call escape(text, .false., plain)
   end function escaped

   !> `escaped` of a text of several lines, whose newlines stay.
   pure function escaped_lines(text) result(plain)
      !> Any bytes.
      character(*), intent(in) :: text
      character(escaped_length(text, .true.)) :: plain

      call escape(text, .true., plain)
   end function escaped_lines

   pure subroutine escape(text, lines, plain)
      character(*), intent(in) :: text
      !> Whether newlines stay.
      logical, intent(in) :: lines
      !> Has `escaped_length` bytes.
      character(*), intent(out) :: plain
      character(10) :: piece
      integer :: i, at, code, bytes

      i = 1
      at = 1
      do while (i <= len(text))
         call decode(text, i, code, bytes)
         if (stays(code, lines)) then
            plain(at:at + bytes - 1) = text(i:i + bytes - 1)
            at = at + bytes
         else
            if (code < 0) code = iachar(text(i:i))
            write (piece, trim(merge('("\x", z2.2)', merge('("\u", z4.4)', '("\U", z8.8)', code < 65536), code < 256))) code
            plain(at:at + code_length(code) - 1) = lower_digits(piece(:code_length(code)))
            at = at + code_length(code)
         end if
         i = i + bytes
      end do
   end subroutine escape

   !> Length of an escaped character.
   pure integer function code_length(code)
      integer, intent(in) :: code

      code_length = merge(4, merge(6, 10, code < 65536), code < 256)
   end function code_length

   !> An escaped character with its hexadecimal digits in lower case, as Python writes them.
   pure function lower_digits(piece) result(lowered)
      character(*), intent(in) :: piece
      character(len(piece)) :: lowered
      integer :: i

      lowered = piece
      do i = 3, len(piece)
         if (piece(i:i) >= 'A' .and. piece(i:i) <= 'F') lowered(i:i) = achar(iachar(piece(i:i)) + 32)
      end do
   end function lower_digits

   pure logical function stays(code, lines)
      integer, intent(in) :: code
      logical, intent(in) :: lines

      stays = .not. acts(code) .or. lines .and. code == newline
   end function stays

   !> Whether a character is not plain; a negative code is a byte that is not UTF-8.
   pure logical function acts(code)
      integer, intent(in) :: code

      acts = code < 0 .or. (code < 32 .or. code > 126) .and. any(code >= acting(1, :) .and. code <= acting(2, :))
   end function acts

   !> Code point of the character that begins at byte `first`, and its number of bytes; -1 and 1 where it is not UTF-8.
   pure subroutine decode(text, first, code, bytes)
      character(*), intent(in) :: text
      integer, intent(in) :: first
      integer, intent(out) :: code, bytes
      integer, parameter :: shortest(3) = [128, 2048, 65536]
      integer :: k, byte, more, found

      code = -1
      bytes = 1
      byte = iachar(text(first:first))
      more = count(byte >= [192, 224, 240])
      if (byte >= 128 .and. more == 0 .or. byte >= 248 .or. first + more > len(text)) return
      found = iand(byte, merge(127, 63/2**more, more == 0))
      do k = first + 1, first + more
         byte = iachar(text(k:k))
         if (iand(byte, 192) /= 128) return
         found = 64*found + iand(byte, 63)
      end do
      ! Neither an overlong form nor a surrogate, and within Unicode.
      if (more > 0 .and. found < shortest(max(1, more))) return
      if (found >= 55296 .and. found <= 57343 .or. found > 1114111) return
      code = found
      bytes = more + 1
   end subroutine decode

end module geartrain_base_plain_text
