/* What takes the time of python/fft.f90. In C, because only there a compiler makes a function in versions for several processors.
   Complex numbers that the stages go over are two arrays, real and imaginary parts, so that four stand side by side. */

#include <stdint.h>

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define VERSIONS __attribute__((target_clones("fma", "default"), optimize("O3")))
#define INLINE static inline __attribute__((always_inline, optimize("O3")))
#else
#define VERSIONS
#define INLINE static inline
#endif

typedef double four __attribute__((vector_size(32), aligned(8), may_alias));
typedef int64_t four_places __attribute__((vector_size(32)));
typedef struct { four re, im; } values;

#pragma GCC diagnostic ignored "-Wpsabi"
#define MIX(a, b, ...) __builtin_shuffle(a, b, (four_places){__VA_ARGS__})

/* Real and imaginary parts from place `i`; where fewer than four are left the other lanes are 0, and are not stored. */
INLINE values load(const double *re, const double *im, int i, int lanes)
{
   values v = {{0}, {0}};
   if (lanes == 4)
      return (values){*(const four *)(re + i), *(const four *)(im + i)};
   for (int l = 0; l < lanes; l++) {
      v.re[l] = re[i + l];
      v.im[l] = im[i + l];
   }
   return v;
}

INLINE void store(double *re, double *im, int i, int lanes, values v)
{
   if (lanes == 4) {
      *(four *)(re + i) = v.re;
      *(four *)(im + i) = v.im;
      return;
   }
   for (int l = 0; l < lanes; l++) {
      re[i + l] = v.re[l];
      im[i + l] = v.im[l];
   }
}

INLINE values all(double re, double im) { return (values){{re, re, re, re}, {im, im, im, im}}; }
INLINE values add(values a, values b) { return (values){a.re + b.re, a.im + b.im}; }
INLINE values subtract(values a, values b) { return (values){a.re - b.re, a.im - b.im}; }
INLINE values times(values a, values b) { return (values){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
INLINE values scale(double a, values b) { return (values){a * b.re, a * b.im}; }
/* Times -i. */
INLINE values turn(values a) { return (values){a.im, -a.re}; }

/* The transform of r values, r from 2 to 5, in place. */
INLINE void butterfly(const int r, values *x)
{
   if (r == 2) {
      values a = x[0];
      x[0] = add(a, x[1]);
      x[1] = subtract(a, x[1]);
   } else if (r == 3) {
      values total = add(x[1], x[2]), middle = subtract(x[0], scale(0.5, total));
      values turned = turn(scale(0.86602540378443864676, subtract(x[1], x[2])));
      x[0] = add(x[0], total);
      x[1] = add(middle, turned);
      x[2] = subtract(middle, turned);
   } else if (r == 4) {
      values even = add(x[0], x[2]), odd = add(x[1], x[3]), difference = subtract(x[0], x[2]), turned = turn(subtract(x[1], x[3]));
      x[0] = add(even, odd);
      x[1] = add(difference, turned);
      x[2] = subtract(even, odd);
      x[3] = subtract(difference, turned);
   } else {
      const double c1 = 0.30901699437494742410, c2 = -0.80901699437494742410;
      const double s1 = 0.95105651629515357212, s2 = 0.58778525229247312917;
      values near = add(x[1], x[4]), far = add(x[2], x[3]), turned = turn(subtract(x[1], x[4])), twice = turn(subtract(x[2], x[3]));
      values m1 = add(x[0], add(scale(c1, near), scale(c2, far))), t1 = add(scale(s1, turned), scale(s2, twice));
      values m2 = add(x[0], add(scale(c2, near), scale(c1, far))), t2 = subtract(scale(s2, turned), scale(s1, twice));
      x[0] = add(x[0], add(near, far));
      x[1] = add(m1, t1);
      x[4] = subtract(m1, t1);
      x[2] = add(m2, t2);
      x[3] = subtract(m2, t2);
   }
}

/* A stage: m transforms of r values, for every one of s interleaved series; root(k) = exp(-2 pi i k/(m s r)), `step` apart. */
INLINE void part(const int r, const int lanes, int s, int m, int p, int q, const values *w, const double *xr, const double *xi,
                 double *yr, double *yi)
{
   values x[5];
   for (int j = 0; j < r; j++)
      x[j] = load(xr, xi, q + s * (p + m * j), lanes);
   butterfly(r, x);
   store(yr, yi, q + s * r * p, lanes, x[0]);
   for (int j = 1; j < r; j++)
      store(yr, yi, q + s * (j + r * p), lanes, times(x[j], w[j]));
}

INLINE void stage(const int r, int s, int m, int step, const double *root, const double *xr, const double *xi,
                  double *yr, double *yi)
{
   for (int p = 0; p < m; p++) {
      values w[5];
      int q = 0;
      for (int j = 1; j < r; j++)
         w[j] = all(root[2 * j * p * s * step], root[2 * j * p * s * step + 1]);
      for (; q + 4 <= s; q += 4)
         part(r, 4, s, m, p, q, w, xr, xi, yr, yi);
      for (; q < s; q++)
         part(r, 1, s, m, p, q, w, xr, xi, yr, yi);
   }
}

/* The first stage of factor 4 has one series alone: so four of its m transforms go side by side. */
INLINE four transposed(const int row, const four *v)
{
   four low = row < 2 ? MIX(v[0], v[1], 0, 4, 1, 5) : MIX(v[0], v[1], 2, 6, 3, 7);
   four high = row < 2 ? MIX(v[2], v[3], 0, 4, 1, 5) : MIX(v[2], v[3], 2, 6, 3, 7);
   return row % 2 == 0 ? MIX(low, high, 0, 1, 4, 5) : MIX(low, high, 2, 3, 6, 7);
}

INLINE void first_stage(int m, int step, const double *root, const double *xr, const double *xi, double *yr, double *yi)
{
   for (int p = 0; p < m; p += 4) {
      const int lanes = m - p < 4 ? m - p : 4;
      values x[4];
      four re[4], im[4];
      for (int j = 0; j < 4; j++)
         x[j] = lanes == 4 ? load(xr, xi, p + m * j, 4) : load(xr, xi, p + m * j, lanes);
      butterfly(4, x);
      for (int j = 0; j < 4; j++) {
         values w = {{0}, {0}};
         for (int l = 0; l < 4; l++) {
            const int place = l < lanes ? 2 * j * (p + l) * step : 0;
            w.re[l] = root[place];
            w.im[l] = root[place + 1];
         }
         if (j > 0)
            x[j] = times(x[j], w);
         re[j] = x[j].re;
         im[j] = x[j].im;
      }
      store(yr, yi, 4 * p, 4, (values){transposed(0, re), transposed(0, im)});
      if (lanes > 1) store(yr, yi, 4 * p + 4, 4, (values){transposed(1, re), transposed(1, im)});
      if (lanes > 2) store(yr, yi, 4 * p + 8, 4, (values){transposed(2, re), transposed(2, im)});
      if (lanes > 3) store(yr, yi, 4 * p + 12, 4, (values){transposed(3, re), transposed(3, im)});
   }
}

VERSIONS void geartrain_split(int r, int s, int m, int step, const double *restrict root, const double *restrict x,
                              double *restrict y)
{
   const int n = r * s * m;
   if (r == 4 && s == 1)
      first_stage(m, step, root, x, x + n, y, y + n);
   else if (r == 2)
      stage(2, s, m, step, root, x, x + n, y, y + n);
   else if (r == 3)
      stage(3, s, m, step, root, x, x + n, y, y + n);
   else if (r == 4)
      stage(4, s, m, step, root, x, x + n, y, y + n);
   else
      stage(5, s, m, step, root, x, x + n, y, y + n);
}

/* Four complex numbers whose parts stand side by side, and in the other order. */
INLINE values get(const double *c)
{
   four a = *(const four *)c, b = *(const four *)(c + 4);
   return (values){MIX(a, b, 0, 2, 4, 6), MIX(a, b, 1, 3, 5, 7)};
}

INLINE void put(double *c, values v)
{
   *(four *)c = MIX(v.re, v.im, 0, 4, 1, 5);
   *(four *)(c + 4) = MIX(v.re, v.im, 2, 6, 3, 7);
}

INLINE values reversed(values v) { return (values){MIX(v.re, v.re, 3, 2, 1, 0), MIX(v.im, v.im, 3, 2, 1, 0)}; }
INLINE values one(const double *c) { return all(c[0], c[1]); }
INLINE values conjugate(values v) { return (values){v.re, -v.im}; }

/* Coefficients k and n - k of 2 n samples from those of the samples in pairs: even and odd ones are parted. */
INLINE void part_pair(values z, values mirror, values root, values *c, values *other)
{
   values even = scale(0.5, add(z, conjugate(mirror))), odd = scale(0.5, subtract(z, conjugate(mirror)));
   values turned = turn(times(odd, root));
   *c = add(even, turned);
   *other = conjugate(subtract(even, turned));
}

VERSIONS void geartrain_part(int n, const double *restrict root, const double *restrict w, double *restrict c)
{
   values a, b;
   int k = 1;

   c[0] = w[0] + w[n];
   c[1] = 0;
   c[2 * n] = w[0] - w[n];
   c[2 * n + 1] = 0;
   for (; 2 * k + 6 < n; k += 4) {
      part_pair(load(w, w + n, k, 4), reversed(load(w, w + n, n - k - 3, 4)), get(root + 2 * k), &a, &b);
      put(c + 2 * k, a);
      put(c + 2 * (n - k - 3), reversed(b));
   }
   for (; 2 * k <= n; k++) {
      part_pair(all(w[k], w[n + k]), all(w[n - k], w[2 * n - k]), one(root + 2 * k), &a, &b);
      c[2 * k] = a.re[0];
      c[2 * k + 1] = a.im[0];
      c[2 * (n - k)] = b.re[0];
      c[2 * (n - k) + 1] = b.im[0];
   }
}

/* The way back; conjugates, since the stages go forward. */
INLINE void join_pair(values c, values mirror, values root, values *z, values *other)
{
   values even = add(c, conjugate(mirror)), turned = turn(times(subtract(c, conjugate(mirror)), conjugate(root)));
   *z = conjugate(subtract(even, turned));
   *other = add(even, turned);
}

VERSIONS void geartrain_join(int n, const double *restrict root, const double *restrict c, double *restrict w)
{
   values a, b;
   int k = 1;

   w[0] = c[0] + c[2 * n];
   w[n] = c[2 * n] - c[0];
   for (; 2 * k + 6 < n; k += 4) {
      join_pair(get(c + 2 * k), reversed(get(c + 2 * (n - k - 3))), get(root + 2 * k), &a, &b);
      store(w, w + n, k, 4, a);
      store(w, w + n, n - k - 3, 4, reversed(b));
   }
   for (; 2 * k <= n; k++) {
      join_pair(one(c + 2 * k), one(c + 2 * (n - k)), one(root + 2 * k), &a, &b);
      w[k] = a.re[0];
      w[n + k] = a.im[0];
      w[n - k] = b.re[0];
      w[2 * n - k] = b.im[0];
   }
}
