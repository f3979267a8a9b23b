!> What a planetary set is in numbers: speeds, mesh frequency, phases of its meshes, and what the phases do with each harmonic.
module geartrain_report_explain_planetary
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use geartrain_base_carry, only: carry, carry_text
   use geartrain_base_field, only: field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_numbers, only: integer_text
   use geartrain_network_load_sharing, only: mesh_load_factor
   use geartrain_network_system, only: system_type
   use geartrain_train_labels, only: body_labels, label_length
   use geartrain_train_mesh, only: is_given
   use geartrain_train_planetary_sets, only: planetary_set_type, torsion_share
   use geartrain_train_train, only: train_type
   use geartrain_train_turning, only: turning_type
   implicit none (type, external)
   private
   public :: explain_set

   !> Difference of phases, and share of a harmonic, that count as rounding [1].
   real(dp), parameter :: rounding = 1e-6_dp

contains

   !> Makes the group of fields of a planetary set.
   subroutine explain_set(system, number, train, set, turning, speed_name, fields)
      type(system_type), intent(in) :: system
      !> Number of the set.
      integer, intent(in) :: number
      !> The train as given.
      type(train_type), intent(in) :: train
      !> One of its planetary sets.
      type(planetary_set_type), intent(in) :: set
      !> Speeds of the bodies.
      type(turning_type), intent(in) :: turning
      !> Name of the body whose revolutions are the speed.
      character(*), intent(in) :: speed_name
      !> Gets the group.
      class(fields_type), intent(inout) :: fields
      character(label_length) :: labels(size(train%bodies))
      character(:), allocatable :: words
      integer :: planets

      labels = body_labels(train)
      if (.not. fields%enter(trim(set%name), 'planetary set', .true.)) return
      planets = size(set%planets)
      call carry(fields, field_type('planets', '', '1', 'number of planets'), planets)
      call tell_body('sun', set%sun)
      call tell_body('ring', set%ring)
      call tell_body('carrier', set%carrier)
      if (turning%determined) then
         call tell_turns('sun_turns', set%sun)
         call tell_turns('planet_turns', set%planets(1))
         call tell_turns('ring_turns', set%ring)
         call tell_turns('carrier_turns', set%carrier)
      end if
      if (turning%determined) then
         call tell_pass('sun', set%sun)
         call tell_pass('ring', set%ring)
      end if
      call tell_teeth(train, set, turning, speed_name, fields)
      call tell_sharing(system, number, fields)
      if (allocated(set%sun_meshes)) call tell_phases('sun', set%sun_meshes)
      if (allocated(set%ring_meshes)) call tell_phases('ring', set%ring_meshes)

   contains

      subroutine tell_body(member, body)
         character(*), intent(in) :: member
         integer, intent(in) :: body

         if (body == 0) return
         words = trim(labels(body))
         if (train%bodies(body)%held) words = words//', held'
         call carry_text(fields, field_type(member, '', '', 'body that is the '//member), words)
      end subroutine tell_body

      subroutine tell_turns(name, body)
         character(*), intent(in) :: name
         integer, intent(in) :: body
         real(dp) :: turns

         if (body == 0) return
         turns = turning%speed(body)
         call carry(fields, field_type(name, '', '1', 'per turn of '//speed_name//', negative in the opposite sense; Willis: &
            &z_s (n_s - n_c) + z_p (n_p - n_c) = 0, z_p (n_p - n_c) = z_r (n_r - n_c)'), turns)
      end subroutine tell_turns

      !> Frequency at which planets pass a tooth of a member.
      subroutine tell_pass(member, body)
         character(*), intent(in) :: member
         integer, intent(in) :: body
         real(dp) :: passes

         if (body == 0) return
         passes = planets*abs(turning%speed(body) - turning%speed(set%carrier))
         call carry(fields, field_type(member//'_planet_pass', '', '1', 'planets that pass a tooth of the '//member// &
                                       ' per turn of '//speed_name//': N |n - n_c|'), passes)
      end subroutine tell_pass

      !> Lags of the meshes of a kind, the class of the set by them, and what becomes of each harmonic.
      subroutine tell_phases(kind, meshes)
         character(*), intent(in) :: kind
         integer, intent(in) :: meshes(:)
         real(dp), allocatable :: lag(:), share(:)
         integer, allocatable :: numbers(:)
         integer :: h

         numbers = meshes
         call carry(fields, field_type(kind//'_meshes', 'planet', '1', 'numbers of the meshes of the planets with the '//kind), &
                    numbers)
         lag = train%meshes(meshes)%phase/(2*pi)
         call carry(fields, field_type(kind//'_phase', 'planet', '1', 'lag of each mesh of the '//kind//', as a share of the mesh &
            &cycle: '//trim(merge('z_s psi of a planet at psi turns from the first            ', &
                                  '-z_r psi of a planet at psi turns, plus the lag of planet 1', kind == 'sun'))), lag)
         words = trim(phasing_of(train%meshes(meshes)%phase))
         call carry_text(fields, field_type(kind//'_phasing', '', '', 'class of the set by these phases'), words)
         share = [(torsion_share(h, train%meshes(meshes)%phase), h=1, 2*size(meshes))]
         where (share < rounding) share = 0
         call carry(fields, field_type(kind//'_torsion', 'harmonic', '1', 'share of harmonics 1, 2, ... of the mesh forces that &
            &acts on the torsion of '//kind//' and carrier, of equal planets with teeth in contact: |sum of exp(i h phase)| &
            &over planets'), share)
         call tell_harmonics(share, words)
         call carry_text(fields, field_type(kind//'_harmonics', '', '', 'by these shares'), words)
      end subroutine tell_phases

   end subroutine explain_set

   !> How the planets share the load at rest.
   subroutine tell_sharing(system, number, fields)
      type(system_type), intent(in) :: system
      integer, intent(in) :: number
      class(fields_type), intent(inout) :: fields
      real(dp), dimension(size(system%sharing%mesh)) :: share, peak
      real(dp), allocatable :: own(:)
      real(dp) :: factor
      integer, allocatable :: element(:)

      element = system%mesh_element(system%sharing%mesh)
      associate (force => system%static_force(element)*system%stiffness(element)*system%characteristic_length)
         call system%sharing%find_shares(force, abs(force), share, peak)
      end associate
      own = pack(share, system%sharing%set == number)
      if (.not. all(ieee_is_finite(own))) return
      call carry(fields, field_type('load_share', 'planet', '1', 'static: force of each planet with the sun (ring, without a sun) &
                                    &over their sum, by placement errors and unequal stiffnesses'), own)
      factor = mesh_load_factor(own)
      call carry(fields, field_type('mesh_load_factor', '', '1', 'K_gamma, static: largest load_share times the number of &
                                    &planets'), factor)
   end subroutine tell_sharing

   !> What the teeth tell: mesh frequency and assembly.
   subroutine tell_teeth(train, set, turning, speed_name, fields)
      type(train_type), intent(in) :: train
      type(planetary_set_type), intent(in) :: set
      type(turning_type), intent(in) :: turning
      character(*), intent(in) :: speed_name
      class(fields_type), intent(inout) :: fields
      character(:), allocatable :: words
      integer :: sun, ring, sum_z, planets
      real(dp) :: frequency

      sun = teeth_of(set%sun_meshes, set%sun)
      ring = teeth_of(set%ring_meshes, set%ring)
      planets = size(set%planets)
      if (turning%determined .and. sun + ring > 0) then
         frequency = abs(merge(sun, ring, sun > 0)*(turning%speed(merge(set%sun, set%ring, sun > 0)) - turning%speed(set%carrier)))
         call carry(fields, field_type('mesh_frequency', '', '1', 'per turn of '//speed_name//': z_s |n_s - n_c| = z_p |n_p - n_c| &
                                       &= z_r |n_r - n_c|'), frequency)
      end if
      if (sun == 0 .or. ring == 0) return
      sum_z = sun + ring
      words = '('//integer_text(sun)//' + '//integer_text(ring)//')/'//integer_text(planets)
      if (modulo(sum_z, planets) == 0) then
         words = words//' = '//integer_text(sum_z/planets)//': planets can be equally spaced'
      else
         words = words//' is not whole: planets cannot be equally spaced'
      end if
      call carry_text(fields, field_type('assembly', '', '', '(z_s + z_r)/planets; every planet stands at a multiple of &
         &1/(z_s + z_r) turns from the first'), words)

   contains

      !> Teeth of the common gear of meshes; 0 where there is none, or where not given.
      pure integer function teeth_of(meshes, body) result(teeth)
         integer, allocatable, intent(in) :: meshes(:)
         integer, intent(in) :: body

         teeth = 0
         if (.not. allocated(meshes)) return
         associate (mesh => train%meshes(meshes(1)))
            if (.not. is_given(mesh%teeth)) return
            if (size(mesh%teeth) /= 2) return
            teeth = nint(mesh%teeth(merge(1, 2, mesh%between(1) == train%bodies(body)%name)))
         end associate
      end function teeth_of

   end subroutine tell_teeth

   !> Class of a set by the phases of its meshes: 'in phase': all are equal; 'counter-phase': two halves, half a cycle apart;
   !> 'sequential': equally distributed over the cycle, alone or in groups; else 'other'.
   pure function phasing_of(phase) result(words)
      !> Lags of the meshes [rad of the mesh cycle], (planet).
      real(dp), intent(in) :: phase(:)
      character(13) :: words
      real(dp) :: share(size(phase))
      integer :: h, first

      share = [(torsion_share(h, phase), h=1, size(phase))]
      first = findloc(share > 1 - rounding, .true., 1)
      words = 'other'
      if (first == 0) return
      ! M equally distributed phases: harmonic M is the first that adds up, all before it cancel.
      if (any(share(:first - 1) > rounding)) return
      select case (first)
      case (1)
         words = 'in phase'
      case (2)
         words = 'counter-phase'
      case default
         words = 'sequential'
      end select
   end function phasing_of

   !> Which harmonics add up, and which cancel: '3, 6 act on torsion; 1, 2, 4, 5 cancel there and load planets only'.
   subroutine tell_harmonics(share, words)
      !> Share of each harmonic [1], (harmonic).
      real(dp), intent(in) :: share(:)
      character(:), allocatable, intent(out) :: words
      character(:), allocatable :: acting, cancelling, partial
      integer :: h

      acting = ''
      cancelling = ''
      partial = ''
      do h = 1, size(share)
         if (share(h) > 1 - rounding) then
            acting = acting//', '//integer_text(h)
         else if (share(h) > rounding) then
            partial = partial//', '//integer_text(h)
         else
            cancelling = cancelling//', '//integer_text(h)
         end if
      end do
      words = ''
      if (acting /= '') words = words//'; '//acting(3:)//' act on torsion'
      if (partial /= '') words = words//'; '//partial(3:)//' act in part'
      if (cancelling /= '') words = words//'; '//cancelling(3:)//' cancel there and load planets only'
      words = words(3:)
   end subroutine tell_harmonics

end module geartrain_report_explain_planetary
