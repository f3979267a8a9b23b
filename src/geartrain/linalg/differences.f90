!> Derivative of a function by differences over steps that shrink, extrapolated to a step of 0 (C. J. F. Ridders, Advances in
!> Engineering Software 4 (1982) 75-76), with an estimate of its error.
module geartrain_linalg_differences
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: differences_type

   !> Most steps, and the factor by which a step is shorter than the step before.
   integer, parameter :: most = 7
   real(dp), parameter :: shorter = 2
   !> Relative error at which no further steps are needed.
   real(dp), parameter :: enough = 1e-10_dp

   type :: differences_type
      !> Next step to take the difference over.
      real(dp) :: step = 0
      !> The derivative; its estimated error.
      real(dp) :: value = 0, error = huge(1.0_dp)
      !> No further difference is needed.
      logical :: done = .false.
      !> Differences so far; the difference of the shortest step in `value`; order of their error in the step; extrapolations,
      !> (order of extrapolation, difference).
      integer, private :: taken = 0, last = 1, order = 2
      real(dp), private :: table(most, most) = 0
   contains
      procedure :: begin
      procedure :: add
      procedure, private :: rounding
   end type differences_type

contains

   !> Begins with the longest step.
   pure subroutine begin(self, step, one_sided)
      class(differences_type), intent(inout) :: self
      !> Longest step.
      real(dp), intent(in) :: step
      !> Differences are taken to one side: their error is of first order in the step, else of second order.
      logical, intent(in) :: one_sided
      type(differences_type) :: fresh

      self%step = step
      self%value = fresh%value
      self%error = fresh%error
      self%done = .false.
      self%taken = 0
      self%order = merge(1, 2, one_sided)
   end subroutine begin

   !> Adds the difference over `step`, and chooses the next step.
   pure subroutine add(self, slope)
      class(differences_type), intent(inout) :: self
      !> Difference of the function over `step`, or over both steps, divided by the distance of the two places.
      real(dp), intent(in) :: slope
      real(dp) :: factor, error
      integer :: j

      self%taken = self%taken + 1
      associate (n => self%taken, t => self%table)
         t(1, n) = slope
         if (n == 1) self%value = slope
         factor = 1
         do j = 2, n
            factor = factor*shorter**self%order
            t(j, n) = (factor*t(j - 1, n) - t(j - 1, n - 1))/(factor - 1)
            error = max(abs(t(j, n) - t(j - 1, n)), abs(t(j, n) - t(j - 1, n - 1)))
            if (error > self%error) cycle
            self%error = error
            self%value = t(j, n)
            self%last = n
         end do
         if (n == most) self%error = max(self%error, self%rounding())
         self%done = n == most .or. self%error <= enough*abs(self%value)
      end associate
      self%step = self%step/shorter
   end subroutine add

   !> Rounding in the value after all steps. Where rounding is all that is left, some neighbours in the table are close to one
   !> another by chance, and say little about the error. The last three differences of a column are rarely so. Of all
   !> columns the smallest of these gives the rounding over the shortest step. Over a step twice as long it is half as large.
   pure real(dp) function rounding(self)
      class(differences_type), intent(in) :: self
      integer :: j

      associate (t => self%table)
         rounding = minval([(max(abs(t(j, most) - t(j, most - 1)), shorter*abs(t(j, most - 1) - t(j, most - 2))), j=1, most - 2)])
      end associate
      rounding = rounding/shorter**(most - self%last)
   end function rounding

end module geartrain_linalg_differences
