#include "constraints/same_rows.hpp"

#include <doctest/doctest.h>

#include <array>
#include <vector>

using namespace springnet;

namespace {

PairRow row_between(const std::array<std::uint32_t, 4>& nodes, const std::array<double, 4>& weights, int count,
                    const Vector3& normal, const Vector3& impulse) {
  PairRow row;
  row.nodes = nodes;
  row.weights = weights;
  row.count = count;
  row.normal = normal;
  row.impulse = impulse;
  row.friction = 0.3;
  return row;
}

// N s, on each of the nodes 0 to 9.
std::array<Vector3, 10> pushes(const std::vector<PairRow>& rows) {
  std::array<Vector3, 10> result;
  result.fill(Vector3::Zero());
  for (const PairRow& row : rows)
    for (std::size_t i = 0; i < static_cast<std::size_t>(row.count); ++i)
      result[row.nodes[i]] += row.weights[i] * row.impulse;
  return result;
}

}  // namespace

TEST_CASE("same rows: a corner on a corner is one row, whichever faces and edges have them, either way round") {
  const Vector3 up = Vector3::UnitZ(), tilted = Vector3(0.1, 0.2, 1.0).normalized();
  std::vector<PairRow> rows{row_between({3, 5, 6, 7}, {1, -1, 0, 0}, 4, up, {0.1, 0, 1}),
                            row_between({4, 5, 3, 8}, {0, 1, -1, 0}, 4, -up, {0, 0.3, -2}),
                            row_between({3, 2, 5, 9}, {1, 0, -1, 0}, 4, tilted, {0, 0, 4}),
                            row_between({3, 5, 6, 7}, {1, -0.5, -0.5, 0}, 4, up, {0, 0, 8}),
                            row_between({6, 5, 3, 0}, {0.5, 0.5, -1, 0}, 3, -up, {0, 0.1, -16})};
  const std::array<Vector3, 10> before = pushes(rows);
  CHECK(join_same(rows) == 2);
  const std::array<Vector3, 10> after = pushes(rows);
  for (std::size_t k = 0; k < 10; ++k) {
    CAPTURE(k);
    CHECK((after[k] - before[k]).norm() < 1e-14);  // sums in another order
  }
  CHECK((rows[0].impulse - Vector3(0.1, -0.3, 3)).norm() < 1e-14);
  CHECK((rows[3].impulse - Vector3(0, -0.1, 24)).norm() < 1e-14);
  for (const std::size_t joined : {1u, 4u}) {
    CHECK(rows[joined].is_blocked);
    CHECK(rows[joined].impulse.isZero(0.0));
  }
  CHECK_FALSE(rows[2].is_blocked);
  CHECK(join_same(rows) == 0);
}

TEST_CASE("same rows: others' friction, blocked and finished rows and obstacles stay apart") {
  const Vector3 up = Vector3::UnitZ();
  const PairRow one = row_between({3, 5, 0, 0}, {1, -1, 0, 0}, 2, up, up);
  std::vector<PairRow> rows(5, one);
  rows[1].friction = 0.2;
  rows[2].is_blocked = true;
  rows[3].is_done = true;
  rows[4].by_rate = true;
  rows.push_back(row_between({3, 0, 0, 0}, {1, 0, 0, 0}, 1, up, up));
  rows.push_back(rows.back());
  CHECK(join_same(rows) == 0);
  for (const PairRow& row : rows) CHECK(row.impulse == up);
}
