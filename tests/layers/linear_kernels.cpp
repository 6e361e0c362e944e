// The loops of the linear solvers against plain ones, and the same bits by every instruction set.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <springnet/error.hpp>

#include "layers/kernels.hpp"
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

namespace {

std::vector<float> singles(std::size_t count, unsigned seed) {
  std::vector<float> result;
  for (const double value : numbers(count, seed)) result.push_back(static_cast<float>(value));
  return result;
}
// x, y, z of nodes and a fourth number that says nothing.
template <class Number>
double plain_dot(const std::vector<Number>& a, const std::vector<Number>& b, NodeRange nodes) {
  double sum = 0.0;
  for (std::size_t k = nodes.begin; k < nodes.end; ++k)
    for (std::size_t c = 0; c < 3; ++c) sum += double{a[4 * k + c]} * b[4 * k + c];
  return sum;
}
bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

constexpr double single_rounding = 3e-6;  // of sums of some tens of products of numbers below 1

}  // namespace

TEST_CASE("loops over nodes in single precision do what plain ones do, for every range") {
  for (std::size_t count = 0; count <= 33; ++count) {
    for (const std::size_t begin : {std::size_t{0}, std::size_t{5}}) {
      CAPTURE(count);
      CAPTURE(begin);
      const std::size_t n = begin + count + 2;
      const NodeRange nodes{begin, begin + count};
      const std::vector<float> a = singles(4 * n, 1), b = singles(4 * n, 2), w = singles(n, 3);
      std::vector<float> d = singles(12 * n, 4);
      for (std::size_t i = 3; i < d.size(); i += 4) d[i] = 0.0F;
      const std::vector<double> d_double(d.begin(), d.end()), a_double(a.begin(), a.end());
      std::vector<std::vector<float>> first;
      std::vector<double> first_sums, first_double;
      for (const Loops& set : all_loops()) {
        const SpringKernels& kernels = *set.springs;
        std::vector<std::vector<float>> y(6, b);
        std::vector<double> y_double(b.begin(), b.end());
        kernels.diagonal(d.data(), nodes, a.data(), y[0].data());
        kernels.diagonal_double(d_double.data(), nodes, a_double.data(), y_double.data());
        kernels.scale_add(-1.3F, a.data(), nodes, y[1].data());
        const double added = kernels.add_and_dot(w.data(), a.data(), nodes, y[2].data());
        y[4] = a;
        const Sums2 sums =
            kernels.advance(0.7F, a.data(), b.data(), d.data(), w.data(), nodes, y[3].data(), y[4].data(), y[5].data());
        for (std::size_t k = 0; k < n; ++k) {
          const bool inside = k >= nodes.begin && k < nodes.end;
          for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t i = 4 * k + c;
            if (!inside) {
              for (const std::size_t which : {0, 1, 2, 3, 5}) REQUIRE(y[which][i] == b[i]);
              REQUIRE(y[4][i] == a[i]);
              REQUIRE(y_double[i] == b[i]);
              continue;
            }
            if (c == 3) continue;
            double sum = 0.0, of_left = 0.0;
            for (std::size_t j = 0; j < 3; ++j) {
              sum += double{d[12 * k + 4 * j + c]} * a[4 * k + j];
              of_left += double{d[12 * k + 4 * j + c]} * y[4][4 * k + j];
            }
            CHECK(std::abs(y[0][i] - sum) <= single_rounding);
            CHECK(std::abs(y_double[i] - sum) <= rounding);
            CHECK(y[1][i] == a[i] + -1.3F * b[i]);
            CHECK(y[2][i] == b[i] + w[k] * a[i]);
            CHECK(y[3][i] == b[i] + 0.7F * a[i]);
            CHECK(y[4][i] == a[i] - 0.7F * b[i]);
            CHECK(std::abs(y[5][i] - of_left) <= single_rounding);
          }
        }
        double square = 0.0, square_left = 0.0;
        for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
          for (std::size_t c = 0; c < 3; ++c) {
            square += double{w[k]} * a[4 * k + c] * a[4 * k + c];
            square_left += double{w[k]} * y[4][4 * k + c] * y[4][4 * k + c];
          }
        }
        const std::vector<double> all{kernels.dot(a.data(), b.data(), nodes), kernels.square(w.data(), a.data(), nodes),
                                      added, sums.first, sums.second};
        const double wanted[] = {plain_dot(a, b, nodes), square, plain_dot(a, y[2], nodes),
                                 plain_dot(y[4], y[5], nodes), square_left};
        for (std::size_t i = 0; i < all.size(); ++i) CHECK(std::abs(all[i] - wanted[i]) <= 10.0 * single_rounding);
        if (first.empty()) {
          first = y;
          first_sums = all;
          first_double = y_double;
        }
        for (std::size_t i = 0; i < y.size(); ++i) CHECK(same_bits(y[i], first[i]));
        CHECK(same_bits(all, first_sums));
        CHECK(same_bits(y_double, first_double));
      }
    }
  }
}

TEST_CASE("products over springs by their first nodes are those of single springs") {
  constexpr std::size_t nodes = 40, begin = 7, end = 31;
  for (unsigned seed = 0; seed < 12; ++seed) {
    for (const bool to_second : {true, false}) {
      CAPTURE(seed);
      CAPTURE(to_second);
      std::mt19937 random(seed);
      std::vector<std::uint32_t> start{0}, second;
      for (std::size_t k = begin; k < end; ++k) {
        // None, one, two, and more; some twice between the same nodes.
        for (std::size_t s = random() % 6; s > 0; --s) {
          second.push_back(static_cast<std::uint32_t>((k + 1 + random() % (nodes - 1)) % nodes));
          if (random() % 5 == 0) second.push_back(second.back());
        }
        start.push_back(static_cast<std::uint32_t>(second.size()));
      }
      const std::vector<float> stiffness = singles(4 * second.size() + 4, seed + 1);
      std::vector<float> x = singles(4 * nodes, seed + 2);
      for (std::size_t i = 3; i < x.size(); i += 4) x[i] = 0.0F;
      const std::vector<double> x_double(x.begin(), x.end());
      std::vector<double> expected(4 * nodes, 0.25);
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t s = start[k - begin]; s < start[k - begin + 1]; ++s) {
          const std::size_t j = second[s];
          const float* const q = &stiffness[4 * s];
          double along = 0.0;
          for (std::size_t c = 0; c < 3; ++c) along += double{q[c]} * (double{x[4 * k + c]} - x[4 * j + c]);
          for (std::size_t c = 0; c < 3; ++c) {
            const double force = double{q[3]} * (double{x[4 * k + c]} - x[4 * j + c]) + q[c] * along;
            expected[4 * k + c] += force;
            if (to_second) expected[4 * j + c] -= force;
          }
        }
      }
      std::vector<double> blocks(8 * nodes, 0.25);  // xx, yy, zz, of no meaning, xy, yz, zx, likewise
      for (std::size_t k = begin; k < end; ++k) {
        for (std::size_t s = start[k - begin]; s < start[k - begin + 1]; ++s) {
          const float* const q = &stiffness[4 * s];
          for (const std::size_t node : {k, std::size_t{second[s]}}) {
            if (node != k && !to_second) continue;
            for (std::size_t c = 0; c < 3; ++c) {
              blocks[8 * node + c] += double{q[3]} + double{q[c]} * q[c];
              blocks[8 * node + 4 + c] += double{q[c]} * q[(c + 1) % 3];
            }
          }
        }
      }
      std::vector<float> first;
      std::vector<double> first_double, first_blocks;
      const SpringRows rows{start.data(), second.data(), stiffness.data()};
      for (const Loops& set : all_loops()) {
        std::vector<float> y(4 * nodes, 0.25F);
        std::vector<double> y_double(4 * nodes, 0.25);
        set.springs->product(rows, {begin, end}, x.data(), to_second, y.data());
        set.springs->product_double(rows, {begin, end}, x_double.data(), to_second, y_double.data());
        for (std::size_t i = 0; i < y.size(); ++i) {
          if (i % 4 == 3) continue;
          CHECK(std::abs(y[i] - expected[i]) <= 10.0 * single_rounding);
          CHECK(std::abs(y_double[i] - expected[i]) <= 1e-12);
        }
        std::vector<double> own(8 * nodes, 0.25);
        set.springs->add_blocks(rows, {begin, end}, to_second, own.data());
        for (std::size_t i = 0; i < own.size(); ++i) {
          if (i % 4 == 3) own[i] = blocks[i] = 0.0;
          CHECK(std::abs(own[i] - blocks[i]) <= 1e-12);
        }
        if (first.empty()) {
          first = y;
          first_double = y_double;
          first_blocks = own;
        }
        CHECK(same_bits(y, first));
        CHECK(same_bits(y_double, first_double));
        CHECK(same_bits(own, first_blocks));
      }
    }
  }
}

TEST_CASE("springs have the stiffness that their laws answer, and what does not fit is marked") {
  constexpr std::size_t count = 150;  // more than the loops take at a time
  constexpr double position = 0.3, velocity = 0.7;
  const std::vector<double> n = numbers(3 * count, 1), length = numbers(count, 2), rate = numbers(count, 3),
                            speed = numbers(count, 4), along = numbers(3 * count, 5);
  std::vector<double> lengths, law[2][3];
  for (std::size_t i = 0; i < count; ++i) lengths.push_back(i % 17 == 0 ? 0.0 : 1.5 + length[i]);
  for (unsigned k = 0; k < 2; ++k) {
    for (unsigned j = 0; j < 3; ++j) law[k][j] = numbers(count, 6 + 3 * k + j);
    for (double& by_length : law[k][1]) by_length += 2.5;  // stiff enough, but for some
  }
  for (std::size_t i = 0; i < count; i += 31) law[0][1][i] = -50.0;
  law[0][1][33] = 1e20;
  law[1][0][34] = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::uint32_t> spring, place;
  for (std::uint32_t i = 0; i < count; ++i) {
    spring.push_back(i % 23 == 5 ? no_spring : i);
    place.push_back((i * 7) % count);
  }
  for (const bool has_both : {true, false}) {
    CAPTURE(has_both);
    AxialAnswers answers{spring.data(),
                         place.data(),
                         count,
                         {n.data(), n.data() + count, n.data() + 2 * count},
                         {along.data(), along.data() + count, along.data() + 2 * count},
                         lengths.data(),
                         rate.data(),
                         speed.data(),
                         {},
                         {},
                         {}};
    for (std::size_t k = 0; k < (has_both ? 2U : 1U); ++k) {
      answers.tension[k] = law[k][0].data();
      answers.by_length[k] = law[k][1].data();
      answers.by_rate[k] = law[k][2].data();
    }
    const auto of = [&](std::size_t j, std::size_t i) { return law[0][j][i] + (has_both ? law[1][j][i] : 0.0); };
    std::vector<float> first;
    for (const Loops& set : all_loops()) {
      std::vector<float> stiffness(4 * count, 9.0F);
      const StiffnessSums sums = set.springs->write_stiffness(answers, position, velocity, stiffness.data());
      CHECK_FALSE(sums.fits);
      double asymmetric = 0.0, all = 0.0;
      for (std::size_t i = 0; i < count; ++i) {
        CAPTURE(i);
        const float* const own = &stiffness[4 * std::size_t{place[i]}];
        if (spring[i] == no_spring) {
          CHECK(own[0] == 9.0F);
          continue;
        }
        const double a = lengths[i] > 0.0 ? position * of(0, i) / lengths[i] : 0.0;
        const double axial = position * of(1, i) + velocity * of(2, i) - a;
        if (!(axial >= 0.0 && axial <= 1e18)) {
          CHECK(std::isnan(own[0]));
          continue;
        }
        CHECK(std::abs(own[3] - a) <= single_rounding);
        for (std::size_t c = 0; c < 3; ++c)
          CHECK(std::abs(own[c] - std::sqrt(axial) * n[c * count + i]) <= single_rounding);
        const double across = std::max(0.0, speed[i] * speed[i] - rate[i] * rate[i]);
        if (lengths[i] > 0.0) asymmetric += 2.0 * across * std::pow(position * of(2, i) / lengths[i], 2);
        all += 2.0 * a * a + (a + axial) * (a + axial);
      }
      CHECK(sums.asymmetric == doctest::Approx(asymmetric).epsilon(1e-12));
      CHECK(sums.all == doctest::Approx(all).epsilon(1e-12));
      if (first.empty()) first = stiffness;
      CHECK(same_bits(stiffness, first));
    }
  }
}
