/* The solver for a computer on board: fixed C99, tables of one sparsity pattern, one block of
 * memory.
 *
 * min 1/2 x'Px + c'x   s.t.   Ax = b,   Gx + s = h,   s in R+^l x Q^q1 x ... x Q^qk
 *
 * Usage: orbsoc_open, orbsoc_set_c (and _b, _h, _p, _a, _g), orbsoc_solve or orbsoc_solve_from;
 * then read `solution`. Nothing is allocated, nothing is global; two solvers in two blocks of
 * memory are independent. ORBSOC_FP (64, 32) is the arithmetic of the iteration; the certificate is
 * always binary64. ORBSOC_INDEX_BITS (16, 32) is the width of the tables. */
#ifndef ORBSOC_FLIGHT_H
#define ORBSOC_FLIGHT_H

#include <stddef.h>
#include <stdint.h>

#ifndef ORBSOC_FP
#define ORBSOC_FP 64
#endif
#ifndef ORBSOC_INDEX_BITS
#define ORBSOC_INDEX_BITS 16
#endif

#if ORBSOC_FP == 64
typedef double orbsoc_real;
#elif ORBSOC_FP == 32
typedef float orbsoc_real;
#else
#error "ORBSOC_FP is 64 or 32"
#endif

#if ORBSOC_INDEX_BITS == 16
typedef uint16_t orbsoc_index;
#elif ORBSOC_INDEX_BITS == 32
typedef uint32_t orbsoc_index;
#else
#error "ORBSOC_INDEX_BITS is 16 or 32"
#endif

/* What a call refuses. */
typedef enum {
  ORBSOC_OK = 0,
  ORBSOC_NO_POINTER = 1,    /* an argument is missing */
  ORBSOC_WRONG_WIDTH = 2,   /* tables of another index width or of another version */
  ORBSOC_TABLES_CHANGED = 3, /* the checksum of the tables is not theirs */
  ORBSOC_SMALL_MEMORY = 4,  /* fewer words than the pattern needs */
  ORBSOC_BAD_VALUE = 5,     /* not finite, or +infinity where a row of the pattern is present */
  ORBSOC_BAD_SETTING = 6,   /* a setting outside its range */
  ORBSOC_NO_DATA = 7,       /* a solve before all data were set */
  ORBSOC_WRONG_ARITHMETIC = 8 /* the compiler does not round every operation as IEEE 754 asks */
} orbsoc_error;

/* Outcome of a solve, supported by numbers recomputed on the original data. */
typedef enum {
  ORBSOC_SOLVED = 0,
  ORBSOC_SOLVED_INACCURATE = 1,
  ORBSOC_PRIMAL_INFEASIBLE = 2,
  ORBSOC_DUAL_INFEASIBLE = 3,
  ORBSOC_MAX_ITERATIONS = 4,
  ORBSOC_MAX_TIME = 5,
  ORBSOC_NUMERICAL_LIMIT = 6,
  ORBSOC_INTERRUPTED = 7
} orbsoc_status;

typedef enum {
  ORBSOC_NO_START = 0,
  ORBSOC_START_USED = 1,
  ORBSOC_START_FELL_BACK = 2
} orbsoc_warm_start;

/* The settings of `orbsoc.Settings` that a solve reads, with its names. */
typedef struct {
  double tol;
  double tol_inaccurate;
  double static_regularization;
  double pivot_floor;
  double dynamic_regularization;
  double refinement_tol;
  double refinement_share;
  double step_fraction;
  uint32_t max_iterations;
  uint32_t refinement_max;
  uint32_t ruiz_passes;
  uint32_t max_restarts; /* 0 where a deadline is hard */
} orbsoc_settings;

/* Positions of a sparse matrix's entries: column j has entries begins[j] up to begins[j + 1]. */
typedef struct {
  const orbsoc_index *begins;
  const orbsoc_index *rows;
} orbsoc_matrix;

typedef enum {
  ORBSOC_SUPERNODE = 0,
  ORBSOC_TWINS = 1,
  ORBSOC_CONDENSED = 2,
  ORBSOC_LEAVES = 3
} orbsoc_kind;

/* Adjacent columns of the factor that share a panel of `width` columns of `leading` entries. */
typedef struct {
  uint8_t kind;      /* an orbsoc_kind */
  uint8_t scattered; /* it contributes entry by entry */
  orbsoc_index width;
  orbsoc_index diagonal; /* size of its diagonal blocks */
  orbsoc_index leading;
  orbsoc_index updates; /* number of blocks that it contributes to, when it is not scattered */
} orbsoc_node;

/* Rows lo..hi of a node's panel are columns of node `target`. */
typedef struct {
  orbsoc_index target;
  orbsoc_index lo;
  orbsoc_index hi;
} orbsoc_update;

/* The tables of a pattern; generated, constant, and covered by a checksum. */
typedef struct {
  uint32_t version;
  uint32_t index_bits;
  uint32_t n;       /* variables */
  uint32_t p;       /* equality rows */
  uint32_t m;       /* cone rows without absent ones */
  uint32_t l;       /* nonnegative rows among them, which come first */
  uint32_t cones;   /* second-order cones of dimension 2 or more */
  uint32_t given_m; /* cone rows as given */
  uint32_t given_l;
  uint32_t given_cones;
  uint32_t nnz_p; /* upper triangle */
  uint32_t nnz_a;
  uint32_t nnz_g;
  uint32_t given_nnz_g;
  uint32_t dim; /* of the KKT matrix */
  uint32_t nnz_kkt;
  uint32_t contiguous; /* numbers in contiguous_columns */
  uint32_t nodes;
  uint32_t updates;
  uint32_t rows; /* numbers in each of these tables */
  uint32_t scatter;
  uint32_t gather;
  uint32_t relative;
  uint32_t runs;
  uint32_t panel_entries;
  uint32_t scratch;      /* words that kernels need for themselves */
  uint32_t work_words;   /* words of orbsoc_real that a solve needs */
  uint32_t number_words; /* doubles that a solve needs */
  uint32_t soc_words;    /* numbers in soc, */
  uint32_t targets;      /* and in entry_target */
  uint32_t size_checksum; /* CRC-32 of the sizes above, */
  uint32_t checksum;      /* and of all tables below */
  orbsoc_matrix cost;
  orbsoc_matrix equality;
  orbsoc_matrix conic;
  orbsoc_matrix given_conic;
  const orbsoc_index *cone_dims;
  const orbsoc_index *given_cone_dims;
  const orbsoc_index *row_origin;
  const orbsoc_index *g_origin;
  const uint8_t *absent; /* of each row as given */
  orbsoc_matrix kkt;
  const orbsoc_index *contiguous_columns; /* first and end of each block */
  const orbsoc_index *position;
  const uint8_t *positive;
  const orbsoc_index *from_p;
  const orbsoc_index *from_a;
  const orbsoc_index *from_g;
  const orbsoc_index *orthant;
  const orbsoc_index *soc;
  const orbsoc_node *node;
  const orbsoc_update *update;
  const orbsoc_index *row;
  const orbsoc_index *scatter_to;
  const orbsoc_index *gather_from;
  const orbsoc_index *relative_row;
  const orbsoc_index *run_value;
  const orbsoc_index *run_length;
  const orbsoc_index *entry_target;
} orbsoc_pattern;

/* Buffers of a solve, numbered as in the method's dataflow table. The first four are empty:
 * equilibration reads the given data themselves. */
typedef enum {
  ORBSOC_RAW_P, ORBSOC_RAW_A, ORBSOC_RAW_G, ORBSOC_RAW_Q, ORBSOC_START, ORBSOC_NORMS,
  ORBSOC_PARAMETERS, ORBSOC_P, ORBSOC_A, ORBSOC_G, ORBSOC_Q, ORBSOC_SCALE, ORBSOC_SCALE_INVERSE,
  ORBSOC_COST_SCALE, ORBSOC_POINT, ORBSOC_SLACK, ORBSOC_HOMOGENIZER, ORBSOC_RESIDUAL,
  ORBSOC_COST_PRODUCT, ORBSOC_EMBEDDING, ORBSOC_CENTERING, ORBSOC_STATISTICS, ORBSOC_W,
  ORBSOC_LAMBDA, ORBSOC_LAMBDA_INVERSE, ORBSOC_CONE, ORBSOC_KKT_VALUES, ORBSOC_REGULARIZATION,
  ORBSOC_FACTOR_L, ORBSOC_PIVOT_INVERSE, ORBSOC_KKT_RHS, ORBSOC_KKT_SOLUTION, ORBSOC_KKT_ERROR,
  ORBSOC_MULTI_RHS, ORBSOC_MULTI_SOLUTION, ORBSOC_MULTI_ERROR, ORBSOC_REFINEMENT_TOLERANCE,
  ORBSOC_REFINEMENT, ORBSOC_MULTI_REFINEMENT, ORBSOC_REFINEMENT_ACTIVE, ORBSOC_CONSTANT_SOLUTION,
  ORBSOC_STEP, ORBSOC_TAU_STEP, ORBSOC_SCALED_Z, ORBSOC_SCALED_S, ORBSOC_SLACK_STEP,
  ORBSOC_COMPLEMENTARITY_RHS, ORBSOC_CONE_DIVISION, ORBSOC_STEP_LENGTH, ORBSOC_BOUNDARY_FRACTION,
  ORBSOC_STEP_TAKEN, ORBSOC_CONTROL, ORBSOC_VERDICT, ORBSOC_BEST, ORBSOC_PRIMAL_CERTIFICATE,
  ORBSOC_DUAL_CERTIFICATE, ORBSOC_UNSCALED_ITERATE, ORBSOC_UNSCALED_CERTIFICATES, ORBSOC_BUFFERS
} orbsoc_buffer;

/* Where a solve ran, and what became of it there; see orbsoc_attach. */
typedef enum {
  ORBSOC_ON_CORE = 0,      /* no device is attached */
  ORBSOC_ON_DEVICE = 1,    /* as the partition says */
  ORBSOC_SECOND_TRY = 2,   /* the same, after a first try that event[0] ended */
  ORBSOC_FELL_BACK = 3     /* on the core alone, after event[0] and event[1] */
} orbsoc_place;

/* Why a try on the device is not believed: below 256 the device's own code, or one of these. */
typedef enum {
  ORBSOC_NO_EVENT = 0,
  ORBSOC_ANSWER_REFUSED = 256, /* no certificate on the original data supports its answer */
  ORBSOC_DEVICE_LATE = 257,    /* a launch did not end within the device's patience */
  ORBSOC_DEVICE_ENDLESS = 258  /* more stages than an attempt can have */
} orbsoc_event;

/* A primal-dual point with the residuals that its own data support. */
typedef struct {
  orbsoc_status status;
  orbsoc_place place;
  uint32_t event[2]; /* of the first and the second try on a device; an orbsoc_event or its code */
  orbsoc_warm_start warm_start;
  uint32_t iterations;
  uint32_t refinements;
  uint32_t attempts;
  double objective;
  double dual_objective;
  double primal_residual; /* ratios of the status table; NaN with a certificate of infeasibility */
  double dual_residual;
  double gap;
  double radius; /* of a certificate of infeasibility; NaN otherwise */
  const double *x;
  const double *y;
  const double *z;
  const double *s; /* +infinity on absent rows */
} orbsoc_solution;

/* Asked at each iteration; what is not 0 ends the solve with its best iterate. */
typedef enum { ORBSOC_GO_ON = 0, ORBSOC_STOP_NOW = 6, ORBSOC_TIME_IS_UP = 8 } orbsoc_answer;
typedef orbsoc_answer (*orbsoc_ask)(void *context);

/* The given data and the points of the certificate, in binary64. */
typedef struct {
  double *p, *a, *g, *c, *b, *h;
  double *point[2];     /* (x, y, z, s) of a finished attempt, and of one before it */
  double *certificate;  /* (x, y, z) of a certificate of infeasibility */
  double *work;         /* 5 n + 3 p + 6 given_m */
} orbsoc_numbers;

/* ---- modules that run elsewhere ---- */

/* Segments of a partition: the problem's data, the stages in the order of the method's dataflow
 * table from 1 on, and whole attempts from cold and from a given point. */
enum { ORBSOC_DATA_SEGMENT = 0, ORBSOC_COLD_SEGMENT = 34, ORBSOC_WARM_SEGMENT = 35,
       ORBSOC_SEGMENT_ROWS = 36 };

/* Buffers that a segment reads from outside and writes: bit k is the orbsoc_buffer k. */
typedef struct {
  uint64_t reads, writes;
} orbsoc_dataflow;

/* Which modules run on the device; generated. */
typedef struct {
  uint32_t modules;  /* bit k: 1 matrix update, 2 matrix scaling, 3 factorization, 4 linear solve,
                        5 cone operations, 6 line search, 7 statistics */
  uint32_t resident; /* 1: it runs whole attempts by itself */
  const orbsoc_dataflow *segment; /* ORBSOC_SEGMENT_ROWS of them */
} orbsoc_partition;

#define ORBSOC_DEVICE_RUNS 0xffffffffu

/* What a driver fills in for its device. Each function returns 0, or a code from 1 to 255 after
 * which the try is given up. Words are the buffer's, from its first on; the device takes and gives
 * those that it has a place for. */
typedef struct {
  void *context;
  uint32_t patience; /* calls of `wait` that a launch may take */
  /* Into a known state: no data, nothing running; with `reload`, the program loaded afresh. */
  uint32_t (*restart)(void *context, uint32_t reload);
  uint32_t (*put)(void *context, uint32_t buffer, const orbsoc_real *words);
  uint32_t (*get)(void *context, uint32_t buffer, orbsoc_real *words);
  /* The core has run this segment; the device need only know. */
  uint32_t (*publish)(void *context, uint32_t segment);
  /* Begin a segment whose inputs are there. */
  uint32_t (*launch)(void *context, uint32_t segment);
  /* Look, for a while, whether it has ended: 0, or ORBSOC_DEVICE_RUNS. */
  uint32_t (*wait)(void *context);
  /* Ask an attempt to end with its best iterate; may be a null pointer. */
  uint32_t (*stop)(void *context);
} orbsoc_device;

typedef struct {
  const orbsoc_pattern *pattern;
  orbsoc_settings settings;
  orbsoc_real *buffer[ORBSOC_BUFFERS];
  orbsoc_real *scratch;
  orbsoc_numbers numbers;
  uint32_t given; /* one bit for each of the six data that were set */
  uint32_t kept;  /* the matrices are equilibrated (1), and in the KKT matrix (2) */
  orbsoc_ask ask; /* may be a null pointer */
  void *context;
  uint32_t attempt;
  uint32_t spent;          /* iterations of earlier attempts */
  uint32_t refined_before; /* refinement steps of earlier attempts */
  uint32_t restarts;
  orbsoc_warm_start warm_start;
  uint32_t stop; /* why the attempt ended */
  orbsoc_solution solution;
  orbsoc_solution earlier; /* of an attempt that stalled */
  uint32_t has_earlier;
  const orbsoc_partition *partition; /* null: all on the core */
  orbsoc_device device;
  uint32_t away;       /* this try uses the device */
  uint32_t loaded;     /* its program is there, and the last try was believed */
  uint32_t event;      /* why this try is not believed */
  uint32_t segments;   /* run in this attempt */
  uint64_t held_here;  /* buffers whose last words the core has, */
  uint64_t held_there; /* and the device */
} orbsoc_solver;

/* Lay a solver's memory out: `work` has pattern->work_words words, `numbers` pattern->number_words.
 * The tables are checked against their checksum. */
orbsoc_error orbsoc_open(orbsoc_solver *solver, const orbsoc_pattern *pattern,
                         const orbsoc_settings *settings, orbsoc_real *work, size_t work_words,
                         double *numbers, size_t number_words);

/* The data, entries of matrices column by column: P's upper triangle, A, G as given. Refused data
 * leave the old ones. */
orbsoc_error orbsoc_set_p(orbsoc_solver *solver, const double *values);
orbsoc_error orbsoc_set_a(orbsoc_solver *solver, const double *values);
orbsoc_error orbsoc_set_g(orbsoc_solver *solver, const double *values);
orbsoc_error orbsoc_set_c(orbsoc_solver *solver, const double *values);
orbsoc_error orbsoc_set_b(orbsoc_solver *solver, const double *values);
orbsoc_error orbsoc_set_h(orbsoc_solver *solver, const double *values);

/* Solve from cold; the outcome is solver->solution. */
orbsoc_error orbsoc_solve(orbsoc_solver *solver);

/* The same from a point nearby, in the user's units and rows. Never a worse status than from cold,
 * as long as settings.max_restarts is not 0. */
orbsoc_error orbsoc_solve_from(orbsoc_solver *solver, const double *x, const double *y,
                               const double *z, const double *s);

/* Have a device run the partition's modules from the next solve on; with null pointers, none. A try
 * that ends by an error, late, or with an answer that the certificate refuses is made once more,
 * with the program loaded afresh; then the solve is made on the core alone. solution.place and
 * solution.event say what happened; the answer is certified on the original data each time. */
orbsoc_error orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition,
                           const orbsoc_device *device);

/* The checksums of a pattern's sizes and tables as they are in memory. */
uint32_t orbsoc_size_checksum(const orbsoc_pattern *pattern);
uint32_t orbsoc_checksum(const orbsoc_pattern *pattern);

/* A word more in a CRC-32 that is not complemented yet. */
uint32_t orbsoc_crc_word(uint32_t crc, uint32_t word);

/* The name of a status, as in other languages and in files. */
const char *orbsoc_status_name(orbsoc_status status);

#endif
