#include "naive.h"

#include <math.h>

/* A law between two nodes; `relative` is known where this is inlined. */
static inline void add_spring(struct NaiveNode* nodes, const struct NaiveSpring* spring, int relative) {
  struct NaiveNode *const a = &nodes[spring->first], *const b = &nodes[spring->second];
  double x = a->position[0] - b->position[0], y = a->position[1] - b->position[1], z = a->position[2] - b->position[2];
  const double u = a->velocity[0] - b->velocity[0], v = a->velocity[1] - b->velocity[1],
               w = a->velocity[2] - b->velocity[2];
  const double length = sqrt(x * x + y * y + z * z), inverse = 1.0 / length;
  x *= inverse;
  y *= inverse;
  z *= inverse;
  double tension = spring->stiffness * (length - spring->rest_length);
  if (!relative) tension += spring->damping * (x * u + y * v + z * w);
  double fx = tension * x, fy = tension * y, fz = tension * z;
  if (relative) {
    fx += spring->damping * u;
    fy += spring->damping * v;
    fz += spring->damping * w;
  }
  a->force[0] -= fx;
  a->force[1] -= fy;
  a->force[2] -= fz;
  b->force[0] += fx;
  b->force[1] += fy;
  b->force[2] += fz;
}

static void add_springs(struct NaiveNet* net) {
  struct NaiveNode* const nodes = net->nodes;
  if (net->relative_damping) {
    for (int s = 0; s < net->spring_count; ++s) add_spring(nodes, &net->springs[s], 1);
  } else {
    for (int s = 0; s < net->spring_count; ++s) add_spring(nodes, &net->springs[s], 0);
  }
}

static inline void subtract(const double* a, const double* b, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = a[i] - b[i];
}

static inline void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* With the edge e and the normals m, n of its triangles: the moment Q turns the tips, by forces along the normals, and
 * the ends of the edge bear them by the lever rule at the tips' feet on it. */
static void add_hinges(struct NaiveNet* net) {
  struct NaiveNode* const nodes = net->nodes;
  for (int h = 0; h < net->hinge_count; ++h) {
    const struct NaiveHinge* const hinge = &net->hinges[h];
    struct NaiveNode *const a = &nodes[hinge->node[0]], *const b = &nodes[hinge->node[1]];
    struct NaiveNode *const c = &nodes[hinge->node[2]], *const d = &nodes[hinge->node[3]];
    double edge[3], to_c[3], to_d[3], m[3], n[3], turn[3];
    subtract(b->position, a->position, edge);
    subtract(c->position, a->position, to_c);
    subtract(d->position, a->position, to_d);
    cross(edge, to_c, m);
    cross(to_d, edge, n);
    cross(m, n, turn);
    const double square = dot(edge, edge), length = sqrt(square), inverse = 1.0 / square;
    const double angle = atan2(dot(turn, edge), length * dot(m, n));
    const double moment = hinge->stiffness * (angle - hinge->rest_angle) * length;
    const double at_c = moment / dot(m, m), at_d = moment / dot(n, n);
    const double foot_c = dot(to_c, edge) * inverse, foot_d = dot(to_d, edge) * inverse;
    for (int i = 0; i < 3; ++i) {
      const double of_c = at_c * m[i], of_d = at_d * n[i], of_b = foot_c * of_c + foot_d * of_d;
      c->force[i] += of_c;
      d->force[i] += of_d;
      b->force[i] -= of_b;
      a->force[i] += of_b - of_c - of_d;
    }
  }
}

/* The tetrahedra between the triangles and a node of the surface have the volume; a node's force is the pressure times
 * its derivative, for each triangle a third of its area vector. */
static void add_filling(struct NaiveNet* net) {
  if (net->triangle_count == 0) return;
  struct NaiveNode* const nodes = net->nodes;
  const double* const origin = nodes[net->triangles[0].node[0]].position;
  double volume = 0.0, a[3], b[3], c[3], normal[3];
  for (int t = 0; t < net->triangle_count; ++t) {
    const int* const node = net->triangles[t].node;
    subtract(nodes[node[0]].position, origin, a);
    subtract(nodes[node[1]].position, origin, b);
    subtract(nodes[node[2]].position, origin, c);
    cross(b, c, normal);
    volume += dot(a, normal) / 6.0;
  }
  const double pressure = -net->filling_stiffness * (volume - net->rest_volume);
  for (int t = 0; t < net->triangle_count; ++t) {
    const int* const node = net->triangles[t].node;
    subtract(nodes[node[1]].position, nodes[node[0]].position, b);
    subtract(nodes[node[2]].position, nodes[node[0]].position, c);
    cross(b, c, normal);
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) nodes[node[k]].force[i] += pressure / 6.0 * normal[i];
    }
  }
}

void naive_forces(struct NaiveNet* net) {
  add_springs(net);
  add_hinges(net);
  add_filling(net);
}

void naive_step(struct NaiveNet* net, double time_step) {
  naive_forces(net);
  for (int k = 0; k < net->node_count; ++k) {
    struct NaiveNode* const node = &net->nodes[k];
    for (int i = 0; i < 3; ++i) {
      if (node->inverse_mass > 0.0) {
        const double force = node->force[i] - net->drag * node->velocity[i];
        node->velocity[i] += time_step * (force * node->inverse_mass + net->gravity[i]);
        node->position[i] += time_step * node->velocity[i];
      }
      node->force[i] = 0.0;
    }
  }
}
