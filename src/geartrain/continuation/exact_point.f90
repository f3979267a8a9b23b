!> Special points and contact onsets of the exact motion: where they are, the motion there, and which multipliers cross.
module geartrain_continuation_exact_point
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_repetition, only: repeat_motion
   use geartrain_base_error, only: error_type, fatal, status_ended_early
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_continuation_branch, only: branch_type, special_point_type
   use geartrain_continuation_decided, only: nearest_decided
   use geartrain_continuation_exact_search, only: ends_of, find_exact
   use geartrain_continuation_orbit_corrector, only: orbit_corrector_type, orbit_type
   use geartrain_continuation_orbit_tests, only: back_contact, critical, is_onset, outside, separation
   use geartrain_flow_orbit, only: measure, stored_harmonics
   use geartrain_model_check, only: check_train
   use geartrain_model_system, only: build_system, system_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: exact_point_type, find_exact_point, onsets_of

   !> Distance from a special point to the orbits on either side whose multipliers are counted, in the units of units_type.
   real(dp), parameter :: beside = 1e-4_dp

   type :: exact_point_type
      !> Kind as in special_point_type; number of the mesh of a contact onset, else 0.
      character(16) :: kind = ''
      integer :: mesh = 0
      !> Lambda [1].
      real(dp) :: frequency_ratio = 0
      !> The motion with its state, multipliers and figures.
      type(motion_type) :: motion
      !> Number of multipliers outside the unit circle just before and just after it along the branch; -1: not known.
      integer :: before = -1, after = -1
   end type exact_point_type

contains

   !> The contact onsets of a branch: its contact edges as special points.
   subroutine onsets_of(branch, onsets)
      !> A branch whose contact edges are located.
      type(branch_type), intent(in) :: branch
      !> The onsets, in the order along the branch.
      type(special_point_type), allocatable, intent(out) :: onsets(:)
      integer :: i, n

      n = 0
      if (allocated(branch%contact_edges)) n = size(branch%contact_edges)
      allocate (onsets(n))
      do i = 1, n
         associate (edge => branch%contact_edges(i))
            onsets(i)%kind = merge(back_contact, separation//'  ', edge%back)
            onsets(i)%mesh = edge%mesh
            onsets(i)%point = edge%point
            onsets(i)%frequency_ratio = edge%frequency_ratio
            onsets(i)%rms = branch%rms(:, edge%point)
         end associate
      end do
   end subroutine onsets_of

   !> Finds the special point of the exact motion that is nearest to a special point, or to a contact onset, of a branch.
   subroutine find_exact_point(train, branch, number, special, exact, error)
      !> The train.
      type(train_type), intent(in) :: train
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> Number of the special point; 0: a contact onset.
      integer, intent(in) :: number
      !> The special point or the contact onset.
      type(special_point_type), intent(in) :: special
      !> The special point of the exact motion.
      type(exact_point_type), intent(out) :: exact
      !> Bad input, or there is none near it (status_ended_early).
      type(error_type), allocatable, intent(out) :: error
      type(system_type) :: system
      type(orbit_corrector_type) :: corrector
      type(orbit_type) :: orbit
      logical :: found

      call check_train(train, error)
      if (allocated(error)) return
      call build_system(train, system)
      call corrector%setup(system, branch%subharmonic)
      call find_exact(corrector, branch, special, change_at(branch, number, special), orbit, found)
      if (train%interrupt%raised()) found = .false.
      if (.not. found) then
         call fatal(error, 'exact: no '//trim(special%kind)//' of the exact motion was found near Lambda = ' &
                    //text(special%frequency_ratio), status_ended_early)
         return
      end if
      exact%kind = special%kind
      exact%mesh = special%mesh
      call take_orbit(corrector, orbit, exact)
   end subroutine find_exact_point

   !> Change of the number that `critical` counts at a special point of a branch; 0: not known.
   integer function change_at(branch, number, special) result(change)
      type(branch_type), intent(in) :: branch
      integer, intent(in) :: number
      type(special_point_type), intent(in) :: special
      integer :: sides(2), ends(2)

      change = 0
      if (is_onset(special%kind) .or. .not. allocated(branch%stable)) return
      ends = ends_of(branch, special)
      sides = [nearest_decided(branch, number, -1), nearest_decided(branch, number, 1)]
      sides = merge(sides, ends, sides > 0)
      change = critical(special%kind, branch%multipliers(:, sides(2))) - critical(special%kind, branch%multipliers(:, sides(1)))
   end function change_at

   !> Takes the motion from the orbit at a special point, and counts multipliers beside it.
   subroutine take_orbit(corrector, orbit, exact)
      type(orbit_corrector_type), intent(inout) :: corrector
      type(orbit_type), intent(in) :: orbit
      type(exact_point_type), intent(inout) :: exact
      type(orbit_type) :: side
      logical :: found
      integer :: harmonics

      associate (motion => exact%motion)
         motion%frequency_ratio = orbit%frequency_ratio
         motion%period = corrector%period
         motion%state = orbit%states(:, 1)
         harmonics = stored_harmonics(corrector%system)
         call measure(corrector%system, harmonics, motion)
         if (corrector%times > 1) call repeat_motion(corrector%times, corrector%times*harmonics, motion)
         motion%multipliers = orbit%multipliers
         motion%undecided = .true.
         motion%error_estimate = 0
         exact%frequency_ratio = motion%frequency_ratio
      end associate
      call corrector%advance(orbit, -beside, side, found)
      if (found) exact%before = outside(side%multipliers)
      call corrector%advance(orbit, beside, side, found)
      if (found) exact%after = outside(side%multipliers)
   end subroutine take_orbit

end module geartrain_continuation_exact_point
