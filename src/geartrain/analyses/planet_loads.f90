!> What a report says of the planets of planetary sets: how unevenly they share the load, and which motions
!> differ by a turn of the planets alone.
module geartrain_analyses_planet_loads
   use geartrain_balance_motion, only: motion_type
   use geartrain_balance_planet_orbits, only: number_orbits
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: counted, significant, text
   use geartrain_base_sheet, only: in_result, sheet_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_load_sharing, only: find_sharing, mesh_load_factor, sharing_type
   use geartrain_readings_frequency_text, only: frequency_text_type
   use geartrain_train_planetary_sets, only: find_sets, planetary_set_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: say_orbits, say_sharing

contains

   !> Adds a sentence where some of the motions are one but for a turn of the planets of a symmetric set.
   subroutine say_orbits(train, motions, sheet)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> Motions at one Lambda.
      type(motion_type), intent(in) :: motions(:)
      type(sheet_type), intent(inout) :: sheet
      integer :: orbit(size(motions))

      call number_orbits(train, motions, orbit)
      if (size(motions) == 0 .or. maxval([0, orbit]) == size(motions)) return
      call sheet%say(in_result, 'Up to a turn of the planets of symmetric sets these are '// &
                     counted(maxval(orbit), 'motion', 'motions')//'.')
   end subroutine say_orbits

   !> Adds a sentence on each planetary set: largest mesh load factor, and largest force of a planet over an even share.
   subroutine say_sharing(share, share_maximum, at, counts, train, told, sheet)
      !> Mean and largest share of each planet [1], NaN of a set without load, (planet, motion).
      real(dp), intent(in) :: share(:, :), share_maximum(:, :)
      !> Lambda, or the parameter, of each motion, (motion).
      real(dp), intent(in) :: at(:)
      !> Whether a motion counts, (motion).
      logical, intent(in) :: counts(:)
      !> The train as given.
      type(train_type), intent(in) :: train
      !> How frequencies are stated.
      type(frequency_text_type), intent(in) :: told
      type(sheet_type), intent(inout) :: sheet
      type(train_type) :: plain
      type(sharing_type) :: sharing
      type(planetary_set_type), allocatable :: sets(:)
      character(:), allocatable :: words, place
      real(dp) :: factor(size(at)), peak(size(at))
      integer, allocatable :: own(:)
      integer :: i, j, k, n

      call plain_train(train, plain)
      call find_sharing(plain, sharing)
      if (size(sharing%mesh) /= size(share, 1)) return
      call find_sets(plain, sets)
      do i = 1, size(sets)
         own = pack([(n, n=1, size(sharing%set))], sharing%set == i)
         if (size(own) < 2) cycle
         factor = -huge(factor)
         peak = -huge(peak)
         do j = 1, size(at)
            ! A set without load has no shares.
            if (.not. counts(j) .or. .not. all(abs(share(own, j)) < huge(1.0_dp))) cycle
            factor(j) = mesh_load_factor(share(own, j))
            peak(j) = mesh_load_factor(share_maximum(own, j))
         end do
         j = maxloc(factor, 1)
         k = maxloc(peak, 1)
         if (.not. factor(j) > 0) cycle
         call told%with_unit(told%number(at(j)), place)
         words = 'Planets of '//trim(sets(i)%name)//': mesh load factor K_gamma (largest mean load over an even share) at most '// &
                 significant(factor(j))
         if (factor(j) > 1.0005_dp) words = words//', of planet '//text(maxloc(share(own, j), 1))//' at '//place
         call told%with_unit(told%number(at(k)), place)
         words = words//'; largest force of a planet '//significant(peak(k))//' even shares, of planet '// &
                 text(maxloc(share_maximum(own, k), 1))//' at '//place
         call sheet%say(in_result, words//'.')
      end do
   end subroutine say_sharing

end module geartrain_analyses_planet_loads
