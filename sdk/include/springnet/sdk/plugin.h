/* springnet plugin ABI, version 1.
 *
 * Everything that crosses between the engine and a plugin is declared here, in C11 without dependencies: no C++ type,
 * no exception, no allocation that one side makes and the other frees. Authors in C++ normally include law.hpp,
 * neuron.hpp or integrator.hpp instead, which generate all of this.
 *
 * Rules that keep old plugins working with new hosts, and the other way round:
 *   - structs only grow at their end, within one ABI major version, and carry their own size first;
 *   - structs are reached through pointers, never stored by value in arrays;
 *   - a reader uses a field only when struct_size covers it (SPRINGNET_HAS_FIELD);
 *   - a host accepts a plugin whose structs are at least as large as the frozen *_SIZE_1_0 below.
 *
 * Quantities are SI throughout. Vector quantities are structures of arrays (x[], y[], z[]). Node numbers in this header
 * are the engine's own (renumbered for locality); springnet_network::user_number maps them to the user's.
 */
#ifndef SPRINGNET_SDK_PLUGIN_H
#define SPRINGNET_SDK_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SPRINGNET_MAGIC UINT64_C(0x54454e474e525053) /* "SPRNGNET" in little-endian memory */
#define SPRINGNET_ABI_MAJOR 1u
#define SPRINGNET_ABI_MINOR 6u

#if defined(_WIN32)
#define SPRINGNET_EXPORT __declspec(dllexport)
#else
#define SPRINGNET_EXPORT __attribute__((visibility("default")))
#endif

/* True if the struct behind `pointer`, as its author compiled it, contains `field`. */
#define SPRINGNET_HAS_FIELD(type, pointer, field) \
  ((pointer)->struct_size >= offsetof(type, field) + sizeof((pointer)->field))

/* The status of every function that can fail. A function that fails also fills the message that it was given. */
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

/* ---- metadata ------------------------------------------------------------------------------------------------- */

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
  double scale;               /* typical magnitude, for learning; > 0 */
  uint32_t flags;             /* SPRINGNET_LEARNABLE … */
  uint32_t choice_count;      /* SPRINGNET_CHOICE */
  const char* const* choices; /* names */
} springnet_parameter;

/* Component kinds. */
enum {
  SPRINGNET_SPRING_FUNCTION = 1,
  SPRINGNET_VISCOSITY_FUNCTION = 2,
  SPRINGNET_NEURON = 3,
  SPRINGNET_INTEGRATOR = 4
};

/* What a component provides beyond its force (or acceleration). */
enum {
  SPRINGNET_HAS_ENERGY = 1u << 0,
  SPRINGNET_HAS_DERIVATIVES = 1u << 1,           /* with respect to q and its rate; F, p, v for a neuron */
  SPRINGNET_HAS_PARAMETER_DERIVATIVES = 1u << 2, /* with respect to each parameter */
  SPRINGNET_HAS_RUPTURE = 1u << 3,               /* writes a margin; the element is removed once it is <= 0 */
  SPRINGNET_ACTS_IN_COMPRESSION = 1u << 4,       /* pushes as well as pulls */
  SPRINGNET_READS_RATE = 1u << 5,                /* else the host does not compute the rate */
  SPRINGNET_HAS_STATE_DERIVATIVES = 1u << 6
};

/* What a law reads of its element's nodes: an invariant q and its rate. The nodes get the forces -Q dq/dp. A law on
 * SPRINGNET_LENGTH is a formula in q, its rate and a reference: hosts use it for springs and, with the units of the
 * invariant, for all elements of more than two nodes. A law on another invariant is used for elements of that kind
 * only. Hosts of ABI 1.1 evaluate 3 to 6; those of 1.0 refuse them. */
enum {
  SPRINGNET_LENGTH = 1,         /* q = |p1 - p2|, rate n.(v1 - v2); reference: rest length */
  SPRINGNET_RELATIVE_SPEED = 2, /* q = |v1 - v2|, no rate; the force acts along v1 - v2; springs only */
  SPRINGNET_ANGLE = 3,          /* rad: between two edges, 0 to pi, or of a hinge between two triangles, -pi to pi */
  SPRINGNET_AREA = 4,           /* m^2, of a triangle */
  SPRINGNET_VOLUME = 5,         /* m^3, of a tetrahedron (signed), or enclosed by a surface */
  SPRINGNET_ENCLOSED_VOLUME = 6 /* m^3, enclosed by a surface of triangles */
};

typedef struct springnet_component {
  uint32_t struct_size;
  uint32_t kind;         /* SPRINGNET_SPRING_FUNCTION … */
  const char* id;        /* the name in a scene; unique within a kind */
  const char* summary;   /* one line */
  const char* reference; /* literature, or "" */
  uint32_t capabilities; /* SPRINGNET_HAS_ENERGY … */
  uint32_t parameter_count;
  const springnet_parameter* const* parameters;
  const void* implementation; /* springnet_law, springnet_neuron_model or springnet_integrator, by kind */
} springnet_component;

typedef struct springnet_plugin {
  uint64_t magic; /* SPRINGNET_MAGIC */
  uint32_t struct_size;
  uint32_t abi_major;
  uint32_t abi_minor;
  uint32_t component_count;
  const char* id; /* e.g. "org.example.my_laws" */
  const char* version;
  const char* author;
  const char* licence; /* SPDX expression */
  const springnet_component* const* components;
} springnet_plugin;

/* The only symbol that a plugin exports: data, so that a host can read it before it runs any code of the plugin. */
#define SPRINGNET_ENTRY_SYMBOL "springnet_plugin_entry"

/* ---- laws: spring functions and viscosity functions ------------------------------------------------------------- */

/* Instruction sets that kernels may be built for. All give the same bits (no contraction, no reassociation). */
enum { SPRINGNET_GENERIC = 0, SPRINGNET_AVX2 = 1, SPRINGNET_AVX512 = 2 };

/* One tile of elements. Input arrays have `count` values, or one if the stride is 0. Output arrays have `count` values,
 * or are null if not wanted. Arrays do not overlap. The outputs of an element depend on its own inputs only, so any
 * tile size gives the same bits. Called from any thread. */
typedef struct springnet_law_batch {
  uint32_t struct_size;
  uint32_t count;
  uint32_t instruction_set; /* SPRINGNET_GENERIC … */
  uint32_t reference_stride;
  double time;                        /* s */
  const double* q;                    /* invariant: m (length), m/s (relative speed), rad, m^2, m^3 */
  const double* rate;                 /* dq/dt; null unless SPRINGNET_READS_RATE */
  const double* reference;            /* reference value of the invariant: rest length, m */
  const double* const* parameters;    /* [parameter_count] */
  const uint32_t* parameter_strides;  /* [parameter_count], 0 or 1 */
  const double* const* states;        /* [state_count] internal state */
  const double* const* inputs;        /* [input_count] input signals */
  const uint32_t* input_strides;      /* [input_count], 0 or 1 */
  const void* table;                  /* result of springnet_law::prepare, or null */
  double* force;                      /* Q, the generalised force: N; > 0 is tension; N m, N/m, Pa for 3 to 6 */
  double* energy;                     /* J */
  double* force_by_q;                 /* dQ/dq */
  double* force_by_rate;              /* dQ/dq' */
  double* const* force_by_parameters; /* [parameter_count] or null; each may be null */
  double* margin;                     /* rupture margin, dimensionless, 1 when unloaded; <= 0 breaks */
  double* const* state_rates;         /* [state_count] dz/dt */
  double* const* force_by_states;     /* [state_count] dQ/dz */
  springnet_message* message;         /* filled on failure; may be null */
} springnet_law_batch;

/* Source of a law's table data in a scene: named arrays of numbers. */
typedef struct springnet_table_source {
  uint32_t struct_size;
  uint32_t reserved;
  void* context;
  /* Values under `name`, *count of them; null if the scene has none. */
  const double* (*array)(void* context, const char* name, uint64_t* count);
} springnet_table_source;

typedef struct springnet_law {
  uint32_t struct_size;
  uint32_t invariant; /* SPRINGNET_LENGTH … */
  uint32_t state_count;
  uint32_t input_count;
  const springnet_parameter* const* states; /* name, unit, default = value at the start */
  const springnet_parameter* const* inputs;
  springnet_status (*evaluate)(const springnet_law_batch* batch);
  /* Makes immutable table data, once for each material; null if the law has none. */
  springnet_status (*prepare)(const springnet_table_source* source, void** table, springnet_message* message);
  void (*release)(void* table);
} springnet_law;

/* ---- neurons ---------------------------------------------------------------------------------------------------- */

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
} springnet_neuron_batch;

typedef struct springnet_neuron_model {
  uint32_t struct_size;
  uint32_t reserved;
  springnet_status (*evaluate)(const springnet_neuron_batch* batch);
} springnet_neuron_model;

/* ---- integrators ------------------------------------------------------------------------------------------------ */

/* The state of all nodes in the host's memory. Made by springnet_host::state_create. */
typedef struct springnet_state {
  uint32_t struct_size;
  uint32_t force_is_current;  /* 1: `force` belongs to this state; 0: the host evaluates it on demand */
  springnet_vectors position; /* [node_count] m */
  springnet_vectors velocity; /* [node_count] m/s */
  springnet_vectors force; /* [node_count] net force at this state, N: springs and loads, without constraint forces */
  double* internal;        /* [internal_count] internal state of laws */
  /* since 1.6, for commit; 1: position and velocity are as the last sweep without an order left them, so that the host
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

/* The network as an integrator sees it. `revision` increases with every change after which a multistep method must
 * restart: a cut, a rupture, a contact made or released, a load switched, a state set by the embedding program. */
typedef struct springnet_network {
  uint32_t struct_size;
  uint32_t node_count;
  uint64_t spring_count; /* live springs */
  uint64_t internal_count;
  uint64_t revision;
  uint32_t unit_count;    /* units of nodes for threads to work on; independent of the number of threads */
  uint32_t event_count;   /* changes only together with `revision` */
  uint32_t surface_count; /* planes and instruments */
  uint32_t reserved;
  /* Typical magnitudes of the network at its start, for tolerances; all above 0. */
  double length_scale;   /* m: mean rest length */
  double velocity_scale; /* m/s: greatest speed, or the one that the greatest acceleration reaches over length_scale */
  double force_scale;    /* N: greatest weight, load or net force of a node, or m v^2 / length_scale */
  const double* mass;    /* [node_count] kg */
  const uint8_t* fixed;  /* [node_count] 1: fixed, or moved over time by the scene */
  const uint8_t* held;   /* [node_count] 1: a surface holds it where it touched, and carries it */
  const uint32_t* user_number; /* [node_count] */
  /* For plugins of ABI 1.6 and later null until network_with_neighbours is called, and again after
   * `connection_revision` has changed: they cost as much as many time steps. */
  const uint32_t* neighbour_start; /* [node_count + 1] */
  const uint32_t* neighbours;      /* by a live spring, element or rigid connection; ascending user number, unique */
  /* since 1.1 */
  const uint8_t* touching; /* [node_count] 1: a surface holds it, or it slides on one */
  const uint32_t* cluster; /* [node_count] the same number for nodes that rigid connections join; 0xffffffff: none */
  uint64_t rigid_count;    /* rigid connections */
  /* since 1.2 */
  uint64_t load_revision; /* increases with every begin_step whose loads differ from those before: accelerations at the
                             end of the last step are then not those at the start of this one */
  /* since 1.3 */
  const uint8_t* status; /* [node_count] SPRINGNET_FREE …: for the outputs of the step's last sweep or constrain; as
                            committed before the first one and after commit. The address of the array does not change.
                            Within a sweep it may be read for the nodes of the batch; it holds the decisions of the
                            sweep before */
  /* since 1.5 */
  uint64_t connection_revision; /* increases with `revision` when neighbours change; from 1 on */
} springnet_network;

/* Evaluation of the layers at a state: springs, loads, neurons. Outputs that are not wanted are null (all three
 * components). Accelerations are those of the constrained motion: fixation, prescribed motion, rigid connections,
 * contact and friction are included. `force` is without any of these. */
typedef struct springnet_evaluation {
  uint32_t struct_size;
  uint32_t reserved;
  double time; /* s */
  springnet_const_vectors position;
  springnet_const_vectors velocity;
  const double* internal;
  springnet_vectors force;        /* out: net force N, without constraint forces */
  springnet_vectors acceleration; /* out: m/s^2 */
  double* internal_rate;          /* out */
  /* since 1.1, for evaluate_nodes only; null if not wanted. For each node by itself, without constraints. */
  double* acceleration_by_velocity; /* out: [node_count][3][3] 1/s, with respect to the node's own velocity */
  double* acceleration_by_position; /* out: [node_count][3][3] 1/s^2 */
  double* energy; /* out: [node_count] J, of the node's springs less the work of its loads; nan if there is no
                     potential: a law without energy, or one that reads the rate */
  /* since 1.5, for evaluate with `acceleration` only; null if not wanted */
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
  /* since 1.1: with springnet_sweep::want_blocks, else null; as in springnet_evaluation, [count][3][3] */
  const double* acceleration_by_velocity;
  const double* acceleration_by_position;
  /* since 1.5: null, or [count] the nodes, instead of first … first + count - 1. Some batches of a sweep with `lists`
   * have them */
  const uint32_t* nodes;
  /* since 1.6 */
  uint32_t instruction_set; /* SPRINGNET_GENERIC …, for kernels of the update */
  uint32_t reserved;
} springnet_node_batch;
typedef void (*springnet_node_update)(void* user, const springnet_node_batch* batch);

/* One sweep of the recurrent network: springs read (position, velocity); each node's update writes its new outputs;
 * the host then applies fixation, prescribed motion and contact to the outputs.
 * Without an order all springs are evaluated before any output is replaced: `next` must differ from (position,
 * velocity), and updates are called tile by tile, from several threads. With an order the nodes are updated one by one
 * in that order (see `lists`), on the calling thread, each reading the newest outputs: `next` must equal (position,
 * velocity). Nodes
 * of one cluster are updated together, in the place of the first of them. If `set_start` divides the order into sets,
 * the nodes of a set are in ascending order and updated by several threads. No two nodes of a set may be joined, unless
 * they belong to the same cluster. An enclosed volume counts as joining only those of its nodes that share a triangle.
 * All of its nodes depend on it, so the host updates them one after another, last in their set. */
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
  springnet_vectors force; /* out: net forces, N; null (since 1.6, without an order): not wanted */
  springnet_node_update update;
  void* user;
  /* since 1.1 */
  double time_constant;      /* s, length of the step; needed if the network has rigid connections or surfaces */
  double theta;              /* P = p + time_constant ((1 - theta) v + theta U); 0 stands for 1 */
  const uint32_t* set_start; /* null, or [set_count + 1] places in `order` */
  uint32_t set_count;
  uint32_t want_blocks; /* with an order; 1: batches have derivatives */
  /* [node_count][3][3] effective mass M of the update, kg, symmetric positive definite: an impulse J on a node changes
   * its new velocity by dv = M^-1 J. The update writes that of its nodes. Null: the neurons' own (mass). */
  const double* inertia;
  /* out, N: what rigid connections, surfaces and friction add to the net force of each node at the end of the step,
   * so that m (U - v) / time_constant = (1 - theta) m a_start + theta (force + this); 0 for nodes that are fixed or
   * held. Null: not wanted. */
  springnet_vectors constraint_force;
  /* since 1.3 */
  uint32_t contacts; /* 0: the sweep decides which nodes stick, slide and separate; 1: they stay as committed, for
                        methods that locate such events in time; 2 and 3: see constrain */
  uint32_t reserved;
  /* since 1.5, with an order; 1: the update takes lists of nodes (springnet_node_batch::nodes), too, and the host may
   * choose any order that gives the same outputs as `order`. Of several nodes whose law fails it may name another one
   */
  uint32_t lists;
  uint32_t reserved_2;
} springnet_sweep;

/* Writes the positions (m) and velocities (m/s) of all nodes at a time (s) within a completed step. */
typedef springnet_status (*springnet_dense_output)(void* user, double time, springnet_vectors position,
                                                   springnet_vectors velocity);

/* A search for touches in a part of a step with dense output. */
typedef struct springnet_impact_search {
  uint32_t struct_size;
  uint32_t reserved;
  double step_from, step_until; /* s */
  double from, until;           /* s, the part */
  double depth;                 /* m: nodes no deeper behind a surface count as outside, because positions between the
                                   ends are not more accurate; event_values at the end shows those that stay behind it */
  springnet_dense_output state_at; /* if it fails, the search ends with its status */
  void* user;
} springnet_impact_search;

/* Since 1.4. A linear map of vectors of a fixed length: replaces x by its image. */
typedef springnet_status (*springnet_linear_map)(void* user, double* x);

/* Which eigenvalue is wanted: that of the largest magnitude, or the rightmost one in the complex plane. */
enum { SPRINGNET_LARGEST_MAGNITUDE = 0, SPRINGNET_LARGEST_REAL_PART = 1 };

/* A search for the dominant eigenvalue of a map. A map that is symmetric in some inner product is best given in
 * coordinates in which that is the Euclidean one (velocities times roots of masses). */
typedef struct springnet_eigenvalue_search {
  uint32_t struct_size;
  uint32_t wanted; /* SPRINGNET_LARGEST_MAGNITUDE … */
  uint64_t size;   /* length of the vectors */
  springnet_linear_map map;
  void* user;
  double* start;              /* [size], not 0: where the search begins; out: a good start for a map nearly the same */
  double tolerance;           /* of the residual, relative to the eigenvalue; > 0 */
  uint64_t most_applications; /* of the map, about */
  uint32_t most_vectors;      /* of `size` numbers, kept at a time */
  uint32_t reserved;
  double *mode_real, *mode_imaginary; /* out: [size] the eigenvector, norm 1; null: not wanted */
  /* out */
  double real, imaginary; /* the eigenvalue; infinity where an image was not finite */
  double error;           /* norm of the residual, map(x) - eigenvalue x */
  uint64_t applications;  /* used */
} springnet_eigenvalue_search;

/* Since 1.5. A linear system of an implicit method: A = (1 + shift) I - velocity_weight da/dv - position_weight da/dp.
 */
typedef struct springnet_linear_system {
  uint32_t struct_size;
  /* 1: A exactly. 0: the host may leave out parts of it that are small and costly, such as what is not symmetric. */
  uint32_t exact;
  double velocity_weight;         /* s */
  double position_weight;         /* s^2 */
  double shift;                   /* 1, at least 0 */
  const springnet_evaluation* at; /* the state; null: that of the last `linearise`, and exactly */
} springnet_linear_system;

/* Since 1.5. How a linear system was solved. */
enum {
  SPRINGNET_SOLVED = 0,
  /* The iteration met a direction in which the matrix has negative curvature: x is the iterate before, 0 if there is
   * none. A greater shift makes the matrix definite. */
  SPRINGNET_TRUNCATED = 1,
  /* x is not as accurate as asked for; `residual` may be that of the preconditioned system, which a stiff filling does
   * not dominate as it does the residual */
  SPRINGNET_STALLED = 2
};

/* Since 1.5. Solves A x = right_side with the system prepared last. */
typedef struct springnet_linear_solve {
  uint32_t struct_size;
  uint32_t outcome;         /* answer: SPRINGNET_SOLVED ... */
  const double* right_side; /* [3 node_count], x of all nodes first; read as 0 for nodes that are fixed or held */
  double* x;                /* [3 node_count]; may be right_side */
  double accuracy;          /* of the residual, relative to the right-hand side, weighted with the masses */
  double residual;          /* answer: as accuracy */
  uint64_t iterations;      /* answer: of Krylov's method; 0 for a factorisation */
} springnet_linear_solve;

/* Matrices A = I - velocity_weight da/dv - position_weight da/dp in 3n unknowns (x of all nodes, then y, then z), at
 * the state last given to `linearise`. Rows of fixed and held nodes are those of the identity. With rigid connections
 * or sliding nodes, `solve` returns the x with A x + W G^T (multipliers) = b and G x = G b. */
typedef struct springnet_host {
  uint32_t struct_size;
  uint32_t abi_minor;
  void* context; /* first argument of every function below */

  const springnet_network* (*network)(void* context);
  springnet_state* (*state_create)(void* context); /* null: out of memory */
  void (*state_destroy)(void* context, springnet_state* state);
  const springnet_state* (*committed)(void* context, double* time);

  /* Loads are averaged over [from, until], so that their impulse is exact for any step. */
  springnet_status (*begin_step)(void* context, double from, double until);
  springnet_status (*evaluate)(void* context, const springnet_evaluation* evaluation);
  /* The same for some nodes, each by itself: accelerations are those of their neurons, without constraints. The arrays
   * still cover all nodes. */
  springnet_status (*evaluate_nodes)(void* context, const springnet_evaluation* evaluation, const uint32_t* nodes,
                                     uint32_t count);
  springnet_status (*sweep)(void* context, const springnet_sweep* sweep);

  /* Derivatives of the accelerations. */
  springnet_status (*linearise)(void* context, const springnet_evaluation* at);
  /* out = da/dp dp + da/dv dv, 3n numbers each. */
  springnet_status (*jacobian_times)(void* context, const double* dp, const double* dv, double* out);
  /* Diagonal 3x3 blocks of the matrix above, row-major, [node_count][9]. */
  springnet_status (*diagonal_blocks)(void* context, double velocity_weight, double position_weight, double* out);
  springnet_status (*factorise)(void* context, double velocity_weight, double position_weight);
  /* x may be right_side. */
  springnet_status (*solve)(void* context, int32_t transposed, const double* right_side, double* x);

  /* Events: contact made (a gap falls through 0), contact released (a normal force rises through 0), rupture (a margin
   * falls through 0). directions: -1 falling, +1 rising, 0 either, may be null; both arrays have network()->event_count
   * entries. */
  springnet_status (*event_values)(void* context, const springnet_evaluation* at, double* values, int32_t* directions);
  /* Carries out the events marked 1 in `fired`, and those that coincide with them, on the given state: projects
   * positions onto surfaces, changes velocities, removes springs. */
  springnet_status (*fire_events)(void* context, double time, springnet_state* state, const int32_t* fired);
  /* The next time after `time` at which a load switches or a cut is due; infinity if there is none. */
  double (*next_discontinuity)(void* context, double time);

  /* Makes `state` the committed state of the network at `time`: the two exchange their memory, and due ruptures and
   * cuts are carried out. Pointers into either are invalid afterwards. */
  springnet_status (*commit)(void* context, double time, springnet_state* state);

  /* Reports a number for the summary, by name; the last value counts. */
  void (*report)(void* context, const char* name, double value);
  /* The reason why the last host function failed; the integrator writes its own reason here. */
  springnet_message* (*message)(void* context);

  /* Since 1.1. */
  /* The end of a sweep by itself: constrains the outputs `next` by fixation, surfaces and rigid connections. `force` is
   * read: net forces at (position, velocity), N. No update is called.
   * Since 1.3 also contact in the two parts of a velocity Verlet step, by `contacts`. 2, the drift: `force` is that at
   * the start, next_velocity v + h/2 a and next_position p + h (v + h/2 a). Nodes in contact, and those rigidly
   * connected to them, are corrected; `status` then tells which nodes are in contact. 3, the kick, once after the
   * drift: `force` is that at next_position, next_velocity the velocity at the end, corrected likewise; contacts are
   * made and released. */
  springnet_status (*constrain)(void* context, const springnet_sweep* sweep);
  /* values -= W G^T (G W G^T)^-1 G values, 3n numbers; 0 for fixed and held nodes. G: derivatives of rigid connections
   * and of surfaces that nodes slide on, at the state last given to `linearise`. W: `mobility` [node_count][3][3] 1/kg,
   * or null: the neurons' own. Velocities so projected satisfy the constraints. */
  springnet_status (*project)(void* context, const double* mobility, double* values);
  /* Projects positions and velocities at `time`, weighted with the masses, onto the constraints: fixation, prescribed
   * motion, rigid connections, surfaces that nodes touch. */
  springnet_status (*project_state)(void* context, double time, springnet_vectors position, springnet_vectors velocity);
  /* A note to the user, once: printed by the tool, kept in the summary. */
  void (*note)(void* context, const char* text);

  /* Since 1.2. */
  /* begin_step for methods that choose their own steps in [from, until]: loads are not averaged, every evaluation has
   * those of its time (at `until` the left limit). */
  springnet_status (*begin_interval)(void* context, double from, double until);

  /* Since 1.3. */
  /* Time, s, at which a node first touches a surface in the searched part of the step; nan if none does. Also finds
   * nodes that have left again by the end, for example through a thin obstacle, which event_values at the ends does not
   * show. The result does not depend on how a step is divided into searches. fire_events at that time, with nothing
   * marked, carries out the touch. */
  springnet_status (*time_of_impact)(void* context, const springnet_impact_search* search, double* time);

  /* Since 1.4. */
  /* `sweep` with an order, of the network linearised at the state last given to `linearise`. The outputs are small
   * changes: velocity u, and position w u with w = theta time_constant. A batch has a = da/dv u + da/dp w u, force m a
   * and, with want_blocks, the node's own blocks of these derivatives. Fixed and held nodes get u = 0; the updates of
   * the others are projected onto rigid connections and surfaces that they slide on, weighted with `inertia`; the host
   * sets positions to w u. The start of the step, forces and time are neither read nor written; sets are updated one
   * after another. Used to find the limits of methods with sweeps. */
  springnet_status (*linear_sweep)(void* context, const springnet_sweep* sweep);
  /* The dominant eigenvalue of a map, by Arnoldi's method with restarts. */
  springnet_status (*dominant_eigenvalue)(void* context, springnet_eigenvalue_search* search);

  /* Since 1.5. */
  /* Assembles a linear system and its preconditioner. It is kept, whatever is linearised later, until the next call or
   * until nodes become fixed, held or free, springs or elements are removed (`revision`), or rigid connections and
   * surfaces that nodes slide on have turned. */
  springnet_status (*prepare_system)(void* context, const springnet_linear_system* system);
  /* Solves it among the changes that rigid connections and surfaces allow; their forces F add F / mass to
   * accelerations, independent of the neurons. SPRINGNET_RECOVERABLE if the matrix is singular. May replace the
   * derivatives of `linearise` and the factors of `factorise`: do not use both kinds of systems at a time. */
  springnet_status (*solve_system)(void* context, springnet_linear_solve* solve);
  /* Wall time left until the present `advance` should end, s: infinity if it has no deadline, below 0 after it. Then a
   * method commits the best it has, with the outcome SPRINGNET_OUT_OF_TIME. solve_system ends soon after the deadline,
   * with SPRINGNET_STALLED and an x on the way. */
  double (*time_left)(void* context);

  /* Since 1.6. */
  /* As `network`, with the lists of neighbours. Not within a sweep. Null: out of memory. */
  const springnet_network* (*network_with_neighbours)(void* context);
} springnet_host;

/* How a time step ended. */
enum {
  SPRINGNET_SETTLED = 0,
  SPRINGNET_OSCILLATING = 1,
  SPRINGNET_OUT_OF_SWEEPS = 2,
  SPRINGNET_DIVERGING = 3,
  SPRINGNET_OUT_OF_TIME = 4 /* since 1.5: committed at the deadline, not settled */
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
  /* since 1.1 */
  uint64_t substeps; /* smaller time steps made in place of steps that did not settle */
  uint64_t stages;   /* smaller time constants passed on the way to the full one */
  /* since 1.5 */
  double position_error; /* m, estimated greatest distance of a node from the settled step; nan: not estimated */
} springnet_step_report;

/* Since 1.4. Whether there is a largest time step. */
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
  void (*tell)(void* context, const springnet_limit* limit);
} springnet_limits;

typedef struct springnet_integrator {
  uint32_t struct_size;
  uint32_t reserved;
  /* `options` are in the order of the component's parameters. */
  springnet_status (*create)(const springnet_host* host, const double* options, void** integrator);
  void (*destroy)(void* integrator);
  /* Advances from the committed state to a committed state at time `until`: in one time step, or by internal steps if
   * the method chooses its own. On SPRINGNET_UNSETTLED the report says how the step ended, and the step is not
   * committed; a method that divides steps may have committed the smaller ones before. */
  springnet_status (*advance)(void* integrator, double until, springnet_step_report* report);
  /* since 1.4; null where the integrator knows of none */
  /* Reports the largest time steps at the committed state, for the options given to create. All host functions may be
   * called but commit and fire_events; loads are those of the committed time. */
  springnet_status (*limits)(void* integrator, const springnet_limits* limits);
  /* since 1.5; null where the integrator keeps nothing */
  /* Drops all that is kept from one call of `advance` to the next (derivatives, steps taken, estimates), so that the
   * next one gives the same bits as that of an integrator created now. */
  springnet_status (*forget)(void* integrator);
} springnet_integrator;

/* Smallest sizes that a host of ABI 1.x accepts: frozen, whatever is appended later. */
#define SPRINGNET_SIZE_TO(type, last) (offsetof(type, last) + sizeof(((type*)0)->last))
#define SPRINGNET_PLUGIN_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_plugin, components)
#define SPRINGNET_COMPONENT_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_component, implementation)
#define SPRINGNET_PARAMETER_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_parameter, choices)
#define SPRINGNET_LAW_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_law, release)
#define SPRINGNET_NEURON_MODEL_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_neuron_model, evaluate)
#define SPRINGNET_INTEGRATOR_SIZE_1_0 SPRINGNET_SIZE_TO(springnet_integrator, advance)

#ifdef __cplusplus
}
#endif

#endif
