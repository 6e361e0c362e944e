/* A neuron in plain C, a = F / m - c v, right but for the mistake that MISTAKE_… chooses. */
#include <stdlib.h>

#include <springnet/sdk/plugin.h>

static const springnet_parameter drag = {.struct_size = sizeof(springnet_parameter),
                                         .type = SPRINGNET_NUMBER,
                                         .name = "drag",
                                         .unit = "1/s",
                                         .summary = "c",
                                         .default_value = 0.5,
                                         .smallest = 0,
                                         .largest = 100,
                                         .scale = 1};
static const springnet_parameter* const parameters[] = {&drag};

static springnet_status evaluate(void* context, const springnet_neuron_batch* b) {
  (void)context;
#ifdef MISTAKE_LEAKS
  static void* kept; /* a list that grows */
  void** const item = malloc(24);
  if (item) *item = kept;
  kept = item;
#endif
  const double *force[] = {b->force.x, b->force.y, b->force.z},
               *velocity[] = {b->velocity.x, b->velocity.y, b->velocity.z};
  double* const acceleration[] = {b->acceleration.x, b->acceleration.y, b->acceleration.z};
  for (uint32_t i = 0; i < b->count; ++i) {
    const double c = b->parameters[0][i * b->parameter_strides[0]];
#ifdef MISTAKE_FORCE
    const double mobility = 0.5 / b->mass[i];
#else
    const double mobility = 1.0 / b->mass[i];
#endif
#ifdef MISTAKE_DERIVATIVE
    const double by_velocity = c;
#else
    const double by_velocity = -c;
#endif
#ifdef MISTAKE_CHANGES
    ((double*)b->mass)[i] = b->mass[i] + 0.0;
#endif
#ifdef MISTAKE_BATCH
    const double slight = 1.0 + 1e-15 * (b->count % 7);
#else
    const double slight = 1.0;
#endif
    for (uint32_t k = 0; k < 3; ++k) acceleration[k][i] = force[k][i] * mobility * slight - c * velocity[k][i];
    for (uint32_t k = 0; k < 9; ++k) {
      const double diagonal = k % 4 == 0 ? 1.0 : 0.0;
      if (b->acceleration_by_force) b->acceleration_by_force[9 * i + k] = diagonal * mobility;
      if (b->acceleration_by_position) b->acceleration_by_position[9 * i + k] = 0.0;
      if (b->acceleration_by_velocity) b->acceleration_by_velocity[9 * i + k] = diagonal * by_velocity;
    }
  }
  return SPRINGNET_OK;
}

static const springnet_neuron_model model = {.struct_size = sizeof(springnet_neuron_model), .evaluate = evaluate};
static const springnet_component component = {.struct_size = sizeof(springnet_component),
                                              .kind = SPRINGNET_NEURON,
                                              .id = "broken",
                                              .summary = "right but for one mistake",
                                              .reference = "",
                                              .capabilities = SPRINGNET_HAS_DERIVATIVES,
                                              .parameter_count = 1,
                                              .parameters = parameters,
                                              .implementation = &model};
static const springnet_component* const components[] = {&component};

SPRINGNET_PLUGIN_NOTE(0);
SPRINGNET_EXPORT extern const springnet_plugin springnet_plugin_entry;
const springnet_plugin springnet_plugin_entry = {.magic = SPRINGNET_MAGIC,
                                                 .struct_size = sizeof(springnet_plugin),
                                                 .abi_major = SPRINGNET_ABI_MAJOR,
                                                 .abi_minor = SPRINGNET_ABI_MINOR,
                                                 .component_count = 1,
                                                 .id = "org.example.broken_neuron",
                                                 .version = "1.0",
                                                 .author = "a test",
                                                 .licence = "MIT",
                                                 .components = components};
