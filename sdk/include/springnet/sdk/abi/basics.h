/* What all parts of the plugin ABI share: statuses, messages, vectors, and how structs grow. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_BASICS_H
#define SPRINGNET_SDK_ABI_BASICS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define SPRINGNET_EXPORT __declspec(dllexport)
#else
#define SPRINGNET_EXPORT __attribute__((visibility("default")))
#endif

/* True if the struct behind `pointer`, as its author compiled it, contains `field`. */
#define SPRINGNET_HAS_FIELD(type, pointer, field) \
  ((pointer)->struct_size >= offsetof(type, field) + sizeof((pointer)->field))
/* Bytes of a struct up to and including the field `last`. */
#define SPRINGNET_SIZE_TO(type, last) (offsetof(type, last) + sizeof(((type*)0)->last))

/* The status of every function. One that fails also fills the message that it was given. */
enum {
  SPRINGNET_OK = 0,
  SPRINGNET_FAILED = 1,      /* the message says why; the run ends */
  SPRINGNET_RECOVERABLE = 2, /* no finite result at this state; a smaller step may succeed */
  SPRINGNET_UNSETTLED = 3    /* advance: the step did not settle; its report says how */
};
typedef int32_t springnet_status;

/* A reason of failure, written by a plugin or the host; zero-terminated UTF-8, truncated if too long. */
typedef struct springnet_message {
  char text[512];
} springnet_message;

/* Three arrays of one length, the components of a vector for each node. */
typedef struct springnet_vectors {
  double *x, *y, *z;
} springnet_vectors;
typedef struct springnet_const_vectors {
  const double *x, *y, *z;
} springnet_const_vectors;

/* Instruction sets that kernels may be built for. All give the same bits (no contraction, no reassociation). */
enum { SPRINGNET_GENERIC = 0, SPRINGNET_AVX2 = 1, SPRINGNET_AVX512 = 2 };

/* A call that needs nothing but a place for the reason of its failure. */
typedef struct springnet_call {
  uint32_t struct_size;
  uint32_t reserved;
  springnet_message* message; /* may be null */
} springnet_call;

#ifdef __cplusplus
}
#endif

#endif
