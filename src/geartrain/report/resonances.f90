!> The table of resonances in a report: local maxima of the vibration of a mesh, what excites them and which mode they are of.
module geartrain_report_resonances
   use geartrain_balance_mesh_load, only: mesh_load_type
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, fixed, significant, text
   use geartrain_base_sheet, only: in_resonances, sheet_type
   use geartrain_base_sorting, only: ascending
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_frequency_unit, only: hertz_per_lambda
   use geartrain_train_mesh_groups, only: short_word
   use geartrain_network_natural_modes, only: modes_type
   use geartrain_readings_frequency_text, only: frequency_text_type, in_width
   use geartrain_readings_summary, only: peak_type, peaks
   use geartrain_report_sources, only: find_sources, sources_type
   use geartrain_trace_branch, only: branch_type
   use geartrain_trace_decided, only: joined
   use geartrain_train_kinematics, only: all_toothed, find_kinematics, kinematics_type
   use geartrain_train_labels, only: label_length
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: find_resonances, put_resonances, resonance_type

   !> Most rows of a short report, and most meshes with a column of their own.
   integer, parameter :: most_rows = 6, most_meshes = 6
   !> Force amplitude below which a resonance is small, over the largest of the mesh [1]; distance within which two maxima of one
   !> order are one resonance, over the speed [1].
   real(dp), parameter :: small = 0.1_dp, same = 0.02_dp
   !> Ratios of the frequencies of vibration and mode between which the vibration is of the mode, since teeth that separate lower
   !> the frequency, and shift that is shown [1].
   real(dp), parameter :: lowest = 0.55_dp, highest = 1.2_dp, shift = 0.02_dp

   type :: resonance_type
      !> Lambda [1]; order of the fundamental that makes the peak [1].
      real(dp) :: frequency_ratio = 0, order = 0
      !> Largest force less mean force [N], (mesh).
      real(dp), allocatable :: amplitude(:)
      !> Whether the motion is unstable.
      logical :: unstable = .false.
   end type resonance_type

contains

   !> Force amplitude of a mesh [N]: largest force less mean force.
   elemental real(dp) function force_amplitude(load)
      !> Load of the mesh.
      type(mesh_load_type), intent(in) :: load

      force_amplitude = load%force_maximum
      if (load%dynamic_factor > 0) force_amplitude = load%force_maximum*(1 - 1/load%dynamic_factor)
   end function force_amplitude

   !> Resonances of a branch over frequency, ascending; maxima of several meshes at nearly one speed are one resonance.
   subroutine find_resonances(branch, found)
      type(branch_type), intent(in) :: branch
      !> The resonances.
      type(resonance_type), allocatable, intent(out) :: found(:)
      type(resonance_type) :: new
      type(peak_type), allocatable :: of_mesh(:)
      integer :: mesh, i, n

      allocate (found(0))
      do mesh = 1, branch%meshes
         of_mesh = peaks(branch, mesh)
         do i = 1, size(of_mesh)
            associate (peak => of_mesh(i))
               new%frequency_ratio = peak%frequency_ratio
               new%order = order_of_peak(branch, mesh, peak%point)
               new%amplitude = force_amplitude(branch%mesh_load(:, peak%point))
               new%unstable = .false.
               if (allocated(branch%stable)) new%unstable = .not. (peak%stable .or. peak%undecided)
            end associate
            do n = 1, size(found)
               if (is_same(found(n), new)) exit
            end do
            if (n > size(found)) then
               call append(new, found)
            else
               if (new%amplitude(mesh) > maxval(found(n)%amplitude)) found(n)%frequency_ratio = new%frequency_ratio
               found(n)%amplitude = max(found(n)%amplitude, new%amplitude)
            end if
         end do
      end do
      found = found(ascending(found%frequency_ratio))
   end subroutine find_resonances

   !> Adds a resonance to a list. Not by an array constructor: gfortran 12 does not free the allocatable components of its elements.
   pure subroutine append(new, found)
      type(resonance_type), intent(in) :: new
      type(resonance_type), allocatable, intent(inout) :: found(:)
      type(resonance_type) :: longer(size(found) + 1)

      longer(:size(found)) = found
      longer(size(longer)) = new
      found = longer
   end subroutine append

   !> Whether two maxima are of one resonance.
   pure logical function is_same(one, other)
      type(resonance_type), intent(in) :: one, other

      is_same = abs(one%order - other%order) < 1e-9_dp*one%order .and. (one%unstable .eqv. other%unstable) .and. &
                abs(one%frequency_ratio - other%frequency_ratio) < same*one%frequency_ratio
   end function is_same

   !> Order of the fundamental that makes a peak [1]: its amplitude exceeds most its amplitude at the feet of the peak.
   pure real(dp) function order_of_peak(branch, mesh, point)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh, point
      real(dp), dimension(size(branch%orders)) :: power, rise
      integer :: feet(2), side

      order_of_peak = 0
      if (size(branch%orders) == 0) return
      power = power_at(branch, mesh, point)
      do side = 1, 2
         associate (foot => feet(side), step => 2*side - 3)
            foot = point
            do
               if (foot + step < 1 .or. foot + step > branch%points) exit
               if (.not. joined(branch, min(foot, foot + step))) exit
               ! The first step is free: of a low peak between two points one may be higher than that at the peak.
               if (foot /= point .and. branch%rms(mesh, foot + step) > branch%rms(mesh, foot)) exit
               foot = foot + step
               if (abs(foot - point) == 1) power = max(power, power_at(branch, mesh, foot))
            end do
         end associate
      end do
      rise = power - max(power_at(branch, mesh, feet(1)), power_at(branch, mesh, feet(2)))
      ! Where one order falls as another rises, none may have a peak.
      if (.not. any(rise > 0)) rise = power
      order_of_peak = real(branch%orders(maxloc(rise, 1)), dp)/branch%subharmonic
   end function order_of_peak

   !> Squared amplitude of each order at a point [1], (order).
   pure function power_at(branch, mesh, point) result(power)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: mesh, point
      real(dp) :: power(size(branch%orders))
      integer :: k

      power = [(branch%coefficients(2*k, mesh, point)**2 + branch%coefficients(2*k + 1, mesh, point)**2, k=1, size(power))]
   end function power_at

   !> Adds the table: stable resonances with a force amplitude that is not small, and how many are left out.
   subroutine put_resonances(found, modes, train, told, sheet)
      !> The resonances.
      type(resonance_type), intent(in) :: found(:)
      type(modes_type), intent(in) :: modes
      !> The train as given.
      type(train_type), intent(in) :: train
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      type(sources_type) :: sources
      type(train_type) :: plain
      character(:), allocatable :: line, head, by
      integer, allocatable :: order(:)
      real(dp) :: relative(size(found)), largest(size(train%meshes)), per_order
      logical :: shown(size(found))
      integer :: i, j, mesh

      if (size(found) == 0) then
         call sheet%say(in_resonances, 'No resonance within the range.')
         return
      end if
      call plain_train(train, plain)
      call find_sources(train, sources)
      largest = [(maxval([(found(i)%amplitude(mesh), i=1, size(found))]), mesh=1, size(largest))]
      relative = [(maxval(found(i)%amplitude/max(largest, tiny(1.0_dp))), i=1, size(found))]
      shown = (relative >= small .and. .not. found%unstable) .or. sheet%verbose
      if (.not. sheet%verbose .and. count(shown) > most_rows) then
         order = ascending(-merge(relative, 0.0_dp, shown))
         shown(order(most_rows + 1:)) = .false.
      end if
      per_order = 1
      if (plain%speed_ratio > 0) per_order = 1/plain%speed_ratio
      if (any(shown)) then
         head = in_width('at '//told%unit, 12)//'   order          Hz  mode        '
         if (size(largest) <= most_meshes) then
            do mesh = 1, size(largest)
               head = head//in_width(trim(short_word(train%meshes, mesh)), 9)
            end do
         else
            head = head//'  largest  mesh'
         end if
         call sheet%add(in_resonances, head//'  excited by')
      end if
      do i = 1, size(found)
         if (.not. shown(i)) cycle
         associate (resonance => found(i), hertz => hertz_per_lambda(plain))
            line = in_width(told%number(resonance%frequency_ratio), 12)//in_width(significant(resonance%order*per_order), 8)// &
                   in_width(significant(resonance%order*resonance%frequency_ratio*hertz), 12)//'  '// &
                   mode_of(resonance%order*resonance%frequency_ratio, modes)
            if (size(largest) <= most_meshes) then
               do mesh = 1, size(largest)
                  line = line//in_width(significant(resonance%amplitude(mesh)), 9)
               end do
            else
               j = maxloc(resonance%amplitude, 1)
               line = line//in_width(significant(resonance%amplitude(j)), 9)//in_width(text(j), 6)
            end if
            call sources%name(resonance%order, by)
            line = line//'  '//by
            if (resonance%unstable) line = line//', unstable'
            call sheet%add(in_resonances, line)
         end associate
      end do
      line = ''
      if (any(shown)) then
         line = 'Under each mesh: force amplitude [N], largest less mean force'
         if (all(train%meshes%is_coupling)) then
            line = 'Under each coupling: torque amplitude [N m], largest less mean torque'
         else if (any(train%meshes%is_coupling)) then
            line = line//'; of couplings torque [N m]'
         end if
      end if
      if (any(shown) .and. plain%speed_ratio > 0) line = line//'; order: per revolution of '//trim(speed_name(train))
      if (.not. all(shown)) then
         if (line /= '') line = line//'; '
         line = line//counted(count(.not. shown), 'smaller or unstable peak', 'smaller or unstable peaks')//' not listed'
      end if
      if (line /= '') call sheet%say(in_resonances, line//'.')
   end subroutine put_resonances

   !> The body whose revolutions are the speed.
   function speed_name(train) result(name)
      type(train_type), intent(in) :: train
      character(label_length) :: name
      type(kinematics_type) :: kinematics

      name = 'the driving end'
      if (.not. (all_toothed(train) .and. allocated(train%bodies))) return
      call find_kinematics(train, kinematics)
      name = train%bodies(kinematics%speed_body)%name
   end function speed_name

   !> The mode whose natural frequency is nearest, and by how much the vibration is off it: '2', '1 (-24 %)'; '-' where all are far.
   function mode_of(frequency_ratio, modes) result(words)
      !> Frequency of the vibration over the characteristic frequency [1].
      real(dp), intent(in) :: frequency_ratio
      type(modes_type), intent(in) :: modes
      character(12) :: words
      real(dp) :: ratio
      integer :: i

      words = '-'
      if (.not. allocated(modes%natural_frequency)) return
      if (size(modes%natural_frequency) == 0 .or. .not. frequency_ratio > 0) return
      associate (natural => max(modes%natural_frequency, tiny(1.0_dp)))
         i = minloc(abs(log(frequency_ratio/natural)), 1)
         ratio = frequency_ratio/natural(i)
      end associate
      if (ratio < lowest .or. ratio > highest) return
      words = text(i)
      if (abs(ratio - 1) >= shift) words = text(i)//' ('//trim(merge('+', ' ', ratio > 1))//fixed(100*(ratio - 1), 0)//' %)'
   end function mode_of

end module geartrain_report_resonances
