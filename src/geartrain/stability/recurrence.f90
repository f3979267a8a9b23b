!> The inner loops of the propagator, in a file of their own and on plain arrays: so the compiler knows that none overlap and makes
!> vector code without checks.
module geartrain_stability_recurrence
   use geartrain_base_kinds, only: dp
   implicit none (type, external)
   private
   public :: find_derivatives, add_up, chunk, most_terms

   !> Terms of kappa come by so many; there are at most as many as this.
   integer, parameter :: chunk = 4, most_terms = 32

contains

   !> Derivatives of one block of columns: psi = -W_nn (kappa p + gamma p'), p'' = psi(n) + before psi(n-1) + after psi(n+1).
   !> The columns of element n are the numbers (n-1)*width + 1 .. n*width, so that most lines are one long loop.
   pure subroutine find_derivatives(width, elements, meshes, degree, most_degree, mesh_element, terms, spring, damper, before, &
                                    after, leibniz, x, p)
      integer, intent(in) :: width, elements, meshes, degree, most_degree, mesh_element(meshes), terms(meshes)
      real(dp), intent(in), dimension(width*elements) :: spring, damper, before, after
      real(dp), intent(in) :: leibniz(0:most_terms - 1, 0:most_degree, meshes), x(width*elements, 2)
      real(dp), intent(inout) :: p(width*elements, 1 - most_terms:most_degree + 1)
      real(dp) :: psi(1 - width:width*(elements + 1))
      integer :: first, i, j, k, l, last, all_

      all_ = width*elements
      p(:, 0:1) = x
      psi(:0) = 0
      psi(all_ + 1:) = 0
      do k = 0, degree - 1
         do i = 1, all_
            psi(i) = spring(i)*p(i, k) + damper(i)*p(i, k + 1)
         end do
         if (width == 2) then
            call add_pairs(elements, meshes, k, most_degree, mesh_element, terms, leibniz, p, psi(1:all_))
         else
            do j = 1, meshes
               first = (mesh_element(j) - 1)*width
               ! Terms beyond k are none.
               last = min(terms(j), k + 1)
               l = 0
               do while (l + chunk < last)
                  call add_eight(width, all_, leibniz(l:l + 7, k, j), p(:, k - l - 7:k - l), first, psi(first + 1:first + width))
                  l = l + 8
               end do
               if (l < last) call add_four(width, all_, leibniz(l:l + 3, k, j), p(:, k - l - 3:k - l), first, &
                                           psi(first + 1:first + width))
            end do
         end if
         do i = 1, all_
            p(i, k + 2) = psi(i) + before(i)*psi(i - width) + after(i)*psi(i + width)
         end do
      end do
   end subroutine find_derivatives

   !> All terms of kappa p for all meshes, two columns only: a call for each mesh would cost more than its eight products.
   pure subroutine add_pairs(elements, meshes, k, most_degree, mesh_element, terms, leibniz, p, psi)
      integer, intent(in) :: elements, meshes, k, most_degree, mesh_element(meshes), terms(meshes)
      real(dp), intent(in) :: leibniz(0:most_terms - 1, 0:most_degree, meshes), p(2, elements, 1 - most_terms:most_degree + 1)
      real(dp), intent(inout) :: psi(2, elements)
      real(dp) :: sum_1, sum_2
      integer :: j, l, n

      do j = 1, meshes
         n = mesh_element(j)
         sum_1 = psi(1, n)
         sum_2 = psi(2, n)
         do l = 0, terms(j) - 1
            sum_1 = sum_1 + leibniz(l, k, j)*p(1, n, k - l)
            sum_2 = sum_2 + leibniz(l, k, j)*p(2, n, k - l)
         end do
         psi(1, n) = sum_1
         psi(2, n) = sum_2
      end do
   end subroutine add_pairs

   !> Eight terms of kappa p for one mesh, two columns at a time.
   pure subroutine add_eight(width, length, c, p, first, psi)
      integer, intent(in) :: width, length, first
      real(dp), intent(in) :: c(0:7), p(length, 0:7)
      real(dp), intent(inout) :: psi(width)
      integer :: i, n

      !GCC$ unroll 1
      do i = 1, width, 2
         n = first + i
         psi(i:i + 1) = psi(i:i + 1) + c(0)*p(n:n + 1, 7) + c(1)*p(n:n + 1, 6) + c(2)*p(n:n + 1, 5) + c(3)*p(n:n + 1, 4) &
                        + c(4)*p(n:n + 1, 3) + c(5)*p(n:n + 1, 2) + c(6)*p(n:n + 1, 1) + c(7)*p(n:n + 1, 0)
      end do
   end subroutine add_eight

   !> Four of them.
   pure subroutine add_four(width, length, c, p, first, psi)
      integer, intent(in) :: width, length, first
      real(dp), intent(in) :: c(0:3), p(length, 0:3)
      real(dp), intent(inout) :: psi(width)
      integer :: i, n

      !GCC$ unroll 1
      do i = 1, width, 2
         n = first + i
         psi(i:i + 1) = psi(i:i + 1) + c(0)*p(n:n + 1, 3) + c(1)*p(n:n + 1, 2) + c(2)*p(n:n + 1, 1) + c(3)*p(n:n + 1, 0)
      end do
   end subroutine add_four

   !> The end of the step: weighted sums of the derivatives of p and, one place on, of p'.
   pure subroutine add_up(length, degree, most_degree, weight, p, x)
      integer, intent(in) :: length, degree, most_degree
      real(dp), intent(in) :: weight(-3:most_degree), p(length, 1 - most_terms:most_degree + 1)
      real(dp), intent(out) :: x(length, 2)
      integer :: i, k

      x = 0
      do k = -modulo(-degree - 1, 4), degree - 3, 4
         do i = 1, length
            x(i, 1) = x(i, 1) + weight(k)*p(i, k) + weight(k + 1)*p(i, k + 1) + weight(k + 2)*p(i, k + 2) &
                      + weight(k + 3)*p(i, k + 3)
            x(i, 2) = x(i, 2) + weight(k)*p(i, k + 1) + weight(k + 1)*p(i, k + 2) + weight(k + 2)*p(i, k + 3) &
                      + weight(k + 3)*p(i, k + 4)
         end do
      end do
   end subroutine add_up

end module geartrain_stability_recurrence
