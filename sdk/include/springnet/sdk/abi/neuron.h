/* Plugin ABI: neurons, which turn net force into acceleration. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_NEURON_H
#define SPRINGNET_SDK_ABI_NEURON_H

#include <springnet/sdk/abi/basics.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A batch of nodes: net force to acceleration. Blocks are 3x3, row-major, nine consecutive numbers a node, or null. */
typedef struct springnet_neuron_batch {
  uint32_t struct_size;
  uint32_t count;
  uint32_t instruction_set;
  uint32_t reserved;
  double time;                       /* s */
  springnet_const_vectors force;     /* net force, N */
  springnet_const_vectors position;  /* m */
  springnet_const_vectors velocity;  /* m/s */
  const double* mass;                /* kg, count values */
  const double* const* parameters;   /* [parameter_count] */
  const uint32_t* parameter_strides; /* 0 or 1 */
  springnet_vectors acceleration;    /* m/s^2, output */
  double* acceleration_by_force;     /* [count][3][3] 1/kg */
  double* acceleration_by_position;  /* [count][3][3] 1/s^2 */
  double* acceleration_by_velocity;  /* [count][3][3] 1/s */
  springnet_message* message;
  /* 2.1, of neurons with SPRINGNET_HAS_PARAMETER_DERIVATIVES: three consecutive numbers a node, or null. */
  double* acceleration_by_mass;              /* [count][3] m/(s^2 kg) */
  double* acceleration_by_time;              /* [count][3] m/s^3, where the formula itself reads the time */
  double* const* acceleration_by_parameters; /* [parameter_count], each [count][3] or null; null: none is wanted */
} springnet_neuron_batch;

typedef struct springnet_neuron_model {
  uint32_t struct_size;
  uint32_t reserved;
  void* context; /* first argument of the function below */
  springnet_status (*evaluate)(void* context, const springnet_neuron_batch* batch);
} springnet_neuron_model;

#ifdef __cplusplus
}
#endif

#endif
