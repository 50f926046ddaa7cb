/* Stages that a device runs in place of the core: which words have to move, launches, and what of a
 * device's answer is believed. The words that come back are not trusted: they decide nothing that
 * could keep the core from ending, and the certificate judges them on the original data. */
#include "kernels.h"
#include "method.h"

#define BIT(k) ((uint64_t)1 << (uint32_t)(k))
#define RAW (BIT(ORBSOC_RAW_P) | BIT(ORBSOC_RAW_A) | BIT(ORBSOC_RAW_G) | BIT(ORBSOC_RAW_Q))
#define SCALED (BIT(ORBSOC_P) | BIT(ORBSOC_A) | BIT(ORBSOC_G) | BIT(ORBSOC_Q))
/* What the core writes anew before each attempt. */
#define REWRITTEN (BIT(ORBSOC_PARAMETERS) | BIT(ORBSOC_CONTROL) | BIT(ORBSOC_VERDICT) | \
                   BIT(ORBSOC_BEST) | BIT(ORBSOC_PRIMAL_CERTIFICATE) | \
                   BIT(ORBSOC_DUAL_CERTIFICATE))
#define ANSWER (BIT(ORBSOC_CONTROL) | BIT(ORBSOC_UNSCALED_ITERATE) | \
                BIT(ORBSOC_UNSCALED_CERTIFICATES))
/* The most stages outside an iteration, and within one beside its refinement. */
#define STAGES_OF_A_LIST 32u

typedef char stages_have_a_segment_each[(ORBSOC_COLD_SEGMENT == ORBSOC_STAGES + 1) ? 1 : -1];

orbsoc_error orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition,
                           const orbsoc_device *device) {
  if (solver == NULL || solver->pattern == NULL || (partition == NULL) != (device == NULL)) {
    return ORBSOC_NO_POINTER;
  }
  solver->partition = NULL;
  solver->loaded = 0;
  if (device != NULL) {
    if (partition->segment == NULL || device->restart == NULL || device->put == NULL ||
        device->get == NULL || device->publish == NULL || device->launch == NULL ||
        device->wait == NULL) {
      return ORBSOC_NO_POINTER;
    }
    if (partition->modules > 0xffu || device->patience == 0u) {
      return ORBSOC_BAD_SETTING;
    }
    solver->device = *device;
    solver->partition = (partition->modules == 0u) ? NULL : partition;
  }
  return ORBSOC_OK;
}

/* Note the first error of a try. */
static void note(orbsoc_solver *solver, uint32_t code) {
  solver->event = (solver->event == 0u) ? code : solver->event;
}

/* The given data go there as equilibration loads them, by way of the buffers that it writes. */
static void move_there(orbsoc_solver *solver, uint64_t buffers) {
  const orbsoc_device *device = &solver->device;
  const uint64_t moved = buffers & ~solver->held_there;
  if ((moved & RAW) != 0u) {
    orbsoc_load_given(solver);
    solver->held_here &= ~SCALED;
  }
  for (uint32_t k = 0; k < (uint32_t)ORBSOC_BUFFERS && solver->event == 0u; k++) {
    if ((moved & BIT(k)) != 0u) {
      const uint32_t from = (k <= (uint32_t)ORBSOC_RAW_Q) ? (uint32_t)ORBSOC_P + k : k;
      note(solver, device->put(device->context, k, solver->buffer[from]));
    }
  }
  solver->held_there |= buffers;
}

void orbsoc_move_here(orbsoc_solver *solver, uint64_t buffers) {
  const orbsoc_device *device = &solver->device;
  const uint64_t moved = buffers & ~(solver->held_here | RAW);
  for (uint32_t k = 0; k < (uint32_t)ORBSOC_BUFFERS && solver->event == 0u; k++) {
    if ((moved & BIT(k)) != 0u) {
      note(solver, device->get(device->context, k, solver->buffer[k]));
    }
  }
  solver->held_here |= moved;
}

/* Run a segment there, and wait for its end. */
static void run_there(orbsoc_solver *solver, uint32_t segment) {
  const orbsoc_device *device = &solver->device;
  const orbsoc_dataflow *flow = &solver->partition->segment[segment];
  uint32_t found = ORBSOC_DEVICE_RUNS, asked = (device->stop == NULL) ? 1u : 0u;
  move_there(solver, flow->reads);
  if (solver->event == 0u) {
    note(solver, device->launch(device->context, segment));
  }
  for (uint32_t k = 0; k < device->patience && found == ORBSOC_DEVICE_RUNS && solver->event == 0u;
       k++) {
    found = device->wait(device->context);
    if (found == ORBSOC_DEVICE_RUNS && segment > (uint32_t)ORBSOC_STAGES && asked == 0u &&
        solver->ask != NULL && solver->ask(solver->context) != ORBSOC_GO_ON) {
      note(solver, device->stop(device->context));
      asked = 1;
    }
  }
  note(solver, (found == ORBSOC_DEVICE_RUNS) ? (uint32_t)ORBSOC_DEVICE_LATE : found);
  solver->held_there |= flow->writes;
  solver->held_here &= ~flow->writes;
}

int orbsoc_runs_there(const orbsoc_solver *solver, uint32_t module) {
  return (solver->partition->modules & (1u << module)) != 0u;
}

void orbsoc_stage_there(orbsoc_solver *solver, orbsoc_stage stage) {
  run_there(solver, (uint32_t)stage + 1u);
}

void orbsoc_before_stage_here(orbsoc_solver *solver, orbsoc_stage stage) {
  orbsoc_move_here(solver, solver->partition->segment[(uint32_t)stage + 1u].reads);
}

static void publish(orbsoc_solver *solver, uint32_t segment) {
  const uint64_t writes = solver->partition->segment[segment].writes;
  solver->held_here |= writes;
  solver->held_there &= ~writes;
  if (solver->event == 0u) {
    note(solver, solver->device.publish(solver->device.context, segment));
  }
}

void orbsoc_after_stage_here(orbsoc_solver *solver, orbsoc_stage stage) {
  publish(solver, (uint32_t)stage + 1u);
}

int orbsoc_try_is_over(orbsoc_solver *solver) {
  const orbsoc_settings *settings = &solver->settings;
  const uint32_t most = (settings->max_iterations + 3u) *
                        (STAGES_OF_A_LIST + 4u * settings->refinement_max);
  solver->segments += 1u;
  if (solver->segments > most) {
    note(solver, (uint32_t)ORBSOC_DEVICE_ENDLESS);
  }
  return solver->event != 0u;
}

void orbsoc_begin_there(orbsoc_solver *solver) {
  const orbsoc_device *device = &solver->device;
  solver->event = 0;
  solver->held_here = ~RAW;
  solver->held_there = 0;
  note(solver, device->restart(device->context, (solver->loaded == 0u) ? 1u : 0u));
  publish(solver, ORBSOC_DATA_SEGMENT);
}

void orbsoc_begin_attempt_there(orbsoc_solver *solver) {
  solver->segments = 0;
  solver->held_here |= REWRITTEN;
  solver->held_there &= ~REWRITTEN;
}

int orbsoc_attempt_there(orbsoc_solver *solver, int warm) {
  if (solver->partition->resident == 0u) {
    return 0;
  }
  if (warm != 0) {
    /* 0 there as well: an attempt that ends before its verdict leaves the old one. */
    move_there(solver, BIT(ORBSOC_VERDICT));
  }
  run_there(solver, (warm != 0) ? (uint32_t)ORBSOC_WARM_SEGMENT : (uint32_t)ORBSOC_COLD_SEGMENT);
  orbsoc_move_here(solver, BIT(ORBSOC_CONTROL) | ((warm != 0) ? BIT(ORBSOC_VERDICT) : 0u));
  const uint32_t verdict = orbsoc_count(solver->buffer[ORBSOC_VERDICT][0]);
  const uint32_t reason = orbsoc_count(solver->buffer[ORBSOC_CONTROL][WORD_STOP]);
  solver->stop = orbsoc_or_from_outside(solver, (verdict != 0u) ? verdict : reason);
  return 1;
}

void orbsoc_fetch_answer(orbsoc_solver *solver) { orbsoc_move_here(solver, ANSWER); }

/* Ends that the certificate supports, or that came from outside. */
int orbsoc_is_believed(const orbsoc_solver *solver) {
  const orbsoc_status status = solver->solution.status;
  return status == ORBSOC_SOLVED || status == ORBSOC_PRIMAL_INFEASIBLE ||
         status == ORBSOC_DUAL_INFEASIBLE || status == ORBSOC_MAX_TIME ||
         status == ORBSOC_INTERRUPTED;
}
