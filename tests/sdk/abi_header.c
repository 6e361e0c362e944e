/* The ABI header as C11 sees it. */
#include "abi_sizes.h"

#define COUNT(type, last, end) +(SPRINGNET_SIZE_TO(type, last) != end)
unsigned springnet_ends_wrong_in_c(void) { return (unsigned)(0 SPRINGNET_ENDS_2_0(COUNT) SPRINGNET_ENDS_2_1(COUNT)); }

/* What a host requires at least. */
_Static_assert(SPRINGNET_PLUGIN_SIZE_2_0 == 72, "frozen");
_Static_assert(SPRINGNET_COMPONENT_SIZE_2_0 == 72, "frozen");
_Static_assert(SPRINGNET_PARAMETER_SIZE_2_0 == 80, "frozen");
_Static_assert(SPRINGNET_TABLE_SIZE_2_0 == 56, "frozen");
_Static_assert(SPRINGNET_LAW_SIZE_2_0 == 120, "frozen");
_Static_assert(SPRINGNET_NEURON_MODEL_SIZE_2_0 == 24, "frozen");
_Static_assert(SPRINGNET_INTEGRATOR_SIZE_2_0 == 56, "frozen");

/* The note of a plugin: header, name and description without gaps. */
_Static_assert(sizeof(springnet_note) == 40, "frozen");
_Static_assert(offsetof(springnet_note, abi_major) == 24, "frozen");
SPRINGNET_PLUGIN_NOTE(0u);
