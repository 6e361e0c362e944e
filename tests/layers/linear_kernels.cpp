// The loops of the linear solvers against plain ones, and the same bits by every instruction set.

#include <doctest/doctest.h>

#include <cstring>
#include <random>
#include <vector>

#include <springnet/error.hpp>

#include "layers/linear/block_kernels.hpp"
#include "layers/linear/spring_kernels.hpp"

using namespace springnet;
using namespace springnet::layers;

namespace {

std::vector<double> numbers(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> values(count);
  for (double& value : values) value = unit(random);
  return values;
}

struct Loops {
  const BlockKernels* blocks;
  const SpringKernels* springs;
};
bool available(InstructionSet set) {
  try {
    return choose_instruction_set(set) == set;
  } catch (const Error&) {
    return false;
  }
}
std::vector<Loops> all_loops() {
  std::vector<Loops> sets{{&generic::block_kernels(), &generic::spring_kernels()}};
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (available(InstructionSet::avx2)) sets.push_back({&avx2::block_kernels(), &avx2::spring_kernels()});
  if (available(InstructionSet::avx512)) sets.push_back({&avx512::block_kernels(), &avx512::spring_kernels()});
#endif
  return sets;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

double plain_dot(const std::vector<double>& a, const std::vector<double>& b, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) sum += a[i] * b[i];
  return sum;
}

// Rows with blocks of up to so many columns, those below the diagonal or above it, or any.
struct Rows {
  std::vector<std::uint32_t> start{0}, column;
  std::vector<double> values;
  Rows(std::size_t n, std::size_t most, int side, unsigned seed) {
    std::mt19937 random(seed);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t low = side > 0 ? k + 1 : 0, high = side < 0 ? k : n;
      for (std::size_t b = random() % (most + 1); b > 0 && low < high; --b)
        column.push_back(static_cast<std::uint32_t>(low + random() % (high - low)));
      start.push_back(static_cast<std::uint32_t>(column.size()));
    }
    values = numbers(9 * column.size() + 1, seed + 1);
    for (double& value : values) value *= 0.3;
  }
  [[nodiscard]] BlockArrays arrays() const { return {start.data(), column.data(), values.data()}; }
  // Component r of row k times x.
  [[nodiscard]] double times(std::size_t k, std::size_t r, const std::vector<double>& x) const {
    double sum = 0.0;
    for (std::size_t b = start[k]; b < start[k + 1]; ++b)
      for (std::size_t c = 0; c < 3; ++c) sum += values[9 * b + 3 * c + r] * x[3 * column[b] + c];
    return sum;
  }
};

constexpr double rounding = 1e-13;

}  // namespace

TEST_CASE("loops over blocks do what plain ones do, for every range of nodes") {
  for (std::size_t count = 0; count <= 17; ++count) {
    for (const std::size_t begin : {std::size_t{0}, std::size_t{3}}) {
      CAPTURE(count);
      CAPTURE(begin);
      const std::size_t end = begin + count, n = end + 2;
      const NodeRange range{begin, end};
      const Rows all(n, 5, 0, 1), below(n, 3, -1, 2), above(n, 3, 1, 3);
      const std::vector<double> x = numbers(3 * n + 1, 4), start = numbers(3 * n + 1, 5),
                                blocks = numbers(9 * n + 1, 6);
      const std::vector<double> weight = numbers(n, 7);
      std::vector<std::vector<double>> first;
      for (const Loops& set : all_loops()) {
        const BlockKernels& kernels = *set.blocks;
        std::vector<std::vector<double>> y(6, start);
        kernels.product(all.arrays(), range, x.data(), y[0].data());
        kernels.diagonal(blocks.data(), range, x.data(), y[1].data());
        kernels.lower(below.arrays(), range, x.data(), y[2].data());
        kernels.upper(above.arrays(), blocks.data(), range, y[3].data());
        kernels.add(0.7, x.data(), range, y[4].data());
        kernels.scale_add(0.7, x.data(), range, y[5].data());
        for (std::size_t i = 0; i < 3 * n + 1; ++i) {
          const std::size_t k = i / 3, r = i % 3;
          if (k < begin || k >= end) {  // not touched
            for (const auto& values : y) REQUIRE(values[i] == start[i]);
            continue;
          }
          CHECK(std::abs(y[0][i] - all.times(k, r, x)) <= rounding);
          double diagonal = 0.0;
          for (std::size_t c = 0; c < 3; ++c) diagonal += blocks[9 * k + 3 * c + r] * x[3 * k + c];
          CHECK(std::abs(y[1][i] - diagonal) <= rounding);
          CHECK(std::abs(y[2][i] + below.times(k, r, y[2]) - x[i]) <= rounding);
          double upper = 0.0;
          for (std::size_t c = 0; c < 3; ++c)
            upper += blocks[9 * k + 3 * c + r] * (start[3 * k + c] - above.times(k, c, y[3]));
          CHECK(std::abs(y[3][i] - upper) <= rounding * (1.0 + std::abs(upper)));
          CHECK(y[4][i] == start[i] + 0.7 * x[i]);
          CHECK(y[5][i] == x[i] + 0.7 * start[i]);
        }
        double square = 0.0;
        for (std::size_t k = begin; k < end; ++k)
          for (std::size_t c = 0; c < 3; ++c) square += weight[k] * x[3 * k + c] * x[3 * k + c];
        const double dot = kernels.dot(x.data(), start.data(), range),
                     own = kernels.square(weight.data(), x.data(), range);
        CHECK(std::abs(dot - plain_dot(x, start, 3 * begin, 3 * end)) <= rounding);
        CHECK(std::abs(own - square) <= rounding);
        y.push_back({dot, own});
        if (first.empty()) first = y;
        for (std::size_t i = 0; i < y.size(); ++i) CHECK(same_bits(y[i], first[i]));
      }
    }
  }
}

TEST_CASE("loops over numbers of one axis do what plain ones do, for every count") {
  for (std::size_t count = 0; count <= 33; ++count) {
    CAPTURE(count);
    const std::vector<double> a = numbers(count + 8, 1), b = numbers(count + 8, 2);
    std::vector<std::vector<double>> d, r;
    for (unsigned c = 0; c < 6; ++c) d.push_back(numbers(count + 8, 10 + c));
    for (unsigned c = 0; c < 3; ++c) r.push_back(numbers(count + 8, 20 + c));
    const double* const blocks[6] = {d[0].data(), d[1].data(), d[2].data(), d[3].data(), d[4].data(), d[5].data()};
    const double* const in[3] = {r[0].data(), r[1].data(), r[2].data()};
    std::vector<std::vector<double>> first;
    for (const Loops& set : all_loops()) {
      const SpringKernels& kernels = *set.springs;
      std::vector<std::vector<double>> y(6, b);
      double* const out[3] = {y[0].data(), y[1].data(), y[2].data()};
      kernels.diagonal(blocks, in, count, out);
      kernels.add(-1.3, a.data(), count, y[3].data());
      kernels.scale_add(-1.3, a.data(), count, y[4].data());
      kernels.multiply(a.data(), b.data(), count, y[5].data());
      constexpr std::size_t component[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
      for (std::size_t i = 0; i < count + 8; ++i) {
        if (i >= count) {
          for (const auto& values : y) REQUIRE(values[i] == b[i]);
          continue;
        }
        for (std::size_t c = 0; c < 3; ++c) {
          double sum = 0.0;
          for (std::size_t j = 0; j < 3; ++j) sum += d[component[c][j]][i] * r[j][i];
          CHECK(std::abs(y[c][i] - sum) <= rounding);
        }
        CHECK(y[3][i] == b[i] + -1.3 * a[i]);
        CHECK(y[4][i] == a[i] + -1.3 * b[i]);
        CHECK(y[5][i] == a[i] * b[i]);
      }
      double square = 0.0;
      for (std::size_t i = 0; i < count; ++i) square += b[i] * a[i] * a[i];
      const double dot = kernels.dot(a.data(), b.data(), count), own = kernels.square(b.data(), a.data(), count);
      CHECK(std::abs(dot - plain_dot(a, b, 0, count)) <= rounding);
      CHECK(std::abs(own - square) <= rounding);
      y.push_back({dot, own});
      if (first.empty()) first = y;
      for (std::size_t i = 0; i < y.size(); ++i) CHECK(same_bits(y[i], first[i]));
    }
  }
}

TEST_CASE("products over springs in runs of every length, and by their ends, are those of single springs") {
  for (std::uint32_t length = 1; length <= 17; ++length) {
    for (const std::uint32_t loose : {0u, 1u, 7u, 23u}) {
      for (const bool to_second : {true, false}) {
        CAPTURE(length);
        CAPTURE(loose);
        CAPTURE(to_second);
        // Runs of different lengths, overlapping in nodes, then springs by their ends, some of which meet at a node.
        std::vector<Run> runs;
        std::vector<std::uint32_t> ends[2];
        const std::uint32_t counts[] = {length, 1, length % 5 + 1, length, 16};
        for (std::uint32_t r = 0; r < 5; ++r) {
          runs.push_back({3 * r, 3 * r + 1 + r % 3, counts[r]});
          for (std::uint32_t i = 0; i < counts[r]; ++i) {
            ends[0].push_back(runs.back().first + i);
            ends[1].push_back(runs.back().second + i);
          }
        }
        const auto in_runs = static_cast<std::uint32_t>(ends[0].size());
        std::mt19937 random(length);
        for (std::uint32_t i = 0; i < loose; ++i) {
          ends[0].push_back(static_cast<std::uint32_t>(random() % 40));
          ends[1].push_back(static_cast<std::uint32_t>((ends[0].back() + 1 + random() % 39) % 40));
        }
        constexpr std::size_t nodes = 40;
        const auto count = static_cast<std::uint32_t>(ends[0].size());
        std::vector<std::vector<float>> b(4);
        for (unsigned c = 0; c < 4; ++c)
          for (const double value : numbers(count + 8, c)) b[c].push_back(static_cast<float>(value));
        std::vector<std::vector<double>> x, first;
        for (unsigned c = 0; c < 3; ++c) x.push_back(numbers(nodes + 8, 30 + c));
        std::vector<std::vector<double>> expected(3, std::vector<double>(nodes + 8, 0.25));
        for (std::uint32_t s = 0; s < count; ++s) {
          const std::uint32_t i = ends[0][s], j = ends[1][s];
          double along = 0.0;
          for (std::size_t c = 0; c < 3; ++c) along += double{b[1 + c][s]} * (x[c][i] - x[c][j]);
          for (std::size_t c = 0; c < 3; ++c) {
            const double force = b[0][s] * (x[c][i] - x[c][j]) + b[1 + c][s] * along;
            expected[c][i] += force;
            if (to_second) expected[c][j] -= force;
          }
        }
        const SegmentSprings springs{
            runs.data(), static_cast<std::uint32_t>(runs.size()), in_runs, count, ends[0].data(), ends[1].data()};
        for (const Loops& set : all_loops()) {
          std::vector<std::vector<double>> y(3, std::vector<double>(nodes + 8, 0.25));
          const double* const from[3] = {x[0].data(), x[1].data(), x[2].data()};
          double* const to[3] = {y[0].data(), y[1].data(), y[2].data()};
          set.springs->product(springs, {b[0].data(), b[1].data(), b[2].data(), b[3].data()}, from, to_second, to);
          for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < nodes + 8; ++k) CHECK(std::abs(y[c][k] - expected[c][k]) <= 1e-12);
          if (first.empty()) first = y;
          for (std::size_t c = 0; c < 3; ++c) CHECK(same_bits(y[c], first[c]));
        }
      }
    }
  }
}
