/* A spring function T = l - l0 that crashes once a spring is longer than 1.5 m, as `how` says. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <springnet/sdk/plugin.h>

SPRINGNET_PLUGIN_NOTE(0);

static volatile int* volatile nowhere = NULL;

/* Needs the whole stack. */
static volatile int forever = 1;
static int deeper(int depth) {
  volatile char room[4096];
  room[depth % 4096] = 1;
  return forever ? deeper(depth + 1) + room[depth % 4096] : depth;
}

static int is_worker(void) { return syscall(SYS_gettid) != getpid(); }

static springnet_status evaluate(void* context, const springnet_law_batch* batch) {
  (void)context;
  for (uint32_t i = 0; i < batch->count; ++i) {
    const double rest = batch->reference[batch->reference_stride * i];
    if (batch->q[i] > 1.5) {
      const int how = (int)batch->parameters[0][0];
      if (how == 0) *nowhere = 1;
      if (how == 1) abort();
      if (how == 5 || (how == 6 && is_worker())) forever += deeper(0);
      if (how < 5) raise(how == 2 ? SIGFPE : how == 3 ? SIGILL : SIGBUS);
    }
    if (batch->force != NULL) batch->force[i] = batch->q[i] - rest;
    if (batch->force_by_q != NULL) batch->force_by_q[i] = 1.0;
    if (batch->force_by_rate != NULL) batch->force_by_rate[i] = 0.0;
  }
  return SPRINGNET_OK;
}

static const springnet_parameter how = {.struct_size = sizeof(springnet_parameter),
                                        .type = SPRINGNET_INTEGER,
                                        .name = "how",
                                        .unit = "1",
                                        .summary = "which signal, or recursion: anywhere, in a worker thread",
                                        .default_value = 0,
                                        .smallest = 0,
                                        .largest = 6,
                                        .scale = 1};
static const springnet_parameter* const parameters[] = {&how};
static const springnet_law law = {.struct_size = sizeof(springnet_law),
                                  .invariant = SPRINGNET_LENGTH,
                                  .update_order = 1,
                                  .largest_stretch = 1e300,
                                  .evaluate = evaluate};
static const springnet_component component = {.struct_size = sizeof(springnet_component),
                                              .kind = SPRINGNET_SPRING_FUNCTION,
                                              .id = "crashing",
                                              .summary = "crashes where it is longer than 1.5 m",
                                              .reference = "",
                                              .capabilities = SPRINGNET_ACTS_IN_COMPRESSION | SPRINGNET_HAS_DERIVATIVES,
                                              .parameter_count = 1,
                                              .parameters = parameters,
                                              .implementation = &law};
static const springnet_component* const components[] = {&component};
SPRINGNET_EXPORT extern const springnet_plugin springnet_plugin_entry;
const springnet_plugin springnet_plugin_entry = {.magic = SPRINGNET_MAGIC,
                                                 .struct_size = sizeof(springnet_plugin),
                                                 .abi_major = SPRINGNET_ABI_MAJOR,
                                                 .abi_minor = SPRINGNET_ABI_MINOR,
                                                 .component_count = 1,
                                                 .id = "org.example.crashing",
                                                 .version = "1.0.0",
                                                 .author = "tests",
                                                 .licence = "MIT",
                                                 .components = components};
