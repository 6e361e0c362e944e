// Included once for each instruction set with KERNEL_NAMESPACE defined. Plain loops only, as in kernels.inl.

#include "layers/linear/spring_kernels.hpp"

#define RESTRICT __restrict
#if defined(__clang__)
#define INDEPENDENT_ITERATIONS _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif

namespace springnet::layers::KERNEL_NAMESPACE {
namespace {

// Springs of a run are taken eight at a time, also beyond its end, where the results are overwritten by those of the
// next run: most runs are short, and a loop over what is left would cost as much as the rest.
constexpr std::size_t lanes = 8;

struct alignas(64) Products {
  double x[max_segment + lanes], y[max_segment + lanes], z[max_segment + lanes];
};

// B (x_first - x_second) of spring `at` of the segment, between nodes i and j.
[[gnu::always_inline]] inline void one(const SpringStiffness& b, const double* RESTRICT px, const double* RESTRICT py,
                                       const double* RESTRICT pz, std::size_t i, std::size_t j, std::size_t at,
                                       Products& out) {
  const double dx = px[i] - px[j], dy = py[i] - py[j], dz = pz[i] - pz[j];
  const double qx = b.qx[at], qy = b.qy[at], qz = b.qz[at], a = b.a[at];
  const double along = qx * dx + qy * dy + qz * dz;
  out.x[at] = a * dx + along * qx;
  out.y[at] = a * dy + along * qy;
  out.z[at] = a * dz + along * qz;
}

template <std::size_t width>
[[gnu::always_inline]] inline void add_lanes(const double* RESTRICT product, double* RESTRICT y) {
  for (std::size_t i = 0; i < width; ++i) y[i] += product[i];
}
template <std::size_t width>
[[gnu::always_inline]] inline void subtract_lanes(const double* RESTRICT product, double* RESTRICT y) {
  for (std::size_t i = 0; i < width; ++i) y[i] -= product[i];
}

// One component of the products of a run. First and second ends have a loop each, in which no node occurs twice.
[[gnu::always_inline]] inline void scatter_run(const Run& run, const double* RESTRICT product, bool to_second,
                                               double* y) {
  const std::size_t count = run.count;
  double* first = y + run.first;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) add_lanes<lanes>(product + i, first + i);
  if (i + 4 <= count) add_lanes<4>(product + i, first + i), i += 4;
  if (i + 2 <= count) add_lanes<2>(product + i, first + i), i += 2;
  if (i < count) first[i] += product[i];
  if (!to_second) return;
  double* second = y + run.second;
  i = 0;
  for (; i + lanes <= count; i += lanes) subtract_lanes<lanes>(product + i, second + i);
  if (i + 4 <= count) subtract_lanes<4>(product + i, second + i), i += 4;
  if (i + 2 <= count) subtract_lanes<2>(product + i, second + i), i += 2;
  if (i < count) second[i] -= product[i];
}

void product(const SegmentSprings& springs, const SpringStiffness& stiffness, const double* const x[3], bool to_second,
             double* const y[3]) {
  Products products;  // not initialised: written before it is read
  const SpringStiffness b = stiffness;
  const double *px = x[0], *py = x[1], *pz = x[2];
  double *yx = y[0], *yy = y[1], *yz = y[2];
  std::size_t at = 0;
  for (std::uint32_t r = 0; r < springs.run_count; ++r) {
    const Run run = springs.runs[r];
    const std::size_t i = run.first, j = run.second, count = run.count;
    for (std::size_t s = 0; s < count; s += lanes) {
      INDEPENDENT_ITERATIONS
      for (std::size_t l = 0; l < lanes; ++l) one(b, px, py, pz, i + s + l, j + s + l, at + s + l, products);
    }
    scatter_run(run, products.x + at, to_second, yx);
    scatter_run(run, products.y + at, to_second, yy);
    scatter_run(run, products.z + at, to_second, yz);
    at += count;
  }
  const std::uint32_t* RESTRICT first = springs.first;
  const std::uint32_t* RESTRICT second = springs.second;
  const std::size_t count = springs.count;
  INDEPENDENT_ITERATIONS
  for (std::size_t s = at; s < count; ++s) one(b, px, py, pz, first[s], second[s], s, products);
  for (std::size_t s = at; s < count; ++s) {
    const std::size_t i = first[s];
    yx[i] += products.x[s];
    yy[i] += products.y[s];
    yz[i] += products.z[s];
    if (to_second) {
      const std::size_t j = second[s];
      yx[j] -= products.x[s];
      yy[j] -= products.y[s];
      yz[j] -= products.z[s];
    }
  }
}

void diagonal(const double* const d[6], const double* const r[3], std::size_t count, double* const z[3]) {
  const double *RESTRICT xx = d[0], *RESTRICT yy = d[1], *RESTRICT zz = d[2];
  const double *RESTRICT xy = d[3], *RESTRICT yz = d[4], *RESTRICT xz = d[5];
  const double *RESTRICT rx = r[0], *RESTRICT ry = r[1], *RESTRICT rz = r[2];
  double *RESTRICT zx = z[0], *RESTRICT zy = z[1], *RESTRICT z3 = z[2];
  for (std::size_t k = 0; k < count; ++k) {
    zx[k] = xx[k] * rx[k] + xy[k] * ry[k] + xz[k] * rz[k];
    zy[k] = xy[k] * rx[k] + yy[k] * ry[k] + yz[k] * rz[k];
    z3[k] = xz[k] * rx[k] + yz[k] * ry[k] + zz[k] * rz[k];
  }
}

// Sums in eight parts, each of every eighth term, so that all instruction sets add alike.
constexpr std::size_t parts = 8;

[[gnu::always_inline]] inline double total(const double (&sum)[parts]) {
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

double dot(const double* RESTRICT a, const double* RESTRICT b, std::size_t count) {
  double sum[parts] = {};
  std::size_t i = 0;
  for (; i + parts <= count; i += parts)
    for (std::size_t p = 0; p < parts; ++p) sum[p] += a[i + p] * b[i + p];
  for (std::size_t p = 0; i < count; ++i, ++p) sum[p] += a[i] * b[i];
  return total(sum);
}

double square(const double* RESTRICT w, const double* RESTRICT a, std::size_t count) {
  double sum[parts] = {};
  std::size_t i = 0;
  for (; i + parts <= count; i += parts)
    for (std::size_t p = 0; p < parts; ++p) sum[p] += w[i + p] * a[i + p] * a[i + p];
  for (std::size_t p = 0; i < count; ++i, ++p) sum[p] += w[i] * a[i] * a[i];
  return total(sum);
}

void add(double s, const double* RESTRICT x, std::size_t count, double* RESTRICT y) {
  for (std::size_t i = 0; i < count; ++i) y[i] += s * x[i];
}

void multiply(const double* RESTRICT w, const double* RESTRICT x, std::size_t count, double* RESTRICT y) {
  for (std::size_t i = 0; i < count; ++i) y[i] = w[i] * x[i];
}

void scale_add(double s, const double* RESTRICT x, std::size_t count, double* RESTRICT y) {
  for (std::size_t i = 0; i < count; ++i) y[i] = x[i] + s * y[i];
}

}  // namespace

const SpringKernels& spring_kernels() {
  static constexpr SpringKernels table{product, diagonal, dot, square, add, scale_add, multiply};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
