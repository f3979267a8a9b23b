/* Fourier coefficients of one jump (spectra.f90). */

#include "../linalg/vectors.h"

/* (a, b) becomes (-b, a) in each pair: the product with the imaginary unit. */
INLINE four turned(four v) { return __builtin_shufflevector(v, -v, 5, 0, 7, 2); }

/* chi(k) += factor(k), chi(k + 8) += factor(k) z, chi(k + 16) += factor(k) z**2, ... for eight complex numbers side by side.
     size                           of chi, complex numbers, a multiple of 8
     factor                         eight complex numbers
     real, imaginary                of z */
VERSIONS void geartrain_add_jump(int size, const double *restrict factor, double real, double imaginary, double *restrict chi)
{
   four a[4];

   for (int i = 0; i < 4; i++)
      a[i] = load(factor + 4 * i);
   for (int k = 0; k < 2 * size; k += 16)
      for (int i = 0; i < 4; i++) {
         store(chi + k + 4 * i, load(chi + k + 4 * i) + a[i]);
         a[i] = real * a[i] + imaginary * turned(a[i]);
      }
}
