!> How long steps along constant contacts may be, and the series that carries a solution over one of them.
!>
!> Between contact events the equations are linear and the solution is, but for small sidebands, a sum of exponentials whose
!> rates lie in an ellipse along the imaginary axis that is known beforehand. An economised exponential series on this ellipse, with
!> the derivatives at the beginning of a step, gives the solution at its end: no step control, and two thirds of the terms of
!> Taylor's series.
module geartrain_floquet_step_rule
   use geartrain_base_kinds, only: dp
   use geartrain_linalg_chebyshev_exponential, only: chebyshev_exponential_type
   use geartrain_network_system, only: system_type
   use geartrain_network_system_spectrum, only: largest_eigenvalue
   implicit none (type, external)
   private
   public :: most_terms, step_rule_type

   !> Most terms of kappa in a step, a multiple of four (step.c).
   integer, parameter :: most_terms = 32
   !> Longest step [rad of the band]: rounding grows as exp(reach).
   real(dp), parameter :: longest = 16
   !> Error of a step relative to the state, and of kappa: multipliers to about 1e-9.
   real(dp), parameter :: tolerance = 5e-10_dp
   !> Sidebands of kappa's highest harmonic that the band makes room for: beside the fastest mode of all, in which meshes
   !> hardly take part or which lies above what a mesh can do alone, and beside the rate of a mesh alone.
   real(dp), parameter :: sidebands = 1, mesh_sidebands = 6
   !> Longest step [rad of kappa's highest harmonic].
   real(dp), parameter :: longest_kappa = 2

   type :: step_rule_type
      type(system_type), pointer :: system => null()
      !> Largest rate of decay of any motion [1].
      real(dp) :: fastest_decay = 0
      !> Largest rate of all modes, with all meshes in contact and stiffest [1].
      real(dp) :: fastest = 0
      !> Largest rate that a step has to follow at `frequency_ratio` [1].
      real(dp) :: band = 1, frequency_ratio = 1
      !> Series of the motion and of a harmonic of kappa. Allocatable, because gfortran 12 never frees the second of two components
      !> of a type that itself has allocatable ones.
      type(chebyshev_exponential_type), allocatable :: motion, kappa
      !> Largest rate of a mesh of varying stiffness alone [1]; highest order of Lambda in any kappa.
      real(dp), private :: fastest_mesh = 0
      integer, private :: highest_order = 0
   contains
      procedure :: put_system
      procedure :: put_frequency
      procedure :: steps
   end type step_rule_type

contains

   subroutine put_system(self, system)
      class(step_rule_type), intent(inout) :: self
      type(system_type), pointer, intent(in) :: system
      real(dp) :: stiffest(system%elements), damping(system%elements), aspect
      integer :: i, j

      self%system => system
      stiffest = system%spring
      damping = system%damping
      self%highest_order = 0
      self%fastest_mesh = 0
      do j = 1, system%meshes
         associate (law => system%law(j), n => system%mesh_element(j))
            stiffest(n) = law%stiffest()
            damping(n) = maxval(law%damping)
            if (.not. any(law%varies)) cycle
            self%fastest_mesh = max(self%fastest_mesh, sqrt(system%own(n)*stiffest(n)))
            self%highest_order = maxval([self%highest_order, law%harmonic])
         end associate
      end do
      self%fastest = sqrt(largest_eigenvalue(system, stiffest))
      self%fastest_decay = largest_eigenvalue(system, damping)
      aspect = min(0.6_dp, max(0.1_dp, 2*self%fastest_decay/self%fastest))
      self%fastest = hypot(self%fastest, self%fastest_decay/aspect)
      if (.not. allocated(self%motion)) allocate (self%motion, self%kappa)
      call self%motion%setup([(longest*i/16, i=1, 16)], aspect, tolerance)
      call self%kappa%setup([(0.05_dp*1.5_dp**i, i=0, 11)], 0.0_dp, tolerance)
   end subroutine put_system

   !> Prepares for steps at `frequency_ratio`, which are shortened by `refinement`.
   subroutine put_frequency(self, frequency_ratio, refinement)
      class(step_rule_type), intent(inout) :: self
      !> Lambda [1]; steps are shorter by this factor [1].
      real(dp), intent(in) :: frequency_ratio, refinement

      self%frequency_ratio = frequency_ratio
      self%band = refinement*max(self%fastest + sidebands*self%highest_order*frequency_ratio, &
                                 self%fastest_mesh + mesh_sidebands*self%highest_order*frequency_ratio)
   end subroutine put_frequency

   !> Number of equal steps in which a time passes.
   integer function steps(self, time, varies)
      class(step_rule_type), intent(in) :: self
      !> The time [1].
      real(dp), intent(in) :: time
      !> The stiffness of some mesh in contact varies.
      logical, intent(in) :: varies
      real(dp) :: limit

      limit = longest/self%band
      if (varies) limit = min(limit, longest_kappa/(self%frequency_ratio*self%highest_order))
      steps = ceiling(time/limit*(1 - 1e-12_dp))
   end function steps

end module geartrain_floquet_step_rule
