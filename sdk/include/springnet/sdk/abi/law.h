/* Plugin ABI: laws, that is spring functions and viscosity functions. See plugin.h. */
#ifndef SPRINGNET_SDK_ABI_LAW_H
#define SPRINGNET_SDK_ABI_LAW_H

#include <springnet/sdk/abi/basics.h>
#include <springnet/sdk/abi/parameter.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a law reads of its element's nodes: an invariant q and its rate. The nodes get the forces -Q dq/dp. A law on
 * SPRINGNET_LENGTH is a formula in q, its rate and a reference: hosts use it for springs and, if it declares
 * SPRINGNET_FITS_ELEMENTS, with the units of the invariant for all elements of more than two nodes. A law on another
 * invariant is used for elements of that kind only. */
enum {
  SPRINGNET_LENGTH = 1,          /* q = |p1 - p2|, rate n.(v1 - v2); reference: rest length */
  SPRINGNET_RELATIVE_SPEED = 2,  /* q = |v1 - v2|, no rate; the force acts along v1 - v2; springs only */
  SPRINGNET_ANGLE = 3,           /* rad: between two edges, 0 to pi, or of a hinge between two triangles, -pi to pi */
  SPRINGNET_AREA = 4,            /* m^2, of a triangle */
  SPRINGNET_VOLUME = 5,          /* m^3, of a tetrahedron (signed), or enclosed by a surface */
  SPRINGNET_ENCLOSED_VOLUME = 6, /* m^3, enclosed by a surface of triangles */
  SPRINGNET_SEVERAL = 7,         /* 2.1: up to SPRINGNET_MOST_INVARIANTS scalars, springnet_law::invariants */
  SPRINGNET_DIHEDRAL = 8         /* rad, -pi to pi: one of several */
};

/* Most scalars that one law reads. */
#define SPRINGNET_MOST_INVARIANTS 7u

/* The nodes of an element whose law reads several scalars of them. */
enum {
  SPRINGNET_CHAIN = 1,      /* three nodes a, b, c: springs a b and b c */
  SPRINGNET_TRIANGLE = 2,   /* three */
  SPRINGNET_HINGE = 3,      /* four: the edge a b, then the tips c and d of the triangles (a, b, c) and (b, a, d) */
  SPRINGNET_TETRAHEDRON = 4 /* four */
};

/* One of several scalars of an element's nodes. */
enum {
  /* The law reads its reference value alone: the host neither computes its value nor applies a force to it. */
  SPRINGNET_REFERENCE_ONLY = 1u << 0
};
typedef struct springnet_invariant {
  uint32_t struct_size;
  uint32_t kind;       /* SPRINGNET_LENGTH, _ANGLE (of three nodes), _AREA, _VOLUME (of a tetrahedron) or _DIHEDRAL */
  uint32_t corners[4]; /* which nodes of the element, in the order of that kind; what it has no use for is 0 */
  uint32_t flags;      /* SPRINGNET_REFERENCE_ONLY */
  uint32_t reserved;
} springnet_invariant;

/* One tile of elements. Input arrays have `count` values, or one if the stride is 0. Output arrays have `count` values,
 * or are null if not wanted. Arrays do not overlap. The outputs of an element depend on its own inputs only, so any
 * tile size gives the same bits. S: state_count, P: parameter_count. Lists of arrays are null if no array of them is
 * wanted; each array in a list may be null. */
typedef struct springnet_law_batch {
  uint32_t struct_size;
  uint32_t count;
  uint32_t instruction_set; /* SPRINGNET_GENERIC … */
  uint32_t reference_stride;
  double time;                       /* s */
  const double* q;                   /* invariant: m (length), m/s (relative speed), rad, m^2, m^3 */
  const double* rate;                /* dq/dt; null unless SPRINGNET_READS_RATE */
  const double* reference;           /* reference value of the invariant: rest length, m */
  const double* const* parameters;   /* [P] */
  const uint32_t* parameter_strides; /* [P], 0 or 1 */
  const double* const* states;       /* [S] internal state z; in an update, at the start of the step */
  const double* const* inputs;       /* [input_count] input signals */
  const uint32_t* input_strides;     /* [input_count], 0 or 1 */
  const void* table;                 /* of springnet_law::prepare, or null */
  /* In an update all outputs are those at its end, and derivatives are total: with the states that follow. */
  double* force;                      /* Q, the generalised force: N; > 0 is tension; N m, N/m, Pa for 3 to 6 */
  double* energy;                     /* E, J */
  double* margin;                     /* rupture margin, dimensionless, 1 when unloaded; <= 0 breaks */
  double* force_by_q;                 /* dQ/dq */
  double* force_by_rate;              /* dQ/dq' */
  double* const* force_by_states;     /* [S] dQ/dz */
  double* const* force_by_parameters; /* [P] */
  double* energy_by_q;                /* dE/dq; not in an update */
  double* const* energy_by_states;    /* [S] dE/dz; not in an update */
  /* Rates of the states, r = dz/dt; not in an update. */
  double* const* state_rates;         /* [S] */
  double* const* rates_by_q;          /* [S] */
  double* const* rates_by_rate;       /* [S] */
  double* const* rates_by_states;     /* [S][S] dr_i/dz_j at i S + j */
  double* const* rates_by_parameters; /* [S][P] at i P + j */
  springnet_message* message;         /* filled on failure; may be null */
  /* 2.1. Of a law over N = springnet_law::invariant_count invariants, in place of q, rate, reference, force and their
   * derivatives, which are then null; arrays of `count` values each. Those of a reference-only invariant are null, but
   * for its reference. */
  const double* const* values;     /* [N] q_i */
  const double* const* rates;      /* [N] dq_i/dt; null unless SPRINGNET_READS_RATE */
  const double* const* references; /* [N] */
  /* [3] of a law that reads a direction: its components at rest in the edges from the element's first node to the
   * others, a = sum_k direction_k (p_k+1 - p_0), |a| = 1; of three nodes the first two. */
  const double* const* direction;
  double* const* forces; /* [N] Q_i, generalised forces: nodes get -sum_i Q_i dq_i/dp */
  /* Any first derivatives, of laws over one invariant (N = 1) or several: [rows][columns], row by row. Rows: the N
   * forces, the energy, the margin, the S rates of the states (in an update: the states at its end). Columns: the N
   * values, their N rates, the N references, P parameters, S states, I inputs, the time, the 3 components of the
   * direction; in an update then the N values, N rates and I inputs at its start. An energy or margin that the law does
   * not have must be null; what does not depend on a column gets zeros. */
  double* const* derivatives;
} springnet_law_batch;

/* A step of the internal state: from `batch->states`, those of the start, to Z at batch->time, where q and rate are
 * those of the batch. */
typedef struct springnet_law_update {
  uint32_t struct_size;
  uint32_t order; /* 1, or 2: wanted if the law has it (springnet_law::update_order) */
  const springnet_law_batch* batch;
  double time_step;                  /* s */
  const double* start_q;             /* invariant at the start */
  const double* start_rate;          /* null unless SPRINGNET_READS_RATE */
  const double* const* start_inputs; /* [input_count] input signals at the start, with the batch's strides */
  double* const* next;               /* [S] Z; null: not wanted */
  double* const* next_by_q;          /* [S] dZ/dq */
  double* const* next_by_rate;       /* [S] dZ/dq' */
  double* const* next_by_states;     /* [S][S] dZ_i/dz_j at i S + j */
  double* const* next_by_parameters; /* [S][P] at i P + j */
  /* 2.1. Of a law over several invariants, in place of start_q, start_rate and the derivatives above. */
  const double* const* start_values; /* [N] */
  const double* const* start_rates;  /* [N]; null unless SPRINGNET_READS_RATE */
} springnet_law_update;

/* The internal state at the start of a run, of elements as they are then. */
typedef struct springnet_law_start {
  uint32_t struct_size;
  uint32_t reserved;
  const springnet_law_batch* batch; /* its states are those declared; no outputs */
  double* const* states;            /* out: [S] */
} springnet_law_start;

/* What a law makes of its tables, once for each material. */
typedef struct springnet_preparation {
  uint32_t struct_size;
  uint32_t table_count;
  const double* const* tables; /* [table_count] in the order of springnet_law::tables; null: the scene has none */
  const uint64_t* lengths;     /* [table_count] */
  const double* parameters;    /* [P] of the material */
  void* prepared;              /* out: springnet_law_batch::table from now on */
  springnet_message* message;
} springnet_preparation;

/* An array of numbers that a law asks of a scene. */
enum {
  SPRINGNET_INCREASING = 1u << 0, /* each value is greater than the one before */
  SPRINGNET_OPTIONAL = 1u << 1    /* a scene need not give it */
};
typedef struct springnet_table {
  uint32_t struct_size;
  uint32_t flags;      /* SPRINGNET_INCREASING … */
  const char* name;    /* key in a scene, snake_case */
  const char* unit;    /* SI, "1": dimensionless */
  const char* summary; /* one line */
  uint32_t least;      /* values */
  uint32_t as_long_as; /* index of the table that must have as many values, or its own */
  double smallest, largest;
} springnet_table;

typedef struct springnet_law {
  uint32_t struct_size;
  uint32_t invariant; /* SPRINGNET_LENGTH … */
  uint32_t state_count;
  uint32_t input_count;
  uint32_t table_count;
  uint32_t update_order; /* 1 or 2: the highest of `update` */
  uint32_t reads_start;  /* 1: steps of order 1 read the invariant at their start, too */
  uint32_t reserved;
  const springnet_parameter* const* states; /* name, unit, bounds, scale; default: value at the start */
  const springnet_parameter* const* inputs; /* default: while a scene gives no signal */
  const springnet_table* const* tables;
  /* Where the formulas hold: q / reference from smallest to largest. */
  double smallest_stretch, largest_stretch;
  void* context; /* first argument of every function below */
  springnet_status (*evaluate)(void* context, const springnet_law_batch* batch);
  /* Null if there are no states. */
  springnet_status (*update)(void* context, const springnet_law_update* update);
  /* Null: states start as declared. */
  springnet_status (*start)(void* context, const springnet_law_start* start);
  /* Makes immutable data of the tables; null if the law has none. */
  springnet_status (*prepare)(void* context, springnet_preparation* preparation);
  /* Frees what `prepare` made; its `prepared` alone is read. */
  springnet_status (*release)(void* context, springnet_preparation* preparation);
  /* 2.1. If `invariant` is SPRINGNET_SEVERAL; such a law has SPRINGNET_NEEDS_SEVERAL. */
  uint32_t shape;           /* SPRINGNET_CHAIN … */
  uint32_t invariant_count; /* 1 to SPRINGNET_MOST_INVARIANTS */
  const springnet_invariant* const* invariants;
  uint32_t reads_direction; /* 1: elements need a direction of the material */
  uint32_t reserved_2;
} springnet_law;

#ifdef __cplusplus
}
#endif

#endif
