// Order, record times and error norms, from made-up data whose answers are known.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/validation.hpp>

#include "validation/displacement.hpp"
#include "validation/error_norm.hpp"

using namespace springnet;

TEST_CASE("the order of errors C t^p is p") {
  for (const double p : {0.5, 1.0, 2.0, 3.7}) {
    std::vector<double> time_steps, errors;
    for (const double t : {0.1, 0.05, 0.02, 0.001}) {
      time_steps.push_back(t);
      errors.push_back(17.0 * std::pow(t, p));
    }
    // Exact but for the rounding of powers and logarithms.
    CHECK(observed_order(time_steps, errors) == doctest::Approx(p).epsilon(1e-12));
  }
}

TEST_CASE("the order is the slope by least squares") {
  // Logarithms to base 10: (0, 0), (1, 3), (2, 0), (3, 3): slope 0.6.
  CHECK(observed_order({1.0, 10.0, 100.0, 1000.0}, {1.0, 1000.0, 1.0, 1000.0}) == doctest::Approx(0.6).epsilon(1e-12));
}

TEST_CASE("errors at or below the floor, zero or not finite do not count for the order") {
  CHECK(observed_order({0.1, 0.01, 0.001}, {1e-2, 1e-3, 5e-4}, 6e-4) == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(observed_order({0.1, 0.01, 0.001}, {1e-2, 1e-3, 0.0}) == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(observed_order({0.1, 0.01, 0.001}, {1e-2, 1e-3, NAN}) == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(observed_order({0.1, 0.01, 0.001}, {INFINITY, 1e-2, 1e-3}) == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("there is no order with fewer than two points") {
  CHECK(std::isnan(observed_order({}, {})));
  CHECK(std::isnan(observed_order({0.1}, {1.0})));
  CHECK(std::isnan(observed_order({0.1, 0.1}, {1.0, 2.0})));
  CHECK(std::isnan(observed_order({0.1, 0.01}, {1.0, 0.1}, 0.5)));
}

TEST_CASE("record times are multiples of the coarsest time step") {
  const RecordTimes records = common_record_times(1.0, 0.0, {0.1, 0.05, 0.025});
  REQUIRE(records.times.size() == 11);
  CHECK(records.times.front() == 0.0);
  CHECK(records.times[3] == doctest::Approx(0.3));
  CHECK(records.times.back() == 1.0);
  CHECK(records.shortened_time_steps.empty());
}

TEST_CASE("the wanted interval is rounded to the coarsest time step") {
  CHECK(common_record_times(1.0, 0.27, {0.1, 0.05}).times[1] == doctest::Approx(0.3));
  CHECK(common_record_times(1.0, 0.01, {0.1, 0.05}).times[1] == doctest::Approx(0.1));
}

TEST_CASE("time steps that do not divide one another meet at a common multiple") {
  const RecordTimes records = common_record_times(2.0, 0.0, {0.05, 0.02});
  CHECK(records.times[1] == doctest::Approx(0.1));
  CHECK(records.shortened_time_steps.empty());
}

TEST_CASE("time steps without a common multiple are named") {
  const RecordTimes records = common_record_times(2.0, 0.0, {0.1, 0.1 / std::sqrt(2.0)});
  CHECK(records.times[1] == doctest::Approx(0.1));
  REQUIRE(records.shortened_time_steps.size() == 1);
  CHECK(records.shortened_time_steps[0] == doctest::Approx(0.1 / std::sqrt(2.0)));
}

TEST_CASE("the end is a record time, whole steps or not") {
  const RecordTimes records = common_record_times(0.25, 0.0, {0.1});
  REQUIRE(records.times.size() == 4);
  CHECK(records.times[2] == doctest::Approx(0.2));
  CHECK(records.times[3] == 0.25);
}

TEST_CASE("time steps that cannot be used are refused") {
  for (const double bad : {0.0, -0.1, 2.0, static_cast<double>(NAN)}) {
    CHECK_THROWS_AS(static_cast<void>(common_record_times(1.0, 0.0, {0.1, bad})), Error);
  }
}

namespace {

using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

ConstNodeMap map_of(const Rows& rows) { return {rows.data(), 3, rows.cols(), Eigen::OuterStride<>(rows.cols())}; }

}  // namespace

TEST_CASE("errors are distances between nodes with the same number") {
  // Two nodes; the runs store them in opposite orders.
  Rows reference(3, 2), run(3, 2);
  reference << 0.0, 1.0,  //
      0.0, 1.0,           //
      0.0, 1.0;
  run << 1.0, 3.0,  //
      1.0, 4.0,     //
      1.0, 0.0;
  ErrorNorm norm;
  norm.add(0.0, map_of(reference), {0, 1}, map_of(reference), {0, 1});
  norm.add(0.5, map_of(run), {1, 0}, map_of(reference), {0, 1});  // node 0: (3, 4, 0) from (0, 0, 0); node 1: no error
  norm.add(1.0, map_of(reference), {0, 1}, map_of(reference), {0, 1});
  const PositionError error = norm.result();
  CHECK(error.max == doctest::Approx(5.0));
  CHECK(error.node == 0);
  CHECK(error.time == 0.5);
  // 25 m^2 over two nodes at two times; the start does not count.
  CHECK(error.rms == doctest::Approx(2.5));
  REQUIRE(error.max_by_time.size() == 3);
  CHECK(error.max_by_time[0] == 0.0);
  CHECK(error.max_by_time[1] == doctest::Approx(5.0));
  CHECK(error.max_by_time[2] == 0.0);
}

TEST_CASE("displacements are from the start, deformations from the best rigid motion of each body") {
  // A right angle, and a single node of no body.
  Network net;
  net.begin_body("angle");
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)}) {
    net.add_node({place, Vector3::Zero(), 1.0, 0, false});
  }
  net.end_body();
  net.add_node({Vector3(5, 5, 5), Vector3::Zero(), 1.0, 0, false});
  DisplacementNorm norm(net);
  // Turned by a right angle about z, and moved by 10 along x; the columns are in another order.
  Rows now(3, 4);
  now.row(0) << 5.0, 10.0, 10.0, 9.0;
  now.row(1) << 5.0, 0.0, 1.0, 0.0;
  now.row(2) << 5.0, 0.0, 0.0, 0.0;
  norm.add(1.0, map_of(now), {1, 2, 3, 0});
  CHECK(norm.result().max == doctest::Approx(10.0));
  CHECK(norm.result().node == 0);
  CHECK(norm.result().time == 1.0);
  CHECK(norm.result().deformation < 1e-14);
  // Its mirror image is no motion as a whole: node 2 on the other side.
  now.row(1)[3] = 0.0;
  now.row(0)[3] = 11.0;
  norm.add(2.0, map_of(now), {1, 2, 3, 0});
  CHECK(norm.result().max == doctest::Approx(std::hypot(11.0, 1.0)));
  // A plane figure turns over instead.
  CHECK(norm.result().deformation < 1e-14);
  now.row(0)[3] = 12.0;
  norm.add(3.0, map_of(now), {1, 2, 3, 0});
  CHECK(norm.result().deformation > 0.3);
}

TEST_CASE("the mirror image of a solid figure is a deformation") {
  Network net;
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 2, 0), Vector3(0, 0, 3)}) {
    net.add_node({place, Vector3::Zero(), 1.0, 0, false});
  }
  Rows turned(3, 4), mirrored(3, 4);
  turned << 0.0, -1.0, 0.0, 0.0,  // by half a turn about z
      0.0, 0.0, -2.0, 0.0,        //
      0.0, 0.0, 0.0, 3.0;
  mirrored = turned;
  mirrored.row(2) *= -1.0;
  DisplacementNorm rigid(net), norm(net);
  rigid.add(1.0, map_of(turned), {0, 1, 2, 3});
  CHECK(rigid.result().deformation < 1e-14);
  norm.add(1.0, map_of(mirrored), {0, 1, 2, 3});
  CHECK(norm.result().deformation > 0.3);
}

TEST_CASE("nan in a position is not hidden by others") {
  Rows reference = Rows::Zero(3, 2), run = Rows::Zero(3, 2);
  run(1, 0) = NAN;
  run(0, 1) = 7.0;
  ErrorNorm norm;
  norm.add(1.0, map_of(run), {0, 1}, map_of(reference), {0, 1});
  CHECK(std::isnan(norm.result().max));
  CHECK(norm.result().node == 0);
  CHECK(std::isnan(norm.result().rms));
}
