/* CRC-32 of a mission's tables, of their numbers' bits, the same for either order of bytes. */
#include <string.h>

#include "insertion.h"

static uint32_t add_numbers(uint32_t crc, const double *numbers, size_t count) {
  for (size_t k = 0; k < count; k++) {
    uint64_t bits;
    (void)memcpy(&bits, &numbers[k], sizeof bits);
    crc = orbsoc_crc_word(crc, (uint32_t)(bits & 0xffffffffu));
    crc = orbsoc_crc_word(crc, (uint32_t)(bits >> 32));
  }
  return crc;
}

static uint32_t add_places(uint32_t crc, const orbsoc_index *places, size_t count) {
  for (size_t k = 0; k < count; k++) { crc = orbsoc_crc_word(crc, places[k]); }
  return crc;
}

static uint32_t add_sizes(uint32_t crc, const orbsoc_insertion *m) {
  const uint32_t sizes[] = {m->nodes, m->entries_a, m->entries_g, m->variables, m->equality_rows,
                            m->cone_rows, m->control_column, m->end_column, m->duration_column,
                            m->above_column, m->below_column, m->end_row, m->target_row,
                            m->longest_row, m->max_subproblems, m->guess_steps, m->check_steps,
                            m->check_samples};
  for (size_t k = 0; k < sizeof(sizes) / sizeof(sizes[0]); k++) {
    crc = orbsoc_crc_word(crc, sizes[k]);
  }
  return crc;
}

static uint32_t add_constants(uint32_t crc, const orbsoc_insertion *m) {
  const double scales[] = {m->length_m, m->speed_m_s, m->time_s, m->acceleration, m->flow,
                           m->longest, m->guess, m->shortest, m->slack_weight};
  const double sizes[] = {m->target.momentum, m->target.eccentricity};
  const double rules[] = {m->rules.step_tol, m->rules.slack_tol, m->rules.infeasible_slack,
                          m->rules.loose_tol, m->rules.tight_tol, m->rules.tighten_below,
                          m->rules.usable_residual, m->rules.final_residual};
  const double limits[] = {m->limits.momentum_rel, m->limits.laplace, m->limits.plane_slope,
                           m->limits.thrust_excess};
  crc = add_numbers(crc, scales, sizeof(scales) / sizeof(scales[0]));
  crc = add_numbers(crc, m->target.normal, 3);
  crc = add_numbers(crc, m->target.perigee, 3);
  crc = add_numbers(crc, m->target.ahead, 3);
  crc = add_numbers(crc, sizes, sizeof(sizes) / sizeof(sizes[0]));
  crc = add_numbers(crc, rules, sizeof(rules) / sizeof(rules[0]));
  return add_numbers(crc, limits, sizeof(limits) / sizeof(limits[0]));
}

uint32_t orbsoc_insertion_checksum(const orbsoc_insertion *m) {
  const size_t nodes = m->nodes;
  uint32_t crc = add_constants(add_sizes(0xffffffffu, m), m);
  crc = add_numbers(crc, m->grid.node, nodes);
  crc = add_numbers(crc, m->grid.weight, nodes);
  crc = add_numbers(crc, m->grid.from_start, nodes);
  crc = add_numbers(crc, m->grid.barycentric, nodes);
  crc = add_numbers(crc, m->fixed.a, m->entries_a);
  crc = add_numbers(crc, m->fixed.g, m->entries_g);
  crc = add_numbers(crc, m->fixed.c, m->variables);
  crc = add_numbers(crc, m->fixed.h, m->cone_rows);
  crc = add_places(crc, m->place.state, (size_t)ORBSOC_BY_STATE * nodes);
  crc = add_places(crc, m->place.control, 3u * nodes);
  crc = add_places(crc, m->place.duration, 6u * nodes);
  crc = add_places(crc, m->place.end_state, (size_t)ORBSOC_BY_STATE * nodes);
  crc = add_places(crc, m->place.end_control, 3u * nodes);
  crc = add_places(crc, m->place.end_duration, 6);
  crc = add_places(crc, m->place.target, (size_t)ORBSOC_TARGET_ROWS * 6u);
  return crc ^ 0xffffffffu;
}
