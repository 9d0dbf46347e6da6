// OpenBLAS asks this function of its own, when it is loaded, how many threads to keep; ours stands
// in front of it. The fronts of these networks are too small to share, and a pool of threads costs
// memory that a limited process may not have.
extern "C" int openblas_num_threads_env() { return 1; }
