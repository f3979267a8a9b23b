/* Makes a pair of vectors orthogonal to many others (arnoldi.f90). In C, because only there a compiler makes a function in versions
   for several processors. The others come from a far cache or from memory: three times for a pair that is made orthogonal twice. */

#include "vectors.h"

/* Rows of a panel, which stays in a near cache; basis vectors that are read side by side. */
enum { PANEL = 128, SIDE = 4 };

INLINE double sum_of(four v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/* factor(j, k) += basis(:, j) . w(:, k) over `rows` rows, for `side` basis vectors; w minus the sum over j of factor(j, k) basis(:, j). */
INLINE void add_products(const int side, int rows, int n, int m, const double *restrict v, const double *restrict w,
                         double *restrict factor)
{
   four sum[SIDE][2] = {{{0}}};
   int i = 0;

   for (; i + 4 <= rows; i += 4)
      for (int j = 0; j < side; j++)
         for (int k = 0; k < 2; k++)
            sum[j][k] += load(v + (int64_t)j * n + i) * load(w + (int64_t)k * n + i);
   for (int j = 0; j < side; j++)
      for (int k = 0; k < 2; k++) {
         double rest = sum_of(sum[j][k]);
         for (int l = i; l < rows; l++)
            rest += v[(int64_t)j * n + l] * w[(int64_t)k * n + l];
         factor[k * m + j] += rest;
      }
}

INLINE void subtract(const int side, int rows, int n, int m, const double *restrict v, const double *restrict factor, double *restrict w)
{
   int i = 0;

   for (; i + 4 <= rows; i += 4)
      for (int k = 0; k < 2; k++) {
         four x = load(w + (int64_t)k * n + i);
         for (int j = 0; j < side; j++)
            x -= factor[k * m + j] * load(v + (int64_t)j * n + i);
         store(w + (int64_t)k * n + i, x);
      }
   for (; i < rows; i++)
      for (int k = 0; k < 2; k++)
         for (int j = 0; j < side; j++)
            w[(int64_t)k * n + i] -= factor[k * m + j] * v[(int64_t)j * n + i];
}

INLINE void add_all_products(int rows, int n, int m, const double *restrict v, const double *restrict w, double *restrict factor)
{
   int j = 0;
   for (; j + SIDE <= m; j += SIDE)
      add_products(SIDE, rows, n, m, v + (int64_t)j * n, w, factor + j);
   for (; j < m; j++)
      add_products(1, rows, n, m, v + (int64_t)j * n, w, factor + j);
}

INLINE void subtract_all(int rows, int n, int m, const double *restrict v, const double *restrict factor, double *restrict w)
{
   int j = 0;
   for (; j + SIDE <= m; j += SIDE)
      subtract(SIDE, rows, n, m, v + (int64_t)j * n, factor + j, w);
   for (; j < m; j++)
      subtract(1, rows, n, m, v + (int64_t)j * n, factor + j, w);
}

/* Subtracts twice from a pair of vectors w(n, 2) what lies in the space of an orthonormal basis(n, m).
     factor(m, 2)                   products of the basis with w that were subtracted
     again(m, 2)                    work space */
VERSIONS void geartrain_project_out(int n, int m, const double *restrict basis, double *restrict w, double *restrict factor,
                                    double *restrict again)
{
   for (int j = 0; j < 2 * m; j++)
      factor[j] = again[j] = 0;
   add_all_products(n, n, m, basis, w, factor);
   for (int i = 0; i < n; i += PANEL) {
      const int rows = n - i < PANEL ? n - i : PANEL;
      subtract_all(rows, n, m, basis + i, factor, w + i);
      add_all_products(rows, n, m, basis + i, w + i, again);
   }
   subtract_all(n, n, m, basis, again, w);
   for (int j = 0; j < 2 * m; j++)
      factor[j] += again[j];
}
