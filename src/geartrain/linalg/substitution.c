/* Forward and back substitution with the LU factors of a small matrix (elimination.f90), for several right-hand sides side by side. */

#include "vectors.h"

enum { WIDTH = 32 };

/* Of 4*vectors right-hand sides: each row is summed in registers. */
INLINE void solve_some(const int vectors, int n, const double *restrict a, double *restrict rows)
{
   four sum[4];

   for (int i = 0; i < n; i++) {
      for (int v = 0; v < vectors; v++)
         sum[v] = load(rows + WIDTH * i + 4 * v);
      for (int k = 0; k < i; k++)
         for (int v = 0; v < vectors; v++)
            sum[v] -= a[i + k * n] * load(rows + WIDTH * k + 4 * v);
      for (int v = 0; v < vectors; v++)
         store(rows + WIDTH * i + 4 * v, sum[v]);
   }
   for (int i = n - 1; i >= 0; i--) {
      for (int v = 0; v < vectors; v++)
         sum[v] = load(rows + WIDTH * i + 4 * v);
      for (int k = i + 1; k < n; k++)
         for (int v = 0; v < vectors; v++)
            sum[v] -= a[i + k * n] * load(rows + WIDTH * k + 4 * v);
      double inverse = 1 / a[i + i * n];
      for (int v = 0; v < vectors; v++)
         store(rows + WIDTH * i + 4 * v, inverse * sum[v]);
   }
}

/* Solves in place.
     n, columns   rows of the matrix, right-hand sides: at most 32, of which the last of a four may be any numbers
     a            factors, by columns, without row exchanges
     rows         right-hand sides with their rows exchanged, 32 places a row */
VERSIONS void geartrain_substitute(int n, int columns, const double *restrict a, double *restrict rows)
{
   int fours = (columns + 3) / 4;

   for (; fours >= 4; fours -= 4, rows += 16)
      solve_some(4, n, a, rows);
   if (fours == 3)
      solve_some(3, n, a, rows);
   if (fours == 2)
      solve_some(2, n, a, rows);
   if (fours == 1)
      solve_some(1, n, a, rows);
}
