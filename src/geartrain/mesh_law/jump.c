/* Fourier coefficients of one jump (spectra.f90). */

#include "../linalg/vectors.h"

/* (a, b) becomes (-b, a) in each pair: the product with the imaginary unit. */
INLINE four turned(four v) { return __builtin_shufflevector(v, -v, 5, 0, 7, 2); }

/* chi(k) += factor(k), chi(k + 8) += factor(k) z, chi(k + 16) += factor(k) z**2, ... for eight complex numbers side by side. A power
   waits for the power before, so those of two steps are side by side, too.
     size                           of chi, complex numbers, a multiple of 8
     factor                         eight complex numbers
     real, imaginary                of z */
VERSIONS void geartrain_add_jump(int size, const double *restrict factor, double real, double imaginary, double *restrict chi)
{
   const double square[2] = {real * real - imaginary * imaginary, 2 * real * imaginary};
   four a[8];
   int k = 0;

   for (int i = 0; i < 4; i++) {
      a[i] = load(factor + 4 * i);
      a[4 + i] = real * a[i] + imaginary * turned(a[i]);
   }
   for (; k + 32 <= 2 * size; k += 32)
      for (int i = 0; i < 8; i++) {
         store(chi + k + 4 * i, load(chi + k + 4 * i) + a[i]);
         a[i] = square[0] * a[i] + square[1] * turned(a[i]);
      }
   for (int i = 0; k < 2 * size; k += 4, i++)
      store(chi + k, load(chi + k) + a[i]);
}
