/* springnet plugin ABI, version 2.
 *
 * Everything that crosses between the engine and a plugin is declared here and in abi/, in C11 without dependencies: no
 * C++ type, no exception, no allocation that one side makes and the other frees. Authors in C++ normally include
 * law.hpp, neuron.hpp or integrator.hpp instead, which generate all of this.
 *
 * Rules that keep old plugins working with new hosts, and the other way round:
 *   - every function takes a context, a struct that carries its own size first, or both, and returns a status;
 *   - structs only grow at their end, within one ABI major version;
 *   - structs are reached through pointers, never stored by value in arrays;
 *   - a reader uses a field only when struct_size covers it (SPRINGNET_HAS_FIELD);
 *   - a host accepts a plugin whose structs are at least as large as the frozen *_SIZE_2_0 below;
 *   - what needs a newer host says so (needs_minor, needs): the host then refuses it by name, and takes the rest.
 *
 * Which function may be called when, from which thread, and how long pointers live: sdk/README.md, "Threads and calls".
 *
 * Quantities are SI throughout. Vector quantities are structures of arrays (x[], y[], z[]). Node numbers in these
 * headers are the engine's own (renumbered for locality); springnet_network::user_number maps them to the user's.
 */
#ifndef SPRINGNET_SDK_PLUGIN_H
#define SPRINGNET_SDK_PLUGIN_H

#include <springnet/sdk/abi/basics.h>
#include <springnet/sdk/abi/integrator.h>
#include <springnet/sdk/abi/law.h>
#include <springnet/sdk/abi/neuron.h>
#include <springnet/sdk/abi/parameter.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SPRINGNET_MAGIC UINT64_C(0x54454e474e525053) /* "SPRNGNET" in little-endian memory */
#define SPRINGNET_ABI_MAJOR 2u
#define SPRINGNET_ABI_MINOR 1u

/* Component kinds. */
enum {
  SPRINGNET_SPRING_FUNCTION = 1,
  SPRINGNET_VISCOSITY_FUNCTION = 2,
  SPRINGNET_NEURON = 3,
  SPRINGNET_INTEGRATOR = 4
};

/* What a component provides beyond its force (or acceleration). */
#define SPRINGNET_HAS_ENERGY (UINT64_C(1) << 0)
#define SPRINGNET_HAS_DERIVATIVES (UINT64_C(1) << 1) /* by q, its rate and states; of the states' rates; F, p, v */
#define SPRINGNET_HAS_PARAMETER_DERIVATIVES (UINT64_C(1) << 2) /* by each parameter; 2.1: neurons, by mass and time */
#define SPRINGNET_HAS_RUPTURE (UINT64_C(1) << 3)         /* writes a margin; the element is removed once it is <= 0 */
#define SPRINGNET_ACTS_IN_COMPRESSION (UINT64_C(1) << 4) /* pushes as well as pulls */
#define SPRINGNET_READS_RATE (UINT64_C(1) << 5)          /* else the host does not compute the rate */
#define SPRINGNET_INTEGRATES_STATES (UINT64_C(1) << 6)   /* an integrator: networks with internal state */
/* What an integrator does, for those who choose one; `plugin show` lists it. A host refuses a network with contact or
 * rigid connections where the integrator declares that it has none. */
#define SPRINGNET_LOCATES_EVENTS (UINT64_C(1) << 10)   /* in time: contact, slip, rupture, not only at ends of steps */
#define SPRINGNET_CHOOSES_STEPS (UINT64_C(1) << 11)    /* by an estimate of its error */
#define SPRINGNET_HAS_DENSE_OUTPUT (UINT64_C(1) << 12) /* `interpolate` */
#define SPRINGNET_WITHOUT_CONTACT (UINT64_C(1) << 13)  /* networks with planes or instruments are refused */
#define SPRINGNET_WITHOUT_RIGID (UINT64_C(1) << 14)    /* networks with rigid connections are refused */
/* Contact of bodies with each other: networks that have it are refused by others. */
#define SPRINGNET_KEEPS_BODIES_APART (UINT64_C(1) << 15)
#define SPRINGNET_KEEPS_RIGID_BODIES_APART (UINT64_C(1) << 8) /* likewise, of nodes with rigid connections */
/* What its author promises, and a checker can verify. */
#define SPRINGNET_MONOTONE (UINT64_C(1) << 16)             /* the force never falls as q or its rate grows */
#define SPRINGNET_NOT_ZERO_AT_REST (UINT64_C(1) << 17)     /* it exerts a force at the reference value, at rest */
#define SPRINGNET_ADDS_POWER (UINT64_C(1) << 18)           /* active: its dissipation may be negative */
#define SPRINGNET_READS_TIME (UINT64_C(1) << 19)           /* its formulas depend on the time */
#define SPRINGNET_CALLING_THREAD_ONLY (UINT64_C(1) << 20)  /* call it from the thread that runs the simulation alone */
#define SPRINGNET_FITS_ELEMENTS (UINT64_C(1) << 21)        /* a law of a length that any other invariant may replace */
#define SPRINGNET_DIVIDES_BY_REFERENCE (UINT64_C(1) << 22) /* it needs a reference value above 0 */
#define SPRINGNET_HAS_ALL_DERIVATIVES (UINT64_C(1) << 7)   /* 2.1: fills springnet_law_batch::derivatives */

/* What a component needs of a host; a host refuses a component with a bit that it does not know. */
#define SPRINGNET_NEEDS_STATES (UINT64_C(1) << 0)
#define SPRINGNET_NEEDS_INPUTS (UINT64_C(1) << 1)
#define SPRINGNET_NEEDS_TABLES (UINT64_C(1) << 2)
#define SPRINGNET_NEEDS_SEVERAL (UINT64_C(1) << 3) /* 2.1: laws over several invariants */

typedef struct springnet_component {
  uint32_t struct_size;
  uint32_t kind;         /* SPRINGNET_SPRING_FUNCTION … */
  const char* id;        /* the name in a scene; unique within a kind */
  const char* summary;   /* one line */
  const char* reference; /* literature, or "" */
  uint64_t capabilities; /* SPRINGNET_HAS_ENERGY … */
  uint64_t needs;        /* SPRINGNET_NEEDS_STATES … */
  uint32_t needs_minor;  /* smallest minor version of a host's ABI */
  uint32_t parameter_count;
  const springnet_parameter* const* parameters;
  const void* implementation; /* springnet_law, springnet_neuron_model or springnet_integrator, by kind */
} springnet_component;

typedef struct springnet_plugin {
  uint64_t magic; /* SPRINGNET_MAGIC */
  uint32_t struct_size;
  uint32_t abi_major;
  uint32_t abi_minor;   /* of the SDK it was built with */
  uint32_t needs_minor; /* smallest minor version of a host's ABI */
  uint32_t component_count;
  uint32_t reserved;
  const char* id; /* e.g. "org.example.my_laws" */
  const char* version;
  const char* author;
  const char* licence; /* SPDX expression */
  const springnet_component* const* components;
} springnet_plugin;

/* The only symbol that a plugin exports: data, so that a host can read it before it runs any code of the plugin. */
#define SPRINGNET_ENTRY_SYMBOL "springnet_plugin_entry"

/* Opening a library runs its constructors. So the version also stands in a note of the ELF file, which a host reads
 * before: a file without it, or with needs that the host does not meet, is not opened. */
#define SPRINGNET_NOTE_NAME "springnet"
#define SPRINGNET_NOTE_TYPE 1u
typedef struct springnet_note {
  uint32_t name_size; /* with its zero */
  uint32_t description_size;
  uint32_t type; /* SPRINGNET_NOTE_TYPE */
  char name[12];
  uint32_t abi_major, abi_minor, needs_minor, reserved; /* the description; it may grow */
} springnet_note;
#if defined(__ELF__)
#define SPRINGNET_PLUGIN_NOTE(needs_minor)                                                         \
  static const springnet_note springnet_plugin_note                                                \
      __attribute__((used, section(".note.springnet"), aligned(4))) = {sizeof SPRINGNET_NOTE_NAME, \
                                                                       16u,                        \
                                                                       SPRINGNET_NOTE_TYPE,        \
                                                                       SPRINGNET_NOTE_NAME,        \
                                                                       SPRINGNET_ABI_MAJOR,        \
                                                                       SPRINGNET_ABI_MINOR,        \
                                                                       (needs_minor),              \
                                                                       0u}
#else
#define SPRINGNET_PLUGIN_NOTE(needs_minor) struct springnet_note
#endif

/* Smallest sizes that a host of ABI 2.x accepts: frozen, whatever is appended later. */
#define SPRINGNET_PLUGIN_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_plugin, components)
#define SPRINGNET_COMPONENT_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_component, implementation)
#define SPRINGNET_PARAMETER_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_parameter, choices)
#define SPRINGNET_TABLE_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_table, largest)
#define SPRINGNET_LAW_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_law, release)
#define SPRINGNET_LAW_SIZE_2_1 SPRINGNET_SIZE_TO(springnet_law, reserved_2) /* over several invariants */
#define SPRINGNET_INVARIANT_SIZE_2_1 SPRINGNET_SIZE_TO(springnet_invariant, reserved)
#define SPRINGNET_NEURON_MODEL_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_neuron_model, evaluate)
#define SPRINGNET_INTEGRATOR_SIZE_2_0 SPRINGNET_SIZE_TO(springnet_integrator, forget)

#ifdef __cplusplus
}
#endif

#endif
