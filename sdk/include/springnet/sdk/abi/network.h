/* Plugin ABI: the network as an integrator sees it, and what it asks of it. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_NETWORK_H
#define SPRINGNET_SDK_ABI_NETWORK_H

#include <springnet/sdk/abi/basics.h>
#include <springnet/sdk/abi/parameter.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The state of all nodes in the host's memory. Made by springnet_host::create_state. */
typedef struct springnet_state {
  uint32_t struct_size;
  uint32_t force_is_current;  /* 1: `force` belongs to this state; 0: the host evaluates it on demand */
  springnet_vectors position; /* [node_count] m */
  springnet_vectors velocity; /* [node_count] m/s */
  springnet_vectors force; /* [node_count] net force at this state, N: springs and loads, without constraint forces */
  double* internal;        /* [internal_count] internal state of laws */
  /* For commit; 1: position and velocity are as the last sweep without an order left them, so that the host
   * need not look for numbers that are not finite once more. The host sets it to 0. */
  uint32_t is_swept;
  uint32_t reserved;
} springnet_state;

/* Constraint status of a single node. Rigid connections are separate: springnet_network::cluster. */
enum {
  SPRINGNET_FREE = 0,       /* no constraint */
  SPRINGNET_PRESCRIBED = 1, /* fixed, or moved over time by the scene */
  SPRINGNET_STICKING = 2,   /* carried by the surfaces that it touches */
  SPRINGNET_SLIDING = 3     /* moves along the surfaces that it touches, with or without friction */
};

/* 2.1: what other bodies, or other parts of its own, do to a node within the sweeps of a step. */
enum {
  SPRINGNET_NEAR = 1,   /* nothing at present */
  SPRINGNET_PUSHED = 2, /* push it */
  SPRINGNET_STUCK = 3   /* push it, and friction holds it on one */
};

/* The internal state of laws in an evaluation. Without a time step it is as given. With one, laws step it: from that
 * committed to the end of the step, where nodes are as in the evaluation; their forces, and all derivatives, are those
 * with the states that follow. */
typedef struct springnet_internal {
  uint32_t struct_size;
  uint32_t order;       /* of the step: 1, or 2, second order and L-stable */
  double time_step;     /* s; 0: none */
  const double* values; /* [internal_count] without a time step; null: those committed */
  double* next;         /* out, with a time step: [internal_count] at its end; null: not wanted */
  double* rates;        /* out, without one: [internal_count]; null: not wanted */
} springnet_internal;

/* A range of the internal state: one state of the elements of one law. */
typedef struct springnet_internal_range {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t first, count;
  const springnet_parameter* state; /* name, unit, bounds, and scale for tolerances */
  const char* law;                  /* id, for messages */
} springnet_internal_range;

/* The network as an integrator sees it. `revision` increases with every change after which a multistep method must
 * restart: a cut, a rupture, a contact made or released, a load switched, a state set by the embedding program. */
typedef struct springnet_network {
  uint32_t struct_size;
  uint32_t node_count;
  uint64_t spring_count; /* live springs */
  uint64_t internal_count;
  uint64_t revision;
  uint32_t unit_count;         /* units of nodes for threads to work on; independent of the number of threads */
  uint32_t event_count;        /* changes only together with `revision` */
  uint32_t surface_count;      /* planes and instruments */
  uint32_t body_contact_count; /* 2.1: contacts of bodies with each other or themselves that the scene has */
  /* Typical magnitudes of the network at its start, for tolerances; all above 0. */
  double length_scale;   /* m: mean rest length */
  double velocity_scale; /* m/s: greatest speed, of nodes and of what the scene moves, or the one that the greatest
                            acceleration reaches over length_scale */
  double force_scale;    /* N: greatest weight, load or net force of a node, or m v^2 / length_scale */
  const double* mass;    /* [node_count] kg */
  const uint8_t* fixed;  /* [node_count] 1: fixed, or moved over time by the scene */
  const uint8_t* held;   /* [node_count] 1: a surface holds it where it touched, and carries it */
  const uint32_t* user_number; /* [node_count] */
  /* Null until they are asked for (springnet_network_query), and again after `connection_revision` has changed: they
   * cost as much as many time steps. */
  const uint32_t* neighbour_start; /* [node_count + 1] */
  const uint32_t* neighbours;      /* by a live spring, element or rigid connection; ascending user number, unique */
  const uint8_t* touching;         /* [node_count] 1: a surface holds it, or it slides on one */
  const uint32_t* cluster; /* [node_count] the same number for nodes that rigid connections join; 0xffffffff: none */
  uint64_t rigid_count;    /* rigid connections */
  uint64_t load_revision;  /* increases with every begin_step whose loads differ from those before: accelerations at the
                              end of the last step are then not those at the start of this one */
  const uint8_t* status;   /* [node_count] SPRINGNET_FREE …: for the outputs of the step's last sweep or constrain; as
                              committed before the first one and after commit. The address of the array does not change.
                              Within a sweep it may be read for the nodes of the batch; it holds the decisions of the
                              sweep before */
  uint64_t connection_revision; /* increases with `revision` when neighbours change; from 1 on */
  const springnet_internal_range* const* internal_ranges; /* [internal_range_count] they cover the internal state */
  uint64_t internal_range_count;
  /* 2.1: springs, elements and input signals that the network was made with, removed ones included: the lengths of
   * arrays by their numbers (springnet_parameter_set). */
  uint64_t spring_number_count, element_number_count, input_count;
  /* 2.1: bodies in contact, for the outputs of the step's last sweep or constrain, as `status`. */
  const uint8_t* pushed;        /* [node_count] 0, or SPRINGNET_NEAR …; null without body_contact_count */
  const uint32_t* pushed_count; /* [1] nodes that are not 0 there */
} springnet_network;

/* Evaluation of the layers at a state: springs, loads, neurons. Outputs that are not wanted are null (all three
 * components). Accelerations are those of the constrained motion: fixation, prescribed motion, rigid connections,
 * contact and friction are included. `force` is without any of these. */
typedef struct springnet_evaluation {
  uint32_t struct_size;
  uint32_t node_count; /* of `nodes` */
  /* Null: all nodes. Else some, each by itself: accelerations are those of their neurons, without constraints. The
   * arrays still cover all nodes. */
  const uint32_t* nodes;
  double time; /* s */
  springnet_const_vectors position;
  springnet_const_vectors velocity;
  const springnet_internal* internal; /* null: the states committed, as they are */
  springnet_vectors force;            /* out: net force N, without constraint forces */
  springnet_vectors acceleration;     /* out: m/s^2 */
  /* For some nodes only; null if not wanted. For each node by itself, without constraints. */
  double* acceleration_by_velocity; /* out: [node_count][3][3] 1/s, with respect to the node's own velocity */
  double* acceleration_by_position; /* out: [node_count][3][3] 1/s^2 */
  double* energy; /* out: [node_count] J, of the node's springs less the work of its loads; nan if there is no
                     potential: a law without energy, or one that reads the rate */
  /* For all nodes, with `acceleration` only; null if not wanted. */
  springnet_vectors free_acceleration; /* out: of the nodes' neurons by themselves, without constraints, m/s^2 */
} springnet_evaluation;

/* Nodes whose net force is final, passed to the integrator's node update while they are in cache. Element i of the
 * arrays belongs to node first + i, or nodes[i]. */
typedef struct springnet_node_batch {
  uint32_t struct_size;
  uint32_t first; /* nodes first … first + count - 1 */
  uint32_t count;
  uint32_t unit;                        /* at most one thread at a time works on a unit */
  springnet_const_vectors force;        /* [count] net force, N */
  springnet_const_vectors acceleration; /* [count] of the node's neuron, m/s^2, without constraints */
  /* With springnet_sweep::want_blocks, else null; as in springnet_evaluation, [count][3][3] */
  const double* acceleration_by_velocity;
  const double* acceleration_by_position;
  /* Null, or [count] the nodes, instead of first … first + count - 1. Some batches of a sweep with `lists` have them.
   */
  const uint32_t* nodes;
  uint32_t instruction_set; /* SPRINGNET_GENERIC …, for kernels of the update */
  uint32_t reserved;
} springnet_node_batch;
typedef springnet_status (*springnet_node_update)(void* user, const springnet_node_batch* batch);

/* 2.1: springnet_sweep::contacts in `constrain`. */
enum {
  SPRINGNET_MAY_TOUCH = 4, /* free nodes may touch, and slips that have turned round end; other contacts stay */
  SPRINGNET_AS_BEFORE = 5  /* contacts stay as the sweep before left them */
};

/* One sweep of the recurrent network: springs read (position, velocity); each node's update writes its new outputs;
 * the host then applies fixation, prescribed motion and contact to the outputs.
 * Without an order all springs are evaluated before any output is replaced: `next` must differ from (position,
 * velocity), and updates are called tile by tile, from several threads. With an order the nodes are updated one by one
 * in that order (see `lists`), on the calling thread, each reading the newest outputs: `next` must equal (position,
 * velocity). Nodes of one cluster are updated together, in the place of the first of them. If `set_start` divides the
 * order into sets, the nodes of a set are in ascending order and updated by several threads. No two nodes of a set may
 * be joined, unless they belong to the same cluster. An enclosed volume counts as joining only those of its nodes that
 * share a triangle. All of its nodes depend on it, so the host updates them one after another, last in their set. */
typedef struct springnet_sweep {
  uint32_t struct_size;
  uint32_t order_count;
  const uint32_t* order;                  /* null, or nodes in the order of their update */
  double time;                            /* s, end of the step */
  springnet_const_vectors start_position; /* frozen activities at the start of the step */
  springnet_const_vectors start_velocity;
  springnet_const_vectors position; /* outputs that springs read */
  springnet_const_vectors velocity;
  springnet_vectors next_position; /* outputs that the update writes */
  springnet_vectors next_velocity;
  springnet_vectors force; /* out: net forces, N; null (without an order): not wanted */
  springnet_node_update update;
  void* user;
  double time_constant;      /* s, length of the step; needed if the network has rigid connections or surfaces */
  double theta;              /* P = p + time_constant ((1 - theta) v + theta U); 0 stands for 1 */
  const uint32_t* set_start; /* null, or [set_count + 1] places in `order` */
  uint32_t set_count;
  uint32_t want_blocks; /* with an order; 1: batches have derivatives */
  /* [node_count][3][3] effective mass M of the update, kg, symmetric positive definite: an impulse J on a node changes
   * its new velocity by dv = M^-1 J. The update writes that of its nodes. Null: the neurons' own (mass). */
  const double* inertia;
  /* out, N: what rigid connections, surfaces, friction and bodies in contact add to the net force of each node at the
   * end of the step, so that m (U - v) / time_constant = (1 - theta) m a_start + theta (force + this); 0 for nodes
   * that are fixed or held. Null: not wanted. */
  springnet_vectors constraint_force;
  uint32_t contacts; /* 0: the sweep decides which nodes stick, slide and separate; 1: they stay as committed, for
                        methods that locate such events in time; in `constrain` also 2, 3 (see there) and
                        SPRINGNET_MAY_TOUCH, SPRINGNET_AS_BEFORE */
  uint32_t reserved;
  /* With an order; 1: the update takes lists of nodes (springnet_node_batch::nodes), too, and the host may
   * choose any order that gives the same outputs as `order`. Of several nodes whose law fails it may name another one
   */
  uint32_t lists;
  uint32_t reserved_2;
  const springnet_internal* internal; /* null: the states committed, as they are; `next` without an order only */
} springnet_sweep;

/* Writes the positions (m) and velocities (m/s) of all nodes at a time (s) within a completed step. */
typedef struct springnet_dense_output {
  uint32_t struct_size;
  uint32_t reserved;
  double time;
  springnet_vectors position, velocity; /* out */
} springnet_dense_output;

/* A search for touches in a part of a step with dense output. */
typedef struct springnet_impact_search {
  uint32_t struct_size;
  uint32_t reserved;
  double step_from, step_until; /* s */
  double from, until;           /* s, the part */
  double depth;                 /* m: nodes no deeper behind a surface count as outside, because positions between the
                                   ends are not more accurate; event_values at the end shows those that stay behind it */
  springnet_status (*state_at)(void* user, const springnet_dense_output* output); /* if it fails, the search ends */
  void* user;
  double time; /* out, s: of the first touch; nan if there is none */
} springnet_impact_search;

#ifdef __cplusplus
}
#endif

#endif
