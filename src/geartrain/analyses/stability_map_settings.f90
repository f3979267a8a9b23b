!> The variables of &stability_map and what a stability map (stability chart, of a linear train an Ince-Strutt diagram) gives.
module geartrain_analyses_stability_map_settings
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: map_row_type, stability_map_settings_type, stability_map_type

   !> from, to, parameter_from and parameter_to are `start`, `stop`, `parameter_start` and `parameter_stop`.
   type :: stability_map_settings_type
      !> Range of Lambda and how many there are in it, both ends included.
      real(dp) :: start = 0, stop = 0
      integer :: points = 200
      !> What varies from row to row: 'stiffness_variation', 'mesh_damping_ratio', 'input_torque' or 'half_backlash'.
      character(24) :: parameter = 'stiffness_variation'
      real(dp) :: parameter_start = 0, parameter_stop = 0
      integer :: parameter_points = 200
      !> The train without backlash, all teeth in contact.
      logical :: linear = .false.
      !> Of the branch of each row, as in &response.
      integer :: harmonics = 6
   end type stability_map_settings_type

   !> One row: as in stability_map_type, without the last index. Not allocated where it is not done.
   type :: map_row_type
      integer, allocatable :: motions(:), stable_motions(:)
      complex(dp), allocatable :: multiplier(:)
      real(dp), allocatable :: rms(:, :)
      !> The branch got from one end to the other.
      logical :: whole = .true.
   end type map_row_type

   !> The grid over Lambda (first index) and the parameter (second), of the rows that were done.
   type :: stability_map_type
      !> 'stiffness_variation', ..., and its unit.
      character(:), allocatable :: name, unit
      logical :: linear = .false.
      !> Lambda, (point); values of the parameter, (row).
      real(dp), allocatable :: frequency_ratio(:), parameter(:)
      !> Motions of the mesh period and how many of them are stable, (point, row).
      integer, allocatable :: motions(:, :), stable_motions(:, :)
      !> Floquet multiplier of largest magnitude of the motion that has it smallest, (point, row); NaN where there is no motion.
      complex(dp), allocatable :: multiplier(:, :)
      !> Largest rms of the stable motions, see motion_type, (mesh, point, row); NaN where there is none. Not of the linear train.
      real(dp), allocatable :: rms(:, :, :)
      !> Rows done, and among them those whose branch got from one end to the other, (row).
      logical, allocatable :: done(:), whole(:)
      !> While the map is under way the rows by themselves, so that it takes memory as it grows: `gather` makes the arrays of them.
      type(map_row_type), allocatable :: rows(:)
      !> 'all rows done', or what is missing.
      character(:), allocatable :: ended
      logical :: complete = .false.
   contains
      procedure :: gather
   end type stability_map_type

contains

   !> Puts the rows done together, without those that are not, and gives their memory back one by one.
   subroutine gather(self)
      class(stability_map_type), intent(inout) :: self
      integer :: i, n

      n = count(self%done)
      associate (points => size(self%frequency_ratio))
         allocate (self%motions(points, n), self%stable_motions(points, n), self%multiplier(points, n))
         do i = 1, size(self%rows)
            if (self%done(i) .and. .not. self%linear) then
               allocate (self%rms(size(self%rows(i)%rms, 1), points, n))
               exit
            end if
         end do
         if (.not. (self%linear .or. allocated(self%rms))) allocate (self%rms(0, points, 0))
      end associate
      self%parameter = pack(self%parameter, self%done)
      self%whole = pack(self%whole, self%done)
      n = 0
      do i = 1, size(self%rows)
         if (.not. self%done(i)) cycle
         n = n + 1
         self%motions(:, n) = self%rows(i)%motions
         self%stable_motions(:, n) = self%rows(i)%stable_motions
         self%multiplier(:, n) = self%rows(i)%multiplier
         if (.not. self%linear) self%rms(:, :, n) = self%rows(i)%rms
         deallocate (self%rows(i)%motions, self%rows(i)%stable_motions, self%rows(i)%multiplier)
         if (.not. self%linear) deallocate (self%rows(i)%rms)
      end do
      self%done = pack(self%done, self%done)
      deallocate (self%rows)
   end subroutine gather

end module geartrain_analyses_stability_map_settings
