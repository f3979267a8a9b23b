!> Motions at which the curve of a special point ends, or beyond which it is not followed.
module geartrain_curves_locus_limits
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_words, only: lambda, operator(//), words_type
   use geartrain_curves_locus_walls, only: floats
   use geartrain_exact_augmented_point, only: augmented_point_type
   use geartrain_exact_augmented_system, only: augmented_system_type
   use geartrain_network_units, only: largest_drive, largest_load
   implicit none (type, external)
   private
   public :: limits_type

   !> Loads and errors, over those at the beginning of the curve, below which the motion vanishes with them.
   real(dp), parameter :: vanishing = 1e-3_dp
   !> Largest Lambda over the one at the beginning, and its inverse the least: the integration of slow motions takes ever longer.
   real(dp), parameter :: widest = 20
   !> Largest displacement, over the larger of half the backlash and the static deflection: there are curves without an end along
   !> which the motion grows towards a parametric resonance of the linear train.
   real(dp), parameter :: largest = 30

   type :: limits_type
      !> At the beginning of the curve: Lambda, largest drive and load of a mesh [1].
      real(dp), private :: frequency_ratio = 0, drive = 0, load = 0
   contains
      procedure :: begin
      procedure :: forbids
      procedure :: ends_at
      procedure :: vanishes
   end type limits_type

contains

   !> Takes the beginning of the curve.
   subroutine begin(self, augmented, first)
      class(limits_type), intent(inout) :: self
      !> The system, with the train of the first point.
      type(augmented_system_type), intent(in) :: augmented
      !> The first point.
      type(augmented_point_type), intent(in) :: first

      self%frequency_ratio = first%frequency_ratio
      self%drive = largest_drive(augmented%system)
      self%load = largest_load(augmented%system)
   end subroutine begin

   !> Why a point is no special point although a multiplier has the value of one: any motion nearby has it. Blank: it is one.
   subroutine forbids(self, augmented, point, why)
      class(limits_type), intent(in) :: self
      !> The system, with the train of the point.
      type(augmented_system_type), intent(inout) :: augmented
      !> A point of the curve.
      type(augmented_point_type), intent(in) :: point
      !> The words.
      character(*), intent(out) :: why

      why = ''
      if (point%events > 0) return
      if (floats(augmented, point, self%load)) then
         why = 'a mesh floats in its gap'
      else if (augmented%mesh == 0 .and. (augmented%kind == 'fold' .or. augmented%period > 1)) then
         ! Without contact events the equation of motion is linear: a motion of a longer period than that of the stiffness, or a
         ! fold, is one of a family of all amplitudes.
         why = 'meets linear motions, of any amplitude,'
      end if
   end subroutine forbids

   !> Why the curve is not followed beyond a point; not allocated: it is.
   subroutine ends_at(self, augmented, point, why)
      class(limits_type), intent(in) :: self
      !> The system, with the train of the point.
      type(augmented_system_type), intent(in) :: augmented
      !> A point of the curve.
      type(augmented_point_type), intent(in) :: point
      !> The words.
      type(words_type), allocatable, intent(out) :: why

      if (maxval(abs(point%states(:augmented%system%displacements, :))) > largest*augmented%metric%units%length) then
         why = 'beyond the amplitude limit '//text(largest)//' at '//lambda(point%frequency_ratio)
      else if (.not. abs(log(point%frequency_ratio/self%frequency_ratio)) < log(widest)) then
         why = 'far from where it began, at '//lambda(point%frequency_ratio)
      else if (self%vanishes(augmented)) then
         why = 'the motion vanishes with all that excites it, at '//lambda(point%frequency_ratio)
      end if
   end subroutine ends_at

   !> Whether all that excites the train has become very small.
   pure logical function vanishes(self, augmented)
      class(limits_type), intent(in) :: self
      !> The system, with a train of the curve.
      type(augmented_system_type), intent(in) :: augmented

      vanishes = largest_drive(augmented%system) < vanishing*self%drive
   end function vanishes

end module geartrain_curves_locus_limits
