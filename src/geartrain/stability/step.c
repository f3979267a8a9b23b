/* One step of the propagator (propagator.f90). In C, because only there a compiler makes a function in versions for several
   processors: wider vectors and fused products halve its time on machines that have them. */

#include <stdint.h>

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define VERSIONS __attribute__((target_clones("fma", "default"), optimize("O3")))
#define INLINE static inline __attribute__((always_inline, optimize("O3")))
#else
#define VERSIONS
#define INLINE static inline
#endif

/* Four columns, at any address of a number; `work` is aligned, so that they do not straddle lines of the cache. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

INLINE four load(const double *p) { return *(const four *)p; }
INLINE void store(double *p, four v) { *(four *)p = v; }

/* psi + sum over l of factor(l) p(k - l), for 4*vectors columns of one element. psi, which waits for the latest derivative, comes
   last. */
INLINE void add_terms(const int vectors, int terms, int all, const double *restrict factor, const double *restrict p,
                      double *restrict psi)
{
   four sum[3] = {{0}};

   for (int l = 0; l < terms; l++)
      for (int i = 0; i < vectors; i++)
         sum[i] += factor[l] * load(p - l * all + 4 * i);
   for (int i = 0; i < vectors; i++)
      store(psi + 4 * i, load(psi + 4 * i) + sum[i]);
}

/* Sums over k of weight(k) p(k) and of weight(k) p(k + 1), for 4*vectors columns of one element. */
INLINE void add_up(const int vectors, int degree, int all, const double *restrict weight, const double *restrict p,
                   double *restrict x)
{
   four here[3] = {{0}}, next[3] = {{0}};

   for (int k = 0; k <= degree; k++)
      for (int i = 0; i < vectors; i++) {
         here[i] += weight[k] * load(p + k * all + 4 * i);
         next[i] += weight[k] * load(p + (k + 1) * all + 4 * i);
      }
   for (int i = 0; i < vectors; i++) {
      store(x + 4 * i, here[i]);
      store(x + all + 4 * i, next[i]);
   }
}

/* Carries one block of columns over a step by the derivatives at its beginning: psi = -W_nn (kappa p + gamma p'),
   p'' = psi(n) + before psi(n-1) + after psi(n+1), kappa p by Leibniz' rule where kappa varies, weighted sums of them at its end.
     width                          columns of the block: 4, 8 or 12; those of one element lie together
     mesh_element(mesh)             number of the element, from 1
     terms(mesh)                    how many terms a varying kappa has, at most most_terms
     spring, damper(column, element)   -W_nn kappa where it is constant, -W_nn gamma
     before, after(column, element)    factors of the neighbours' psi
     binomial(term, derivative), kappa(term, mesh)   room for most_terms, a multiple of four; their product is Leibniz' factor
     weight(derivative)             from 0 to degree
     work                           room for width (elements (degree + 3) + 2) + most_terms + 4 numbers
     x(column, element, 2)          displacements and velocities, in and out */
VERSIONS void geartrain_step(int width, int elements, int meshes, int degree, int most_terms, const int *restrict mesh_element,
                             const int *restrict terms, const double *restrict spring, const double *restrict damper,
                             const double *restrict before, const double *restrict after, const double *restrict binomial,
                             const double *restrict kappa, const double *restrict weight, double *restrict work,
                             double *restrict x)
{
   const int all = width * elements;
   double *restrict factor = (double *)(((uintptr_t)work + 31) & ~(uintptr_t)31);
   double *restrict psi = factor + most_terms + width;
   double *restrict p = psi + all + width;

   for (int i = 0; i < width; i += 4) {
      store(psi - width + i, (four){0});
      store(psi + all + i, (four){0});
   }
   for (int i = 0; i < 2 * all; i += 4)
      store(p + i, load(x + i));
   for (int k = 0; k < degree; k++) {
      const double *restrict here = p + k * all;
      double *restrict next = p + (k + 2) * all;
      for (int i = 0; i < all; i += 4)
         store(psi + i, load(spring + i) * load(here + i) + load(damper + i) * load(here + all + i));
      for (int j = 0; j < meshes; j++) {
         const int first = (mesh_element[j] - 1) * width;
         const int last = terms[j] < k + 1 ? terms[j] : k + 1;
         for (int l = 0; l < last; l += 4)
            store(factor + l, load(binomial + k * most_terms + l) * load(kappa + j * most_terms + l));
         if (width == 4)
            add_terms(1, last, all, factor, here + first, psi + first);
         else if (width == 8)
            add_terms(2, last, all, factor, here + first, psi + first);
         else
            add_terms(3, last, all, factor, here + first, psi + first);
      }
      for (int i = 0; i < all; i += 4)
         store(next + i, load(psi + i) + load(before + i) * load(psi + i - width) + load(after + i) * load(psi + i + width));
   }
   for (int first = 0; first < all; first += width)
      if (width == 4)
         add_up(1, degree, all, weight, p + first, x + first);
      else if (width == 8)
         add_up(2, degree, all, weight, p + first, x + first);
      else
         add_up(3, degree, all, weight, p + first, x + first);
}
