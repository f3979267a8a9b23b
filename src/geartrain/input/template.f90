!> A case file to begin with: figure 3 of Al-shyyab and Kahraman (2007), with every variable explained.
module geartrain_input_template
   use geartrain_analyses_analysis, only: analysis_type
   use geartrain_analyses_list, only: analyses, case_type, find_analysis, results_type
   use geartrain_base_kinds, only: dp
   use geartrain_input_text, only: commented_text
   use geartrain_train_mesh, only: mesh_type
   use geartrain_train_shaft, only: shaft_type
   implicit none (type, external)
   private
   public :: template_text, paper_case

contains

   !> Writes a complete case file with every variable explained.
   subroutine template_text(text)
      !> The text of the file.
      character(:), allocatable, intent(out) :: text
      character(*), parameter :: newline = new_line('a')
      character(:), allocatable :: groups
      integer :: i

      call commented_text(paper_case(), groups)
      do i = 1, size(analyses)
         if (analyses(i)%set_aside) call set_aside(groups, trim(analyses(i)%name))
      end do
      text = '! A case for geartrain. Run it with: geartrain CASE.nml'//newline// &
             '! SI units throughout. Lines that begin with ! are comments: remove the ! to give that variable or group.'// &
             newline//groups
   end subroutine template_text

   !> Turns a group of the text into comments.
   subroutine set_aside(text, group)
      character(:), allocatable, intent(inout) :: text
      character(*), intent(in) :: group
      character(:), allocatable :: changed
      character(*), parameter :: newline = new_line('a')
      integer :: first, last, i

      first = index(text, newline//'&'//group//newline)
      last = first + index(text(first + 1:), newline//'/'//newline)
      changed = text(:first)
      do i = first + 1, last + 1
         if (text(i - 1:i - 1) == newline) changed = changed//'! '
         changed = changed//text(i:i)
      end do
      text = changed//text(last + 2:)
   end subroutine set_aside

   !> The train of table 1 of the paper, the analyses of figure 3, attractors at Lambda = 0.6, and a stability map.
   function paper_case() result(case)
      type(case_type), target :: case
      type(results_type), target :: none
      class(analysis_type), allocatable :: analysis
      integer :: i

      associate (train => case%train)
         train%title = 'Al-shyyab and Kahraman 2007, figure 3'
         train%input_torque = 150.0_dp
         train%prime_mover_inertia = 2.3e-7_dp
         train%load_inertia = 2.3e-7_dp
         train%characteristic_length = 30.0e-6_dp
         train%characteristic_frequency = 9870.0_dp
         allocate (train%shafts(3), train%meshes(2))
         train%shafts = shaft_type(damping_ratio=0.01_dp)
         train%shafts%stiffness = [1.0e3_dp, 1.0e8_dp, 1.0e3_dp]
         train%meshes = mesh_type(driving_radius=0.05_dp, driven_radius=0.1_dp, damping_ratio=0.05_dp, &
                                  half_backlash=30.0e-6_dp, stiffness_cos=[0.3_dp])
         train%meshes%driving_inertia = [0.0023_dp, 0.0046_dp]
         train%meshes%driven_inertia = [0.037_dp, 0.074_dp]
         train%meshes%stiffness = [2.5e8_dp, 5.0e8_dp]
      end associate
      do i = 1, size(analyses)
         call find_analysis(i, case, none, analysis, ask=.true.)
      end do
      case%attractors%frequency = 0.6_dp
      case%basins%frequency = 0.7_dp
      case%bifurcation_diagram%start = 0.2_dp
      case%bifurcation_diagram%stop = 2.6_dp
      case%integration%start = 0.2_dp
      case%integration%stop = 2.6_dp
      case%integration%direction = 'both'
      case%locus%near = 0.46_dp
      case%locus%parameter = 'stiffness_variation'
      case%locus%start = 0.1_dp
      case%locus%stop = 0.5_dp
      case%response%start = 0.2_dp
      case%response%stop = 2.6_dp
      case%run_up%start = 0.2_dp
      case%run_up%stop = 2.6_dp
      case%run_up%duration = 2
      case%stability_map%start = 0.2_dp
      case%stability_map%stop = 4.2_dp
      case%stability_map%parameter_stop = 0.5_dp
      case%output_file = ''
   end function paper_case

end module geartrain_input_template
