/* The self-test with every table and every buffer in memory of its own, for a build with AddressSanitizer: an index outside
 * its own list is noticed, not only one outside the arena. With lines `list at bit` on standard input, each in a process of
 * its own on tables of which this bit is another and whose checksum fits: prints what the self-test says, and how it ended. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pattern.h"

static orbsoc_pattern changed;
static orbsoc_error open_apart(orbsoc_solver *solver, const orbsoc_pattern *pattern,
                               const orbsoc_settings *settings, orbsoc_real *work, size_t words,
                               double *numbers, size_t count);
static const orbsoc_pattern *tables_of_this_process(void) { return &changed; }
#define orbsoc_tables (*tables_of_this_process())
#define orbsoc_open open_apart
#define main selftest_main
#include "selftest.c"
#undef orbsoc_tables
#undef orbsoc_open
#undef main

#define LIMIT_S 20u

static void *own(const void *from, size_t bytes) {
  void *to = malloc(bytes);
  if (to == NULL) {
    abort();
  }
  memcpy(to, from, bytes);
  return to;
}

static double *numbers_apart(const double *from, const double *end) {
  return own(from, (size_t)(end - from) * sizeof(double));
}

static orbsoc_error open_apart(orbsoc_solver *s, const orbsoc_pattern *pattern,
                               const orbsoc_settings *settings, orbsoc_real *work, size_t words,
                               double *numbers, size_t count) {
  const orbsoc_error found = orbsoc_open(s, pattern, settings, work, words, numbers, count);
  if (found != ORBSOC_OK) {
    return found;
  }
  orbsoc_numbers *n = &s->numbers;
  const double *begins[] = {n->p, n->a, n->g, n->c, n->b, n->h, n->point[0], n->point[1],
                            n->certificate, n->work, numbers + count};
  double **to[] = {&n->p, &n->a, &n->g, &n->c, &n->b, &n->h, &n->point[0], &n->point[1],
                   &n->certificate, &n->work};
  for (size_t k = 0; k < sizeof to / sizeof to[0]; k++) {
    *to[k] = numbers_apart(begins[k], begins[k + 1]);
  }
  const orbsoc_real *end = s->scratch;
  s->scratch = own(end, pattern->scratch * sizeof(orbsoc_real));
  for (size_t k = ORBSOC_BUFFERS; k-- > 0;) {
    orbsoc_real *from = s->buffer[k];
    s->buffer[k] = own(from, (size_t)(end - from) * sizeof(orbsoc_real));
    end = from;
  }
  return ORBSOC_OK;
}

typedef struct {
  const void **list;
  size_t count, bytes;
} entry_t;

/* Each list of the tables by its number, as LISTS has them. */
static entry_t entry(size_t number) {
  orbsoc_pattern *p = &changed;
  const size_t wide = sizeof(orbsoc_index);
#define LIST(member, count) {(const void **)&p->member, (count), wide}
  const entry_t all[] = {
      LIST(cone_dims, p->cones), LIST(given_cone_dims, p->given_cones),
      LIST(cost.begins, p->n + 1u), LIST(cost.rows, p->nnz_p), LIST(equality.begins, p->n + 1u),
      LIST(equality.rows, p->nnz_a), LIST(conic.begins, p->n + 1u), LIST(conic.rows, p->nnz_g),
      LIST(given_conic.begins, p->n + 1u), LIST(given_conic.rows, p->given_nnz_g),
      LIST(row_origin, p->m), LIST(g_origin, p->nnz_g),
      {(const void **)&p->absent, p->given_m, 1}, LIST(kkt.begins, p->dim + 1u),
      LIST(kkt.rows, p->nnz_kkt), LIST(contiguous_columns, p->contiguous), LIST(position, p->dim),
      {(const void **)&p->positive, p->dim, 1}, LIST(from_p, p->nnz_p), LIST(from_a, p->nnz_a),
      LIST(from_g, p->nnz_g), LIST(orthant, p->l), LIST(soc, p->soc_words),
      {(const void **)&p->node, p->nodes, sizeof(orbsoc_node)},
      {(const void **)&p->update, p->updates, sizeof(orbsoc_update)}, LIST(row, p->rows),
      LIST(scatter_to, p->scatter), LIST(gather_from, p->gather), LIST(relative_row, p->relative),
      LIST(run_value, p->runs), LIST(run_length, p->runs), LIST(entry_target, p->targets)};
  return all[number];
}
#define LISTS 32u

static void copy_tables(void) {
  changed = orbsoc_tables;
  for (size_t k = 0; k < LISTS; k++) {
    const entry_t e = entry(k);
    *e.list = own(*e.list, e.count * e.bytes);
  }
}

/* Fields of a node count as numbers of their own, by their places in memory. */
static void change(size_t list, size_t at, unsigned bit) {
  const entry_t e = entry(list);
  unsigned char *bytes = (unsigned char *)(uintptr_t)*e.list;
  bytes[at + bit / 8u] = (unsigned char)(bytes[at + bit / 8u] ^ (1u << (bit % 8u)));
  changed.checksum = orbsoc_checksum(&changed);
}

int main(int count, char **names) {
  unsigned long list, at;
  unsigned bit;
  copy_tables();
  if (count < 2 || strcmp(names[1], "-") != 0) {
    return selftest_main();
  }
  while (scanf("%lu %lu %u", &list, &at, &bit) == 3) {
    (void)fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
      (void)alarm(LIMIT_S);
      (void)freopen("/dev/null", "w", stdout);
      change(list, at, bit);
      _exit(selftest_main() != 0 ? 1 : 0);
    }
    int status = 0;
    (void)waitpid(child, &status, 0);
    printf("%d\n", WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status));
  }
  return 0;
}
