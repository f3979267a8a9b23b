!> Case texts at random: valid ones mutated byte by byte and piece by piece. The reader must refuse or read each without a crash.
!>
!> fuzz [COUNT [SEED]]: the last line is '1 passed, 0 failed' where all went well. Built with sanitizers by scripts/sanitize.
program fuzz
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use geartrain, only: case_text, case_type, error_type, read_case_text, status_input, template_text
   use geartrain_input_table, only: list_variables, row_type
   use testing, only: number_argument
   implicit none (type, external)
   character(*), parameter :: newline = new_line('a')
   !> Pieces of the grammar, and what is likely to upset a reader.
   character(16), parameter :: pieces(*) = [character(16) :: '&', '/', '=', ',', '!', '''', '"', '(1)', '%x', '*', '3*', '1000*0', &
      '99999999999*1', 'nan', '-inf', '1e999', '1e-999', '.true.', '+', '-', '.', 'e', '1d5', '&end', '&train', '&shaft', '&mesh', &
      '&modes', '&response', '&integration', '&attractors', '&output', '2147483648', '''''', ' ', achar(9), achar(13), newline, &
      achar(0), achar(127), char(239)//char(187)//char(191), char(195)//char(164), char(255), '= = =', '/ x', '!!!', '&&', &
      '0', '1', &
      '-1', '0.5']
   type(row_type), allocatable :: rows(:)
   integer(int64) :: state
   integer :: failed

   call feed(number_argument(1, 2000), number_argument(2, 1))
   if (failed > 0) stop 1, quiet=.true.

contains

   !> Feeds the reader with `count` texts. In a procedure, at whose end all is freed: what is left then is a leak.
   subroutine feed(count, seed)
      integer, intent(in) :: count, seed
      type(case_type) :: case
      type(error_type), allocatable :: error
      character(:), allocatable :: text, template, again, again_read
      integer :: i, k, read_well

      state = 1 + mod(abs(int(seed, int64))*7919_int64, 2147483646_int64)
      call template_text(template)
      call list_variables(rows)
      read_well = 0
      failed = 0
      do i = 1, count
         text = start_text(template)
         do k = 1, 1 + below(6)
            call mutate(text)
         end do
         call read_case_text(text, 'fuzz.nml', case, error)
         if (allocated(error)) then
            if (error%status == status_input .and. index(error%message, 'fuzz.nml') == 1) cycle
            call fail('an error without place or with the wrong status', text)
         else
            ! What is read well is written and read again to the same text.
            read_well = read_well + 1
            call case_text(case, again)
            call read_case_text(again, 'again.nml', case, error)
            if (allocated(error)) then
               call fail(error%message, text)
            else
               call case_text(case, again_read)
               if (again_read /= again) call fail('it is written differently when read again', text)
            end if
         end if
      end do
      write (output_unit, '(3(i0, a))') count, ' texts: ', read_well, ' read without an error, ', failed, ' wrongly'
      write (output_unit, '(a)') trim(merge('1 passed, 0 failed', '0 passed, 1 failed', failed == 0))
      deallocate (rows)
   end subroutine feed

   subroutine fail(why, text)
      character(*), intent(in) :: why, text

      failed = failed + 1
      write (error_unit, '(3a)') 'FAILED: ', why, ', with the text'
      write (error_unit, '(a)') text
   end subroutine fail

   !> The template, a short case, or nothing but noise.
   function start_text(template) result(text)
      character(*), intent(in) :: template
      character(:), allocatable :: text

      select case (below(8))
      case (0)
         text = template
      case (1)
         text = ''
      case default
         text = '&train input_torque=1 prime_mover_inertia=1 load_inertia=1 characteristic_length=1,'//newline// &
                'characteristic_frequency=1 title=''x'' /'//newline//'&shaft stiffness=1.0, damping_ratio=0.01 /'//newline// &
                '&mesh driving_radius=1 driven_radius=1 driving_inertia=1 driven_inertia=1 stiffness=2.5e8'//newline// &
                'stiffness_cos=0.3, 2*0.1 half_backlash=1e-5 /'//newline//'&shaft rigid=.true. /'//newline// &
                '&modes /'//newline//'&response from=0.2, to=2.6 /'//newline//'&output file=''a.h5'' /'//newline
      end select
   end function start_text

   !> One change: a piece or a variable put in, a stretch cut, doubled or moved, a byte changed.
   subroutine mutate(text)
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: piece
      integer :: a, b, c, n

      n = len(text)
      a = 1 + below(n + 1)
      b = min(n, a + below(20))
      select case (below(7))
      case (0, 1)
         piece = pieces(1 + below(size(pieces)))
         if (below(4) > 0) piece = trim(piece)
         text = text(:a - 1)//piece//text(a:)
      case (2)
         c = 1 + below(size(rows))
         piece = ' '//trim(rows(c)%variable%name)//' = '//trim(pieces(1 + below(size(pieces))))//' '
         text = text(:a - 1)//piece//text(a:)
      case (3)
         text = text(:a - 1)//text(b + 1:)
      case (4)
         text = text(:b)//text(a:)
      case (5)
         c = 1 + below(n + 1)
         piece = text(a:b)
         text = text(:c - 1)//piece//text(c:)
      case default
         if (a <= n) text(a:a) = char(below(256))
      end select
   end subroutine mutate

   !> Uniform in 0 to n-1, by Park and Miller's minimal standard generator.
   integer function below(n)
      integer, intent(in) :: n

      state = mod(48271_int64*state, 2147483647_int64)
      below = int(mod(state, int(n, int64)))
   end function below

end program fuzz
