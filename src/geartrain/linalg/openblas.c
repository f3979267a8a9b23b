#include <stdlib.h>
#include <string.h>

/* Another BLAS has no such calls. */
extern void openblas_set_num_threads(int) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));
extern char *openblas_get_corename(void) __attribute__((weak));
extern void gotoblas_dynamic_init(void) __attribute__((weak));
extern void gotoblas_dynamic_quit(void) __attribute__((weak));

/* Lets OpenBLAS use so many threads, and tells how many there were; 0: it is not there.
   OpenBLAS wakes its threads for matrices of a hundred rows, and they wait for each other longer than they compute: with two
   threads and other work beside it a response takes several times as long as with one. */
int geartrain_blas_threads(int number)
{
    int before = 0;

    if (openblas_set_num_threads && openblas_get_num_threads) {
        before = openblas_get_num_threads();
        openblas_set_num_threads(number);
    }
    return before;
}

/* OpenBLAS chooses its kernels by the model of the processor. On a model newer than itself it takes those of 2004, which are three
   times slower: those of the newest models that it knows are named in their place, and it chooses anew. */
void geartrain_blas_kernels(void)
{
#ifdef __x86_64__
    const char *kernels = NULL;

    if (!openblas_get_corename || !gotoblas_dynamic_init || !gotoblas_dynamic_quit || getenv("OPENBLAS_CORETYPE")) return;
    if (strcmp(openblas_get_corename(), "Prescott") != 0) return;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels = "Haswell";
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")
        && __builtin_cpu_supports("avx512vl")) kernels = "SkylakeX";
    if (!kernels) return;
    setenv("OPENBLAS_CORETYPE", kernels, 0);
    gotoblas_dynamic_quit();
    gotoblas_dynamic_init();
#endif
}
