// The ABI header as C++ sees it, with nothing else included.
#include <springnet/sdk/plugin.h>

static_assert(SPRINGNET_PLUGIN_SIZE_1_0 == 64);
static_assert(SPRINGNET_COMPONENT_SIZE_1_0 == 56);
static_assert(SPRINGNET_PARAMETER_SIZE_1_0 == 80);
static_assert(SPRINGNET_LAW_SIZE_1_0 == 56);
static_assert(SPRINGNET_NEURON_MODEL_SIZE_1_0 == 16);
static_assert(SPRINGNET_INTEGRATOR_SIZE_1_0 == 32);
