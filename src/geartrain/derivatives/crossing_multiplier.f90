!> The multiplier that crosses the unit circle at a period doubling or a Neimark-Sacker point of a branch, from the monodromy
!> matrix of the balanced motion, as a function of the coefficients, Lambda and the train.
module geartrain_derivatives_crossing_multiplier
   use geartrain_balance_balance, only: balance_type
   use geartrain_base_kinds, only: dp
   use geartrain_floquet_monodromy, only: monodromy_type
   use geartrain_floquet_multipliers, only: are_numbers
   use geartrain_network_system, only: system_type
   use geartrain_trace_branch, only: branch_type, carried_by, has_sets
   use geartrain_trace_points, only: repeats_of
   implicit none (type, external)
   private
   public :: crossing_multiplier_type, plan_type

   !> How a point of a branch was balanced.
   type :: plan_type
      !> Highest harmonic of Lambda/eta, sub-harmonic index, how often the motion goes through its waveform within the period.
      integer :: highest = 0, eta = 1, repeats = 1
      !> The carried harmonics; not allocated: those that the excitation reaches.
      integer, allocatable :: carried(:)
   contains
      procedure :: take
      procedure :: apply
   end type plan_type

   type :: crossing_multiplier_type
      type(balance_type), private :: balance
      type(monodromy_type), private :: monodromy
      logical, private :: doubles = .false.
   contains
      procedure :: setup
      procedure :: choose
      procedure :: value_at
      procedure, private :: multipliers_at
   end type crossing_multiplier_type

contains

   !> Takes the harmonics that a point of a branch was solved with.
   subroutine take(self, system, branch, point)
      class(plan_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(branch_type), intent(in) :: branch
      !> Number of the point.
      integer, intent(in) :: point

      self%highest = branch%point_harmonics(point)
      self%eta = branch%subharmonic
      self%repeats = repeats_of(branch, system)
      if (allocated(self%carried)) deallocate (self%carried)
      if (has_sets(branch)) self%carried = carried_by(branch, point, point)
   end subroutine take

   !> Plans a balance.
   subroutine apply(self, system, balance)
      class(plan_type), intent(in) :: self
      type(system_type), pointer, intent(in) :: system
      type(balance_type), intent(inout) :: balance

      if (allocated(self%carried)) then
         call balance%setup(system, self%highest, self%eta, 0, self%carried, self%repeats)
      else
         call balance%setup(system, self%highest, self%eta, 0, repeats=self%repeats)
      end if
   end subroutine apply

   !> Prepares for motions of a train.
   subroutine setup(self, system, plan, doubles)
      class(crossing_multiplier_type), intent(out) :: self
      type(system_type), pointer, intent(in) :: system
      !> Harmonics of the motions.
      type(plan_type), intent(in) :: plan
      !> A real multiplier crosses at -1, else a complex pair.
      logical, intent(in) :: doubles

      call plan%apply(system, self%balance)
      call self%monodromy%setup(system)
      self%doubles = doubles
   end subroutine setup

   !> Multipliers of a motion over one repetition of its waveform.
   subroutine multipliers_at(self, u, frequency_ratio, multipliers)
      class(crossing_multiplier_type), intent(inout) :: self
      !> Coefficients [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> The multipliers.
      complex(dp), allocatable, intent(out) :: multipliers(:)

      allocate (multipliers(self%monodromy%given))
      call self%balance%evaluate(u, frequency_ratio)
      call self%monodromy%integrate(self%balance, frequency_ratio)
      call self%monodromy%multipliers(multipliers)
   end subroutine multipliers_at

   !> Chooses the multiplier at a motion next to the crossing: the real one nearest to -1, or of the pair nearest to the unit circle
   !> the one with positive imaginary part.
   subroutine choose(self, u, frequency_ratio, multiplier, found)
      class(crossing_multiplier_type), intent(inout) :: self
      !> Coefficients [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> The multiplier.
      complex(dp), intent(out) :: multiplier
      !> There is one.
      logical, intent(out) :: found
      complex(dp), allocatable :: multipliers(:)
      logical, allocatable :: candidate(:)
      integer :: i

      multiplier = 0
      call self%multipliers_at(u, frequency_ratio, multipliers)
      found = are_numbers(multipliers)
      if (.not. found) return
      if (self%doubles) then
         candidate = abs(multipliers%im) <= 0
         i = minloc(abs(multipliers + 1), 1, candidate)
      else
         candidate = multipliers%im > 0
         i = minloc(abs(abs(multipliers) - 1), 1, candidate)
      end if
      found = any(candidate)
      if (found) multiplier = multipliers(i)
   end subroutine choose

   !> What is 0 at the crossing: the real multiplier plus 1, or the logarithm of the magnitude of the pair.
   subroutine value_at(self, u, frequency_ratio, reference, value, found, multiplier)
      class(crossing_multiplier_type), intent(inout) :: self
      !> Coefficients [1], (block, unknown), and Lambda [1].
      real(dp), intent(in) :: u(:, :), frequency_ratio
      !> The multiplier at a motion nearby; the multiplier next to it is taken.
      complex(dp), intent(in) :: reference
      !> The value.
      real(dp), intent(out) :: value
      !> It is known.
      logical, intent(out) :: found
      !> The multiplier.
      complex(dp), intent(out), optional :: multiplier
      complex(dp), allocatable :: multipliers(:)
      integer :: i

      value = 0
      call self%multipliers_at(u, frequency_ratio, multipliers)
      found = are_numbers(multipliers)
      if (.not. found) return
      i = minloc(abs(multipliers - reference), 1)
      if (self%doubles) then
         value = multipliers(i)%re + 1
      else
         value = log(abs(multipliers(i)))
      end if
      ! A pair that has become real, or two real multipliers that have become a pair, has no derivative.
      found = (abs(multipliers(i)%im) > 0) .neqv. self%doubles
      if (present(multiplier)) multiplier = multipliers(i)
   end subroutine value_at

end module geartrain_derivatives_crossing_multiplier
