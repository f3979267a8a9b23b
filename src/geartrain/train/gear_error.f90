!> Errors of a gear that repeat once a revolution: of each tooth, by runout, or by their harmonics. They add to the transmission
!> error of the mesh. The stiffness of each tooth, as of a cracked one, is a factor of the mesh stiffness.
module geartrain_train_gear_error
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_series, only: delay, table_harmonics, window_harmonics
   use geartrain_base_variable, only: row => variable_type, visitor_type
   implicit none (type, external)
   private
   public :: first_variable, gear_error_type, gear_words, has_gear_error, has_tooth_factors, make_plain, visit_gear_error

   !> Which gear of a mesh, as variables and messages name it.
   character(*), parameter :: gear_words(2) = ['driving', 'driven ']

   type :: gear_error_type
      !> Cumulative pitch error of each tooth along the line of action [m], (tooth).
      real(dp), allocatable :: pitch(:)
      !> Runout: amplitude along the line of action [m] and phase in the revolution of the gear [rad].
      real(dp) :: runout = 0, runout_phase = 0
      !> Amplitudes at the orders 1, 2, ... of the revolution [m], (order). In a plain train of all errors of the gear.
      real(dp), allocatable :: cosine(:), sine(:)
      !> Stiffness of each tooth over that of a sound one [1], (tooth).
      real(dp), allocatable :: tooth_stiffness(:)
      !> Derived from it: mean factor of the mesh stiffness [1], and its harmonics of the revolution [1], (order); not allocated:
      !> the factor is 1.
      real(dp) :: factor_mean = 1
      real(dp), allocatable :: factor_cos(:), factor_sin(:)
      !> Derived: revolution of the gear, on a carrier against the carrier, as a multiple of the fundamental.
      integer :: order = 1
   end type gear_error_type

contains

   !> Visits the variables of the errors of a gear.
   subroutine visit_gear_error(error, gear, v)
      !> The errors; the visitor may change them.
      type(gear_error_type), intent(inout) :: error
      !> 1: the driving gear, 2: the driven gear.
      integer, intent(in) :: gear
      !> Reads, checks, sets or lists each variable.
      class(visitor_type), intent(inout) :: v
      character(:), allocatable :: which
      logical :: given

      which = trim(gear_words(gear))
      call v%on_list(row(which//'_pitch_error', 'm', meaning('pitch_error', 'cumulative pitch errors of the driving gear, one a &
                         &tooth in the order in which the teeth engage, along the line of action; positive: towards the mate. &
                         &Every mesh must have teeth'), least=-1.0_dp, most=1.0_dp), error%pitch)
      call v%on_list(row(which//'_tooth_stiffness', '', meaning('tooth_stiffness', 'stiffness of each tooth of the driving gear &
                         &over that of a sound tooth, in the order of the pitch errors: 0.7 of a cracked tooth, 0 of a missing &
                         &one. A factor of the mesh stiffness, which a cosine leads from tooth to tooth'), least=0.0_dp, &
                         most=10.0_dp), error%tooth_stiffness)
      given = .not. abs(error%runout) <= 0
      call v%on_real(row(which//'_runout', 'm', meaning('runout', 'amplitude of the error by eccentricity of the driving gear, &
                         &along the line of action, once a revolution'), least=0.0_dp, most=1.0_dp), error%runout, given)
      given = .not. abs(error%runout_phase) <= 0
      call v%on_real(row(which//'_runout_phase', 'rad', meaning('runout_phase', 'angle of the driving gear at which its runout is &
                         &largest, from the beginning of the first mesh cycle')), error%runout_phase, given)
      call v%on_list(row(which//'_error_cos', 'm', meaning('error_cos', 'cosine amplitudes of the error of the driving gear, &
                         &orders 1, 2, ... of its revolution, on a carrier against it; they add to pitch errors and runout'), &
                         least=-1.0_dp, most=1.0_dp), error%cosine)
      call v%on_list(row(which//'_error_sin', 'm', 'sine amplitudes, orders 1, 2, ...', least=-1.0_dp, most=1.0_dp), error%sine)

   contains

      !> Meaning of a variable of the driving gear; the variable of the driven gear is alike.
      pure function meaning(name, words)
         character(*), intent(in) :: name, words
         character(max(len(words), len(name) + 40)) :: meaning

         meaning = words
         if (gear == 2) meaning = 'as driving_'//name//', of the driven gear'
      end function meaning

   end subroutine visit_gear_error

   !> Whether a gear has errors.
   elemental logical function has_gear_error(error) result(has)
      !> Errors of a gear.
      type(gear_error_type), intent(in) :: error

      has = error%runout > 0
      if (allocated(error%pitch)) has = has .or. size(error%pitch) > 0
      if (allocated(error%cosine)) has = has .or. size(error%cosine) > 0
      if (allocated(error%sine)) has = has .or. size(error%sine) > 0
      has = has .or. has_tooth_factors(error)
   end function has_gear_error

   !> Whether the stiffness differs from tooth to tooth.
   elemental logical function has_tooth_factors(error) result(has)
      !> Errors of a gear.
      type(gear_error_type), intent(in) :: error

      has = allocated(error%factor_cos)
      if (allocated(error%tooth_stiffness)) has = has .or. size(error%tooth_stiffness) > 0
   end function has_tooth_factors

   !> Name of the first variable that is given.
   pure function first_variable(error, gear) result(name)
      !> Errors of a gear that has them.
      type(gear_error_type), intent(in) :: error
      !> 1: the driving gear, 2: the driven gear.
      integer, intent(in) :: gear
      character(24) :: name

      name = 'error_sin'
      if (has_tooth_factors(error)) name = 'tooth_stiffness'
      if (allocated(error%cosine)) then
         if (size(error%cosine) > 0) name = 'error_cos'
      end if
      if (error%runout > 0) name = 'runout'
      if (allocated(error%pitch)) then
         if (size(error%pitch) > 0) name = 'pitch_error'
      end if
      name = trim(gear_words(gear))//'_'//name
   end function first_variable

   !> Replaces what is given of each tooth, and runout, by harmonics: tooth j has its pitch error at the beginning of mesh cycle j
   !> of the revolution.
   pure subroutine make_plain(error, teeth, phase, middle, contact_ratio, overlap_ratio, cycle_harmonics, mean)
      !> Errors of a gear as given; gets amplitudes alone.
      type(gear_error_type), intent(inout) :: error
      !> Number of teeth of the gear, which may still be out of range.
      real(dp), intent(in) :: teeth
      !> Lag of the mesh [rad of the mesh cycle].
      real(dp), intent(in) :: phase
      !> Middle of the contact of the first tooth [mesh cycles].
      real(dp), intent(in) :: middle
      !> Transverse contact ratio and overlap ratio over which pitch errors as steps are smoothed [1], 0: a polynomial joins them.
      real(dp), intent(in) :: contact_ratio, overlap_ratio
      !> Harmonics of the mesh cycle up to which steps are taken.
      integer, intent(in) :: cycle_harmonics
      !> Mean of the pitch errors [m].
      real(dp), intent(out) :: mean
      real(dp), allocatable :: cosine(:), sine(:)

      mean = 0
      if (.not. has_gear_error(error)) return
      allocate (cosine(0), sine(0))
      if (allocated(error%tooth_stiffness)) then
         if (size(error%tooth_stiffness) > 0) call window_harmonics(error%tooth_stiffness, &
            blend(2*size(error%tooth_stiffness), real(size(error%tooth_stiffness), dp)), error%factor_mean, error%factor_cos, &
            error%factor_sin)
         if (allocated(error%factor_cos)) call delay((phase + 2*pi*middle)/teeth, error%factor_cos, error%factor_sin)
         deallocate (error%tooth_stiffness)
      end if
      if (allocated(error%pitch)) then
         associate (n => size(error%pitch))
            if (n > 0 .and. contact_ratio > 0) then
               call window_harmonics(error%pitch, step(cycle_harmonics*n, real(n, dp), contact_ratio, overlap_ratio), mean, &
                                     cosine, sine)
               call delay(2*pi*middle/teeth, cosine, sine)
            else if (n > 0) then
               call table_harmonics(error%pitch, mean, cosine, sine)
            end if
         end associate
         deallocate (error%pitch)
      end if
      if (abs(error%runout) > 0) then
         call add([error%runout*cos(error%runout_phase)], cosine)
         call add([error%runout*sin(error%runout_phase)], sine)
         error%runout = 0
         error%runout_phase = 0
      end if
      if (allocated(error%cosine)) call add(error%cosine, cosine)
      if (allocated(error%sine)) call add(error%sine, sine)
      call move_alloc(cosine, error%cosine)
      call move_alloc(sine, error%sine)
      if (abs(phase) > 0) call delay(phase/teeth, error%cosine, error%sine)
   end subroutine make_plain

   !> Fourier transform of the window cos(pi x/2)^2, |x| < 1 mesh cycle, at the harmonics 1, 2, ... of a revolution of so many
   !> cycles [1]. The windows of all teeth add up to 1.
   pure function blend(highest, teeth) result(transform)
      integer, intent(in) :: highest
      real(dp), intent(in) :: teeth
      real(dp) :: transform(highest), x
      integer :: h

      do h = 1, highest
         x = h/teeth
         transform(h) = 0.5_dp
         if (abs(2*x - 1) > 1e-9_dp) transform(h) = sinc(2*x)/(1 - 4*x**2)
      end do
   end function blend

   !> Fourier transform of a step of one mesh cycle, smoothed over the share contact_ratio - 1 of it, in which two teeth bear, and
   !> averaged over the face, whose ends are overlap_ratio cycles apart.
   pure function step(highest, teeth, contact_ratio, overlap_ratio) result(transform)
      integer, intent(in) :: highest
      real(dp), intent(in) :: teeth, contact_ratio, overlap_ratio
      real(dp) :: transform(highest)
      integer :: h

      transform = [(sinc(h/teeth)*sinc((contact_ratio - 1)*h/teeth)*sinc(overlap_ratio*h/teeth), h=1, highest)]
   end function step

   !> sin(pi x)/(pi x).
   elemental real(dp) function sinc(x)
      real(dp), intent(in) :: x

      sinc = 1
      if (abs(x) > 1e-9_dp) sinc = sin(pi*x)/(pi*x)
   end function sinc

   !> Adds amplitudes to a list, which may be shorter.
   pure subroutine add(amplitude, list)
      real(dp), intent(in) :: amplitude(:)
      real(dp), allocatable, intent(inout) :: list(:)
      integer :: i

      list = [list, [(0.0_dp, i=size(list) + 1, size(amplitude))]]
      list(:size(amplitude)) = list(:size(amplitude)) + amplitude
   end subroutine add

end module geartrain_train_gear_error
