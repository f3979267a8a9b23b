!> A case to begin with: the drawing of a gear reducer, every line with its comment.
module geartrain_input_new_case
   use geartrain_base_plain_text, only: escaped
   implicit none (type, external)
   private
   public :: new_case_text

   !> Shorter than the template, which has every variable there is; runs in a second or two. FILE stands for the name of the file.
   character(120), parameter :: lines(*) = [character(120) :: &
      "! A gear reducer as its drawing gives it: motor, shaft, pinion, wheel, shaft, load. SI units, angles in degrees.", &
      "! Text after a ! is a comment. Change any number and run again: errors are reported with their line.", &
      "!", &
      "!    geartrain FILE: computes for a second, prints a report, writes the results to a file .h5", &
      "!    geartrain --explain FILE: prints every number derived from the drawing, with formula and standard", &
      "!    geartrain --reference: prints every group and variable of a case", &
      "", &
      "&train", &
      "   title = 'gear reducer'                     ! title of results and pictures", &
      "!  modal_damping = 0.02                       ! damping ratio of all modes, in place of every damping_ratio below", &
      "/", &
      "", &
      "! A body turns as one. Its inertia is the given one; without it, that of its gears as discs of steel.", &
      "&body", &
      "   name     = 'motor'                         ! name used by shafts and meshes", &
      "   inertia  = 0.02                            ! kg m^2", &
      "   torque   = 90.0                            ! N m; the speed in rpm is that of the first body", &
      "/", &
      "&body", &
      "   name     = 'pinion'                        ! inertia from its gear", &
      "/", &
      "&body", &
      "   name     = 'wheel'                         ! inertia from its gear", &
      "/", &
      "&body", &
      "   name     = 'load'                          ! driven machine", &
      "   inertia  = 0.5                             ! kg m^2", &
      "   balances = .true.                          ! its mean torque balances all others", &
      "/", &
      "", &
      "! Shafts join bodies. Diameter and length give the stiffness of a steel shaft.", &
      "&shaft", &
      "   between       = 'motor', 'pinion'          ! names of the bodies at its ends", &
      "   diameter      = 0.030                      ! m", &
      "   length        = 0.150                      ! m", &
      "   damping_ratio = 0.01                       ! damping over critical damping", &
      "/", &
      "&shaft", &
      "   between       = 'wheel', 'load'            ! names of the bodies at its ends", &
      "   diameter      = 0.045                      ! m", &
      "   length        = 0.150                      ! m", &
      "   damping_ratio = 0.01                       ! damping over critical damping", &
      "/", &
      "", &
      "! A mesh is a gear pair between two bodies, the driving gear first. A second stage is another mesh.", &
      "&mesh", &
      "   between             = 'pinion', 'wheel'    ! bodies with the two gears", &
      "   teeth               = 23, 71               ! numbers of teeth, in the same order", &
      "   normal_module       = 2.5e-3               ! m", &
      "   helix_angle         = 15.0                 ! degrees; 0 for spur gears", &
      "   face_width          = 0.040                ! m; the drawing gives the mesh stiffness by ISO 6336-1", &
      "   backlash            = 60e-6                ! m, along the pitch circles", &
      "   damping_ratio       = 0.08                 ! damping over critical damping, teeth in contact", &
      "   stiffness_harmonics = 3                    ! harmonics of the mesh stiffness variation", &
      "   error_cos           = 3e-6                 ! m, transmission error, half of peak to peak, in phase with stiffness", &
      "/", &
      "", &
      "! Planetary sets, clutches and splines, gears on bearings: &planetary, &coupling and &bearing, as in the project's files", &
      "! namelists/planetary.nml, namelists/clutch.nml and namelists/bearings.nml.", &
      "", &
      "! Analyses; a group that is left out is not computed.", &
      "&modes", &
      "/                                             ! natural frequencies and mode shapes", &
      "&response                                     ! steady motions over speed, stable and unstable", &
      "   from      = 1000.0                         ! first speed", &
      "   to        = 2500.0                         ! last speed", &
      "   unit      = 'rpm'                          ! of the first body", &
      "   harmonics = 0                              ! 0: as many as the tolerance needs", &
      "   tolerance = 1e-3                           ! relative error of the waveform", &
      "/", &
      "&run_up                                       ! forces and torques while the speed rises", &
      "   from      = 1000.0                         ! first speed", &
      "   to        = 2500.0                         ! last speed", &
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
