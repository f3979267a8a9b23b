!> Branches over a parameter of a train, as tests ask for them, and their points against the trains with the values of the points.
module branches_over_parameters
   use fixtures, only: settings_of
   use geartrain, only: branch_type, dp, error_type, motion_type, response, response_settings_type, train_type
   use geartrain_network_system, only: build_system, system_type
   use geartrain_network_units, only: units_of, units_type
   use geartrain_trace_points, only: motion_of
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
      if (.not. branch%complete) call tests%is_true(.false., parameter//': '//branch%ended%text)
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
      !> Longest last step of Newton's method over the size of a solution (corrector.f90) [1].
      real(dp), parameter :: last_step = 1e-10_dp
      !> Rounding of what follows from a solution, relative [1].
      real(dp), parameter :: same = 1e-9_dp
      !> Error of multipliers (floquet/step_rule.f90).
      real(dp), parameter :: integrated = 1e-9_dp
      type(system_type) :: system
      type(units_type) :: units
      !> Difference of the displacements from which the figures of the two solutions follow; difference of the displacements of
      !> two neighbouring motions [1].
      real(dp) :: moved, apart
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
         call tests%is_true(.false., name//': '//near%ended%text)
         return
      end if
      call build_system(train, system)
      units = units_of(system)
      ! Contacts, and with them torques and multipliers, are those before the last step of Newton's method.
      associate (u => near%coefficients(:, :, k))
         moved = 2*last_step*(2*units%length + sqrt(sum((abs(u(1, :)) - system%half_backlash)**2) + 0.5_dp*sum(u(2:, :)**2)))
      end associate
      ! The neighbouring motion: an error of a solution lies along the branch where it is large, as near a fold.
      n = merge(k - 1, k + 1, k == near%points)
      apart = max(tiny(apart), size_of(near%coefficients(:, :, n) - near%coefficients(:, :, k)))
      call close('rms', near%rms(:, k), branch%rms(:, i))
      call close('mean', near%mean(:, k), branch%mean(:, i))
      call close('minimum', near%minimum(:, k), branch%minimum(:, i))
      call close('maximum', near%maximum(:, k), branch%maximum(:, i))
      call close('force', near%mesh_load(:, k)%force_maximum, branch%mesh_load(:, i)%force_maximum, &
                 maxval(system%stiffness)*system%characteristic_length)
      ! The dynamic factor is the force over the static one.
      call close('dynamic factor', near%mesh_load(:, k)%dynamic_factor, branch%mesh_load(:, i)%dynamic_factor, &
                 maxval(system%stiffness)*system%characteristic_length*maxval(abs(near%mesh_load(:, k)%dynamic_factor)/ &
                                                                              near%mesh_load(:, k)%force_maximum, &
                                                                              near%mesh_load(:, k)%force_maximum > 0))
      call close('separation', near%mesh_load(:, k)%separation, branch%mesh_load(:, i)%separation, &
                 maxval(abs(near%mesh_load(:, n)%separation - near%mesh_load(:, k)%separation))/apart)
      call close('shaft torque', near%shaft_torque_mean(:, k), branch%shaft_torque_mean(:, i), torque_of_displacement(system))
      call close('shaft torque', near%shaft_torque_maximum(:, k), branch%shaft_torque_maximum(:, i), &
                 torque_of_displacement(system))
      call close('half backlash', near%half_backlash, branch%half_backlash_at(:, i))
      call close('multipliers', [maxval(abs(near%multipliers(:, k)))], [maxval(abs(branch%multipliers(:, i)))], &
                 abs(maxval(abs(near%multipliers(:, n))) - maxval(abs(near%multipliers(:, k))))/apart, &
                 2*integrated*system%excitation_order)
      call tests%is_true(near%stable(k) .eqv. branch%stable(i), name//': stability')

   contains

      subroutine close(what, value, expected, per_displacement, further)
         character(*), intent(in) :: what
         real(dp), intent(in) :: value(:), expected(:)
         !> Change of the values per change of the displacements; absent: 1.
         real(dp), intent(in), optional :: per_displacement
         !> What the relative difference may be beside rounding and the difference of the displacements [1].
         real(dp), intent(in), optional :: further
         real(dp) :: allowed, sensitivity

         sensitivity = 1
         if (present(per_displacement)) sensitivity = per_displacement
         allowed = same + moved*sensitivity/(maxval(abs(expected)) + 1e-3_dp)
         if (present(further)) allowed = allowed + further
         call tests%is_close(maxval(abs(value - expected)/(maxval(abs(expected)) + 1e-3_dp)), 0.0_dp, allowed, name//': '//what)
      end subroutine close

   end subroutine compare

   !> Length of a change of coefficients in the metric of a branch, whose unit is 1 here [1].
   pure real(dp) function size_of(u)
      real(dp), intent(in) :: u(:, :)

      size_of = sqrt(0.5_dp*(sum(u**2) + sum(u(1, :)**2)))
   end function size_of

   !> Largest torque of a shaft per displacement of its elements over the characteristic length [N m].
   pure real(dp) function torque_of_displacement(system) result(torque)
      type(system_type), intent(in) :: system
      integer :: s

      torque = 0
      associate (paths => system%torque_paths)
         do s = 1, paths%rows
            associate (first => paths%first(s), last => paths%first(s + 1) - 1)
               torque = max(torque, sum(abs(paths%gain(first:last))*system%stiffness(paths%element(first:last)))* &
                            system%characteristic_length)
            end associate
         end do
      end associate
   end function torque_of_displacement

end module branches_over_parameters
