!> The command line: what is asked for.
module arguments
   use options, only: shells, unknown_option
   implicit none (type, external)
   private
   public :: arguments_type, file_name_type, read_arguments

   type :: file_name_type
      character(:), allocatable :: name
   end type file_name_type

   type :: arguments_type
      !> 'run', or what another option says, without its dashes.
      character(:), allocatable :: action
      type(file_name_type), allocatable :: case_files(:)
      !> As given by --output; '' where it was not.
      character(:), allocatable :: output_file
      !> Of --completion.
      character(:), allocatable :: shell
      !> Go on from the checkpoint of a run that was killed.
      logical :: resume = .false.
      !> Remove the checkpoint of a run that was killed, and begin anew.
      logical :: force = .false.
      !> Report with all details.
      logical :: verbose = .false.
      !> What is wrong with the command line; '' where all is well.
      character(:), allocatable :: wrong
   end type arguments_type

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
      arguments%shell = ''
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
         case ('--completion')
            arguments%action = word(3:)
            if (i < command_argument_count()) arguments%shell = argument(i + 1)
            if (all(shells /= arguments%shell)) arguments%wrong = '--completion needs bash, zsh or fish'
            return
         case ('--new', '--check', '--explain', '--audit', '--from-rexs')
            if (arguments%action /= 'run' .and. arguments%action /= word(3:)) &
               arguments%wrong = '--'//arguments%action//' and '//word//' contradict each other'
            arguments%action = word(3:)
         case ('--resume')
            arguments%resume = .true.
         case ('--verbose')
            arguments%verbose = .true.
         case ('--force')
            arguments%force = .true.
         case ('--output', '-o')
            i = i + 1
            if (i <= command_argument_count()) arguments%output_file = argument(i)
            if (arguments%output_file == '') arguments%wrong = word//' needs the name of a file'
         case default
            if (index(word, '--output=') == 1) then
               arguments%output_file = word(10:)
               if (arguments%output_file == '') arguments%wrong = '--output needs the name of a file'
            else if (word == '--pitch-errors' .or. word == '--load-case') then
               arguments%wrong = word//' is an option of geartrain-rexs, by which --from-rexs reads the file'
            else if (index(word, '-') == 1) then
               call unknown_option(word, arguments%wrong)
            else
               n = n + 1
               files(n)%name = word
            end if
         end select
      end do
      arguments%case_files = files(:n)
      if (arguments%wrong == '' .and. size(arguments%case_files) == 0) arguments%wrong = 'no case file given'
      if (arguments%wrong == '' .and. arguments%action == 'new' .and. size(arguments%case_files) > 1) &
         arguments%wrong = '--new writes one case: '//arguments%case_files(2)%name//' is one too many'
      if (arguments%wrong == '' .and. arguments%action == 'from-rexs' .and. size(arguments%case_files) > 1) &
         arguments%wrong = '--from-rexs reads one file: '//arguments%case_files(2)%name//' is one too many'
      if (arguments%wrong == '' .and. arguments%action /= 'run') then
         if (arguments%output_file /= '') arguments%wrong = '--'//arguments%action//' writes no results: leave out --output'
         if (arguments%resume) arguments%wrong = '--'//arguments%action//' goes on with no run: leave out --resume'
         if (arguments%verbose) arguments%wrong = '--'//arguments%action//' prints no report: leave out --verbose'
         if (arguments%force) arguments%wrong = '--'//arguments%action//' writes no results: leave out --force'
      else if (arguments%wrong == '' .and. arguments%resume .and. arguments%force) then
         arguments%wrong = '--resume and --force contradict each other'
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
