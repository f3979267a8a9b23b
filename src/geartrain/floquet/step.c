/* One step of the propagator (propagator.f90); `work` is aligned, so that vectors do not straddle lines of the cache. */

#include "../linalg/vectors.h"

/* psi of one element at derivative k: constant stiffness or damping, and terms of a varying kappa. Of 4*vectors columns. */
INLINE void find_psi(const int vectors, int all, double spring, double damper, int terms, const double *restrict factor,
                     const double *restrict p, four *restrict psi)
{
   for (int i = 0; i < vectors; i++)
      psi[i] = spring * load(p + 4 * i);
   const double *restrict q = p;
#pragma GCC unroll 2
   for (int l = 0; l < terms; l++, q -= all)
      for (int i = 0; i < vectors; i++)
         psi[i] += factor[l] * load(q + 4 * i);
   for (int i = 0; i < vectors; i++)
      psi[i] += damper * load(p + all + 4 * i);
}

/* Sums over k of weight(k) p(k) and of weight(k) p(k + 1), for 4*vectors columns of one element. */
INLINE void add_up(const int vectors, int degree, int all, int given, const double *restrict weight, const double *restrict p,
                   double *restrict x)
{
   four here[3] = {{0}}, next[3] = {{0}};

#pragma GCC unroll 2
   for (int k = 0; k <= degree; k++, p += all)
      for (int i = 0; i < vectors; i++) {
         here[i] += weight[k] * load(p + 4 * i);
         next[i] += weight[k] * load(p + all + 4 * i);
      }
   for (int i = 0; i < vectors; i++) {
      store(x + 4 * i, here[i]);
      store(x + given + 4 * i, next[i]);
   }
}

/* One derivative of the elements that close loops, from those of the coordinates. */
INLINE void close_loops(const int vectors, int coordinates, int elements, const double *restrict loop, double *restrict p)
{
   const int width = 4 * vectors;

   for (int n = coordinates; n < elements; n++, loop += coordinates) {
      four sum[3] = {{0}};
      for (int m = 0; m < coordinates; m++)
         for (int i = 0; i < vectors; i++)
            sum[i] += loop[m] * load(p + m * width + 4 * i);
      for (int i = 0; i < vectors; i++)
         store(p + n * width + 4 * i, sum[i]);
   }
}

/* The whole step for 4*vectors columns. On a chain psi of three neighbouring elements stays at hand. */
INLINE void carry(const int vectors, const int chain, int coordinates, int elements, int degree, int most_terms, const int *restrict terms,
                  const double *restrict spring, const double *restrict damper, const int *restrict first,
                  const int *restrict neighbour, const double *restrict share, const double *restrict loop,
                  const double *restrict binomial, const double *restrict kappa, const double *restrict weight,
                  double *restrict factor, double *restrict psi,
                  double *restrict p, double *restrict x)
{
   const int width = 4 * vectors, all = width * elements, given = width * coordinates;

   for (int k = 0; k < 2; k++) {
      for (int i = 0; i < given; i += 4)
         store(p + k * all + i, load(x + k * given + i));
      close_loops(vectors, coordinates, elements, loop, p + k * all);
   }
   for (int k = 0; k < degree; k++) {
      const double *restrict here = p + k * all;
      double *restrict next = p + (k + 2) * all;
      four below[3] = {{0}}, middle[3] = {{0}}, above[3] = {{0}};
      for (int n = 0; n < elements + chain; n++) {
         for (int i = 0; i < vectors; i++) {
            below[i] = middle[i];
            middle[i] = above[i];
            above[i] = (four){0};
         }
         if (n < elements) {
            const int last = terms[n] < k + 1 ? terms[n] : k + 1;
            for (int l = 0; l < last; l += 4)
               store(factor + l, load(binomial + k * most_terms + l) * load(kappa + n * most_terms + l));
            find_psi(vectors, all, spring[n], damper[n], last, factor, here + n * width, above);
         }
         if (!chain)
            for (int i = 0; i < vectors; i++)
               store(psi + n * width + 4 * i, above[i]);
         else if (n > 0)
            for (int i = 0; i < vectors; i++)
               store(next + (n - 1) * width + 4 * i, middle[i] + share[2 * n - 3] * below[i] + share[2 * n - 2] * above[i]);
      }
      for (int n = 0; n < coordinates && !chain; n++) {
         four sum[3];
         for (int i = 0; i < vectors; i++)
            sum[i] = load(psi + n * width + 4 * i);
         for (int j = first[n]; j < first[n + 1]; j++)
            for (int i = 0; i < vectors; i++)
               sum[i] += share[j] * load(psi + neighbour[j] * width + 4 * i);
         for (int i = 0; i < vectors; i++)
            store(next + n * width + 4 * i, sum[i]);
      }
      close_loops(vectors, coordinates, elements, loop, next);
   }
   for (int n = 0; n < coordinates; n++)
      add_up(vectors, degree, all, given, weight, p + n * width, x + n * width);
}

/* Carries one block of columns over a step by the derivatives at its beginning: psi = -W_nn (kappa p + gamma p'),
   p'' = psi(n) + sum over its neighbours m of share psi(m), kappa p by Leibniz' rule where kappa varies, weighted sums of them at
   its end.
     width                          columns of the block: 4, 8 or 12; those of one element lie together
     terms(element)                 how many terms a varying kappa has, at most most_terms; 0 for none
     spring, damper(element)        -W_nn kappa where it is constant, -W_nn gamma
     chain                          the neighbours of each element are the one before and the one after it
     first(element + 1), neighbour, share   neighbours first[n] to first[n + 1] - 1 of each element and the factors of their psi;
                                    share[-1] and share[2 elements - 2] can be read, and are 0 on a chain
     loop(coordinate, element - coordinates)   displacements of the elements that close loops per coordinate
     binomial(term, derivative), kappa(term, element)   room for most_terms, a multiple of four; their product is Leibniz' factor
     weight(derivative)             from 0 to degree
     work                           room for width elements (degree + 3) + most_terms + 4 numbers
     x(column, coordinate, 2)       displacements and velocities, in and out */
VERSIONS void geartrain_step(int width, int chain, int coordinates, int elements, int degree, int most_terms, const int *restrict terms,
                             const double *restrict spring, const double *restrict damper, const int *restrict first,
                             const int *restrict neighbour, const double *restrict share, const double *restrict loop,
                             const double *restrict binomial, const double *restrict kappa, const double *restrict weight, double *restrict work,
                             double *restrict x)
{
   double *restrict factor = (double *)(((uintptr_t)work + 31) & ~(uintptr_t)31);
   double *restrict psi = factor + most_terms;
   double *restrict p = psi + width * elements;

#define CARRY(vectors, chain) \
   carry(vectors, chain, coordinates, elements, degree, most_terms, terms, spring, damper, first, neighbour, share, loop, \
         binomial, kappa, weight, factor, psi, p, x)
   if (width == 4)
      chain ? CARRY(1, 1) : CARRY(1, 0);
   else if (width == 8)
      chain ? CARRY(2, 1) : CARRY(2, 0);
   else
      chain ? CARRY(3, 1) : CARRY(3, 0);
}

/* Numbers of two elements, each for both vectors. */
INLINE four twice(const double *p) { return (four){p[0], p[0], p[1], p[1]}; }

/* Carries a pair of vectors of a large train over a step, as `geartrain_step` does columns. The two numbers of an element lie together,
   and so do all elements. Derivatives are over factorials: Leibniz' rule has no binomials.
     rows, varying                  elements, and those of a varying kappa, which come first: both times two, rounded up to eights;
                                    what is of elements alone has half as many numbers
     degree, terms                  derivatives, terms of kappa
     spring, damper(row)            -W_nn kappa where it is constant, -W_nn gamma
     kappa(varying, terms + 1)      -W_nn kappa, and zeros
     diagonals                      of the matrix of the neighbours' shares, those that are worth being taken as a whole:
     offset, low, high(diagonal), share(row, diagonal)   column less row; range of rows, multiples of eight; elements
     rest                           rows with other elements:
     to, number(rest)               row, how many
     from, factor                   column, of one row after another; rows of equal number follow one another, which a processor foresees
     weight(degree + 1)             weights of the derivatives at the end
     work                           room for rows (degree + 4) + 32 numbers
     x(row, 2)                      displacements and velocities, in and out */
VERSIONS void geartrain_step_pair(int rows, int varying, int degree, int terms, const double *restrict spring,
                                  const double *restrict damper, const double *restrict kappa, int diagonals,
                                  const int *restrict offset, const int *restrict low, const int *restrict high,
                                  const double *restrict share, int rest, const int *restrict to, const int *restrict number,
                                  const int *restrict from, const double *restrict factor, const double *restrict weight, double *restrict work,
                                  double *restrict x)
{
   double *restrict margin = (double *)(((uintptr_t)work + 63) & ~(uintptr_t)63);
   double *restrict psi = margin + 8;
   double *restrict ahead = psi + rows + 8;
   double *restrict p = ahead + varying;

   for (int n = 0; n < 8; n += 4) {
      store(margin + n, (four){0});
      store(psi + rows + n, (four){0});
   }
   for (int n = 0; n < 2 * rows; n += 4)
      store(p + n, load(x + n));
   for (int k = 0; k < degree; k++) {
      const double *restrict here = p + k * rows;
      double *restrict next = p + (k + 2) * rows;
      const double scale = 1 / ((k + 1.0) * (k + 2.0)), rate = k + 1;
      const int last = terms < k + 1 ? terms : k + 1;
      for (int n = 0; n < rows; n += 4) {
         four sum = twice(spring + n / 2) * load(here + n) + rate * twice(damper + n / 2) * load(here + rows + n);
         if (n < varying && k % 2)
            sum += twice(kappa + n / 2) * load(here + n) + load(ahead + n);
         else if (n < varying) {
            /* What the terms make of the derivatives so far, for this product and for the next: each is fetched once. */
            four factor = twice(kappa + n / 2), part = {0};
            for (int l = 0; l < last; l++) {
               const four q = load(here - l * rows + n);
               sum += factor * q;
               factor = twice(kappa + ((l + 1) * varying + n) / 2);
               part += factor * q;
            }
            store(ahead + n, part);
         }
         sum *= scale;
         store(psi + n, sum);
         store(next + n, sum);
      }
      for (int d = 0; d < diagonals; d++)
         for (int n = low[d]; n < high[d]; n += 4)
            store(next + n, load(next + n) + twice(share + (d * rows + n) / 2) * load(psi + n + offset[d]));
      const int *restrict column = from;
      const double *restrict value = factor;
      for (int i = 0; i < rest; i++) {
         two sum = *(const two *)(next + to[i]);
         for (int j = 0; j < number[i]; j++)
            sum += *value++ * *(const two *)(psi + *column++);
         *(two *)(next + to[i]) = sum;
      }
   }
   for (int n = 0; n < rows; n += 4) {
      four displacement = {0}, velocity = {0};
      for (int k = 0; k <= degree; k++) {
         displacement += weight[k] * load(p + k * rows + n);
         velocity += (k + 1) * weight[k] * load(p + (k + 1) * rows + n);
      }
      store(x + n, displacement);
      store(x + rows + n, velocity);
   }
}
