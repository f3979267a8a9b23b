!> The group /integration of a results file: the motions of a sweep.
module geartrain_results_integration
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use geartrain_base_kinds, only: dp
   use geartrain_motion_integration_settings, only: sweep_type
   use geartrain_motion_mesh_load, only: mesh_load_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_results_labels, only: about_coefficients, about_multipliers, about_rms, about_stable, about_true_ac_rms, &
      about_undecided, as_parts, coefficient_labels, frequency_description
   use geartrain_results_mesh_load, only: write_mesh_loads
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_integration, write_motions

   character(*), parameter :: home = '/integration'
   character(*), parameter :: about_exponent = 'largest Lyapunov exponent per unit of time (1/characteristic_frequency): &
      &positive = chaos, about 0 = quasi-periodic; of a periodic motion the rate at which disturbances decay'
   character(*), parameter :: about_kind = 'periodic; where no period was found chaotic, quasi-periodic, still settling (or of a &
      &longer period than 16), undecided, or unbounded (given up, without figures)'

contains

   !> Writes the motions done: those at the end without a frequency are still to come.
   subroutine write_integration(store, sweep)
      type(store_type), intent(inout) :: store
      type(sweep_type), intent(in) :: sweep
      integer :: n

      n = 0
      if (allocated(sweep%motions)) n = count(sweep%motions%frequency > 0)
      call store%group(home)
      call store%attribute(home, 'description', 'time integration to steady motion over a range of frequencies, each begun &
         &with the state that the one before ended in')
      if (n > 0) call store%attribute(home, 'coordinates', 'frequency direction')
      if (allocated(sweep%ended)) then
         call store%attribute(home, 'ended', sweep%ended)
      else
         call store%attribute(home, 'ended', 'not yet: these are the points so far')
      end if
      call store%attribute(home, 'complete', merge(1, 0, sweep%complete))
      call store%axis(home//'/point', n, 'point, in the order visited')
      if (n == 0) return
      call write_motions(store, home, 'point', sweep%motions(:n))
      call store%put(home//'/direction', sweep%direction(:n), ['point'], '', 'up or down: the way in which the sweep went')
   end subroutine write_integration

   !> What is known of each motion, along the dimension `along`, whose axis stands already.
   subroutine write_motions(store, home, along, motions)
      type(store_type), intent(inout) :: store
      !> Path of the group.
      character(*), intent(in) :: home, along
      type(motion_type), intent(in) :: motions(:)
      real(dp), allocatable :: values(:, :, :), coefficients(:, :, :)
      character(11) :: dimensions(3)
      type(mesh_load_type), allocatable :: loads(:, :)
      logical :: known(size(motions))
      integer :: i, n, meshes, length

      dimensions(1) = along
      dimensions(2:) = ['mesh       ', 'coefficient']
      n = size(motions)
      meshes = 0
      length = 0
      do i = 1, n
         if (.not. allocated(motions(i)%coefficients)) cycle
         meshes = size(motions(i)%rms)
         length = max(length, size(motions(i)%coefficients, 1))
      end do
      ! A motion that ran away has no figures.
      allocate (values(meshes, n, 4), coefficients(length, meshes, n), source=ieee_value(1.0_dp, ieee_quiet_nan))
      allocate (loads(meshes, n))
      known = .false.
      do i = 1, n
         if (.not. allocated(motions(i)%coefficients)) cycle
         values(:, i, 1) = motions(i)%rms
         values(:, i, 2) = motions(i)%mean
         values(:, i, 3) = motions(i)%minimum
         values(:, i, 4) = motions(i)%maximum
         known(i) = allocated(motions(i)%mesh_load)
         if (known(i)) loads(:, i) = motions(i)%mesh_load
         coefficients(:size(motions(i)%coefficients, 1), :, i) = motions(i)%coefficients
      end do
      call store%axis(home//'/mesh', meshes, 'mesh, in the order of the train')
      call store%axis(home//'/coefficient', coefficient_labels(length), &
                      'order of the coefficient in multiples of Lambda/period')
      call store%put(home//'/frequency', (motions%frequency), [along], '1', frequency_description)
      call store%put(home//'/period', (motions%period), [along], '1', &
                     'period of the motion in fundamental mesh periods; 0 = none found, the figures are then of the last &
                     &16 mesh periods')
      call store%put(home//'/rms', values(:, :, 1), dimensions(:2), '1', about_rms)
      call store%put(home//'/true_ac_rms', values(:, :, 1)/sqrt(2.0_dp), dimensions(:2), '1', about_true_ac_rms)
      call store%put(home//'/mean', values(:, :, 2), dimensions(:2), '1', 'mean mesh displacement / characteristic_length')
      call store%put(home//'/minimum', values(:, :, 3), dimensions(:2), '1', 'smallest mesh displacement / characteristic_length')
      call store%put(home//'/maximum', values(:, :, 4), dimensions(:2), '1', 'largest mesh displacement / characteristic_length')
      call write_mesh_loads(store, home, along, loads, known)
      call store%put(home//'/coefficients', coefficients, dimensions, '1', &
                     about_coefficients)
      call store%put(home//'/kind', motions%kind, [along], '', about_kind)
      if (any(has_exponent(motions))) then
         call store%put(home//'/lyapunov_exponent', [(exponent_of(motions(i)), i=1, n)], [along], '1', about_exponent)
         call store%put(home//'/lyapunov_error', (motions%lyapunov_error), [along], '1', &
                        'uncertainty of lyapunov_exponent at 95 %; 0 for a periodic motion')
      end if
      if (any(motions%floating)) call store%put(home//'/floating', (motions%floating), [along], 'some mesh bears on neither &
         &flank and no mean torque holds it: its mean position in the gap is not unique, any other would do')
      if (any(has_multipliers(motions))) call write_stability(store, home, along, motions)
   end subroutine write_motions

   subroutine write_stability(store, home, along, motions)
      type(store_type), intent(inout) :: store
      character(*), intent(in) :: home, along
      type(motion_type), intent(in) :: motions(:)
      complex(dp), allocatable :: multipliers(:, :)
      character(8) :: dimensions(3)
      real(dp) :: nan
      integer :: i, states

      dimensions(1) = along
      dimensions(2:) = ['state   ', 'complex ']
      states = 0
      do i = 1, size(motions)
         if (allocated(motions(i)%multipliers)) states = size(motions(i)%multipliers)
      end do
      nan = ieee_value(1.0_dp, ieee_quiet_nan)
      allocate (multipliers(states, size(motions)), source=cmplx(nan, nan, dp))
      do i = 1, size(motions)
         if (allocated(motions(i)%multipliers)) multipliers(:, i) = motions(i)%multipliers
      end do
      call store%put(home//'/stable', (motions%stable), [along], about_stable//'; 0 also where no period was found')
      call store%put(home//'/undecided', (motions%undecided), [along], about_undecided)
      call store%axis(home//'/state', states, 'number of the multiplier, in no order that holds between '//along//'s')
      call store%axis(home//'/complex', ['real     ', 'imaginary'], 'part of a complex number')
      call store%put(home//'/multipliers', as_parts(multipliers), dimensions, '1', &
                     about_multipliers//'; NaN where no period was found')
   end subroutine write_stability

   elemental logical function has_exponent(motion)
      type(motion_type), intent(in) :: motion

      has_exponent = allocated(motion%lyapunov_exponent)
   end function has_exponent

   real(dp) function exponent_of(motion)
      type(motion_type), intent(in) :: motion

      exponent_of = ieee_value(1.0_dp, ieee_quiet_nan)
      if (allocated(motion%lyapunov_exponent)) exponent_of = motion%lyapunov_exponent
   end function exponent_of

   elemental logical function has_multipliers(motion)
      type(motion_type), intent(in) :: motion

      has_multipliers = allocated(motion%multipliers)
   end function has_multipliers

end module geartrain_results_integration
