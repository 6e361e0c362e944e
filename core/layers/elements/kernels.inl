// Included by layers/kernels.inl, in the namespace of an instruction set: plain loops only.

namespace {

// The rate is taken relative to the first corner, so that a common motion contributes exactly nothing.
template <Measure measure>
void geometry_of(const BatchCorners& corners, const NodeArrays& node_arrays, BatchGeometry& out) {
  constexpr bool four = measure == Measure::dihedral || measure == Measure::volume;
  const NodeArrays n = node_arrays;
  const std::uint32_t *RESTRICT at_a = corners.corner[0], *RESTRICT at_b = corners.corner[1],
                                *RESTRICT at_c = corners.corner[2], *RESTRICT at_d = corners.corner[four ? 3 : 0];
  const double* RESTRICT reference = corners.reference;
  const std::size_t count = corners.count;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t a = at_a[i], b = at_b[i], c = at_c[i], d = at_d[i];
    const Point pa{n.px[a], n.py[a], n.pz[a]}, pb{n.px[b], n.py[b], n.pz[b]}, pc{n.px[c], n.py[c], n.pz[c]},
        pd{n.px[d], n.py[d], n.pz[d]};
    Point ga, gb, gc, gd;
    gradients<measure>(pa, pb, pc, pd, ga, gb, gc, gd);
    const double value = value_at<measure>(pa, pb, pc, pd);
    const Point v{n.vx[a], n.vy[a], n.vz[a]};
    double rate = dot(gb, Point{n.vx[b], n.vy[b], n.vz[b]} - v) + dot(gc, Point{n.vx[c], n.vy[c], n.vz[c]} - v);
    if constexpr (four) rate += dot(gd, Point{n.vx[d], n.vy[d], n.vz[d]} - v);
    out.value[i] = measure == Measure::dihedral ? turned(value, reference[i]) : value;
    out.rate[i] = rate;
    out.gradient[0][i] = ga.x;
    out.gradient[1][i] = ga.y;
    out.gradient[2][i] = ga.z;
    out.gradient[3][i] = gb.x;
    out.gradient[4][i] = gb.y;
    out.gradient[5][i] = gb.z;
    out.gradient[6][i] = gc.x;
    out.gradient[7][i] = gc.y;
    out.gradient[8][i] = gc.z;
    if constexpr (four) {
      out.gradient[9][i] = gd.x;
      out.gradient[10][i] = gd.y;
      out.gradient[11][i] = gd.z;
    }
  }
}

void corner_forces(const BatchGeometry& geometry, std::size_t corner_count, std::size_t count, const double* q_1,
                   const double* q_2, const CornerForces& out) {
  alignas(64) double sum[element_batch];
  const double* RESTRICT first = q_1 == nullptr ? q_2 : q_1;
  const double* RESTRICT second = q_2;
  if (q_1 == nullptr || q_2 == nullptr) {
    for (std::size_t i = 0; i < count; ++i) sum[i] = -first[i];
  } else {
    for (std::size_t i = 0; i < count; ++i) sum[i] = -(first[i] + second[i]);
  }
  double* const to[3] = {out.x, out.y, out.z};
  for (std::size_t corner = 0; corner < corner_count; ++corner) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double* RESTRICT gradient = geometry.gradient[3 * corner + c];
      double* RESTRICT force = to[c] + corner * out.pitch;
      for (std::size_t i = 0; i < count; ++i) force[i] = sum[i] * gradient[i];
    }
  }
}

}  // namespace
