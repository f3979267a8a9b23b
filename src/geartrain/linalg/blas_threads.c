/* OpenBLAS wakes its threads for matrices of a hundred rows, and they wait for each other longer than they compute: with two threads
   and other work beside it a response takes several times as long as with one. Another BLAS has no such calls. */
extern void openblas_set_num_threads(int) __attribute__((weak));
extern int openblas_get_num_threads(void) __attribute__((weak));

/* Lets OpenBLAS use so many threads, and tells how many there were; 0: it is not there. */
int geartrain_blas_threads(int number)
{
    int before = 0;

    if (openblas_set_num_threads && openblas_get_num_threads) {
        before = openblas_get_num_threads();
        openblas_set_num_threads(number);
    }
    return before;
}
