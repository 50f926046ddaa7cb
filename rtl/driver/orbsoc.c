#include "orbsoc.h"

#define FIELD(word, name) (((word) & name##_MASK) >> name##_SHIFT)

static uint32_t low(uint64_t word) { return (uint32_t)word; }
static uint32_t high(uint64_t word) { return (uint32_t)(word >> 32); }

static uint32_t read_register(const orbsoc_pl *pl, uint32_t address) { return orbsoc_pl_read(pl->registers + address); }
static void write_register(const orbsoc_pl *pl, uint32_t address, uint32_t value) { orbsoc_pl_write(pl->registers + address, value); }

/* What the accesses so far have met. */
static orbsoc_pl_error bus(const orbsoc_pl *pl) { return pl->bus_errors ? ORBSOC_PL_BUS_ERROR : ORBSOC_PL_OK; }

/* STATUS, and the fault in it. */
static orbsoc_pl_error read_status(const orbsoc_pl *pl, uint32_t *status) {
  *status = read_register(pl, ORBSOC_REG_STATUS);
  return pl->bus_errors ? ORBSOC_PL_BUS_ERROR : (orbsoc_pl_error)FIELD(*status, ORBSOC_STATUS_FAULT);
}

/* Buffers that a stage would read and must not: neither valid, nor updated from an older content. */
static uint64_t unreadable(const orbsoc_pl *pl, const orbsoc_pl_segment *segment) {
  return segment->reads & ~(pl->valid | (segment->writes & pl->written));
}

static void write_frame(orbsoc_pl *pl, uint32_t module, uint32_t segment, uint32_t command) {
  pl->sequence += 1u;
  write_register(pl, ORBSOC_REG_MODULE, module);
  write_register(pl, ORBSOC_REG_SEGMENT, segment);
  write_register(pl, ORBSOC_REG_SEQUENCE, pl->sequence);
  write_register(pl, ORBSOC_REG_CONTROL, command);
}

/* The PL has carried out this command and no other; take over its data-valid flags. */
static orbsoc_pl_error confirm(orbsoc_pl *pl) {
  uint32_t status;
  orbsoc_pl_error fault = read_status(pl, &status);
  if (fault != ORBSOC_PL_OK) return fault;
  if (FIELD(status, ORBSOC_STATUS_BUSY) || FIELD(status, ORBSOC_STATUS_ARMED)) return ORBSOC_PL_LOST_WRITE;
  if (FIELD(status, ORBSOC_STATUS_SEQUENCE) != (pl->sequence & 0xffu)) return ORBSOC_PL_LOST_WRITE;
  if (FIELD(status, ORBSOC_STATUS_SEGMENT) != pl->number) return ORBSOC_PL_WRONG_SEGMENT;
  pl->valid = 0;
  for (uint32_t word = 0; word < pl->flag_words; ++word)
    pl->valid |= (uint64_t)read_register(pl, ORBSOC_REG_DATA_VALID + 4u * word) << (32u * word);
  if (pl->writes & ~pl->stales & ~pl->valid) return ORBSOC_PL_READ_BEFORE_VALID;
  pl->written |= pl->may_write;
  return ORBSOC_PL_OK;
}

static void announce(orbsoc_pl *pl, uint32_t number, uint64_t writes, uint64_t stales, uint64_t may_write) {
  pl->number = number;
  pl->writes = writes;
  pl->stales = stales;
  pl->may_write = may_write;
}

/* A launch. What was written to the memories is there first: a word read back through their port comes behind it. */
static void start(orbsoc_pl *pl, uint32_t module, uint32_t segment, uint32_t command) {
  orbsoc_pl_barrier();
  (void)orbsoc_pl_read(pl->memories + ORBSOC_REGION_STORAGE);
  orbsoc_pl_barrier();
  pl->taken = 0;
  pl->result = ORBSOC_PL_OK;
  pl->out = 1;
  write_frame(pl, module, segment, command);
}

/* The end of a launch: confirmed, and acknowledged. After an error the PL may still be busy: the launch stays out. */
static orbsoc_pl_error complete(orbsoc_pl *pl) {
  const orbsoc_pl_error found = confirm(pl);
  if (found != ORBSOC_PL_OK) return found;
  write_register(pl, ORBSOC_REG_IRQ_ACK, pl->sequence);
  orbsoc_pl_barrier();
  pl->out = 0;
  return ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_open(orbsoc_pl *pl, uintptr_t registers, uintptr_t memories, uint32_t buffers) {
  if (buffers == 0 || buffers > ORBSOC_PL_BUFFERS) return ORBSOC_PL_OUT_OF_RANGE;
  pl->registers = registers;
  pl->memories = memories;
  pl->flag_words = ORBSOC_PIECES(buffers);
  pl->bus_errors = 0;
  pl->engine = read_register(pl, ORBSOC_REG_ENGINE);
  pl->binary64 = FIELD(pl->engine, ORBSOC_ENGINE_BINARY64);
  const uint32_t sizes = read_register(pl, ORBSOC_REG_SIZES);
  pl->address_bits = FIELD(sizes, ORBSOC_SIZES_ADDRESS_BITS);
  pl->code_bits = FIELD(sizes, ORBSOC_SIZES_CODE_BITS);
  pl->code_width = FIELD(sizes, ORBSOC_SIZES_CODE_WIDTH);
  pl->identity = read_register(pl, ORBSOC_REG_IDENTITY);
  pl->words = FIELD(pl->engine, ORBSOC_ENGINE_FEWER_WORDS) ? read_register(pl, ORBSOC_REG_WORDS) : 1u << pl->address_bits;
  pl->residents = 0;
  pl->first = 0;
  if (pl->bus_errors) return ORBSOC_PL_BUS_ERROR;
  return orbsoc_pl_reset(pl);
}

orbsoc_pl_error orbsoc_pl_reset(orbsoc_pl *pl) {
  pl->bus_errors = 0;
  write_register(pl, ORBSOC_REG_RESET, 1u);
  pl->sequence = 0;
  pl->valid = 0;
  pl->written = 0;
  pl->out = 0;
  pl->taken = 0;
  pl->result = ORBSOC_PL_OK;
  return orbsoc_pl_require_rest(pl);
}

/* Ports of streamed microcode; 0: the PL has a memory for it. */
static uint32_t ports(const orbsoc_pl *pl) { return FIELD(pl->engine, ORBSOC_ENGINE_STREAM); }

orbsoc_pl_error orbsoc_pl_load_line(orbsoc_pl *pl, uint32_t line, const uint32_t *pieces) {
  const uint32_t count = ORBSOC_PIECES(pl->code_width);
  uint32_t bytes = 4;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (line >> pl->code_bits) return ORBSOC_PL_OUT_OF_RANGE;
  while (bytes < 4u * count) bytes *= 2u;
  for (uint32_t piece = 0; piece < count; ++piece)
    orbsoc_pl_write(pl->memories + ORBSOC_REGION_MICROCODE + (uintptr_t)bytes * line + 4u * piece, pieces[piece]);
  return bus(pl);
}

orbsoc_pl_error orbsoc_pl_load_template(orbsoc_pl *pl, uint32_t number, uint32_t word) {
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (number >= ORBSOC_TEMPLATES) return ORBSOC_PL_OUT_OF_RANGE;
  orbsoc_pl_write(pl->memories + ORBSOC_REGION_TEMPLATES + 4u * number, word);
  return bus(pl);
}

static void write_mask(const orbsoc_pl *pl, uint32_t address, uint64_t mask) {
  write_register(pl, address, low(mask));
  write_register(pl, address + 4u, high(mask));
}

orbsoc_pl_error orbsoc_pl_load_segment(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment) {
  const uint32_t entry = ORBSOC_TABLE + ORBSOC_TABLE_ENTRY * number;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (number >= ORBSOC_SEGMENTS) return ORBSOC_PL_OUT_OF_RANGE;
  write_register(pl, entry + ORBSOC_ENTRY_START, segment->start);
  write_mask(pl, entry + ORBSOC_ENTRY_READS, segment->reads);
  write_mask(pl, entry + ORBSOC_ENTRY_WRITES, segment->writes);
  write_mask(pl, entry + ORBSOC_ENTRY_STALES, segment->stales);
  write_register(pl, entry + ORBSOC_ENTRY_MODULE, segment->module); /* makes it exist */
  return ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_load_instruction(orbsoc_pl *pl, uint32_t place, const orbsoc_pl_instruction *instruction) {
  const uint32_t entry = ORBSOC_PROGRAM + ORBSOC_PROGRAM_ENTRY * place;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (place >= ORBSOC_INSTRUCTIONS || !FIELD(pl->engine, ORBSOC_ENGINE_RESIDENT)) return ORBSOC_PL_OUT_OF_RANGE;
  write_register(pl, entry + ORBSOC_PROGRAM_FLAG, instruction->flag);
  write_register(pl, entry, instruction->word);
  return ORBSOC_PL_OK;
}

/* One word more of a CRC-32, as rtl/axi/axi_digest.sv has it. */
static uint32_t crc_word(uint32_t crc, uint32_t word) {
  crc ^= word;
  for (int bit = 0; bit < 32; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  return crc;
}

/* Of the numbers of an image's templates, and of its lines from one on. */
static uint32_t crc_of_places(const orbsoc_pl_image *image, uint32_t first, uint32_t lines) {
  uint32_t crc = ~0u;
  for (uint32_t i = 0; i < image->template_count; ++i) crc = crc_word(crc, 0x80000000u | i);
  for (uint32_t i = 0; i < lines; ++i) crc = crc_word(crc, first + i);
  return crc;
}

/* An image's digest is of lines from 0 on. */
static uint32_t digest_at(const orbsoc_pl_image *image, uint32_t first) {
  if (first == 0) return image->digest;
  return image->digest ^ crc_of_places(image, 0, image->lines) ^ crc_of_places(image, first, image->lines);
}

static uint32_t digest_of_templates(const orbsoc_pl_image *image) {
  uint32_t crc = ~0u;
  for (uint32_t i = 0; i < image->template_count; ++i) crc = crc_word(crc, image->templates[i]);
  return crc ^ crc_of_places(image, 0, 0);
}

static int is_of_this_engine(const orbsoc_pl *pl, const orbsoc_pl_image *image) {
  return image->identity == pl->identity && image->binary64 == pl->binary64 && image->address_bits == pl->address_bits &&
         image->code_width == pl->code_width;
}

static int fits(const orbsoc_pl *pl, uint32_t first, uint32_t lines) {
  const uint32_t all = 1u << pl->code_bits;
  return first <= all && lines <= all - first;
}

static int overlaps(const orbsoc_pl_resident *one, uint32_t first, uint32_t lines) {
  return one->first < first + lines && first < one->first + one->image->lines;
}

static void forget(orbsoc_pl *pl, const orbsoc_pl_image *image, uint32_t first, uint32_t lines) {
  uint32_t kept = 0;
  for (uint32_t i = 0; i < pl->residents; ++i)
    if (pl->resident[i].image != image && !overlaps(&pl->resident[i], first, lines)) pl->resident[kept++] = pl->resident[i];
  pl->residents = kept;
}

static orbsoc_pl_error load_templates(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  orbsoc_pl_error found = ORBSOC_PL_OK;
  write_register(pl, ORBSOC_REG_DIGEST, 0u);
  orbsoc_pl_barrier();
  for (uint32_t i = 0; i < image->template_count && found == ORBSOC_PL_OK; ++i)
    found = orbsoc_pl_load_template(pl, i, image->templates[i]);
  return found;
}

static orbsoc_pl_error begin_at(orbsoc_pl *pl, const orbsoc_pl_image *image, uint32_t first) {
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (!fits(pl, first, image->lines)) return ORBSOC_PL_OUT_OF_RANGE;
  forget(pl, image, first, ports(pl) ? 0 : image->lines);
  pl->first = first;
  return load_templates(pl, image);
}

static orbsoc_pl_error load_lines(orbsoc_pl *pl, const orbsoc_pl_image *image, orbsoc_pl_error found) {
  const uint32_t lines = ports(pl) ? 0 : image->lines;
  for (uint32_t i = 0; i < lines && found == ORBSOC_PL_OK; ++i)
    found = orbsoc_pl_load_line(pl, pl->first + i, image->microcode + (size_t)ORBSOC_PIECES(pl->code_width) * i);
  return found == ORBSOC_PL_OK ? orbsoc_pl_load_end(pl, image) : found;
}

orbsoc_pl_error orbsoc_pl_load(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  return load_lines(pl, image, orbsoc_pl_load_begin(pl, image));
}

orbsoc_pl_error orbsoc_pl_load_begin(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  return is_of_this_engine(pl, image) ? begin_at(pl, image, 0) : ORBSOC_PL_WRONG_ENGINE;
}

orbsoc_pl_error orbsoc_pl_load_beside(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  return load_lines(pl, image, orbsoc_pl_load_beside_begin(pl, image));
}

orbsoc_pl_error orbsoc_pl_load_beside_begin(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  uint32_t first = 0;
  if (!is_of_this_engine(pl, image)) return ORBSOC_PL_WRONG_ENGINE;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  forget(pl, image, 0, 0);
  for (uint32_t i = 0; !ports(pl) && i < pl->residents;) {
    const int taken = overlaps(&pl->resident[i], first, image->lines);
    if (taken) first = pl->resident[i].first + pl->resident[i].image->lines;
    i = taken ? 0 : i + 1u;
  }
  if (pl->residents == ORBSOC_PL_PROGRAMS || !fits(pl, first, image->lines)) return ORBSOC_PL_OUT_OF_RANGE;
  const orbsoc_pl_error found = orbsoc_pl_reset(pl);
  return found == ORBSOC_PL_OK ? begin_at(pl, image, first) : found;
}

/* Literals as they are in storage. */
static orbsoc_pl_error literals_there(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  for (size_t i = 0; i < image->literal_count; ++i) {
    uint64_t word = 0;
    const orbsoc_pl_error found = orbsoc_pl_get_words(pl, image->literal_addresses + i, &word, 1);
    if (found != ORBSOC_PL_OK) return found;
    if (word != image->literals[i]) return ORBSOC_PL_WRONG_PROGRAM;
  }
  return ORBSOC_PL_OK;
}

/* Literals and tables, once the memories hold what the digest says. */
static orbsoc_pl_error finish(orbsoc_pl *pl, const orbsoc_pl_image *image, uint32_t digest) {
  orbsoc_pl_error found = orbsoc_pl_set_words(pl, image->literal_addresses, image->literals, image->literal_count);
  if (found != ORBSOC_PL_OK) return found;
  orbsoc_pl_barrier();
  (void)orbsoc_pl_read(pl->memories + ORBSOC_REGION_STORAGE); /* comes behind all that was written */
  orbsoc_pl_barrier();
  if (read_register(pl, ORBSOC_REG_DIGEST) != digest) return ORBSOC_PL_WRONG_PROGRAM;
  found = literals_there(pl, image);
  return found == ORBSOC_PL_OK ? orbsoc_pl_load_tables(pl, image) : found;
}

orbsoc_pl_error orbsoc_pl_load_end(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  const orbsoc_pl_error found = finish(pl, image, digest_at(image, pl->first));
  if (found == ORBSOC_PL_OK && pl->residents < ORBSOC_PL_PROGRAMS) {
    pl->resident[pl->residents].image = image;
    pl->resident[pl->residents].first = pl->first;
    pl->residents += 1u;
  }
  return found;
}

orbsoc_pl_error orbsoc_pl_switch(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  uint32_t at = 0;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  while (at < pl->residents && pl->resident[at].image != image) ++at;
  if (at == pl->residents) return ORBSOC_PL_WRONG_PROGRAM;
  orbsoc_pl_error found = orbsoc_pl_reset(pl);
  if (found != ORBSOC_PL_OK) return found;
  pl->first = pl->resident[at].first;
  found = load_templates(pl, image);
  return found == ORBSOC_PL_OK ? finish(pl, image, digest_of_templates(image)) : found;
}

/* Where each port finds its parts of the lines. */
static orbsoc_pl_error point_at(const orbsoc_pl *pl, const orbsoc_pl_image *image) {
  uint32_t base = orbsoc_pl_bus_address(image->microcode);
  if (base % ORBSOC_STREAM_ALIGN) return ORBSOC_PL_OUT_OF_RANGE;
  for (uint32_t port = 0; port < ports(pl); ++port) {
    const uint32_t bytes = image->lines * (pl->code_width / 8u >> ports(pl) / 2u); /* 1, 2 or 4 ports */
    write_register(pl, ORBSOC_REG_STREAM_BASE + 4u * port, base);
    base += (bytes + ORBSOC_STREAM_ALIGN - 1u) / ORBSOC_STREAM_ALIGN * ORBSOC_STREAM_ALIGN;
  }
  return bus(pl);
}

/* Lines of a segment that begins with one: up to the next segment, or the last line. */
static uint32_t lines_from(const orbsoc_pl_image *image, uint32_t start) {
  uint32_t end = image->lines;
  for (uint32_t i = 0; i < image->segment_count; ++i)
    if (image->segments[i].start > start && image->segments[i].start < end) end = image->segments[i].start;
  return end - start;
}

orbsoc_pl_error orbsoc_pl_load_tables(orbsoc_pl *pl, const orbsoc_pl_image *image) {
  orbsoc_pl_error found = ports(pl) ? point_at(pl, image) : ORBSOC_PL_OK;
  uint32_t status;
  for (uint32_t i = 0; i < image->segment_count && found == ORBSOC_PL_OK; ++i) {
    orbsoc_pl_segment segment = image->segments[i];
    if (ports(pl))
      write_register(pl, ORBSOC_TABLE + ORBSOC_TABLE_ENTRY * i + ORBSOC_ENTRY_LINES, lines_from(image, segment.start));
    if (segment.module != ORBSOC_MODULE_PS) segment.start += pl->first;
    found = orbsoc_pl_load_segment(pl, i, &segment);
  }
  for (uint32_t i = 0; i < image->instruction_count && found == ORBSOC_PL_OK; ++i)
    found = orbsoc_pl_load_instruction(pl, i, image->instructions + i);
  return found == ORBSOC_PL_OK ? read_status(pl, &status) : found;
}

orbsoc_pl_error orbsoc_pl_set_words(orbsoc_pl *pl, const uint32_t *addresses, const uint64_t *words, size_t count) {
  const uintptr_t storage = pl->memories + ORBSOC_REGION_STORAGE;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  for (size_t i = 0; i < count; ++i) {
    if (addresses[i] >= pl->words) return ORBSOC_PL_OUT_OF_RANGE;
    if (pl->binary64) {
      orbsoc_pl_write(storage + (uintptr_t)8u * addresses[i], low(words[i]));
      orbsoc_pl_write(storage + (uintptr_t)8u * addresses[i] + 4u, high(words[i])); /* writes the word */
    } else {
      orbsoc_pl_write(storage + (uintptr_t)4u * addresses[i], low(words[i]));
    }
  }
  return bus(pl);
}

orbsoc_pl_error orbsoc_pl_get_words(orbsoc_pl *pl, const uint32_t *addresses, uint64_t *words, size_t count) {
  const uintptr_t storage = pl->memories + ORBSOC_REGION_STORAGE;
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  for (size_t i = 0; i < count; ++i) {
    if (addresses[i] >= pl->words) return ORBSOC_PL_OUT_OF_RANGE;
    if (pl->binary64) {
      words[i] = orbsoc_pl_read(storage + (uintptr_t)8u * addresses[i]);
      words[i] |= (uint64_t)orbsoc_pl_read(storage + (uintptr_t)8u * addresses[i] + 4u) << 32;
    } else {
      words[i] = orbsoc_pl_read(storage + (uintptr_t)4u * addresses[i]);
    }
  }
  if (!FIELD(pl->engine, ORBSOC_ENGINE_PARITY)) return bus(pl);
  uint32_t status = 0;
  return read_status(pl, &status);
}

orbsoc_pl_error orbsoc_pl_readable(const orbsoc_pl *pl, const orbsoc_pl_segment *segment) {
  return unreadable(pl, segment) ? ORBSOC_PL_READ_BEFORE_VALID : ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_publish(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment) {
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  announce(pl, number, segment->writes, segment->stales, segment->writes);
  write_frame(pl, ORBSOC_MODULE_PS, number, ORBSOC_CONTROL_PUBLISH);
  return confirm(pl);
}

orbsoc_pl_error orbsoc_pl_launch(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment) {
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  announce(pl, number, segment->writes, segment->stales, segment->writes);
  start(pl, segment->module, number, ORBSOC_CONTROL_START);
  return ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_launch_attempt(orbsoc_pl *pl, const orbsoc_pl_attempt *attempt) {
  if (pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (!FIELD(pl->engine, ORBSOC_ENGINE_RESIDENT)) return ORBSOC_PL_OUT_OF_RANGE;
  announce(pl, 0, attempt->closing, 0, attempt->written);
  start(pl, ORBSOC_MODULE_PS, attempt->entry, ORBSOC_CONTROL_ATTEMPT);
  return ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_limit(orbsoc_pl *pl, uint32_t clocks) {
  write_register(pl, ORBSOC_REG_LIMIT, clocks);
  if (read_register(pl, ORBSOC_REG_LIMIT) != clocks && !pl->bus_errors) return ORBSOC_PL_LOST_WRITE;
  return bus(pl);
}

uint32_t orbsoc_pl_spent(const orbsoc_pl *pl) { return read_register(pl, ORBSOC_REG_SPENT); }

orbsoc_pl_error orbsoc_pl_stop(orbsoc_pl *pl) {
  if (!pl->out) return ORBSOC_PL_NOT_AT_REST;
  if (!FIELD(pl->engine, ORBSOC_ENGINE_RESIDENT)) return ORBSOC_PL_OUT_OF_RANGE;
  write_register(pl, ORBSOC_REG_STOP, 1u);
  return ORBSOC_PL_OK;
}

orbsoc_pl_error orbsoc_pl_poll(orbsoc_pl *pl, uint32_t budget) {
  if (!pl->out) return ORBSOC_PL_NOT_AT_REST;
  for (; budget > 0; --budget) {
    uint32_t status;
    const orbsoc_pl_error fault = read_status(pl, &status);
    if (fault != ORBSOC_PL_OK) return fault;
    if (FIELD(status, ORBSOC_STATUS_DONE)) return complete(pl);
  }
  return ORBSOC_PL_LAUNCH_TIMEOUT;
}

orbsoc_pl_error orbsoc_pl_on_interrupt(orbsoc_pl *pl) {
  if (!pl->out) return ORBSOC_PL_NOT_AT_REST;
  pl->result = complete(pl);
  pl->taken = 1;
  return pl->result;
}

void orbsoc_pl_on_bus_error(orbsoc_pl *pl) { pl->bus_errors += 1u; }

orbsoc_pl_error orbsoc_pl_await(orbsoc_pl *pl, uint32_t budget) {
  if (!pl->out && !pl->taken) return ORBSOC_PL_NOT_AT_REST;
  for (; budget > 0; --budget)
    if (pl->taken) return pl->result;
  uint32_t status;
  const orbsoc_pl_error fault = read_status(pl, &status);
  if (pl->taken) return pl->result; /* it came between */
  if (fault != ORBSOC_PL_OK) return fault;
  return FIELD(status, ORBSOC_STATUS_DONE) ? ORBSOC_PL_LOST_INTERRUPT : ORBSOC_PL_LAUNCH_TIMEOUT;
}

orbsoc_pl_error orbsoc_pl_require_rest(orbsoc_pl *pl) {
  uint32_t status;
  const orbsoc_pl_error fault = read_status(pl, &status);
  if (fault != ORBSOC_PL_OK) return fault;
  if (FIELD(status, ORBSOC_STATUS_DONE)) return ORBSOC_PL_UNACKNOWLEDGED_INTERRUPT;
  if (FIELD(status, ORBSOC_STATUS_BUSY) || FIELD(status, ORBSOC_STATUS_ARMED)) return ORBSOC_PL_LOST_WRITE;
  return ORBSOC_PL_OK;
}

uint32_t orbsoc_pl_cycles(const orbsoc_pl *pl) { return read_register(pl, ORBSOC_REG_CYCLES); }
