!> Writes points into a branch: room that grows, what is derived from the coefficients, stability where it was asked for.
module geartrain_branch_recorder
   use geartrain_base_fftw, only: transform_type
   use geartrain_base_kinds, only: dp
   use geartrain_branch_branch, only: branch_type
   use geartrain_branch_path, only: place_type
   use geartrain_branch_verdict, only: judge, verdict_type
   use geartrain_motion_balance, only: balance_type
   use geartrain_motion_mesh_load, only: force_reader_type
   use geartrain_motion_trigonometric, only: extremes, fine_samples, rms
   use geartrain_motion_truncation, only: truncation_type
   use geartrain_stability_monodromy, only: monodromy_type
   implicit none (type, external)
   private
   public :: recorder_type

   type :: recorder_type
      logical :: stability = .false.
      type(monodromy_type) :: monodromy
      complex(dp), allocatable :: multipliers(:)
      type(transform_type), private :: transform
      type(force_reader_type), private :: reader
      integer, allocatable, private :: harmonic(:)
   contains
      procedure :: setup
      procedure :: add
      procedure :: finish
   end type recorder_type

contains

   !> Empties the branch and prepares it for points of this balance.
   subroutine setup(self, balance, stability, branch)
      class(recorder_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      logical, intent(in) :: stability
      type(branch_type), intent(inout), target :: branch

      self%stability = stability
      branch%points = 0
      branch%meshes = balance%system%meshes
      branch%backlash = balance%system%backlash
      branch%subharmonic = balance%eta
      branch%harmonics = balance%highest
      allocate (branch%special_points(0))
      if (stability) then
         call self%monodromy%setup(balance%system)
         branch%states = self%monodromy%given
         allocate (self%multipliers(branch%states))
      end if
      call resize(branch, 16, balance%highest, stability)
   end subroutine setup

   !> Adds the place at which the balance was last evaluated.
   subroutine add(self, balance, place, truncation, part, branch)
      class(recorder_type), intent(inout) :: self
      type(balance_type), intent(in) :: balance
      type(place_type), intent(in) :: place
      type(truncation_type), intent(in) :: truncation
      integer, intent(in) :: part
      type(branch_type), intent(inout), target :: branch
      real(dp) :: coefficients(1 + 2*balance%highest, balance%system%meshes)
      type(verdict_type) :: verdict
      integer :: j, k, n

      if (branch%points == size(branch%frequency) .or. balance%highest > branch%harmonics) then
         n = size(branch%frequency)
         if (branch%points == n) n = 2*n
         call resize(branch, n, max(balance%highest, branch%harmonics), self%stability)
      end if
      call balance%full_coefficients(place%u, place%frequency, coefficients)
      n = branch%points + 1
      if (.not. allocated(self%harmonic)) allocate (self%harmonic(0))
      if (size(self%harmonic) /= balance%highest) self%harmonic = [(k, k=1, balance%highest)]
      call self%transform%plan(fine_samples(balance%highest))
      call self%reader%setup(balance%system, balance%eta, self%transform%samples)
      branch%frequency(n) = place%frequency
      branch%coefficients(:, :, n) = 0
      branch%coefficients(:size(coefficients, 1), :, n) = coefficients
      branch%error_estimate(n) = truncation%estimate
      branch%estimate_doubtful(n) = truncation%doubtful
      branch%point_harmonics(n) = balance%highest
      branch%part(n) = part
      do j = 1, branch%meshes
         branch%rms(j, n) = rms(coefficients(:, j))
         branch%mean(j, n) = coefficients(1, j)
         call extremes(coefficients(:, j), self%harmonic, self%transform, branch%minimum(j, n), branch%maximum(j, n))
         call self%reader%read(balance%system, j, place%frequency, coefficients(:, j), self%harmonic, self%transform, &
                               branch%mesh_load(j, n))
         branch%mesh_load(j, n)%separation = 0
         branch%mesh_load(j, n)%back_contact = 0
      end do
      do j = 1, balance%unknowns
         associate (load => branch%mesh_load(balance%mesh(j), n))
            call balance%contact(j)%shares(load%separation, load%back_contact)
         end associate
      end do
      if (self%stability) then
         call self%monodromy%integrate(balance, place%frequency)
         call self%monodromy%multipliers(self%multipliers)
         branch%multipliers(:, n) = self%multipliers
         call judge(self%monodromy, balance, place%u, place%frequency, truncation, self%multipliers, verdict)
         branch%stable(n) = verdict%stable
         branch%undecided(n) = verdict%undecided
         branch%second_estimate(n) = verdict%second
         branch%count_undecided(n) = verdict%count_undecided
      end if
      branch%points = n
   end subroutine add

   !> Gives spare room back.
   subroutine finish(self, branch)
      class(recorder_type), intent(in) :: self
      type(branch_type), intent(inout), target :: branch

      call resize(branch, branch%points, branch%harmonics, self%stability)
   end subroutine finish

   !> Room for `points` points with `harmonics` harmonics, keeping those that are there.
   subroutine resize(branch, points, harmonics, stability)
      type(branch_type), intent(inout), target :: branch
      integer, intent(in) :: points, harmonics
      logical, intent(in) :: stability
      type(branch_type) :: old
      integer :: n, c

      n = branch%points
      call move_alloc(branch%frequency, old%frequency)
      call move_alloc(branch%coefficients, old%coefficients)
      call move_alloc(branch%rms, old%rms)
      call move_alloc(branch%mean, old%mean)
      call move_alloc(branch%minimum, old%minimum)
      call move_alloc(branch%maximum, old%maximum)
      call move_alloc(branch%mesh_load, old%mesh_load)
      call move_alloc(branch%multipliers, old%multipliers)
      call move_alloc(branch%stable, old%stable)
      call move_alloc(branch%undecided, old%undecided)
      call move_alloc(branch%second_estimate, old%second_estimate)
      call move_alloc(branch%count_undecided, old%count_undecided)
      call move_alloc(branch%error_estimate, old%error_estimate)
      call move_alloc(branch%estimate_doubtful, old%estimate_doubtful)
      call move_alloc(branch%point_harmonics, old%point_harmonics)
      call move_alloc(branch%part, old%part)
      associate (m => branch%meshes)
         allocate (branch%frequency(points), branch%coefficients(1 + 2*harmonics, m, points), branch%rms(m, points), &
                   branch%mean(m, points), branch%minimum(m, points), branch%maximum(m, points), &
                   branch%mesh_load(m, points), branch%error_estimate(points), branch%estimate_doubtful(points), &
                   branch%point_harmonics(points), branch%part(points))
         if (stability) allocate (branch%multipliers(branch%states, points), branch%stable(points), branch%undecided(points), &
                                  branch%second_estimate(points), branch%count_undecided(points))
      end associate
      branch%harmonics = harmonics
      if (.not. allocated(old%frequency)) return
      c = size(old%coefficients, 1)
      branch%frequency(:n) = old%frequency(:n)
      branch%coefficients(:, :, :n) = 0
      branch%coefficients(:c, :, :n) = old%coefficients(:, :, :n)
      branch%rms(:, :n) = old%rms(:, :n)
      branch%mean(:, :n) = old%mean(:, :n)
      branch%minimum(:, :n) = old%minimum(:, :n)
      branch%maximum(:, :n) = old%maximum(:, :n)
      branch%mesh_load(:, :n) = old%mesh_load(:, :n)
      branch%error_estimate(:n) = old%error_estimate(:n)
      branch%estimate_doubtful(:n) = old%estimate_doubtful(:n)
      branch%point_harmonics(:n) = old%point_harmonics(:n)
      branch%part(:n) = old%part(:n)
      if (.not. stability) return
      branch%multipliers(:, :n) = old%multipliers(:, :n)
      branch%stable(:n) = old%stable(:n)
      branch%undecided(:n) = old%undecided(:n)
      branch%second_estimate(:n) = old%second_estimate(:n)
      branch%count_undecided(:n) = old%count_undecided(:n)
   end subroutine resize

end module geartrain_branch_recorder
