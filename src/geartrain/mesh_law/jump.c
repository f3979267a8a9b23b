/* Fourier coefficients of one jump (spectra.f90). */

#include "../linalg/vectors.h"

/* (a, b) becomes (-b, a) in each pair: the product with the imaginary unit. */
INLINE eight turned(eight v) { return __builtin_shufflevector(v, -v, 9, 0, 11, 2, 13, 4, 15, 6); }

/* chi(k) += factor(k), chi(k + 8) += factor(k) z, chi(k + 16) += factor(k) z**2, ... for eight complex numbers side by side.
     size                           of chi, complex numbers, a multiple of 8
     factor                         eight complex numbers
     real, imaginary                of z */
WIDE_VERSIONS void geartrain_add_jump(int size, const double *restrict factor, double real, double imaginary, double *restrict chi)
{
   eight a = load8(factor), b = load8(factor + 8);

   for (int k = 0; k < 2 * size; k += 16) {
      store8(chi + k, load8(chi + k) + a);
      store8(chi + k + 8, load8(chi + k + 8) + b);
      a = real * a + imaginary * turned(a);
      b = real * b + imaginary * turned(b);
   }
}
