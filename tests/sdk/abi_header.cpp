// The ABI header as C++ sees it, with nothing else included.
#include <springnet/sdk/plugin.h>

static_assert(SPRINGNET_PLUGIN_SIZE_2_0 == 72);
static_assert(SPRINGNET_COMPONENT_SIZE_2_0 == 72);
static_assert(SPRINGNET_PARAMETER_SIZE_2_0 == 80);
static_assert(SPRINGNET_TABLE_SIZE_2_0 == 56);
static_assert(SPRINGNET_LAW_SIZE_2_0 == 120);
static_assert(SPRINGNET_NEURON_MODEL_SIZE_2_0 == 24);
static_assert(SPRINGNET_INTEGRATOR_SIZE_2_0 == 56);
