/* The steps of the flow of the linearised train (linear_flow.f90). A step waits for the step before, so the period is cut into eight
   segments whose steps are taken side by side: of what is known at the steps, the numbers of all segments lie together. */

#include "../linalg/vectors.h"

/* Four rows of four numbers each become its columns. */
INLINE void turn(four *restrict v)
{
   const four a = __builtin_shufflevector(v[0], v[1], 0, 4, 2, 6), b = __builtin_shufflevector(v[0], v[1], 1, 5, 3, 7);
   const four c = __builtin_shufflevector(v[2], v[3], 0, 4, 2, 6), d = __builtin_shufflevector(v[2], v[3], 1, 5, 3, 7);
   v[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
   v[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
   v[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
   v[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/* to(column, row) = from(row, column) of 8 rows or columns; the other number is a multiple of 4. */
VERSIONS void geartrain_transpose(int rows, int columns, const double *restrict from, double *restrict to)
{
   for (int row = 0; row < rows; row += 4)
      for (int column = 0; column < columns; column += 4) {
         four v[4];
         for (int i = 0; i < 4; i++)
            v[i] = load(from + (column + i) * rows + row);
         turn(v);
         for (int i = 0; i < 4; i++)
            store(to + (row + i) * columns + column, v[i]);
      }
}

/* Steps of all segments.
     elements, unknowns, steps      numbers of elements, at most 24, of unknown meshes and of steps of a segment
     element(unknown)               element of each unknown mesh, counted from 1
     h                              length of a step
     mass(element, element)         velocity that a force on the second element takes from the first in a step
     spring, damper(element)        stiffness of the linear elements and damping of all
     stiffness, drive(segment, step, unknown)   stiffness of the unknown meshes along the motion and their force besides
     p, v(segment, element)         displacements and velocities at the beginning of each segment, at its end afterwards
     y(segment, step, unknown)      displacements of the unknown meshes */
VERSIONS void geartrain_flow_steps(int elements, int unknowns, int steps, const int *restrict element, double h, const double *restrict mass,
                                   const double *restrict spring, const double *restrict damper, const double *restrict stiffness,
                                   const double *restrict drive, double *restrict p, double *restrict v, double *restrict y)
{
   four force[24][2];

   for (int k = 0; k < steps; k++) {
      for (int n = 0; n < elements; n++)
         for (int i = 0; i < 2; i++)
            force[n][i] = spring[n] * load(p + 8 * n + 4 * i) + damper[n] * load(v + 8 * n + 4 * i);
      for (int u = 0; u < unknowns; u++) {
         const int n = element[u] - 1, at = 8 * (u * steps + k);
         for (int i = 0; i < 2; i++) {
            const four here = load(p + 8 * n + 4 * i);
            store(y + at + 4 * i, here);
            force[n][i] += load(stiffness + at + 4 * i) * here + load(drive + at + 4 * i);
         }
      }
      for (int n = 0; n < elements; n++) {
         four speed[2] = {load(v + 8 * n), load(v + 8 * n + 4)};
         for (int m = 0; m < elements; m++)
            for (int i = 0; i < 2; i++)
               speed[i] -= mass[m * elements + n] * force[m][i];
         for (int i = 0; i < 2; i++) {
            store(v + 8 * n + 4 * i, speed[i]);
            store(p + 8 * n + 4 * i, load(p + 8 * n + 4 * i) + h * speed[i]);
         }
      }
   }
}

/* Of so many states side by side. */
INLINE void add_states(int side_by_side, int states, int steps, const double *restrict influence, const double *restrict force,
                       double *restrict added)
{
   four sum[8];

   for (int i = 0; i < 2 * side_by_side; i++)
      sum[i] = load(added + 4 * i);
   for (int k = 0; k < steps; k++) {
      const four here[2] = {load(force + 8 * k), load(force + 8 * k + 4)};
      for (int i = 0; i < 2 * side_by_side; i++)
         sum[i] += here[i % 2] * load(influence + 8 * k * states + 4 * i);
   }
   for (int i = 0; i < 2 * side_by_side; i++)
      store(added + 4 * i, sum[i]);
}

/* Adds what forces at the steps add to the end states of the segments: influence(segment, state, step) per force(segment, step).
   A sum waits for the sum before, so four states are summed side by side. */
VERSIONS void geartrain_add_influence(int states, int steps, const double *restrict influence, const double *restrict force,
                                      double *restrict added)
{
   int l = 0;

   for (; l + 4 <= states; l += 4)
      add_states(4, states, steps, influence + 8 * l, force, added + 8 * l);
   for (; l < states; l++)
      add_states(1, states, steps, influence + 8 * l, force, added + 8 * l);
}

/* Carries functionals of the end states of the segments back over the steps, to the states at their beginnings. The last functional
   is a sum over the steps, with weights row(segment, step, unknown).
     functionals                    their number, 2 elements + 1
     p, v(segment, functional, element)   factors of displacements and velocities, in and out
     force(segment, functional, element)  work space
     influence(segment, functional, step, unknown)   what a force on an unknown mesh at a step adds to the functionals
   The rest as in geartrain_flow_steps. */
VERSIONS void geartrain_carry_back(int elements, int unknowns, int steps, int functionals, const int *restrict element, double h,
                                   const double *restrict mass, const double *restrict spring, const double *restrict damper,
                                   const double *restrict stiffness, const double *restrict row, double *restrict p, double *restrict v,
                                   double *restrict force, double *restrict influence)
{
   const int all = 8 * functionals;

   for (int k = steps - 1; k >= 0; k--) {
      for (int l = 0; l < elements * all; l += 4)
         store(v + l, load(v + l) + h * load(p + l));
      for (int n = 0; n < elements; n++)
         for (int l = 0; l < all; l += 4) {
            four sum = {0};
            for (int m = 0; m < elements; m++)
               sum -= mass[n * elements + m] * load(v + m * all + l);
            store(force + n * all + l, sum);
         }
      for (int n = 0; n < elements; n++)
         for (int l = n * all; l < (n + 1) * all; l += 4) {
            store(p + l, load(p + l) + spring[n] * load(force + l));
            store(v + l, load(v + l) + damper[n] * load(force + l));
         }
      for (int i = 0; i < unknowns; i++) {
         const int at = i * steps + k;
         double *restrict q = p + (element[i] - 1) * all;
         const double *restrict f = force + (element[i] - 1) * all;
         const four stiff[2] = {load(stiffness + 8 * at), load(stiffness + 8 * at + 4)};
         for (int l = 0; l < all; l += 4) {
            store(q + l, load(q + l) + stiff[l / 4 % 2] * load(f + l));
            store(influence + at * all + l, load(f + l));
         }
         for (int l = 0; l < 8; l += 4)
            store(q + all - 8 + l, load(q + all - 8 + l) + load(row + 8 * at + l));
      }
   }
}
