/* The ABI header as C11 sees it. */
#include "abi_sizes.h"

#define COUNT(type, last, end) +(SPRINGNET_SIZE_TO(type, last) != end)
unsigned springnet_ends_wrong_in_c(void) {
  return (unsigned)(0 SPRINGNET_ENDS_1_0(COUNT) SPRINGNET_ENDS_1_1(COUNT) SPRINGNET_ENDS_1_2(COUNT) SPRINGNET_ENDS_1_3(
      COUNT) SPRINGNET_ENDS_1_4(COUNT) SPRINGNET_ENDS_1_5(COUNT) SPRINGNET_ENDS_1_6(COUNT));
}

/* What a host requires at least. */
_Static_assert(SPRINGNET_PLUGIN_SIZE_1_0 == 64, "frozen");
_Static_assert(SPRINGNET_COMPONENT_SIZE_1_0 == 56, "frozen");
_Static_assert(SPRINGNET_PARAMETER_SIZE_1_0 == 80, "frozen");
_Static_assert(SPRINGNET_LAW_SIZE_1_0 == 56, "frozen");
_Static_assert(SPRINGNET_NEURON_MODEL_SIZE_1_0 == 16, "frozen");
_Static_assert(SPRINGNET_INTEGRATOR_SIZE_1_0 == 32, "frozen");
