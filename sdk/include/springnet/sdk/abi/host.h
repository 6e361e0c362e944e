/* Plugin ABI: the functions of the host that an integrator calls. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_HOST_H
#define SPRINGNET_SDK_ABI_HOST_H

#include <springnet/sdk/abi/basics.h>
#include <springnet/sdk/abi/law.h>
#include <springnet/sdk/abi/network.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct springnet_network_query {
  uint32_t struct_size;
  uint32_t with_neighbours;         /* 1: with the lists of neighbours; not within a sweep */
  const springnet_network* network; /* out */
} springnet_network_query;

typedef struct springnet_state_creation {
  uint32_t struct_size;
  uint32_t reserved;
  springnet_state* state; /* out */
} springnet_state_creation;

typedef struct springnet_committed {
  uint32_t struct_size;
  uint32_t reserved;
  double time;                  /* out, s */
  const springnet_state* state; /* out */
} springnet_committed;

typedef struct springnet_interval {
  uint32_t struct_size;
  /* 0: a step; loads are averaged over it, so that their impulse is exact for any step. 1: for methods that choose
   * their own steps within; every evaluation has the loads of its time (at `until` the left limit). */
  uint32_t own_steps;
  double from, until; /* s */
} springnet_interval;

/* Where derivatives are taken. */
typedef struct springnet_linearisation {
  uint32_t struct_size;
  uint32_t reserved;
  const springnet_evaluation* at; /* its states; no outputs */
  /* s. Above 0, without a time step of the states: internal states follow positions and velocities by
   * dz = elimination (dr/dq dq + dr/dq' dq' + dr/dz dz), as in a step of an implicit method with that weight. 0: they
   * stay as they are. */
  double elimination;
} springnet_linearisation;

/* 2.1: kinds of products and projections. */
enum {
  SPRINGNET_TRANSPOSED = 1u << 0, /* by the transposed matrix; of projections only */
  /* Friction of nodes that slide follows their normal reaction, as in the motion itself: accelerations change by
   * W (G^T - B) (multipliers), where B has the friction that a unit normal reaction causes. Products with derivatives
   * then also have the changes of G, of the curvature terms and of the directions of friction with the state. Without
   * it normal reactions count as constant, as in the systems of implicit methods. */
  SPRINGNET_TRUE_FRICTION = 1u << 1
};

/* out = da/dp dp + da/dv dv, 3 node_count numbers each, x of all nodes, then y, then z. */
typedef struct springnet_jacobian_product {
  uint32_t struct_size;
  uint32_t kind; /* 2.1: 0, or SPRINGNET_TRUE_FRICTION */
  const double *dp, *dv;
  double* out;
} springnet_jacobian_product;

/* 2.1: by_position = (da/dp)^T weights, by_velocity = (da/dv)^T weights; arrays as above. */
typedef struct springnet_transposed_product {
  uint32_t struct_size;
  uint32_t kind; /* 0, or SPRINGNET_TRUE_FRICTION */
  const double* weights;
  double *by_position, *by_velocity; /* out; not `weights` */
} springnet_transposed_product;

/* The eliminated internal state, with r the right-hand side of its equations [internal_count]:
 * dz = (I - elimination dr/dz)^-1 (r + elimination (dr/dq dq + dr/dq' dq')). */
typedef struct springnet_internal_change {
  uint32_t struct_size;
  uint32_t reserved;
  const double* right_side; /* r */
  const double *dp, *dv;    /* 3 node_count numbers each; null: 0 */
  double* change;           /* out: dz; null: not wanted */
  double* acceleration;     /* out: da/dz dz, 3 node_count numbers; null: not wanted */
} springnet_internal_change;

/* Diagonal 3x3 blocks of the matrix, row-major, [node_count][9]. */
typedef struct springnet_diagonal_blocks {
  uint32_t struct_size;
  uint32_t reserved;
  double velocity_weight, position_weight;
  double* out;
} springnet_diagonal_blocks;

typedef struct springnet_factorisation {
  uint32_t struct_size;
  uint32_t reserved;
  double velocity_weight, position_weight;
} springnet_factorisation;

typedef struct springnet_solve {
  uint32_t struct_size;
  uint32_t transposed;
  const double* right_side;
  double* x; /* may be right_side */
} springnet_solve;

/* A linear system of an implicit method: A = (1 + shift) I - velocity_weight da/dv - position_weight da/dp. */
typedef struct springnet_linear_system {
  uint32_t struct_size;
  /* 1: A exactly. 0: the host may leave out parts of it that are small and costly, such as what is not symmetric. */
  uint32_t exact;
  double velocity_weight;         /* s */
  double position_weight;         /* s^2 */
  double shift;                   /* 1, at least 0 */
  const springnet_evaluation* at; /* the state; null: that of the last `linearise`, and exactly */
} springnet_linear_system;

/* How a linear system was solved. */
enum {
  SPRINGNET_SOLVED = 0,
  /* The iteration met a direction in which the matrix has negative curvature: x is the iterate before, 0 if there is
   * none. A greater shift makes the matrix definite. */
  SPRINGNET_TRUNCATED = 1,
  /* x is not as accurate as asked for; `residual` may be that of the preconditioned system, which a stiff filling does
   * not dominate as it does the residual */
  SPRINGNET_STALLED = 2
};

/* Solves A x = right_side with the system prepared last. */
typedef struct springnet_linear_solve {
  uint32_t struct_size;
  uint32_t outcome;         /* answer: SPRINGNET_SOLVED ... */
  const double* right_side; /* [3 node_count], x of all nodes first; read as 0 for nodes that are fixed or held */
  double* x;                /* [3 node_count]; may be right_side */
  double accuracy;          /* of the residual, relative to the right-hand side, weighted with the masses */
  double residual;          /* answer: as accuracy */
  uint64_t iterations;      /* answer: of Krylov's method; 0 for a factorisation */
} springnet_linear_solve;

/* A linear map of vectors of a fixed length: replaces x by its image. */
typedef struct springnet_linear_image {
  uint32_t struct_size;
  uint32_t reserved;
  double* x;
} springnet_linear_image;
typedef springnet_status (*springnet_linear_map)(void* user, const springnet_linear_image* image);

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

/* What an event is. */
enum {
  SPRINGNET_EVENT_TOUCH = 1,   /* a gap closes */
  SPRINGNET_EVENT_RELEASE = 2, /* a normal force ends */
  SPRINGNET_EVENT_SLIP = 3,    /* a sticking node reaches the limit of friction */
  SPRINGNET_EVENT_REST = 4,    /* a slip ends */
  SPRINGNET_EVENT_SLIP_CHANGE =
      5,                    /* a slip becomes so slow that friction keeps its direction, quick again, or stalls */
  SPRINGNET_EVENT_SEAM = 6, /* a sliding node crosses a line where the curvature of its surface jumps */
  SPRINGNET_EVENT_SPRING_RUPTURE = 7, /* a margin falls through 0 */
  SPRINGNET_EVENT_ELEMENT_RUPTURE = 8
};

/* Events: contact made (a gap falls through 0), contact released (a normal force rises through 0), rupture (a margin
 * falls through 0). Both arrays have springnet_network::event_count entries. */
typedef struct springnet_event_values {
  uint32_t struct_size;
  uint32_t reserved;
  const springnet_evaluation* at;
  double* values;
  int32_t* directions; /* -1 falling, +1 rising, 0 either; may be null */
  /* From ABI 2.1 on; [event_count], each null where it is not wanted. They change only together with `revision`. */
  uint32_t* kinds;    /* SPRINGNET_EVENT_TOUCH ... */
  uint32_t* who;      /* a node, engine's number; for ruptures the number of the spring or element, as in the scene */
  uint32_t* surfaces; /* that the node touches, as in the scene: planes, then instruments; 0xffffffff: none, as of a
                         pair of bodies that touch, whose first node is in `who` */
} springnet_event_values;

/* Carries out the events marked 1 in `fired`, and those that coincide with them, on the given state: projects positions
 * onto surfaces, changes velocities, removes springs. */
typedef struct springnet_event_firing {
  uint32_t struct_size;
  uint32_t reserved;
  double time; /* s */
  springnet_state* state;
  const int32_t* fired;
} springnet_event_firing;

typedef struct springnet_discontinuity {
  uint32_t struct_size;
  uint32_t reserved;
  double after; /* s */
  double time;  /* out, s: the next at which a load or an input switches or a cut is due; infinity if there is none */
} springnet_discontinuity;

/* Makes `state` the committed state of the network at `time`: the two exchange their memory, and due ruptures and cuts
 * are carried out. Pointers into either are invalid afterwards. */
typedef struct springnet_commitment {
  uint32_t struct_size;
  uint32_t reserved;
  double time; /* s */
  springnet_state* state;
} springnet_commitment;

/* A number for the summary, by name. The host keeps it, in saved states too: count there, not in the integrator, whose
 * memory a run that is resumed begins anew. */
typedef struct springnet_number_report {
  uint32_t struct_size;
  uint32_t adds; /* from ABI 2.1 on; 1: adds `value` to the number; 0: the last value counts */
  const char* name;
  double value;
} springnet_number_report;

/* A note to the user: printed by the tool, kept in the summary. The same text is noted once. */
typedef struct springnet_user_note {
  uint32_t struct_size;
  uint32_t reserved;
  const char* text;
  const char* topic; /* from ABI 2.1 on; of all notes on a topic the first one is kept; null: none */
} springnet_user_note;

/* values -= W G^T (G W G^T)^-1 G values, 3n numbers; 0 for fixed and held nodes. G: derivatives of rigid connections
 * and of surfaces that nodes slide on, at the state last given to `linearise`. W: `mobility`. Velocities so projected
 * satisfy the constraints. With SPRINGNET_TRUE_FRICTION: at the state last given to `linearise` or `prepare_system`. */
typedef struct springnet_projection {
  uint32_t struct_size;
  uint32_t kind;          /* 2.1: SPRINGNET_TRANSPOSED | SPRINGNET_TRUE_FRICTION; 0: as described above */
  const double* mobility; /* [node_count][3][3] 1/kg; null: the neurons' own */
  double* values;
} springnet_projection;

/* Projects positions and velocities at `time`, weighted with the masses, onto the constraints: fixation, prescribed
 * motion, rigid connections, surfaces that nodes touch. */
typedef struct springnet_state_projection {
  uint32_t struct_size;
  uint32_t reserved;
  double time; /* s */
  springnet_vectors position, velocity;
} springnet_state_projection;

/* 2.1: what forces and accelerations are differentiated by. */
enum {
  SPRINGNET_BY_REFERENCE = 1,           /* reference values: rest lengths (m), or as the invariant */
  SPRINGNET_BY_SPRING_PARAMETER = 2,    /* a parameter of spring functions */
  SPRINGNET_BY_VISCOSITY_PARAMETER = 3, /* of viscosity functions */
  SPRINGNET_BY_MASS = 4,                /* kg: neurons read it, and weights depend on it */
  SPRINGNET_BY_NEURON_PARAMETER = 5,    /* a parameter of neurons */
  SPRINGNET_BY_INPUT = 6,               /* the value of one of the network's input signals, now */
  SPRINGNET_BY_TIME = 7                 /* s: that laws and neurons read; signals and loads stay as they are */
};

/* Scalars of one kind, one for each of these: springs, elements (by their numbers in the network, removed ones
 * included), nodes (the engine's numbers), or a single one for an input signal and the time. The reference value of an
 * element whose laws read several scalars is its growth at rest, 1: lengths are multiplied by it, areas by its square,
 * volumes by its cube. */
typedef struct springnet_parameter_set {
  uint32_t struct_size;
  uint32_t kind;         /* SPRINGNET_BY_REFERENCE … */
  uint32_t of_elements;  /* 1: of elements in place of springs */
  uint32_t input;        /* number of the signal: in the order in which the network has them */
  const char* component; /* id of the law or neuron; null: of all that have a parameter of this name */
  const char* parameter; /* its name */
  /* A tangent reads the direction, a cotangent adds its answers; what has no such parameter, or was removed, is left
   * alone. */
  double* values;
} springnet_parameter_set;

/* Derivatives of net forces F, accelerations a and internal states by parameters, at a state that is held. Internal
 * states are held, too, and what is differentiated is their rates; or, with a time step (springnet_internal), it is the
 * states at its end, which forces follow: then all derivatives are total ones of the step. Arrays `force` and
 * `acceleration` have 3 node_count numbers, x of all nodes, then y, then z, `internal` has internal_count; null: not
 * wanted, or no weights.
 * Tangent: force = sum_sets dF/d(values) values, the others likewise. Cotangent: values += (dF/d(values))^T force +
 * (da/d(values))^T acceleration + … . Accelerations are those of the constrained motion. */
typedef struct springnet_parameter_product {
  uint32_t struct_size;
  uint32_t set_count;
  const springnet_evaluation* at; /* the state; no outputs */
  const springnet_parameter_set* const* sets;
  double *force, *acceleration, *internal; /* tangent: out; cotangent: read */
} springnet_parameter_product;

/* 2.1: derivatives of one event function at a state, of those that depend on no force: gaps of touches, and margins of
 * ruptures with internal states as for springnet_parameter_product. SPRINGNET_FAILED for others. */
typedef struct springnet_event_derivative {
  uint32_t struct_size;
  uint32_t event; /* its number in event_values */
  const springnet_evaluation* at;
  double *by_position, *by_velocity;          /* out: [3 node_count], x of all nodes first; null: not wanted */
  const springnet_parameter_set* const* sets; /* values += d(value)/d(values) */
  uint32_t set_count;
  uint32_t reserved;
  double by_time; /* out: 1/s times the unit of the value, as obstacles move and laws read the time */
} springnet_event_derivative;

typedef struct springnet_deadline {
  uint32_t struct_size;
  uint32_t reserved;
  double time_left; /* out, s: infinity without a deadline */
} springnet_deadline;

/* Parts of the net forces. */
#define SPRINGNET_PART_SPRINGS 1u             /* spring functions of springs */
#define SPRINGNET_PART_VISCOSITIES 2u         /* viscosity functions of springs */
#define SPRINGNET_PART_ELEMENTS 4u            /* spring functions of elements */
#define SPRINGNET_PART_ELEMENT_VISCOSITIES 8u /* viscosity functions of elements */
#define SPRINGNET_PART_GRAVITY 16u
#define SPRINGNET_PART_LOADS 32u /* forces, tractions and pressures */

/* Forces of some parts on all nodes. All six add up to the net force of `evaluate`, to rounding. */
typedef struct springnet_part_forces {
  uint32_t struct_size;
  uint32_t parts;                 /* SPRINGNET_PART_SPRINGS | ... */
  const springnet_evaluation* at; /* its state; no outputs */
  springnet_vectors force;        /* out: [node_count] N */
} springnet_part_forces;

/* Springs, or elements, one by one: with q the value of its invariant (length, angle, area, volume) member i exerts
 * -Q dq/dp on each of its nodes, Q = Q_spring + Q_viscosity. Numbers are those of the scene, removed ones included,
 * which have no nodes and zeros. Elements whose laws read several scalars have the value, rate and gradients of their
 * angle, area or volume, and nan for Q and its derivatives: see springnet_scalar_view. Arrays are null where they are
 * not wanted. */
typedef struct springnet_element_view {
  uint32_t struct_size;
  uint32_t of_elements;           /* 0: springs; 1: elements */
  uint64_t first, count;          /* members first ... first + count - 1 */
  const springnet_evaluation* at; /* its state; no outputs */
  uint64_t node_capacity;         /* of `nodes` and `gradients` */
  uint64_t node_total;            /* out: of all members; `nodes` and `gradients` need that much room */
  uint64_t* node_start;           /* out: [count + 1] places in `nodes` */
  uint32_t* nodes;                /* out: [node_total] engine's numbers */
  double* gradients;              /* out: [node_total][3] dq/dp */
  double *value, *rate;           /* out: [count] q and dq/dt; m, rad, m^2 or m^3, and per second */
  double* reference;              /* out: [count] rest length, or value at rest */
  double* force;                  /* out: [count][2] Q of the spring function, of the viscosity function; N, N m, ... */
  double* by_value;               /* out: [count][2] dQ/dq; needs laws with derivatives */
  double* by_rate;                /* out: [count][2] dQ/dq'; likewise */
  /* out: [count] 1: the viscosity function acts along the relative velocity of both ends. It is none of these numbers.
   */
  uint32_t* relative;
} springnet_element_view;

/* One element whose laws read several scalars q_i of its nodes: it exerts -sum_i Q_i dq_i/dp on each node,
 * Q_i = Q_i spring + Q_i viscosity. The scalars are those of the spring function, then those of the viscosity function
 * that the former does not read. One that is read at rest alone has a value, a rate, gradients and forces of 0. */
typedef struct springnet_scalar_view {
  uint32_t struct_size;
  uint32_t element;                         /* its number in the scene; SPRINGNET_FAILED for one with a single scalar */
  const springnet_evaluation* at;           /* its state; no outputs */
  uint32_t node_count, scalar_count;        /* out; 0: the element was removed */
  uint32_t nodes[4];                        /* out: engine's numbers */
  uint32_t kind[SPRINGNET_MOST_INVARIANTS]; /* out: as springnet_invariant::kind */
  uint32_t corners[SPRINGNET_MOST_INVARIANTS][4];     /* out: which of `nodes`, in the order of the kind */
  uint32_t reference_only[SPRINGNET_MOST_INVARIANTS]; /* out: 1: both laws read it at rest alone */
  double value[SPRINGNET_MOST_INVARIANTS];            /* out: q_i; m, rad, m^2 or m^3 */
  double rate[SPRINGNET_MOST_INVARIANTS];
  double reference[SPRINGNET_MOST_INVARIANTS];      /* out: at rest */
  double gradient[SPRINGNET_MOST_INVARIANTS][4][3]; /* out: dq_i/dp of each node */
  double force[2][SPRINGNET_MOST_INVARIANTS];       /* out: Q_i of the spring function, of the viscosity function */
  double by_value[2][SPRINGNET_MOST_INVARIANTS][SPRINGNET_MOST_INVARIANTS]; /* out: dQ_i/dq_j */
  double by_rate[2][SPRINGNET_MOST_INVARIANTS][SPRINGNET_MOST_INVARIANTS];  /* out: dQ_i/dq_j' */
} springnet_scalar_view;

/* Energy and momentum at a state. */
typedef struct springnet_balance {
  uint32_t struct_size;
  uint32_t reserved;
  const springnet_evaluation* at; /* its state; no outputs */
  double potential;               /* out, J: of laws that have an energy, and of gravity; nan if one fails */
  double kinetic;                 /* out, J */
  double momentum[3];             /* out, kg m/s */
  double angular_momentum[3];     /* out, kg m^2/s, about the origin */
} springnet_balance;

/* A loop in the host's threads: body(user, begin, end) for parts of 0 ... count - 1, each in one call, in any order.
 * The parts do not depend on the number of threads, so neither do results that each part computes by itself. Host
 * functions must not be called from a body, but those that may be within a sweep's update. */
typedef struct springnet_loop {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t count;
  uint64_t part;                                                      /* things in a part; 0: 1024 */
  springnet_status (*body)(void* user, uint64_t begin, uint64_t end); /* if some fail: the status of the first part */
  void* user;
} springnet_loop;

/* The system prepared last, row by row: S = M A, with M the masses (kg), is
 *   S = blocks + sum over i of g_i w_i^T,
 * the latter of enclosed volumes and of friction between bodies. Rows and columns of fixed and held nodes are zero but
 * for their own block. Constraints are not in it. The arrays live until the next call that prepares, linearises or
 * changes the network. */
typedef struct springnet_system_rows {
  uint32_t struct_size;
  uint32_t low_rank_count;               /* out: number of rank-one terms */
  const uint32_t* row_start;             /* out: [node_count + 1] */
  const uint32_t* columns;               /* out: nodes; ascending in a row */
  const double* blocks;                  /* out: [row_start[node_count]][9], each block column by column, kg */
  const uint64_t* low_rank_start;        /* out: [low_rank_count + 1] */
  const uint32_t* low_rank_nodes;        /* out: nodes where g and w are not 0 */
  const double *low_rank_g, *low_rank_w; /* out: [place][3] */
} springnet_system_rows;

/* Whether the step should end early. */
enum { SPRINGNET_GO_ON = 0, SPRINGNET_STOP_DEADLINE = 1, SPRINGNET_STOP_ASKED = 2 };
typedef struct springnet_stop {
  uint32_t struct_size;
  uint32_t reason; /* out: SPRINGNET_GO_ON ... */
} springnet_stop;

/* Matrices A = I - velocity_weight da/dv - position_weight da/dp in 3n unknowns (x of all nodes, then y, then z), at
 * the state last given to `linearise`. Rows of fixed and held nodes are those of the identity. With rigid connections
 * or sliding nodes, `solve` returns the x with A x + W G^T (multipliers) = b and G x = G b. */
typedef struct springnet_host {
  uint32_t struct_size;
  uint32_t abi_minor;
  void* context;              /* first argument of every function below */
  springnet_message* message; /* the reason why the last function failed; an integrator writes its own reason here */

  springnet_status (*network)(void* context, springnet_network_query* query);
  springnet_status (*create_state)(void* context, springnet_state_creation* creation);
  springnet_status (*destroy_state)(void* context, springnet_state* state);
  springnet_status (*committed)(void* context, springnet_committed* committed);

  springnet_status (*begin)(void* context, const springnet_interval* interval);
  springnet_status (*evaluate)(void* context, const springnet_evaluation* evaluation);
  springnet_status (*sweep)(void* context, const springnet_sweep* sweep);

  /* Derivatives of the accelerations. */
  springnet_status (*linearise)(void* context, const springnet_linearisation* linearisation);
  springnet_status (*jacobian_times)(void* context, const springnet_jacobian_product* product);
  springnet_status (*change_internal)(void* context, const springnet_internal_change* change);
  springnet_status (*diagonal_blocks)(void* context, const springnet_diagonal_blocks* blocks);
  springnet_status (*factorise)(void* context, const springnet_factorisation* factorisation);
  springnet_status (*solve)(void* context, const springnet_solve* solve);
  /* Assembles a linear system and its preconditioner. It is kept, whatever is linearised later, until the next call or
   * until nodes become fixed, held or free, springs or elements are removed (`revision`), or rigid connections and
   * surfaces that nodes slide on have turned. */
  springnet_status (*prepare_system)(void* context, const springnet_linear_system* system);
  /* Solves it among the changes that rigid connections and surfaces allow; their forces F add F / mass to
   * accelerations, independent of the neurons. SPRINGNET_RECOVERABLE if the matrix is singular. May replace the
   * derivatives of `linearise` and the factors of `factorise`: do not use both kinds of systems at a time. */
  springnet_status (*solve_system)(void* context, springnet_linear_solve* solve);
  /* `sweep` with an order, of the network linearised at the state last given to `linearise`. The outputs are small
   * changes: velocity u, and position w u with w = theta time_constant. A batch has a = da/dv u + da/dp w u, force m a
   * and, with want_blocks, the node's own blocks of these derivatives. Fixed and held nodes get u = 0; the updates of
   * the others are projected onto rigid connections and surfaces that they slide on, weighted with `inertia`; the host
   * sets positions to w u. The start of the step, forces and time are neither read nor written; sets are updated one
   * after another. Used to find the limits of methods with sweeps. */
  springnet_status (*linear_sweep)(void* context, const springnet_sweep* sweep);
  /* The dominant eigenvalue of a map, by Arnoldi's method with restarts. */
  springnet_status (*dominant_eigenvalue)(void* context, springnet_eigenvalue_search* search);

  springnet_status (*event_values)(void* context, const springnet_event_values* values);
  springnet_status (*fire_events)(void* context, const springnet_event_firing* firing);
  springnet_status (*next_discontinuity)(void* context, springnet_discontinuity* discontinuity);
  /* When a node first touches a surface, or a body another one, in the searched part of the step. Also finds nodes that
   * have left again by the end, for example through a thin obstacle, which event_values at the ends does not show. The
   * result does not depend on how a step is divided into searches, except for bodies that come no deeper than `depth`.
   * fire_events at that time, with nothing marked, carries out the touch. */
  springnet_status (*time_of_impact)(void* context, springnet_impact_search* search);

  springnet_status (*commit)(void* context, const springnet_commitment* commitment);

  /* The end of a sweep by itself: constrains the outputs `next` by fixation, surfaces and rigid connections. `force` is
   * read: net forces at (position, velocity), N. No update is called. Where nodes decided their contacts in an earlier
   * call of the step, only those may change that a decision moves farthest, so that decisions of many nodes do not run
   * in a circle; `status` differs from that before as long as others want to change. Also contact in the two parts of a
   * velocity Verlet step, by `contacts`. 2, the drift: `force` is that at the start, next_velocity v + h/2 a and
   * next_position p + h (v + h/2 a). Nodes in contact, and those rigidly connected to them, are corrected; `status`
   * then tells which nodes are in contact. 3, the kick, once after the drift: `force` is that at next_position,
   * next_velocity the velocity at the end, corrected likewise; contacts are made and released. Both also
   * keep bodies apart from each other; call them where surface_count or body_contact_count is not 0. */
  springnet_status (*constrain)(void* context, const springnet_sweep* sweep);
  springnet_status (*project)(void* context, const springnet_projection* projection);
  springnet_status (*project_state)(void* context, const springnet_state_projection* projection);

  springnet_status (*report)(void* context, const springnet_number_report* report);
  springnet_status (*note)(void* context, const springnet_user_note* note);
  /* Wall time left until the present `advance` should end. Past it a method commits the best it has, with the outcome
   * SPRINGNET_OUT_OF_TIME. solve_system ends soon after the deadline, with SPRINGNET_STALLED and an x on the way. */
  springnet_status (*deadline)(void* context, springnet_deadline* deadline);

  /* 2.1 */
  /* jacobian_times by the transposed matrices. */
  springnet_status (*jacobian_transposed_times)(void* context, const springnet_transposed_product* product);
  /* Derivatives by parameters, times a direction, and weighted derivatives by them. Independent of `linearise`. They
   * need laws and neurons that give them: SPRINGNET_FAILED with a message that names one that does not. */
  springnet_status (*parameter_tangent)(void* context, const springnet_parameter_product* product);
  springnet_status (*parameter_cotangent)(void* context, const springnet_parameter_product* product);
  springnet_status (*event_derivative)(void* context, springnet_event_derivative* derivative);
  springnet_status (*part_forces)(void* context, const springnet_part_forces* forces);
  springnet_status (*view_elements)(void* context, springnet_element_view* view);
  springnet_status (*balance)(void* context, springnet_balance* balance);
  springnet_status (*parallel_for)(void* context, const springnet_loop* loop);
  springnet_status (*system_rows)(void* context, springnet_system_rows* rows);
  /* Why the present `advance` should end early: its deadline has passed, or the program asked for it. What `deadline`
   * says of a method then holds for both; `deadline` answers -1 s once the program has asked. */
  springnet_status (*stop)(void* context, springnet_stop* stop);
  springnet_status (*view_scalars)(void* context, springnet_scalar_view* view);
} springnet_host;

#ifdef __cplusplus
}
#endif

#endif
