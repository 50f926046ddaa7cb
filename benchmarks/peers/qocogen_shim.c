/* One call into a solver that QOCOGEN generated: numbers in, point and clock out. The workspace is static. */
#include <string.h>
#include <time.h>

#include "qoco_custom.h"

static Workspace work;

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Arrays have the sizes and the entry order of the problem that the code was generated for. */
int orbsoc_solve(const double *P, const double *c, const double *A, const double *b, const double *G, const double *h,
                 int nnz_p, int nnz_a, int nnz_g, double tol, double regularisation, double *x, double *y, double *z,
                 int *iterations, double *setup_s, double *solve_s) {
    double started = seconds();
    memset(&work, 0, sizeof work);
    set_default_settings(&work);
    work.settings.verbose = 0;
    work.settings.abstol = work.settings.reltol = tol;
    if (regularisation > 0.0) work.settings.kkt_static_reg = regularisation;
    load_data(&work);
    if (nnz_p) memcpy(work.P, P, sizeof(double) * (size_t)nnz_p);
    memcpy(work.c, c, sizeof(double) * (size_t)work.n);
    memcpy(work.A, A, sizeof(double) * (size_t)nnz_a);
    memcpy(work.b, b, sizeof(double) * (size_t)work.p);
    memcpy(work.G, G, sizeof(double) * (size_t)nnz_g);
    memcpy(work.h, h, sizeof(double) * (size_t)work.m);
    double loaded = seconds();
    qoco_custom_solve(&work);
    *solve_s = seconds() - loaded;
    *setup_s = loaded - started;
    memcpy(x, work.sol.x, sizeof(double) * (size_t)work.n);
    memcpy(y, work.sol.y, sizeof(double) * (size_t)work.p);
    memcpy(z, work.sol.z, sizeof(double) * (size_t)work.m);
    *iterations = work.sol.iters;
    return work.sol.status;
}
