!> The options of the command line: what the help tells of them, and what shells complete.
module options
   use geartrain_base_nearest, only: nearest_name
   implicit none (type, external)
   private
   public :: completion_text, help_text, shells, unknown_option

   !> A line of the usage.
   type :: option_type
      !> With its dashes; '' of a line about files alone.
      character(18) :: name
      character(36) :: usage
      !> Without quotes, brackets and colons, which shells read otherwise.
      character(80) :: meaning
   end type option_type

   type(option_type), parameter :: options_known(*) = [ &
      option_type('', 'CASE.nml', 'run a case; the results go to CASE.h5'), &
      option_type('--output', 'CASE.nml --output FILE.h5', 'run a case; the results go to FILE.h5'), &
      option_type('--resume', 'CASE.nml --resume', 'continue a killed run from FILE.h5.partial'), &
      option_type('--force', 'CASE.nml --force', 'remove FILE.h5.partial of a killed run, start again'), &
      option_type('--verbose', 'CASE.nml --verbose', 'run a case; the report has all peaks, jumps and ranges'), &
      option_type('', 'A.nml B.nml ...', 'run several cases, as many at a time as there are threads'), &
      option_type('--new', '--new CASE.nml', 'write a commented case to begin with'), &
      option_type('--from-rexs', '--from-rexs X.rexs > X.nml', 'a case from a REXS file, by the Python package'), &
      option_type('--check', '--check CASE.nml ...', 'check cases without computing'), &
      option_type('--explain', '--explain CASE.nml ...', 'print every number of the train with its formula and standard'), &
      option_type('--audit', '--audit CASE.nml ...', &
                  'check points of its branches, and all special points, by shooting'), &
      option_type('--template', '--template > CASE.nml', 'a complete chain of gear pairs, its variables explained'), &
      option_type('--reference', '--reference', 'the tables of input variables, as Markdown'), &
      option_type('--output-reference', '--output-reference', &
                  'the tables of what a results file holds, as Markdown'), &
      option_type('--completion', '--completion bash|zsh|fish', 'print the completion script of a shell'), &
      option_type('--version', '--version', 'print the version'), &
      option_type('--help', '--help', 'print this help')]

   character(4), parameter :: shells(*) = ['bash', 'zsh ', 'fish']

   character(*), parameter :: newline = new_line('a')

contains

   !> What is wrong with a word that is no option.
   subroutine unknown_option(word, text)
      character(*), intent(in) :: word
      character(:), allocatable, intent(out) :: text
      integer :: i

      i = nearest_name(word, options_known%name)
      text = 'unknown option '//word
      if (i > 0) text = text//' (did you mean '//trim(options_known(i)%name)//'?)'
   end subroutine unknown_option

   subroutine help_text(text)
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = 'Nonlinear torsional dynamics of gear trains.'//newline//newline//'Usage:'//newline
      do i = 1, size(options_known)
         text = text//'   geartrain '//options_known(i)%usage(:28)//trim(options_known(i)%meaning)//newline
      end do
      text = text//newline// &
         'Without --output the results go to the file that &output names, otherwise to CASE.h5'//newline// &
         'in the working directory. To have options completed in bash: source <(geartrain --completion bash)'//newline// &
         newline// &
         'Exit status: 0 done; 2 bad input, nothing written; 3 an analysis ended early, results so far are written;'//newline// &
         '4 a file or standard output cannot be written, or there is no memory. Of several cases the largest.'//newline// &
         'An audit ends with status 3 if it contradicts a branch.'//newline// &
         'Threads: one per core, or OMP_NUM_THREADS.'//newline
   end subroutine help_text

   !> What a shell has to read to complete options, case files and results files.
   subroutine completion_text(shell, text)
      !> One of `shells`.
      character(*), intent(in) :: shell
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: names
      type(option_type) :: option
      integer :: i

      names = ''
      do i = 1, size(options_known)
         option = options_known(i)
         if (option%name == '') cycle
         select case (shell)
         case ('bash')
            names = names//' '//trim(option%name)
         case ('zsh')
            names = names//" '"//trim(option%name)//'['//trim(option%meaning)//']'//zsh_argument(option%name)//"' \"//newline
         case ('fish')
            names = names//'complete -c geartrain -l '//trim(option%name(3:))//" -d '"//trim(option%meaning)//"'"// &
                    trim(fish_argument(option%name))//newline
         end select
      end do
      select case (shell)
      case ('bash')
         text = '# Of geartrain, for bash: source <(geartrain --completion bash)'//newline// &
            '_geartrain() {'//newline// &
            '   local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} ending=nml'//newline// &
            '   compopt +o filenames'//newline// &
            '   case $before in'//newline// &
            "      --completion) mapfile -t COMPREPLY < <(compgen -W 'bash zsh fish' -- ""$word""); return ;;"//newline// &
            '      --output | -o) ending=h5 ;;'//newline// &
            "      --from-rexs) ending='rexs*' ;;"//newline// &
            '   esac'//newline// &
            '   if [[ $word == -* ]]; then'//newline// &
            "      mapfile -t COMPREPLY < <(compgen -W '"//names(2:)//"' -- ""$word"")"//newline// &
            '   else'//newline// &
            '      compopt -o filenames'//newline// &
            '      mapfile -t COMPREPLY < <(compgen -f -X "!*.$ending" -- "$word"; compgen -d -- "$word")'//newline// &
            '   fi'//newline// &
            '}'//newline// &
            'complete -F _geartrain geartrain'//newline
      case ('zsh')
         text = '#compdef geartrain'//newline// &
            '# Of geartrain, for zsh: source <(geartrain --completion zsh), after compinit'//newline// &
            '_geartrain() {'//newline// &
            '   _arguments \'//newline//names//" '*:case:_files -g ""*.nml""'"//newline// &
            '}'//newline// &
            'if [[ ${funcstack[1]} == _geartrain ]]; then _geartrain "$@"; else compdef _geartrain geartrain; fi'//newline
      case default
         ! Fish puts the files of an ending first, and leaves out no others.
         text = '# Of geartrain, for fish: geartrain --completion fish | source'//newline//names// &
            "complete -c geartrain -f -k -a '(__fish_complete_suffix .nml)'"//newline
      end select
   end subroutine completion_text

   !> What follows an option, in zsh's words.
   pure function zsh_argument(name) result(text)
      character(*), intent(in) :: name
      character(:), allocatable :: text

      text = ''
      if (name == '--output') text = ':results:_files -g "*.h5"'
      if (name == '--from-rexs') text = ':gearbox:_files -g "*.rexs*"'
      if (name == '--completion') text = ':shell:(bash zsh fish)'
   end function zsh_argument

   !> What follows an option, in fish's words.
   pure function fish_argument(name) result(text)
      character(*), intent(in) :: name
      character(48) :: text

      text = ''
      if (name == '--output') text = " -s o -r -k -a '(__fish_complete_suffix .h5)'"
      if (name == '--from-rexs') text = " -r -k -a '(__fish_complete_suffix .rexs)'"
      if (name == '--completion') text = " -x -a 'bash zsh fish'"
   end function fish_argument

end module options
