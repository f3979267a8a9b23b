!> Branches over a parameter of a train, as tests ask for them, and their points against the trains with the values of the points.
module branches_over_parameters
   use fixtures, only: settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, train_type
   use geartrain_continuation_points, only: motion_of
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_units, only: units_of, units_type
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: compare, over

contains

   !> A branch over a parameter.
   function over(tests, train, parameter, from, to, frequency, harmonics) result(branch)
      class(tests_type), intent(inout) :: tests
      type(train_type), intent(in) :: train
      character(*), intent(in) :: parameter
      real(dp), intent(in) :: from, to, frequency
      integer, intent(in) :: harmonics
      type(branch_type) :: branch
      type(response_settings_type) :: settings
      type(error_type), allocatable :: error

      settings = settings_of(from, to, harmonics)
      settings%parameter = parameter
      settings%frequency = frequency
      settings%tolerance = 1e-3_dp
      call response(train, settings, branch, error)
      if (allocated(error)) then
         call tests%is_true(.false., parameter//': '//error%message)
         return
      end if
      if (.not. branch%complete) call tests%is_true(.false., parameter//': '//branch%ended)
   end function over

   !> Every output of a point against the motion of the train with its value, solved at the Lambda of the branch by itself.
   subroutine compare(tests, train, branch, i, name)
      class(tests_type), intent(inout) :: tests
      !> The train with the value of the point.
      type(train_type), intent(in) :: train
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: i
      character(*), intent(in) :: name
      type(branch_type) :: near
      type(motion_type) :: motion
      type(error_type), allocatable :: error
      !> Difference of two solutions of the balance, each converged to 1e-10 of its largest amplitude (corrector.f90), and of
      !> what follows from them, relative [1].
      real(dp), parameter :: solved = 2e-10_dp, same = 1e-9_dp
      !> Error of multipliers (floquet/step_rule.f90).
      real(dp), parameter :: integrated = 1e-9_dp
      type(system_type) :: system
      type(units_type) :: units
      integer :: k, n, r

      motion = motion_of(branch, i)
      motion%frequency_ratio = branch%constant_frequency
      ! A branch that turns within the range has no point at the Lambda of the motion: then the range is narrowed.
      do r = 4, 10, 2
         call response(train, settings_of((1 - 0.1_dp**r)*motion%frequency_ratio, (1 + 0.1_dp**r)*motion%frequency_ratio, &
                                          branch%point_harmonics(i), branch%subharmonic), near, error, seed=motion)
         if (allocated(error)) then
            call tests%is_true(.false., name//': '//error%message)
            return
         end if
         k = 0
         if (near%points > 0) k = minloc(abs(near%frequency_ratio(:near%points) - motion%frequency_ratio), 1)
         if (k == 0) exit
         if (abs(near%frequency_ratio(k) - motion%frequency_ratio) <= same*1e-3_dp*motion%frequency_ratio) exit
      end do
      if (k == 0) then
         call tests%is_true(.false., name//': '//near%ended)
         return
      end if
      ! The point next to it, by which what hangs on Lambda strongly is known: such figures hang on the solution as strongly.
      n = merge(k - 1, k + 1, k == near%points)
      call build_system(train, system)
      units = units_of(system)
      call close('rms', near%rms(:, k), branch%rms(:, i))
      call close('mean', near%mean(:, k), branch%mean(:, i))
      call close('minimum', near%minimum(:, k), branch%minimum(:, i))
      call close('maximum', near%maximum(:, k), branch%maximum(:, i))
      call close('force', near%mesh_load(:, k)%force_maximum, branch%mesh_load(:, i)%force_maximum)
      call close('dynamic factor', near%mesh_load(:, k)%dynamic_factor, branch%mesh_load(:, i)%dynamic_factor)
      call close('separation', near%mesh_load(:, k)%separation, branch%mesh_load(:, i)%separation, &
                 solved*maxval(abs(near%mesh_load(:, n)%separation - near%mesh_load(:, k)%separation)) &
                 *near%frequency_ratio(k)/abs(near%frequency_ratio(n) - near%frequency_ratio(k)))
      call close('shaft torque', near%shaft_torque_mean(:, k), branch%shaft_torque_mean(:, i))
      call close('shaft torque', near%shaft_torque_maximum(:, k), branch%shaft_torque_maximum(:, i))
      call close('half backlash', near%half_backlash, branch%half_backlash_at(:, i))
      call close('multipliers', [maxval(abs(near%multipliers(:, k)))], [maxval(abs(branch%multipliers(:, i)))], &
                 2*integrated*system%excitation_order)
      call tests%is_true(near%stable(k) .eqv. branch%stable(i), name//': stability')

   contains

      subroutine close(what, value, expected, further)
         character(*), intent(in) :: what
         real(dp), intent(in) :: value(:), expected(:)
         !> What the difference may be beyond `same`.
         real(dp), intent(in), optional :: further
         real(dp) :: allowed

         ! The balance is solved to its tolerance in units of the train's displacements, however small the motion.
         allowed = same + 2*solved*units%length/(maxval(abs(expected)) + 1e-3_dp)
         if (present(further)) allowed = allowed + further
         call tests%is_close(maxval(abs(value - expected)/(maxval(abs(expected)) + 1e-3_dp)), 0.0_dp, allowed, name//': '//what)
      end subroutine close

   end subroutine compare

end module branches_over_parameters
