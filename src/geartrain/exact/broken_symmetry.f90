!> The symmetry of the train that breaks at a branch point, as a linear form that it turns round: of every symmetric orbit the form
!> is 0, and of the motions that branch off it is not.
!> The form is made of the left null vector of M - I. Where the symmetry holds at every instant it turns this vector round, at any
!> time. Where it comes with a shift by half the period it takes the vector at the beginning to minus that of half a period later,
!> and the state likewise to the state there: then the sum of both products with the states is 0.
module geartrain_exact_broken_symmetry
   use geartrain_base_kinds, only: dp
   use geartrain_flow_sections, only: sections_type
   use geartrain_linalg_border, only: border_type
   implicit none (type, external)
   private
   public :: broken_symmetry_type

   !> Changes of the states, over the largest: the first one tried; at which the orbit counts as symmetric; the longest in all.
   real(dp), parameter :: first_step = 1e-7_dp, restored = 1e-11_dp, farthest = 1e-3_dp
   !> Most changes.
   integer, parameter :: max_iterations = 8

   type :: broken_symmetry_type
      private
      !> Left null vector of M - I at the beginning and half a period later, (state, place); the section that begins there, 1 where
      !> none does.
      real(dp), allocatable :: left(:, :)
      integer :: half = 1
   contains
      procedure :: find
      procedure :: share_of
      procedure, private :: take_form
   end type broken_symmetry_type

contains

   !> Finds the form at a branch point, and makes the orbit there symmetric. Next to a branch point rounding moves an orbit along
   !> the null vector s, and this moves the left null vector: the share of the orbit in its own form is an odd function of s, whose
   !> zero the secant method finds.
   subroutine find(self, border, sections, frequency_ratio, states, symmetric)
      class(broken_symmetry_type), intent(inout) :: self
      !> Of M - I; then its borders are null vectors.
      type(border_type), intent(inout) :: border
      !> Set up for the period of the orbit.
      type(sections_type), intent(inout) :: sections
      !> Lambda [1].
      real(dp), intent(in) :: frequency_ratio
      !> States at the beginnings of the sections [1], (state, section).
      real(dp), intent(inout) :: states(:, :)
      !> Whether the orbit is symmetric now.
      logical, intent(out) :: symmetric
      real(dp) :: null(size(states, 1), size(states, 2)), share, before, step, way, largest
      integer :: i, k, info

      symmetric = .false.
      largest = maxval(abs(states))
      way = 0
      before = 0
      step = 0
      do i = 1, max_iterations
         call sections%fly(frequency_ratio, states)
         if (sections%interrupted()) return
         do k = 1, 2
            call border%find(sections%monodromy, -1.0_dp, info)
            if (info /= 0) return
            call border%renew()
         end do
         call self%take_form(border%column, sections, frequency_ratio, states)
         do k = 1, sections%sections
            null(:, k) = sections%step_at(k, border%row, 0.0_dp)
         end do
         share = self%share_of(states)
         if (i == 1) then
            step = first_step*largest/maxval(abs(null))
         else
            if (.not. abs(share - before) > 0) return
            step = -share*step/(share - before)
         end if
         before = share
         way = way + step
         if (.not. abs(way)*maxval(abs(null)) < farthest*largest) return
         symmetric = abs(step)*maxval(abs(null)) < restored*largest
         if (symmetric) return
         states = states + step*null
      end do
   end subroutine find

   !> Takes the form from a left null vector.
   subroutine take_form(self, left, sections, frequency_ratio, states)
      class(broken_symmetry_type), intent(inout) :: self
      !> Left null vector of M - I, (state).
      real(dp), intent(in) :: left(:)
      !> Set up for the period of the orbit.
      type(sections_type), intent(inout) :: sections
      !> Lambda [1]; states at the beginnings of the sections [1], (state, section).
      real(dp), intent(in) :: frequency_ratio, states(:, :)
      real(dp) :: second_half(size(left), size(left))
      integer :: i

      if (allocated(self%left)) deallocate (self%left)
      allocate (self%left(size(left), 2), source=0.0_dp)
      self%left(:, 1) = left
      self%half = 1
      if (mod(sections%sections, 2) > 0) return
      self%half = sections%sections/2 + 1
      second_half = 0
      do i = 1, size(left)
         second_half(i, i) = 1
      end do
      call sections%carry_vectors(frequency_ratio, states, second_half, self%half)
      self%left(:, 2) = matmul(left, second_half)
   end subroutine take_form

   !> The share in states, or in a change of them.
   pure real(dp) function share_of(self, states)
      class(broken_symmetry_type), intent(in) :: self
      !> States at the beginnings of the sections, (state, section).
      real(dp), intent(in) :: states(:, :)

      share_of = dot_product(self%left(:, 1), states(:, 1)) + dot_product(self%left(:, 2), states(:, self%half))
   end function share_of

end module geartrain_exact_broken_symmetry
