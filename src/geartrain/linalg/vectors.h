/* Vectors of numbers for functions in C that are made in versions for several processors: wider vectors and fused products halve
   the time on machines that have them, and only in C does a compiler make such versions. */

#include <stdint.h>

#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
#define VERSIONS __attribute__((target_clones("fma", "default"), optimize("O3")))
#define INLINE static inline __attribute__((always_inline, optimize("O3")))
#else
#define VERSIONS
#define INLINE static inline
#endif

/* At any address of a number. Not wider: a compiler takes eight numbers through memory, at a tenth of the speed, where the processor
   has four side by side. */
typedef double two __attribute__((vector_size(16), aligned(8), may_alias));
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Inlined, so that how a vector would be returned, which differs between processors, does not matter. */
#pragma GCC diagnostic ignored "-Wpsabi"
INLINE four load(const double *p) { return *(const four *)p; }
INLINE void store(double *p, four v) { *(four *)p = v; }
