// OpenBLAS calls this function of its own at load time to get the number of its threads. This
// definition replaces it; another BLAS does not call it. The frontal matrices of these networks are
// too small to be shared between threads. A thread pool would need memory that a limited process
// may not have.
extern "C" int openblas_num_threads_env() { return 1; }
