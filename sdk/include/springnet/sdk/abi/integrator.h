/* Plugin ABI: integrators. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_INTEGRATOR_H
#define SPRINGNET_SDK_ABI_INTEGRATOR_H

#include <springnet/sdk/abi/basics.h>
#include <springnet/sdk/abi/host.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How a time step ended. */
enum {
  SPRINGNET_SETTLED = 0,
  SPRINGNET_OSCILLATING = 1,
  SPRINGNET_OUT_OF_SWEEPS = 2,
  SPRINGNET_DIVERGING = 3,
  SPRINGNET_OUT_OF_TIME = 4 /* committed at the deadline, not settled */
};

typedef struct springnet_step_report {
  uint32_t struct_size;
  int32_t outcome;         /* SPRINGNET_SETTLED … */
  uint64_t steps;          /* time steps done */
  uint64_t sweeps;         /* sweeps, or evaluations of all springs, done */
  double force_difference; /* N, between the last two sweeps */
  double residual;         /* N, of the equation of motion over the step; nan if not evaluated */
  uint32_t node;           /* where the force difference was greatest */
  uint32_t start_node;     /* where the last sweep started; 0xffffffff: it has no start node */
  uint64_t substeps;       /* smaller time steps made in place of steps that did not settle */
  uint64_t stages;         /* smaller time constants passed on the way to the full one */
  double position_error;   /* m, estimated greatest distance of a node from the settled step; nan: not estimated */
} springnet_step_report;

/* Whether there is a largest time step. */
enum {
  SPRINGNET_LIMIT_KNOWN = 0,    /* to about a per cent */
  SPRINGNET_LIMIT_ESTIMATE = 1, /* the search ended before it was that accurate */
  SPRINGNET_LIMIT_NONE = 2,     /* every time step settles, or is stable, as far as linear theory tells */
  SPRINGNET_LIMIT_UNKNOWN = 3   /* a law or neuron cannot be linearised, say */
};

/* The largest time step under one update rule of an integrator. */
typedef struct springnet_limit {
  uint32_t struct_size;
  uint32_t kind;    /* SPRINGNET_LIMIT_KNOWN … */
  const char* rule; /* its name, letters a to z, digits, '_'; "" for an integrator that has no rules to choose from */
  double time_step; /* s; read of KNOWN and ESTIMATE */
  double weight;    /* s: at the limit stiffness k and damping d act on a mass m as weight^2 k / m and weight d / m; 0:
                       the time step */
  uint32_t node;    /* that moves most in the motion that grows first; 0xffffffff: not known */
  uint32_t reserved;
  const char* reason; /* of NONE and UNKNOWN; may be null */
} springnet_limit;

/* Receives the limits of an integrator, one call of `tell` for each rule. `limit` is read within the call. */
typedef struct springnet_limits {
  uint32_t struct_size;
  uint32_t reserved;
  void* context;
  springnet_status (*tell)(void* context, const springnet_limit* limit);
} springnet_limits;

typedef struct springnet_integrator_creation {
  uint32_t struct_size;
  uint32_t option_count;
  const springnet_host* host;
  const double* options; /* [option_count] in the order of the component's parameters */
  void* integrator;      /* out: context of the functions below */
} springnet_integrator_creation;

/* From the committed state to a committed state at `until`: in one time step, or by internal steps if the method
 * chooses its own. */
typedef struct springnet_advance {
  uint32_t struct_size;
  uint32_t reserved;
  double until; /* s */
  springnet_step_report* report;
} springnet_advance;

/* Takes bytes from an integrator that saves its memory; any number of calls, one after another. */
typedef struct springnet_byte_sink {
  uint32_t struct_size;
  uint32_t reserved;
  void* context;
  springnet_status (*write)(void* context, const void* bytes, uint64_t count);
} springnet_byte_sink;

typedef struct springnet_bytes {
  uint32_t struct_size;
  uint32_t reserved;
  const void* bytes; /* all that was written, in one piece */
  uint64_t count;
} springnet_bytes;

/* 2.1: what a motion is differentiated by: a scalar s that changes values of parameters and the committed state. */
typedef struct springnet_sensitivity {
  uint32_t struct_size;
  uint32_t set_count;
  const springnet_parameter_set* const* sets; /* values: d(values)/ds, which stay as they are while the column exists */
  /* d(state)/ds at the committed state, [3 node_count], x of all nodes first; 0 of fixed nodes. Null: 0. Read within
   * the call. */
  const double *position, *velocity;
  /* Size of a change of s, above 0: the errors of the changes that it causes are what the tolerances limit. */
  double scale;
} springnet_sensitivity;

typedef struct springnet_sensitivities {
  uint32_t struct_size;
  uint32_t count; /* of columns; 0: no more sensitivities */
  const springnet_sensitivity* const* columns;
} springnet_sensitivities;

/* Derivatives of the committed state by the scalar of one column. */
typedef struct springnet_sensitivity_values {
  uint32_t struct_size;
  uint32_t column;
  double *position, *velocity; /* out: [3 node_count], x of all nodes first */
} springnet_sensitivity_values;

/* All functions are called from the thread that created the integrator. Reasons of failure go to
 * springnet_host::message.
 */
typedef struct springnet_integrator {
  uint32_t struct_size;
  uint32_t reserved;
  void* context; /* first argument of create */
  springnet_status (*create)(void* context, springnet_integrator_creation* creation);
  springnet_status (*destroy)(void* integrator);
  /* On SPRINGNET_UNSETTLED the report says how the step ended, and the step is not committed; a method that divides
   * steps may have committed the smaller ones before. */
  springnet_status (*advance)(void* integrator, const springnet_advance* advance);
  /* Reports the largest time steps at the committed state, for the options given to create. All host functions may be
   * called but commit and fire_events; loads are those of the committed time. Null where the integrator knows of none.
   */
  springnet_status (*limits)(void* integrator, const springnet_limits* limits);
  /* Drops all that is kept from one call of `advance` to the next (derivatives, steps taken, estimates), so that the
   * next one gives the same bits as that of an integrator created now. Null where the integrator keeps nothing. */
  springnet_status (*forget)(void* integrator);

  /* From ABI 2.1 on; null where an integrator has none of it. */
  /* Writes what the next `advance` needs of the ones before: with it an integrator created anew, of the same options,
   * on the same network and committed state, gives the same bits. The bytes need not be portable between machines. */
  springnet_status (*save)(void* integrator, const springnet_byte_sink* sink);
  /* Takes it up again. The committed state and `revision` are those that it belongs to, whatever their numbers were.
   * Fails on bytes that are not of this integrator and network, and then keeps nothing, as after `forget`. */
  springnet_status (*restore)(void* integrator, const springnet_bytes* bytes);
  /* Positions and velocities at a time within the last step that it committed, [node_count] each. Fails at other times,
   * and where it has no interpolation, as at a step that ended with an event. */
  springnet_status (*interpolate)(void* integrator, const springnet_dense_output* output);
  /* Forward sensitivities: from the committed state on, `advance` carries along the derivatives of the motion by these
   * scalars, in place of those that it has. It fails where the motion has what the integrator cannot differentiate. */
  springnet_status (*begin_sensitivities)(void* integrator, const springnet_sensitivities* sensitivities);
  /* Those of the committed state; null where begin_sensitivities is, and only then. */
  springnet_status (*sensitivity)(void* integrator, const springnet_sensitivity_values* values);
} springnet_integrator;

#ifdef __cplusplus
}
#endif

#endif
