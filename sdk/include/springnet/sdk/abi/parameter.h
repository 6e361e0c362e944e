/* Plugin ABI: descriptions of parameters, states and inputs. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_PARAMETER_H
#define SPRINGNET_SDK_ABI_PARAMETER_H

#include <springnet/sdk/abi/basics.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Type of a parameter in a scene. All types cross the boundary as double. */
enum {
  SPRINGNET_NUMBER = 0,
  SPRINGNET_INTEGER = 1,
  SPRINGNET_BOOLEAN = 2, /* 0 or 1 */
  SPRINGNET_CHOICE = 3   /* index into `choices` */
};

enum {
  SPRINGNET_LEARNABLE = 1u << 0,         /* identification may change it */
  SPRINGNET_EXCLUDES_SMALLEST = 1u << 1, /* the value must be greater than `smallest` */
  SPRINGNET_REQUIRED = 1u << 2           /* no default: a scene must give it */
};

typedef struct springnet_parameter {
  uint32_t struct_size;
  uint32_t type;        /* SPRINGNET_NUMBER … */
  const char* name;     /* key in a scene, snake_case */
  const char* unit;     /* SI, "1": dimensionless */
  const char* summary;  /* one line */
  double default_value; /* ignored if SPRINGNET_REQUIRED */
  double smallest;
  double largest;
  double scale;               /* typical magnitude, for learning, and for tolerances of states; > 0 */
  uint32_t flags;             /* SPRINGNET_LEARNABLE … */
  uint32_t choice_count;      /* SPRINGNET_CHOICE */
  const char* const* choices; /* names */
} springnet_parameter;

#ifdef __cplusplus
}
#endif

#endif
