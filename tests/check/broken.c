/* A law in plain C, right but for one mistake, which MISTAKE_… chooses. A spring with the tension
 *   T = k (l - l0) + d l',   E = k (l - l0)^2 / 2,   margin 1 - |T| / strength;
 * with WITH_STATE in place of that a spring and a dashpot in series, T = k (l - l0 - z), z' = (l - l0 - z) / tau. */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include <springnet/sdk/plugin.h>

#ifndef RATE_SIGN
#define RATE_SIGN 1.0
#endif
#ifndef LICENCE
#define LICENCE "MIT"
#endif
#ifndef UNIT
#define UNIT "N/m"
#endif
#ifndef CAPABILITIES
#define CAPABILITIES SPRINGNET_ACTS_IN_COMPRESSION
#endif
#ifndef SMALLEST_STRETCH
#define SMALLEST_STRETCH 0.0
#endif
#ifndef MISTAKE_SIZE
#define MISTAKE_SIZE 1e-4
#endif
#ifndef LARGEST_STRETCH
#define LARGEST_STRETCH (double)INFINITY
#endif

enum { stiffness, damping, strength, parameter_count };

static springnet_parameter described(const char* name, const char* unit, double smallest, double scale) {
  springnet_parameter p;
  memset(&p, 0, sizeof p);
  p.struct_size = sizeof p;
  p.type = SPRINGNET_NUMBER;
  p.name = name;
  p.unit = unit;
  p.summary = "a number";
  p.default_value = scale;
  p.smallest = smallest;
  p.largest = INFINITY;
  p.scale = scale;
  return p;
}

#ifdef WITH_STATE
enum { tau = damping }; /* in its place, s */

static double rate_of(double e, double z, double time) { return (e - z) / time; }

static springnet_status evaluate(void* context, const springnet_law_batch* b) {
  (void)context;
  for (uint32_t i = 0; i < b->count; ++i) {
    const double k = b->parameters[stiffness][i * b->parameter_strides[stiffness]];
    const double time = 0.1 + b->parameters[tau][i * b->parameter_strides[tau]];
    const double e = b->q[i] - b->reference[i * b->reference_stride], z = b->states[0][i];
    if (b->force) b->force[i] = k * (e - z);
    if (b->energy) b->energy[i] = 0.5 * k * (e - z) * (e - z);
    if (b->state_rates && b->state_rates[0]) b->state_rates[0][i] = rate_of(e, z, time);
  }
  return SPRINGNET_OK;
}

static springnet_status update(void* context, const springnet_law_update* u) {
  (void)context;
  const springnet_law_batch* b = u->batch;
  static double remembered = 0.0;
  for (uint32_t i = 0; i < b->count; ++i) {
    const double k = b->parameters[stiffness][i * b->parameter_strides[stiffness]];
    const double time = 0.1 + b->parameters[tau][i * b->parameter_strides[tau]];
    const double e = b->q[i] - b->reference[i * b->reference_stride];
    double h = u->time_step / time;
#ifdef MISTAKE_HALF_STEPS
    h *= 0.5;
#endif
    double next = (b->states[0][i] + h * e) / (1.0 + h); /* backward Euler */
#ifdef MISTAKE_REMEMBERS_STATES
    next += 1e-9 * remembered;
    remembered = next;
#else
    (void)remembered;
#endif
    if (u->next && u->next[0]) u->next[0][i] = next;
    if (b->force) b->force[i] = k * (e - next);
    if (b->energy) b->energy[i] = 0.5 * k * (e - next) * (e - next);
  }
  return SPRINGNET_OK;
}
#else
static void write_list(double* const* list, int j, uint32_t i, double value) {
  if (list && list[j]) list[j][i] = value;
}

#if defined(MISTAKE_THREAD) || defined(MISTAKE_SPINS)
static void* spin(void* unused) {
  for (volatile int forever = 1; forever;) {
  }
  return unused;
}
#endif

static springnet_status evaluate(void* context, const springnet_law_batch* b) {
  (void)context;
#ifdef MISTAKE_SPINS
  pthread_t thread;
  for (int k = 0; k < 5; ++k) pthread_create(&thread, NULL, spin, NULL);
  spin(NULL);
#endif
#ifdef MISTAKE_EXITS
  exit(0);
#endif
#ifdef MISTAKE_HANGS
  for (volatile int forever = 1; forever;) {
  }
#endif
#ifdef MISTAKE_CRASHES
  *(volatile double*)b->force_by_parameters = 0.0;
  *(volatile double*)NULL = 0.0;
#endif
#ifdef MISTAKE_LEAKS
  static void* kept; /* a list that grows */
  void** const item = malloc(24);
  if (item) *item = kept;
  kept = item;
#endif
#ifdef MISTAKE_FAILS
  return SPRINGNET_FAILED;
#endif
#ifdef MISTAKE_REMEMBERS
  static uint32_t calls = 0;
#endif
#ifdef MISTAKE_THREADS
  static volatile double elongations[64]; /* scratch memory that all threads share */
  for (uint32_t i = 0; i < b->count; ++i) elongations[i % 64] = b->q[i] - b->reference[i * b->reference_stride];
#endif
  for (uint32_t i = 0; i < b->count; ++i) {
    const double k = b->parameters[stiffness][i * b->parameter_strides[stiffness]];
    const double d = b->parameters[damping][i * b->parameter_strides[damping]] * RATE_SIGN;
    const double limit = b->parameters[strength][i * b->parameter_strides[strength]];
    const double q = b->q[i], reference = b->reference[i * b->reference_stride], e = q - reference;
    double force = k * e + d * b->rate[i], energy = 0.5 * k * e * e, by_q = k, margin_slope = 1.0;
#ifdef MISTAKE_LOADED_AT_REST
    force += 0.1 * k, energy += 0.1 * k * e;
#endif
#ifdef MISTAKE_FALLS
    force = k * sin(3.0 * e) + d * b->rate[i], energy = k * (1.0 - cos(3.0 * e)) / 3.0, by_q = 3.0 * k * cos(3.0 * e);
#endif
#ifdef MISTAKE_POLE
    force = k * e / (1.0 - 4.0 * e * e / (reference * reference)) + d * b->rate[i];
#endif
#ifdef MISTAKE_WRONG_ENERGY
    energy *= 1.0 + MISTAKE_SIZE;
#endif
#ifdef MISTAKE_WRONG_DERIVATIVE
    by_q *= 1.0 + MISTAKE_SIZE;
#endif
#ifdef MISTAKE_NAN
    if (q > 1.2 * reference && q < 1.3 * reference) force = NAN;
#endif
#ifdef MISTAKE_DIVIDES
    force = k * (e / reference) * reference + d * b->rate[i];
#endif
#ifdef MISTAKE_BATCH_SIZE
    force *= 1.0 + 1e-15 * (b->count % 7);
#endif
#ifdef MISTAKE_REMEMBERS
    force *= 1.0 + 1e-15 * (calls++ % 5);
#endif
#ifdef MISTAKE_CHANGES_INPUTS
    ((double*)b->q)[i] = q + 0.0;
#endif
#ifdef MISTAKE_READS_PARAMETER_BEYOND
    force += 0.0 * *(const volatile double*)b->parameters[parameter_count];
#endif
#ifdef MISTAKE_STRIDE
    force = k * e + b->parameters[damping][i * b->parameter_strides[stiffness]] * b->rate[i];
#endif
#ifdef MISTAKE_MIXED_STRIDES
    if (b->parameter_strides[stiffness] == 1 && b->parameter_strides[damping] == 0) force *= 1.5;
#endif
#ifdef MISTAKE_SECOND_HALF
    if (b->count >= 100 && i >= b->count / 2) force *= 1.5;
#endif
#ifdef MISTAKE_ENERGY_ALONE
    if (!b->force) energy *= 2.0;
#endif
#ifdef MISTAKE_MARGIN_ALONE
    if (!b->force) margin_slope = 0.5;
#endif
#ifdef MISTAKE_ENERGY_OF_RATE
    energy += 0.01 * b->rate[i] * b->rate[i];
#endif
#ifdef MISTAKE_NOISE
    force += 1e-12 * (rand() % 2);
#endif
#ifdef MISTAKE_MARGIN
    margin_slope = 0.0;
#endif
#ifdef MISTAKE_THREADS
    if (b->count <= 64) force = k * elongations[i] + d * b->rate[i];
#endif
    if (b->force) b->force[i] = force;
    if (b->energy) b->energy[i] = energy;
    if (b->margin) b->margin[i] = margin_slope * (1.0 - fabs(force) / limit);
    if (b->force_by_q) b->force_by_q[i] = by_q;
    if (b->energy_by_q) b->energy_by_q[i] = force - d * b->rate[i];
    if (b->force_by_rate) b->force_by_rate[i] = d;
#ifdef MISTAKE_WRONG_PARAMETER_DERIVATIVE
    write_list(b->force_by_parameters, stiffness, i, q);
#else
    write_list(b->force_by_parameters, stiffness, i, force == 0.0 ? 0.0 : (force - d * b->rate[i]) / k);
#endif
    write_list(b->force_by_parameters, damping, i, RATE_SIGN * b->rate[i]);
    write_list(b->force_by_parameters, strength, i, 0.0);
  }
#ifdef MISTAKE_READS_BEYOND
  if (b->force) b->force[0] += 0.0 * *(const volatile double*)(b->q + b->count);
#endif
#ifdef MISTAKE_READS_BEFORE
  if (b->force) b->force[0] += 0.0 * *(const volatile double*)(b->q - 1);
#endif
#ifdef MISTAKE_AVX2_BEYOND
  if (b->instruction_set == SPRINGNET_AVX2 && b->force) b->force[b->count] = 0.0;
#endif
#ifdef MISTAKE_LARGE_BEYOND
  if (b->count > 20 && b->force) b->force[b->count] = 0.0;
#endif
#ifdef MISTAKE_WRITES_BEYOND
  if (b->force) b->force[b->count] = 0.0;
#endif
  return SPRINGNET_OK;
}
#endif

#ifdef MISTAKE_CONSTRUCTOR
__attribute__((constructor)) static void at_load(void) { exit(7); }
#endif

#ifdef MISTAKE_ABORTS
__attribute__((constructor)) static void at_load(void) { abort(); }
#endif
#ifdef MISTAKE_DESTRUCTOR
__attribute__((destructor)) static void at_end(void) { abort(); }
#endif
#ifdef MISTAKE_THREAD
__attribute__((constructor)) static void at_load(void) {
  pthread_t thread;
  pthread_create(&thread, NULL, spin, NULL);
}
#endif

#ifdef MISTAKE_PREPARES
static springnet_status prepare(void* context, springnet_preparation* preparation) {
  (void)context, (void)preparation;
  abort();
}
static springnet_status release(void* context, springnet_preparation* preparation) {
  (void)context, (void)preparation;
  return SPRINGNET_OK;
}
static springnet_table table;
static const springnet_table* const table_list[] = {&table};
#endif

/* Filled in when the file is opened: C has no constants of structs that are made by functions. */
static springnet_parameter parameters[parameter_count], state;
static const springnet_parameter* const parameter_list[] = {&parameters[0], &parameters[1], &parameters[2]};
static const springnet_parameter* const state_list[] = {&state};
static springnet_law law;
static springnet_component component;
static const springnet_component* const components[] = {&component};

SPRINGNET_PLUGIN_NOTE(0);
SPRINGNET_EXPORT springnet_plugin springnet_plugin_entry = {SPRINGNET_MAGIC,
                                                            sizeof(springnet_plugin),
                                                            SPRINGNET_ABI_MAJOR,
                                                            SPRINGNET_ABI_MINOR,
                                                            0,
                                                            1,
                                                            0,
                                                            "org.example.broken",
                                                            "1.0",
                                                            "a test",
                                                            LICENCE,
                                                            components};

__attribute__((constructor)) static void fill_in(void) {
  parameters[stiffness] = described("stiffness", UNIT, 0.0, 3.0);
  parameters[damping] = described("damping", "N s/m", 0.0, 0.5);
  parameters[strength] = described("strength", "N", 0.01, 50.0);
  state = described("flow", "m", -INFINITY, 0.01);
  state.default_value = 0.0;
  law.struct_size = sizeof law;
  law.invariant = SPRINGNET_LENGTH;
  law.update_order = 1;
  law.smallest_stretch = SMALLEST_STRETCH;
  law.largest_stretch = LARGEST_STRETCH;
  law.evaluate = evaluate;
  component.struct_size = sizeof component;
  component.kind = SPRINGNET_SPRING_FUNCTION;
  component.id = "broken";
  component.summary = "right but for one mistake";
  component.reference = "";
  component.parameter_count = parameter_count;
  component.parameters = parameter_list;
  component.implementation = &law;
  component.capabilities = (uint64_t)(CAPABILITIES) | SPRINGNET_HAS_ENERGY;
#ifdef MISTAKE_POLE
  component.capabilities |= SPRINGNET_DIVIDES_BY_REFERENCE;
#endif
#ifdef MISTAKE_PREPARES
  table.struct_size = sizeof table;
  table.name = "points";
  table.unit = "m";
  table.summary = "numbers";
  table.least = 2;
  table.smallest = -INFINITY;
  table.largest = INFINITY;
  law.table_count = 1;
  law.tables = table_list;
  law.prepare = prepare;
  law.release = release;
  component.needs = SPRINGNET_NEEDS_TABLES;
#endif
#ifdef WITH_STATE
  law.state_count = 1;
  law.states = state_list;
  law.update = update;
  component.needs = SPRINGNET_NEEDS_STATES;
#else
  (void)state_list;
  component.capabilities |=
      SPRINGNET_READS_RATE | SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES | SPRINGNET_HAS_RUPTURE;
#endif
}
