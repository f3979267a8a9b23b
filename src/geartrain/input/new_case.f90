!> A case to begin with: the drawing of a gear reducer, every line with its comment.
module geartrain_input_new_case
   use geartrain_base_plain_text, only: escaped
   implicit none (type, external)
   private
   public :: new_case_text

   !> Shorter than the template, which has every variable there is; runs in a second or two. FILE stands for the name of the file.
   character(120), parameter :: lines(*) = [character(120) :: &
      "! A gear reducer as its drawing gives it: motor, shaft, pinion, wheel, shaft, load. SI units, angles in degrees.", &
      "! What follows a ! is a comment. Change any number and run again: a slip is told with its line.", &
      "!", &
      "!    geartrain FILE: runs it in a second or two and writes the results, .h5 beside the name", &
      "!    geartrain --explain FILE: every number that follows from the drawing, with formula and source", &
      "!    geartrain --template: every variable that there is", &
      "", &
      "&train", &
      "   title = 'gear reducer'                     ! stands in the results and above pictures", &
      "/", &
      "", &
      "! Bodies turn as one. Gears on a body add their inertia to it, as discs of steel.", &
      "&body", &
      "   name     = 'motor'                         ! shafts and meshes below call it so", &
      "   inertia  = 0.02                            ! kg m^2", &
      "   torque   = 90.0                            ! N m; speeds are those of the first body", &
      "/", &
      "&body", &
      "   name     = 'pinion'                        ! nothing but its gear", &
      "/", &
      "&body", &
      "   name     = 'wheel'                         ! its gear likewise", &
      "/", &
      "&body", &
      "   name     = 'load'                          ! what is driven", &
      "   inertia  = 0.5                             ! kg m^2", &
      "   balances = .true.                          ! its mean torque follows from the others'", &
      "/", &
      "", &
      "! Shafts join bodies; diameter and length give the stiffness, of steel.", &
      "&shaft", &
      "   between       = 'motor', 'pinion'          ! names of the bodies at its ends", &
      "   diameter      = 0.030                      ! m", &
      "   length        = 0.150                      ! m", &
      "   damping_ratio = 0.01                       ! of the critical damping", &
      "/", &
      "&shaft", &
      "   between       = 'wheel', 'load'            ! names of the bodies at its ends", &
      "   diameter      = 0.045                      ! m", &
      "   length        = 0.150                      ! m", &
      "   damping_ratio = 0.01                       ! of the critical damping", &
      "/", &
      "", &
      "! Meshes join bodies by a pair of gears, the driving gear first. A second stage is one more mesh.", &
      "&mesh", &
      "   between             = 'pinion', 'wheel'    ! the bodies that the gears are on", &
      "   teeth               = 23, 71               ! numbers of teeth, in the same order", &
      "   normal_module       = 2.5e-3               ! m", &
      "   helix_angle         = 15.0                 ! degrees; 0 of spur gears", &
      "   face_width          = 0.040                ! m; with the rest of the drawing: stiffness by ISO 6336-1", &
      "   backlash            = 60e-6                ! m, along the pitch circles", &
      "   damping_ratio       = 0.08                 ! of the teeth in contact", &
      "   stiffness_harmonics = 3                    ! of the wave of stiffness that the contact ratio gives", &
      "   error_cos           = 3e-6                 ! m, transmission error: once a tooth", &
      "/", &
      "", &
      "! What to compute; leave out a group, and it is not.", &
      "&modes", &
      "/                                             ! natural frequencies and mode shapes", &
      "&response                                     ! every steady motion over speed, also the unstable ones", &
      "   from      = 1000.0                         ! speed at which it begins", &
      "   to        = 2500.0                         ! speed at which it ends", &
      "   unit      = 'rpm'                          ! of the first body", &
      "   harmonics = 0                              ! 0: as many as the tolerance needs", &
      "   tolerance = 1e-3                           ! of the waveform", &
      "/", &
      "&run_up                                       ! forces and torques over time while the speed rises", &
      "   from      = 1000.0                         ! speed at which it begins", &
      "   to        = 2500.0                         ! speed at which it ends", &
      "   unit      = 'rpm'                          ! of the first body", &
      "   duration  = 1.0                            ! s", &
      "/"]

contains

   !> Writes a commented case that runs.
   subroutine new_case_text(file, text)
      !> Name of the file that it is for, as its first lines tell how to run it.
      character(*), intent(in) :: file
      !> The text of the file.
      character(:), allocatable, intent(out) :: text
      integer :: i, at

      text = ''
      do i = 1, size(lines)
         at = index(lines(i), 'FILE')
         if (at > 0) then
            text = text//lines(i)(:at - 1)//escaped(file)//trim(lines(i)(at + 4:))//new_line('a')
         else
            text = text//trim(lines(i))//new_line('a')
         end if
      end do
   end subroutine new_case_text

end module geartrain_input_new_case
