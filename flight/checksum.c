/* CRC-32 (IEEE 802.3) of a pattern's sizes and tables, of their numbers and not of their bytes in
 * memory, so that it is the same for either order of bytes. */
#include "orbsoc_flight.h"

#define POLYNOMIAL 0xedb88320u

static uint32_t add_byte(uint32_t crc, uint32_t byte) {
  crc ^= byte;
  for (uint32_t bit = 0; bit < 8u; bit++) {
    crc = (crc >> 1) ^ ((crc & 1u) != 0u ? POLYNOMIAL : 0u);
  }
  return crc;
}

uint32_t orbsoc_crc_word(uint32_t crc, uint32_t word) {
  for (uint32_t byte = 0; byte < 4u; byte++) { crc = add_byte(crc, (word >> (8u * byte)) & 0xffu); }
  return crc;
}

/* A table's numbers, of the bytes that the index width asks for. */
static uint32_t add_list(uint32_t crc, const orbsoc_index *list, size_t count) {
  for (size_t k = 0; k < count; k++) {
    for (uint32_t byte = 0; byte < ORBSOC_INDEX_BITS / 8u; byte++) {
      crc = add_byte(crc, ((uint32_t)list[k] >> (8u * byte)) & 0xffu);
    }
  }
  return crc;
}

static uint32_t add_bytes(uint32_t crc, const uint8_t *list, size_t count) {
  for (size_t k = 0; k < count; k++) { crc = add_byte(crc, list[k]); }
  return crc;
}

static uint32_t add_matrix(uint32_t crc, const orbsoc_matrix *matrix, size_t columns,
                           size_t entries) {
  return add_list(add_list(crc, matrix->begins, columns + 1u), matrix->rows, entries);
}

static uint32_t add_factor(uint32_t crc, const orbsoc_pattern *p) {
  for (size_t k = 0; k < p->nodes; k++) {
    const orbsoc_node *node = &p->node[k];
    const orbsoc_index numbers[4] = {node->width, node->diagonal, node->leading, node->updates};
    crc = add_byte(add_byte(crc, node->kind), node->scattered);
    crc = add_list(crc, numbers, 4);
  }
  for (size_t k = 0; k < p->updates; k++) {
    const orbsoc_index numbers[3] = {p->update[k].target, p->update[k].lo, p->update[k].hi};
    crc = add_list(crc, numbers, 3);
  }
  crc = add_list(crc, p->row, p->rows);
  crc = add_list(crc, p->scatter_to, p->scatter);
  crc = add_list(crc, p->gather_from, p->gather);
  crc = add_list(crc, p->relative_row, p->relative);
  crc = add_list(crc, p->run_value, p->runs);
  crc = add_list(crc, p->run_length, p->runs);
  return add_list(crc, p->entry_target, p->targets);
}

uint32_t orbsoc_size_checksum(const orbsoc_pattern *p) {
  const uint32_t sizes[] = {p->version, p->index_bits, p->n, p->p, p->m, p->l, p->cones,
                            p->given_m, p->given_l, p->given_cones, p->nnz_p, p->nnz_a, p->nnz_g,
                            p->given_nnz_g, p->dim, p->nnz_kkt, p->contiguous, p->nodes,
                            p->updates, p->rows, p->scatter, p->gather, p->relative, p->runs,
                            p->panel_entries, p->scratch, p->work_words, p->number_words,
                            p->soc_words, p->targets};
  uint32_t crc = 0xffffffffu;
  for (size_t k = 0; k < sizeof(sizes) / sizeof(sizes[0]); k++) {
    crc = orbsoc_crc_word(crc, sizes[k]);
  }
  return crc ^ 0xffffffffu;
}

uint32_t orbsoc_checksum(const orbsoc_pattern *p) {
  uint32_t crc = 0xffffffffu;
  crc = add_list(crc, p->cone_dims, p->cones);
  crc = add_list(crc, p->given_cone_dims, p->given_cones);
  crc = add_matrix(crc, &p->cost, p->n, p->nnz_p);
  crc = add_matrix(crc, &p->equality, p->n, p->nnz_a);
  crc = add_matrix(crc, &p->conic, p->n, p->nnz_g);
  crc = add_matrix(crc, &p->given_conic, p->n, p->given_nnz_g);
  crc = add_list(crc, p->row_origin, p->m);
  crc = add_list(crc, p->g_origin, p->nnz_g);
  crc = add_bytes(crc, p->absent, p->given_m);
  crc = add_matrix(crc, &p->kkt, p->dim, p->nnz_kkt);
  crc = add_list(crc, p->contiguous_columns, p->contiguous);
  crc = add_list(crc, p->position, p->dim);
  crc = add_bytes(crc, p->positive, p->dim);
  crc = add_list(crc, p->from_p, p->nnz_p);
  crc = add_list(crc, p->from_a, p->nnz_a);
  crc = add_list(crc, p->from_g, p->nnz_g);
  crc = add_list(crc, p->orthant, p->l);
  crc = add_list(crc, p->soc, p->soc_words);
  return add_factor(crc, p) ^ 0xffffffffu;
}
