/* OpenBLAS wakes its threads for matrices of a hundred rows, and they wait for each other longer than they compute: a response takes
   a quarter more processor time with two threads than with one. Another BLAS has no such call. */
extern void openblas_set_num_threads(int) __attribute__((weak));

void geartrain_one_blas_thread(void)
{
    if (openblas_set_num_threads)
        openblas_set_num_threads(1);
}
