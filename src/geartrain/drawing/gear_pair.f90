!> A pair of involute gears as a drawing gives it, and what follows from it: base radii, contact ratios, mesh stiffness.
!>
!> Geometry by ISO 21771, mesh stiffness by ISO 6336-1:2006, method B (section 9.3). Lengths [m], angles [rad]; subscript 1 is the
!> driving gear, 2 the driven one. The diameters of an internal gear are positive here.
module geartrain_drawing_gear_pair
   use geartrain_base_kinds, only: dp, pi
   implicit none (type, external)
   private
   public :: gear_pair_type, pair_geometry_type, pair_stiffness_type, find_geometry, find_stiffness, involute, light_load, &
      rectangular_wave

   !> What the drawing says.
   type :: gear_pair_type
      !> Numbers of teeth; 0: not given.
      integer :: teeth(2) = 0
      logical :: internal = .false.
      !> Normal module, face width [m].
      real(dp) :: normal_module = 0, face_width = 0
      !> Normal pressure angle of the basic rack and helix angle at the reference cylinder [rad].
      real(dp) :: pressure_angle = 20*pi/180, helix_angle = 0
      !> Profile shift coefficients [1], positive towards the tip of the tooth: of an internal gear inwards.
      real(dp) :: profile_shift(2) = 0
      !> Centre distance, tip diameters [m]; 0: not given.
      real(dp) :: centre_distance = 0, tip_diameter(2) = 0
      !> Dedendum of the basic rack over the normal module [1].
      real(dp) :: dedendum = 1.25_dp
      !> Circumferential backlash along the working pitch circles, in the transverse plane [m]; 0: by the centre distance.
      real(dp) :: backlash = 0
      !> Modulus of elasticity of the gears [N/m^2].
      real(dp) :: elastic_modulus(2) = 2.06e11_dp
   end type gear_pair_type

   type :: pair_geometry_type
      !> Transverse pressure angle at the reference and at the working pitch circles, helix angle at the base circles [rad].
      real(dp) :: transverse_angle = 0, working_angle = 0, base_helix_angle = 0
      !> Transverse module [m].
      real(dp) :: transverse_module = 0
      !> Of the reference, base and tip circles [m].
      real(dp) :: reference_diameter(2) = 0, base_radius(2) = 0, tip_diameter(2) = 0
      !> In use; with which the flanks would touch without backlash; without profile shift [m].
      real(dp) :: centre_distance = 0, tight_distance = 0, reference_distance = 0
      !> Circumferential backlash along the working pitch circles by the centre distance alone, for teeth of the thickness that goes
      !> with the profile shift [m]; negative: the flanks jam. Half of the backlash in use along the transverse line of action [m].
      real(dp) :: distance_backlash = 0, half_backlash = 0
      !> Transverse contact ratio, overlap ratio, teeth of the virtual spur gears [1].
      real(dp) :: contact_ratio = 0, overlap_ratio = 0, virtual_teeth(2) = 0
      !> Tooth thickness at the tip circles over the normal module [1]; negative: the flanks meet below it.
      real(dp) :: tip_thickness(2) = 0
      !> By how much profile shift is below that at which cutting by a rack undercuts the tooth [1]; positive: undercut.
      real(dp) :: undercut(2) = 0
      !> Smallest distance of the path of contact from the base circle of a gear, along the line of action [m]; negative: the tip
      !> of the mate meets the flank below the base circle.
      real(dp) :: clear_of_base = 0
   end type pair_geometry_type

   type :: pair_stiffness_type
      !> Theoretical single stiffness c'_th, single stiffness c', mesh stiffness c_gamma_alpha [N/m per m of face width].
      real(dp) :: theoretical = 0, single = 0, mesh = 0
      !> Basic rack factor C_B; reduction at light load, (line load/100 N per mm)^0.25 below that load [1].
      real(dp) :: rack_factor = 1, load_factor = 1
   end type pair_stiffness_type

   !> C_M: measured over theoretical stiffness of solid gears. 100 N/mm: below this line load the stiffness falls [N/m].
   real(dp), parameter :: theory_correction = 0.8_dp, light_load = 1.0e5_dp
   !> Modulus of elasticity of steel, to which the formula of c' refers [N/m^2].
   real(dp), parameter :: steel = 2.06e11_dp
   !> N/(mm um) in N/m per m.
   real(dp), parameter :: per_millimetre_micrometre = 1.0e9_dp

contains

   !> The involute function of an angle [rad]: tan - angle.
   elemental real(dp) function involute(angle)
      !> The angle [rad].
      real(dp), intent(in) :: angle

      involute = tan(angle) - angle
   end function involute

   !> The angle [rad] of an involute function > 0, by Newton from a start above the root, where the function is convex.
   elemental real(dp) function involute_angle(value) result(angle)
      real(dp), intent(in) :: value
      real(dp) :: change
      integer :: i

      angle = min((3*value)**(1.0_dp/3), 1.5_dp)
      do i = 1, 100
         change = (involute(angle) - value)/tan(angle)**2
         angle = angle - change
         if (abs(change) <= 4*epsilon(angle)*angle) return
      end do
   end function involute_angle

   !> Geometry of a pair whose teeth, module and face width are given. Where flanks cannot meet, `centre_distance` below the sum of
   !> the base radii, the working angle is 0.
   elemental subroutine find_geometry(pair, geometry)
      !> The drawing. Of an internal pair the gear with more teeth is the internal gear.
      type(gear_pair_type), intent(in) :: pair
      !> The geometry.
      type(pair_geometry_type), intent(out) :: geometry
      type(gear_pair_type) :: turned

      if (pair%internal .and. pair%teeth(1) > pair%teeth(2)) then
         turned = pair
         turned%teeth = pair%teeth([2, 1])
         turned%profile_shift = pair%profile_shift([2, 1])
         turned%tip_diameter = pair%tip_diameter([2, 1])
         call find_ordered(turned, geometry)
         geometry%reference_diameter = geometry%reference_diameter([2, 1])
         geometry%base_radius = geometry%base_radius([2, 1])
         geometry%tip_diameter = geometry%tip_diameter([2, 1])
         geometry%virtual_teeth = geometry%virtual_teeth([2, 1])
         geometry%tip_thickness = geometry%tip_thickness([2, 1])
         geometry%undercut = geometry%undercut([2, 1])
      else
         call find_ordered(pair, geometry)
      end if
   end subroutine find_geometry

   !> Geometry of a pair whose second gear is the internal gear, if one is.
   elemental subroutine find_ordered(pair, geometry)
      type(gear_pair_type), intent(in) :: pair
      type(pair_geometry_type), intent(out) :: geometry
      real(dp) :: z(2), sign_2, sum_z, sum_x, addendum, tip_angle(2), cosine, path(2), line, tight_involute
      integer :: i

      z = pair%teeth
      ! An internal gear has its number of teeth, hence all its diameters, negative in the formulas of ISO 21771.
      sign_2 = merge(-1.0_dp, 1.0_dp, pair%internal)
      sum_z = z(1) + sign_2*z(2)
      sum_x = sum(pair%profile_shift)
      associate (g => geometry, m => pair%normal_module, beta => pair%helix_angle, alpha => pair%pressure_angle)
         g%transverse_angle = atan(tan(alpha)/cos(beta))
         g%base_helix_angle = asin(sin(beta)*cos(alpha))
         g%transverse_module = m/cos(beta)
         g%reference_diameter = z*g%transverse_module
         g%base_radius = g%reference_diameter*cos(g%transverse_angle)/2
         g%virtual_teeth = z/(cos(g%base_helix_angle)**2*cos(beta))
         g%reference_distance = abs(sum_z)*g%transverse_module/2
         ! An involute function <= 0 is of no angle: profile shifts so negative leave no tooth.
         tight_involute = max(tiny(1.0_dp), involute(g%transverse_angle) + 2*tan(alpha)*sum_x/sum_z)
         g%tight_distance = g%reference_distance*cos(g%transverse_angle)/cos(involute_angle(tight_involute))
         g%centre_distance = pair%centre_distance
         if (.not. g%centre_distance > 0) g%centre_distance = g%tight_distance
         cosine = g%reference_distance*cos(g%transverse_angle)/g%centre_distance
         g%working_angle = 0
         if (cosine < 1) g%working_angle = acos(cosine)
         g%distance_backlash = 0
         if (pair%centre_distance > 0) &
            g%distance_backlash = 2*sign_2*g%centre_distance*(involute(g%working_angle) - tight_involute)
         g%half_backlash = max(0.0_dp, merge(pair%backlash, g%distance_backlash, pair%backlash > 0))*cos(g%working_angle)/2
         g%overlap_ratio = pair%face_width*sin(beta)/(pi*m)
         ! Tips shortened so that the clearance of the rack stays, ISO 21771 (k <= 0).
         addendum = 1 + min(0.0_dp, sign_2*(g%tight_distance - g%reference_distance)/m - sum_x)
         g%tip_diameter = g%reference_diameter + 2*m*[1.0_dp, sign_2]*(addendum + pair%profile_shift)
         where (pair%tip_diameter > 0) g%tip_diameter = pair%tip_diameter
         path = 0
         tip_angle = 0
         do i = 1, 2
            cosine = 2*g%base_radius(i)/g%tip_diameter(i)
            if (cosine >= 1) cycle
            tip_angle(i) = acos(cosine)
            path(i) = g%base_radius(i)*tan(tip_angle(i))
         end do
         line = g%centre_distance*sin(g%working_angle)
         g%contact_ratio = (path(1) + sign_2*(path(2) - line))/(pi*g%transverse_module*cos(g%transverse_angle))
         g%clear_of_base = merge(path(2) - line, min(line - path(1), line - path(2)), pair%internal)
         g%tip_thickness = g%tip_diameter*cos(beta)/m &
                           *((pi/2 + 2*pair%profile_shift*tan(alpha))/z &
                             + [1.0_dp, sign_2]*(involute(g%transverse_angle) - involute(tip_angle)))
         ! The straight flank of the cutting rack reaches one module below the reference line; no internal gear is cut by it.
         g%undercut = 1 - pair%profile_shift - z*sin(g%transverse_angle)**2/(2*cos(beta))
         if (pair%internal) g%undercut(2) = -1
      end associate
   end subroutine find_ordered

   !> ISO 6336-1:2006, section 9.3: valid for x1 >= x2, -0.5 <= x1 + x2 <= 2, helix angles up to 45 degrees (c_gamma_alpha: 30
   !> degrees and contact ratios from 1.2 on), solid gears of one material each.
   elemental subroutine find_stiffness(pair, geometry, line_load, stiffness)
      !> The drawing.
      type(gear_pair_type), intent(in) :: pair
      !> Its geometry.
      type(pair_geometry_type), intent(in) :: geometry
      !> Tangential force with its application factor over the face width, F_t K_A/b [N/m]; 0: as for a full load.
      real(dp), intent(in) :: line_load
      !> Stiffnesses per face width.
      type(pair_stiffness_type), intent(out) :: stiffness
      real(dp) :: q, x1, x2, inverse(2), modulus
      integer :: order(2)

      ! Index 1 is the pinion.
      order = merge([1, 2], [2, 1], pair%teeth(1) <= pair%teeth(2))
      x1 = pair%profile_shift(order(1))
      x2 = pair%profile_shift(order(2))
      inverse = 1/geometry%virtual_teeth(order)
      ! An internal gear counts as a rack.
      if (pair%internal) inverse(2) = 0
      ! Equation (84), in mm um/N.
      q = 0.04723_dp + 0.15551_dp*inverse(1) + 0.25791_dp*inverse(2) - 0.00635_dp*x1 - 0.11654_dp*x1*inverse(1) &
          - 0.00193_dp*x2 - 0.24188_dp*x2*inverse(2) + 0.00529_dp*x1**2 + 0.00182_dp*x2**2
      stiffness%theoretical = per_millimetre_micrometre/q
      ! Equation (86).
      stiffness%rack_factor = (1 + 0.5_dp*(1.2_dp - pair%dedendum))*(1 - 0.02_dp*(20 - pair%pressure_angle*180/pi))
      stiffness%load_factor = 1
      if (line_load > 0) stiffness%load_factor = min(1.0_dp, line_load/light_load)**0.25_dp
      modulus = 2*product(pair%elastic_modulus)/sum(pair%elastic_modulus)
      stiffness%single = stiffness%theoretical*theory_correction*stiffness%rack_factor*cos(pair%helix_angle) &
                         *stiffness%load_factor*modulus/steel
      stiffness%mesh = stiffness%single*(0.75_dp*geometry%contact_ratio + 0.25_dp)
   end subroutine find_stiffness

   !> Amplitude of harmonic h of kappa [1] as tooth pairs come and go, averaged over the face:
   !> 2 sin(h pi (eps_alpha - 1))/(h pi eps_alpha) times sin(h pi eps_beta)/(h pi eps_beta).
   elemental real(dp) function rectangular_wave(h, contact_ratio, overlap_ratio) result(amplitude)
      !> Harmonic of the mesh frequency, >= 1.
      integer, intent(in) :: h
      !> Transverse contact ratio and overlap ratio [1].
      real(dp), intent(in) :: contact_ratio, overlap_ratio

      amplitude = 2*sin(h*pi*(contact_ratio - 1))/(h*pi*contact_ratio)
      if (overlap_ratio > 0) amplitude = amplitude*sin(h*pi*overlap_ratio)/(h*pi*overlap_ratio)
   end function rectangular_wave

end module geartrain_drawing_gear_pair
