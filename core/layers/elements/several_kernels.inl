// Included by layers/kernels.inl, in the namespace of an instruction set: plain loops only.

namespace {

using Eights = Triple<Eight>;

template <std::size_t size>
[[gnu::always_inline]] inline Eights load_triple(const double (*rows)[size], std::size_t at) {
  Eights result;
  load(rows[0] + at, result.x);
  load(rows[1] + at, result.y);
  load(rows[2] + at, result.z);
  return result;
}
template <std::size_t size>
[[gnu::always_inline]] inline void store_triple(const Eights& value, double (*rows)[size], std::size_t at) {
  store(value.x, rows[0] + at);
  store(value.y, rows[1] + at);
  store(value.z, rows[2] + at);
}
[[gnu::always_inline]] inline Eight dot_of(const Eights& a, const Eights& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline Eights cross_of(const Eights& a, const Eights& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[gnu::always_inline]] inline Eights minus(const Eights& a, const Eights& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Eights plus(const Eights& a, const Eights& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Eights times(const Eight& s, const Eights& a) { return {s * a.x, s * a.y, s * a.z}; }
[[gnu::always_inline]] inline Eights negated(const Eights& a) { return {-a.x, -a.y, -a.z}; }

// Corners of all members, relative to their first one: a common motion then contributes exactly nothing to rates.
void gather_corners(const ScalarList& list, const BatchCorners& corners, const NodeArrays& node_arrays, bool rates,
                    SeveralGeometry& out) {
  const NodeArrays n = node_arrays;
  const std::size_t padded = (corners.count + several_at_once - 1) / several_at_once * several_at_once;
  for (std::size_t c = 0; c < list.corners; ++c) {
    const std::uint32_t *RESTRICT own = corners.corner[c], *RESTRICT origin = corners.corner[0];
    for (std::size_t i = 0; i < padded; ++i) {
      const std::size_t member = i < corners.count ? i : corners.count - 1;
      const std::size_t k = own[member], o = origin[member];
      out.position[3 * c][i] = n.px[k] - n.px[o];
      out.position[3 * c + 1][i] = n.py[k] - n.py[o];
      out.position[3 * c + 2][i] = n.pz[k] - n.pz[o];
      if (!rates) continue;
      out.velocity[3 * c][i] = n.vx[k] - n.vx[o];
      out.velocity[3 * c + 1][i] = n.vy[k] - n.vy[o];
      out.velocity[3 * c + 2][i] = n.vz[k] - n.vz[o];
    }
  }
}

// The loops of lengths and volumes, of which solids and membranes consist.
void length_of(const std::array<std::uint8_t, 4>& corner, std::size_t padded, bool rates, SeveralGeometry& g,
               std::size_t s) {
  for (std::size_t at = 0; at < padded; at += several_at_once) {
    const Eights d = minus(load_triple(g.position + 3 * corner[0], at), load_triple(g.position + 3 * corner[1], at));
    const Eight length = root(dot_of(d, d)), inverse = 1.0 / or_one(length);
    const Eights n = times(inverse, d);
    store(length, g.value[s] + at);
    store_triple(n, g.gradient[s], at);
    if (!rates) continue;
    const Eights v = minus(load_triple(g.velocity + 3 * corner[0], at), load_triple(g.velocity + 3 * corner[1], at));
    store(dot_of(n, v), g.rate[s] + at);
  }
}
void volume_of(const std::array<std::uint8_t, 4>& corner, std::size_t padded, bool rates, SeveralGeometry& g,
               std::size_t s) {
  for (std::size_t at = 0; at < padded; at += several_at_once) {
    const Eights a = load_triple(g.position + 3 * corner[0], at);
    const auto from_a = [&](std::size_t k) { return minus(load_triple(g.position + 3 * corner[k], at), a); };
    const Eights u = from_a(1), v = from_a(2), w = from_a(3);
    const Eight sixth = 1.0 / 6.0 - Eight{};
    const Eights vw = cross_of(v, w);
    store(dot_of(u, vw) / 6.0, g.value[s] + at);
    const Eights by_b = times(sixth, vw), by_c = times(sixth, cross_of(w, u)), by_d = times(sixth, cross_of(u, v));
    store_triple(negated(plus(plus(by_b, by_c), by_d)), g.gradient[s], at);
    store_triple(by_b, g.gradient[s] + 3, at);
    store_triple(by_c, g.gradient[s] + 6, at);
    store_triple(by_d, g.gradient[s] + 9, at);
    if (!rates) continue;
    const Eights va = load_triple(g.velocity + 3 * corner[0], at);
    const auto rate_of = [&](std::size_t k, const Eights& by) {
      return dot_of(by, minus(load_triple(g.velocity + 3 * corner[k], at), va));
    };
    store(rate_of(1, by_b) + rate_of(2, by_c) + rate_of(3, by_d), g.rate[s] + at);
  }
}

template <Measure measure>
void measure_of(const std::array<std::uint8_t, 4>& corner, const double* RESTRICT reference, std::size_t count,
                std::size_t padded, bool rates, SeveralGeometry& g, std::size_t s) {
  constexpr bool four = measure == Measure::dihedral || measure == Measure::volume;
  const std::size_t a = 3 * corner[0], b = 3 * corner[1], c = 3 * corner[2], d = four ? 3 * corner[3] : 0;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < padded; ++i) {
    const auto at = [&](std::size_t k) { return Point{g.position[k][i], g.position[k + 1][i], g.position[k + 2][i]}; };
    const Point pa = at(a), pb = at(b), pc = at(c), pd = at(d);
    Point ga, gb, gc, gd;
    gradients<measure>(pa, pb, pc, pd, ga, gb, gc, gd);
    const double value = value_at<measure>(pa, pb, pc, pd);
    g.value[s][i] = measure == Measure::dihedral ? turned(value, reference[i < count ? i : count - 1]) : value;
    const auto put = [&](std::size_t k, const Point& by) {
      g.gradient[s][3 * k][i] = by.x;
      g.gradient[s][3 * k + 1][i] = by.y;
      g.gradient[s][3 * k + 2][i] = by.z;
    };
    put(0, ga);
    put(1, gb);
    put(2, gc);
    if constexpr (four) put(3, gd);
    if (!rates) continue;
    const auto v = [&](std::size_t k) {
      return Point{g.velocity[k][i] - g.velocity[a][i], g.velocity[k + 1][i] - g.velocity[a + 1][i],
                   g.velocity[k + 2][i] - g.velocity[a + 2][i]};
    };
    double rate = dot(gb, v(b)) + dot(gc, v(c));
    if constexpr (four) rate += dot(gd, v(d));
    g.rate[s][i] = rate;
  }
}

void several_geometry(const ScalarList& list, const BatchCorners& corners, const double* const* references,
                      const NodeArrays& nodes, bool rates, SeveralGeometry& out) {
  gather_corners(list, corners, nodes, rates, out);
  const std::size_t count = corners.count, padded = (count + several_at_once - 1) / several_at_once * several_at_once;
  for (std::size_t s = 0; s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    if (scalar.reference_only) continue;
    switch (scalar.measure) {
      case Measure::length:
        length_of(scalar.corner, padded, rates, out, s);
        break;
      case Measure::volume:
        volume_of(scalar.corner, padded, rates, out, s);
        break;
      case Measure::angle:
        measure_of<Measure::angle>(scalar.corner, references[s], count, padded, rates, out, s);
        break;
      case Measure::dihedral:
        measure_of<Measure::dihedral>(scalar.corner, references[s], count, padded, rates, out, s);
        break;
      case Measure::area:
        measure_of<Measure::area>(scalar.corner, references[s], count, padded, rates, out, s);
        break;
    }
  }
}

void several_forces(const ScalarList& list, const SeveralGeometry& g, std::size_t count,
                    const double* const (*q)[max_scalars], const CornerForces& out) {
  alignas(64) double force[12][several_at_once];
  for (std::size_t at = 0; at < count; at += several_at_once) {
    const std::size_t size = count - at < several_at_once ? count - at : several_at_once;
    for (std::size_t c = 0; c < 3 * list.corners; ++c) store(Eight{}, force[c]);
    for (std::size_t s = 0; s < list.count; ++s) {
      const double *first = q[0][s], *second = q[1][s];
      if (first == nullptr) first = second;
      if (first == nullptr) continue;
      Eight total;
      if (first == second || second == nullptr) {
        load(first + at, total);
      } else {
        Eight other;
        load(first + at, total);
        load(second + at, other);
        total = total + other;
      }
      const ElementScalar& scalar = list.scalar[s];
      const auto add = [&](std::size_t corner, const Eights& by, const Eight& factor) {
        double(*const to)[several_at_once] = force + 3 * scalar.corner[corner];
        Eight x, y, z;
        load(to[0], x);
        load(to[1], y);
        load(to[2], z);
        store(x - factor * by.x, to[0]);
        store(y - factor * by.y, to[1]);
        store(z - factor * by.z, to[2]);
      };
      if (scalar.measure == Measure::length) {
        const Eights n = load_triple(g.gradient[s], at);
        add(0, n, total);
        add(1, n, -total);
        continue;
      }
      for (std::size_t c = 0; c < scalar.corner_count(); ++c) add(c, load_triple(g.gradient[s] + 3 * c, at), total);
    }
    double* const to[3] = {out.x, out.y, out.z};
    for (std::size_t corner = 0; corner < list.corners; ++corner) {
      for (std::size_t c = 0; c < 3; ++c) {
        double* const row = to[c] + corner * out.pitch + at;
        if (size == several_at_once) {
          Eight value;
          load(force[3 * corner + c], value);
          store(value, row);
        } else {
          for (std::size_t i = 0; i < size; ++i) row[i] = force[3 * corner + c][i];
        }
      }
    }
  }
}

using Nine = double (*)[several_at_once];

[[gnu::always_inline]] inline void add_to(Nine rows, std::size_t entry, const Eight& value) {
  Eight sum;
  load(rows[entry], sum);
  store(sum + value, rows[entry]);
}
// Adds factor [a]x, the matrix of a cross product.
[[gnu::always_inline]] inline void add_cross(Nine rows, const Eight& factor, const Eights& a) {
  const Eights b = times(factor, a);
  add_to(rows, 1, -b.z);
  add_to(rows, 2, b.y);
  add_to(rows, 3, b.z);
  add_to(rows, 5, -b.x);
  add_to(rows, 6, -b.y);
  add_to(rows, 7, b.x);
}
// Adds a b^T.
[[gnu::always_inline]] inline void add_outer(Nine rows, const Eights& a, const Eights& b) {
  const Eight left[3] = {a.x, a.y, a.z}, right[3] = {b.x, b.y, b.z};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) add_to(rows, 3 * r + c, left[r] * right[c]);
}

// Q times the Hessian, (I - n n^T) / l; that of the rate along v.
[[gnu::always_inline]] inline void add_length_hessian(const ElementScalar& scalar, const SeveralGeometry& g,
                                                      std::size_t s, std::size_t at, const Eight& q,
                                                      SeveralBlocks& out) {
  Eight length;
  load(g.value[s] + at, length);
  const Eights n = load_triple(g.gradient[s], at);
  const Eight factor = length > 0.0 ? q / or_one(length) : Eight{};
  const Eight normal[3] = {n.x, n.y, n.z};
  const std::size_t a = scalar.corner[0], b = scalar.corner[1];
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) {
      const Eight entry = factor * ((r == c ? 1.0 - Eight{} : Eight{}) - normal[r] * normal[c]);
      if (a != 0) add_to(out.stiffness[a][a], 3 * r + c, entry);
      if (b != 0) add_to(out.stiffness[b][b], 3 * r + c, entry);
      if (a == 0 || b == 0) continue;
      add_to(out.stiffness[a][b], 3 * r + c, -entry);
      add_to(out.stiffness[b][a], 3 * r + c, -entry);
    }
}
// With u, v, w from the first corner to the others: d(dV/db)/dv = -[w]x / 6, and so on; rows and columns of the first
// corner of the volume are minus the sums of the others.
[[gnu::always_inline]] inline void add_volume_hessian(const ElementScalar& scalar, const SeveralGeometry& g,
                                                      std::size_t at, const Eight& q, SeveralBlocks& out) {
  const auto p = [&](std::size_t k) { return load_triple(g.position + 3 * scalar.corner[k], at); };
  const Eights a = p(0), u = minus(p(1), a), v = minus(p(2), a), w = minus(p(3), a);
  const Eight sixth = q / 6.0;
  const auto put = [&](std::size_t i, std::size_t j, const Eights& x) {
    const std::size_t row = scalar.corner[i], column = scalar.corner[j];
    if (row != 0 && column != 0) add_cross(out.stiffness[row][column], sixth, x);
  };
  put(1, 2, negated(w));
  put(1, 3, v);
  put(2, 3, negated(u));
  put(2, 1, w);
  put(3, 1, negated(v));
  put(3, 2, u);
  put(1, 0, minus(w, v));
  put(2, 0, minus(u, w));
  put(3, 0, minus(v, u));
  put(0, 1, minus(v, w));
  put(0, 2, minus(w, u));
  put(0, 3, minus(u, v));
}

// dq'/dp of lengths, (v - n u) / l, and volumes.
void rate_gradients_of(const ScalarList& list, const SeveralGeometry& g, std::size_t at, SeveralRateGradients& out) {
  for (std::size_t s = 0; s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    if (scalar.reference_only) continue;
    const auto p = [&](std::size_t k) { return load_triple(g.position + 3 * scalar.corner[k], at); };
    const auto speed = [&](std::size_t k) { return load_triple(g.velocity + 3 * scalar.corner[k], at); };
    if (scalar.measure == Measure::length) {
      Eight length, rate;
      load(g.value[s] + at, length);
      load(g.rate[s] + at, rate);
      const Eights n = load_triple(g.gradient[s], at);
      const Eight inverse = length > 0.0 ? 1.0 / or_one(length) : Eight{};
      store_triple(times(inverse, minus(minus(speed(0), speed(1)), times(rate, n))), out.value[s], 0);
    } else if (scalar.measure == Measure::volume) {
      const Eights a = p(0), va = speed(0), u = minus(p(1), a), v = minus(p(2), a), w = minus(p(3), a);
      const Eights du = minus(speed(1), va), dv = minus(speed(2), va), dw = minus(speed(3), va);
      const Eight sixth = 1.0 / 6.0 - Eight{};
      const Eights b = times(sixth, plus(cross_of(dv, w), cross_of(v, dw)));
      const Eights c = times(sixth, plus(cross_of(dw, u), cross_of(w, du)));
      const Eights d = times(sixth, plus(cross_of(du, v), cross_of(u, dv)));
      store_triple(negated(plus(plus(b, c), d)), out.value[s], 0);
      store_triple(b, out.value[s] + 3, 0);
      store_triple(c, out.value[s] + 6, 0);
      store_triple(d, out.value[s] + 9, 0);
    }
  }
}

// Adds factor times rows of a scalar, by its corners, to a vector by the element's corners.
template <std::size_t size>
[[gnu::always_inline]] inline void add_scalar(const ElementScalar& scalar, const double (*rows)[size], std::size_t at,
                                              const Eight& factor, Eights* sum) {
  if (scalar.measure == Measure::length) {
    const Eights change = times(factor, load_triple(rows, at));
    sum[scalar.corner[0]] = plus(sum[scalar.corner[0]], change);
    sum[scalar.corner[1]] = minus(sum[scalar.corner[1]], change);
    return;
  }
  for (std::size_t c = 0; c < scalar.corner_count(); ++c)
    sum[scalar.corner[c]] = plus(sum[scalar.corner[c]], times(factor, load_triple(rows + 3 * c, at)));
}

bool several_sum(const double* first, const double* second, std::size_t count, double* RESTRICT out) {
  if (first == nullptr) first = second;
  std::uint64_t not_finite = 0;
  if (first == nullptr) {
    for (std::size_t i = 0; i < count; ++i) out[i] = 0.0;
  } else if (second == nullptr || first == second) {
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = first[i];
      not_finite += first[i] - first[i] == 0.0 ? 0u : 1u;
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const double sum = first[i] + second[i];
      out[i] = sum;
      not_finite += sum - sum == 0.0 ? 0u : 1u;
    }
  }
  return not_finite == 0;
}

// A common motion changes no force, and forces add up to 0: the blocks of the first corner follow from the others'.
[[gnu::always_inline]] inline void complete(double (*blocks)[4][9][several_at_once], std::size_t corners) {
  for (std::size_t k = 0; k < 9; ++k) {
    Eight corner{};
    for (std::size_t i = 1; i < corners; ++i) {
      Eight row{}, column{};
      for (std::size_t j = 1; j < corners; ++j) {
        Eight by_row, by_column;
        load(blocks[i][j][k], by_row);
        load(blocks[j][i][k], by_column);
        row = row + by_row;
        column = column + by_column;
      }
      store(-row, blocks[i][0][k]);
      store(-column, blocks[0][i][k]);
      corner = corner + row;
    }
    store(corner, blocks[0][0][k]);
  }
}

void several_blocks(const ScalarList& list, const SeveralGeometry& g, std::size_t at, const SeveralTangent& tangent,
                    SeveralRateGradients& rate_gradients, SeveralBlocks& out) {
  const std::size_t corners = list.corners;
  const bool rates = tangent.has_rates;
  if (rates) rate_gradients_of(list, g, at, rate_gradients);
  for (std::size_t a = 1; a < corners; ++a)
    for (std::size_t b = 1; b < corners; ++b)
      for (std::size_t k = 0; k < 9; ++k) {
        store(Eight{}, out.stiffness[a][b][k]);
        if (rates) store(Eight{}, out.damping[a][b][k]);
      }
  for (std::size_t s = 0; s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    if (scalar.reference_only) continue;
    Eight q;
    load(tangent.force[s] + at, q);
    if (scalar.measure == Measure::length) add_length_hessian(scalar, g, s, at, q, out);
    if (scalar.measure == Measure::volume) add_volume_hessian(scalar, g, at, q, out);
    // sum_j (dQ/dq_j dq_j/dp + dQ/dq_j' dq_j'/dp), and sum_j dQ/dq_j' dq_j/dp
    Eights by_position[4]{}, by_velocity[4]{};
    for (std::size_t j = 0; j < list.count; ++j) {
      if (list.scalar[j].reference_only) continue;
      Eight factor;
      load(tangent.by_value[max_scalars * s + j] + at, factor);
      add_scalar(list.scalar[j], g.gradient[j], at, factor, by_position);
      if (!rates) continue;
      load(tangent.by_rate[max_scalars * s + j] + at, factor);
      add_scalar(list.scalar[j], rate_gradients.value[j], 0, factor, by_position);
      add_scalar(list.scalar[j], g.gradient[j], at, factor, by_velocity);
    }
    for (std::size_t c = 0; c < scalar.corner_count(); ++c) {
      if (scalar.corner[c] == 0) continue;
      const bool opposite = scalar.measure == Measure::length && c == 1;
      Eights own = load_triple(g.gradient[s] + (opposite ? 0 : 3 * c), at);
      if (opposite) own = negated(own);
      for (std::size_t b = 1; b < corners; ++b) {
        add_outer(out.stiffness[scalar.corner[c]][b], own, by_position[b]);
        if (rates) add_outer(out.damping[scalar.corner[c]][b], own, by_velocity[b]);
      }
    }
  }
  complete(out.stiffness, corners);
  if (rates) complete(out.damping, corners);
}

// Rows become columns: pairs of numbers, pairs of these, halves.
[[gnu::always_inline]] inline void transpose(Eight (&row)[8]) {
  for (std::size_t i = 0; i < 8; i += 2) {
    const Eight a = row[i], b = row[i + 1];
    row[i] = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    row[i + 1] = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (std::size_t i = 0; i < 8; i += 4)
    for (std::size_t k = i; k < i + 2; ++k) {
      const Eight a = row[k], b = row[k + 2];
      row[k] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
      row[k + 2] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (std::size_t k = 0; k < 4; ++k) {
    const Eight a = row[k], b = row[k + 4];
    row[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    row[k + 4] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

void several_spread(const double (*blocks)[4][9][several_at_once], std::size_t corners, SeveralSpread& out) {
  const double* rows[4 * 4 * 9 + 7];
  std::size_t count = 0;
  for (std::size_t a = 0; a < corners; ++a)
    for (std::size_t b = 0; b < corners; ++b)
      for (std::size_t k = 0; k < 9; ++k) rows[count++] = blocks[a][b][k];
  for (std::size_t more = 0; more < 7; ++more) rows[count + more] = rows[0];  // up to a multiple of eight
  for (std::size_t begin = 0; begin < count; begin += 8) {
    Eight row[8];
    for (std::size_t i = 0; i < 8; ++i) load(rows[begin + i], row[i]);
    transpose(row);
    for (std::size_t member = 0; member < several_at_once; ++member) store(row[member], out.entries[member] + begin);
  }
}

}  // namespace
