!> The command line: what is asked for.
module arguments
   implicit none (type, external)
   private
   public :: arguments_type, file_name_type, read_arguments, help_text

   type :: file_name_type
      character(:), allocatable :: name
   end type file_name_type

   type :: arguments_type
      !> 'run', 'check', 'explain', 'audit', 'template', 'reference', 'output-reference', 'version' or 'help'.
      character(:), allocatable :: action
      type(file_name_type), allocatable :: case_files(:)
      !> As given by --output; '' where it was not.
      character(:), allocatable :: output_file
      !> Go on from the checkpoint of a run that was killed.
      logical :: resume = .false.
      !> What is wrong with the command line; '' where all is well.
      character(:), allocatable :: wrong
   end type arguments_type

   character(*), parameter :: newline = new_line('a')

   character(*), parameter :: help_text = &
      'Nonlinear torsional dynamics of gear trains.'//newline// &
      newline// &
      'Usage:'//newline// &
      '   geartrain CASE.nml [--output FILE.h5]   run a case; the results go to FILE.h5'//newline// &
      '   geartrain CASE.nml --resume             go on with a run that was killed, from FILE.h5.partial'//newline// &
      '   geartrain A.nml B.nml ...               run several cases, as many at a time as there are threads'//newline// &
      '   geartrain --check CASE.nml ...          say what is wrong with cases, compute nothing'//newline// &
      '   geartrain --explain CASE.nml ...        every number of the train, how it is derived, its source'//newline// &
      '   geartrain --audit CASE.nml ...          check points of its branches, and all special points, by shooting'//newline// &
      '   geartrain --template > CASE.nml         a complete case, every variable explained'//newline// &
      '   geartrain --reference                   the tables of input variables, as Markdown'//newline// &
      '   geartrain --output-reference            the tables of what a results file holds, likewise'//newline// &
      '   geartrain --version'//newline// &
      '   geartrain --help'//newline// &
      newline// &
      'Without --output the results go to the file that &output names, or else to the name of the case with .h5,'//newline// &
      'in the working directory.'//newline// &
      newline// &
      'Exit status: 0 done; 2 bad input, nothing written; 3 an analysis ended early, what was computed is written;'//newline// &
      '4 the file system failed, standard output is lost, or there is no memory. Of several cases the largest.'//newline// &
      'An audit ends with 3 unless all is as the branches say.'//newline// &
      'Threads: one a core, or as many as the environment variable OMP_NUM_THREADS says.'

contains

   subroutine read_arguments(arguments)
      type(arguments_type), intent(out) :: arguments
      character(:), allocatable :: word
      type(file_name_type), allocatable :: files(:)
      integer :: i, n

      arguments%action = 'run'
      allocate (files(command_argument_count()))
      n = 0
      arguments%output_file = ''
      arguments%wrong = ''
      i = 0
      do while (i < command_argument_count() .and. arguments%wrong == '')
         i = i + 1
         word = argument(i)
         select case (word)
         case ('--help', '-h', '--version', '--template', '--reference', '--output-reference')
            arguments%action = word(3:)
            if (word == '-h') arguments%action = 'help'
            return
         case ('--check', '--explain', '--audit')
            if (arguments%action /= 'run' .and. arguments%action /= word(3:)) &
               arguments%wrong = '--'//arguments%action//' and '//word//' contradict each other'
            arguments%action = word(3:)
         case ('--resume')
            arguments%resume = .true.
         case ('--output', '-o')
            i = i + 1
            if (i <= command_argument_count()) arguments%output_file = argument(i)
            if (arguments%output_file == '') arguments%wrong = word//' needs the name of a file'
         case default
            if (index(word, '--output=') == 1) then
               arguments%output_file = word(10:)
               if (arguments%output_file == '') arguments%wrong = '--output needs the name of a file'
            else if (index(word, '-') == 1) then
               arguments%wrong = 'unknown option '//word
            else
               n = n + 1
               files(n)%name = word
            end if
         end select
      end do
      arguments%case_files = files(:n)
      if (arguments%wrong == '' .and. size(arguments%case_files) == 0) arguments%wrong = 'no case file given'
      if (arguments%wrong == '' .and. arguments%action /= 'run') then
         if (arguments%output_file /= '') arguments%wrong = '--'//arguments%action//' writes nothing: leave out --output'
         if (arguments%resume) arguments%wrong = '--'//arguments%action//' goes on with no run: leave out --resume'
      else if (arguments%wrong == '' .and. size(arguments%case_files) > 1) then
         if (arguments%resume) arguments%wrong = '--resume goes on with one case, and there are several: resume them one by one'
         if (arguments%output_file /= '') &
            arguments%wrong = '--output names one file, and there are several cases: name their files in &output'
      end if
   end subroutine read_arguments

   function argument(i) result(word)
      integer, intent(in) :: i
      character(:), allocatable :: word
      integer :: length

      call get_command_argument(i, length=length)
      allocate (character(length) :: word)
      if (length > 0) call get_command_argument(i, word)
   end function argument

end module arguments
