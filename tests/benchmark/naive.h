/* The plain way to compute a net: arrays of structs, a loop over its springs, one over its hinges, one over its nodes,
 * symplectic Euler. What a step costs here is the unit of the table of steps (steps_table.cpp): ratios to it are
 * comparable between machines. Linear springs, hinges and one filling; the laws that the table's nets have.
 * naive.c is compiled for the processor that it is compiled on. It is C, and knows nothing but this header: an inline
 * function of the C++ library that it emitted with wide instructions could replace that of the other sources. */
#ifndef SPRINGNET_BENCHMARK_NAIVE_H
#define SPRINGNET_BENCHMARK_NAIVE_H

#ifdef __cplusplus
extern "C" {
#endif

/* force: of springs and elements, N. inverse_mass: 1/kg; 0 for a node that does not move. */
struct NaiveNode {
  double position[3], velocity[3], force[3], inverse_mass;
};

/* tension = stiffness (length - rest_length), N/m, m; damping: N s/m. */
struct NaiveSpring {
  int first, second;
  double stiffness, damping, rest_length;
};

/* An edge node[0] node[1] and the tips of the triangles at it, as Invariant::dihedral has them; N m/rad, rad. */
struct NaiveHinge {
  int node[4];
  double stiffness, rest_angle;
};

struct NaiveTriangle {
  int node[3];
};

struct NaiveNet {
  struct NaiveNode* nodes;
  const struct NaiveSpring* springs;
  const struct NaiveHinge* hinges;
  const struct NaiveTriangle* triangles; /* of the filling's surface */
  int node_count, spring_count, hinge_count, triangle_count;
  double filling_stiffness, rest_volume; /* Pa/m^3, m^3 */
  double gravity[3];                     /* m/s^2 */
  double drag;                           /* kg/s, of every node */
  int relative_damping; /* springs damp the whole relative velocity of their ends, not only that along the spring */
};

/* Adds the forces of springs, hinges and filling to those of the nodes. */
void naive_forces(struct NaiveNet* net);
/* A step of time_step, s. The nodes' forces must be 0 before, and are 0 after it. */
void naive_step(struct NaiveNet* net, double time_step);

#ifdef __cplusplus
}
#endif

#endif
