#include "learning/touching_cluster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <springnet/sdk/host.hpp>

#include "constraints/least_squares.hpp"
#include "constraints/vectors.hpp"
#include "learning/at_scope_end.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The sweep settles to 1e-13 of the connections' length: differences over steps of this share of it are good to some
// 1e-8.
constexpr double step_share = 2e-5;
// Steps are divided by this as long as contacts change within them, or a rebound begins: half of the step has another
// derivative then.
constexpr double finer = 4.0;
constexpr int most_finer = 5;
constexpr double same = 1e-6;

class Sweep {
 public:
  Sweep(Model& model, std::size_t cluster, const std::shared_ptr<const Placement>& start, const StepPlacement& step,
        double until, const std::vector<StepContact>& contacts)
      : model_(model), cluster_(cluster), start_(start), step_(step), until_(until), contacts_(contacts) {
    for (std::vector<double>& each : arrays_) each.resize(3 * model.node_count());
  }

  struct Input {
    VectorXd p, v, free, mobility, length;  // length: one number, s, of the step
  };
  struct Output {
    VectorXd both;  // (P, U)
    std::vector<Touch> touches;
  };
  [[nodiscard]] std::optional<Output> operator()(const std::vector<std::uint32_t>& nodes, const Input& input) {
    begin(nodes, input);
    const double h = input.length[0];
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto at = static_cast<Index>(3 * i);
      const Vector3 p = input.p.segment<3>(at), v = input.v.segment<3>(at), free = input.free.segment<3>(at);
      put(0, nodes[i], p);
      put(1, nodes[i], v);
      put(2, nodes[i], p + h * ((1.0 - step_.theta) * v + step_.theta * free));
      put(3, nodes[i], free);
    }
    auto sweep = sdk::sized<springnet_sweep>();
    sweep.time = until_;
    sweep.start_position = read_only(vectors(0));
    sweep.start_velocity = read_only(vectors(1));
    sweep.next_position = vectors(2);
    sweep.next_velocity = vectors(3);
    sweep.time_constant = h;
    sweep.theta = step_.theta;
    sweep.contacts = contacts_.front().kept ? 1 : 0;
    std::vector<double> masses;
    for (const std::uint32_t node : nodes) masses.push_back(model_.mass[node]);
    const AtScopeEnd put_back([&] {
      for (std::size_t i = 0; i < nodes.size(); ++i) model_.mass[nodes[i]] = masses[i];
    });
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (const double w = input.mobility[static_cast<Index>(i)]; w > 0.0) model_.mass[nodes[i]] = 1.0 / w;
    springnet_message message{};
    if (model_.rigid.constrain(step_.end, cluster_, sweep, message) != SPRINGNET_OK) return std::nullopt;
    Output output;
    output.both.resize(static_cast<Index>(6 * nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      output.both.segment<3>(static_cast<Index>(3 * i)) = vector_at(vectors(2), nodes[i]);
      output.both.segment<3>(static_cast<Index>(3 * (nodes.size() + i))) = vector_at(vectors(3), nodes[i]);
      output.touches.push_back(model_.contact.now(nodes[i]));
    }
    return output;
  }

 private:
  // Contacts as they were committed at the start.
  void begin(const std::vector<std::uint32_t>& nodes, const Input& input) {
    Contact& contact = model_.contact;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::uint32_t k = nodes[i];
      const auto own =
          std::find_if(contacts_.begin(), contacts_.end(), [k](const StepContact& each) { return each.node == k; });
      const Touch before = own == contacts_.end() ? Touch{} : own->before;
      contact.touch(k, before, Vector3::Zero());
      if (before.surface < 0 || !before.slides) continue;
      const auto at = static_cast<Index>(3 * i);
      const Vector3 slip = contact.slip_vector(*start_, k, static_cast<std::size_t>(before.surface),
                                               input.p.segment<3>(at), input.v.segment<3>(at));
      contact.set_slip(k, slip.norm() > 0.0 ? Vector3(slip.normalized()) : Vector3(Vector3::Zero()));
    }
    contact.begin_step(start_);
  }
  void put(std::size_t array, std::uint32_t node, const Vector3& value) { put_vector(vectors(array), node, value); }
  [[nodiscard]] springnet_vectors vectors(std::size_t array) {
    double* const first = arrays_[array].data();
    const std::size_t n = model_.node_count();
    return {first, first + n, first + 2 * n};
  }

  Model& model_;
  std::size_t cluster_;
  const std::shared_ptr<const Placement>& start_;
  const StepPlacement& step_;
  double until_;
  const std::vector<StepContact>& contacts_;
  std::vector<double> arrays_[4];
};

// The nearest positions with the rods' lengths. Those that stick are carried as they are: with other lengths no step
// would begin.
VectorXd with_lengths(const ClusterOverStep& cluster, VectorXd place) {
  const auto rods = static_cast<Index>(cluster.rods.size());
  constexpr int most = 10;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most; ++i) {
    MatrixXd rows = MatrixXd::Zero(rods, place.size());
    VectorXd gap(rods);
    for (Index r = 0; r < rods; ++r) {
      const ClusterOverStep::Rod& rod = cluster.rods[static_cast<std::size_t>(r)];
      const Vector3 way = place.segment<3>(3 * rod.first) - place.segment<3>(3 * rod.second);
      gap[r] = way.norm() - rod.length;
      for (const auto& [node, sign] : {std::pair(rod.first, 1.0), std::pair(rod.second, -1.0)})
        if (cluster.mobility[node] > 0.0) rows.block<1, 3>(r, 3 * node) = sign * way.normalized().transpose();
    }
    const double worst = gap.cwiseAbs().maxCoeff();
    if (worst >= 0.5 * last) break;  // only rounding is left
    last = worst;
    place -= least_squares(rows, gap);
  }
  return place;
}

}  // namespace

std::optional<ClusterDerivative> output_differences(Model& model, std::size_t cluster,
                                                    const std::shared_ptr<const Placement>& start,
                                                    const StepPlacement& step, double until,
                                                    const std::vector<StepContact>& contacts,
                                                    const ClusterOverStep& given) {
  Sweep sweep(model, cluster, start, step, until, contacts);
  const Sweep::Input input{given.p, given.v, given.free, given.mobility, VectorXd::Constant(1, step.h)};
  const std::optional<Sweep::Output> base = sweep(given.nodes, input);
  const Index size = given.p.size(), nodes = given.mobility.size();
  // As where there are no surfaces: steps have settled to the tolerance of the integrator only.
  constexpr double tolerance = 1e-4, rounding = 1e-9;
  const double speed = given.v.norm() + given.U.norm() + (given.free - given.v).norm();
  if (!base || !((base->both.tail(size) - given.U).norm() <= tolerance * speed) ||
      !((base->both.head(size) - given.P).norm() <= tolerance * step.h * speed + rounding * given.P.norm()))
    return std::nullopt;
  double length = 0.0;
  for (const ClusterOverStep::Rod& rod : given.rods) length = std::max(length, rod.length);

  // By one number of the input.
  const auto difference = [&](VectorXd Sweep::Input::*part, Index place, double h) -> std::optional<VectorXd> {
    VectorXd ends[2];
    for (const int side : {0, 1}) {
      Sweep::Input other = input;
      (other.*part)[place] += side == 0 ? h : -h;
      if (part == &Sweep::Input::p) other.p = with_lengths(given, std::move(other.p));
      std::optional<Sweep::Output> found = sweep(given.nodes, other);
      if (!found || found->touches != base->touches) return std::nullopt;
      ends[side] = std::move(found->both);
    }
    return (ends[0] - ends[1]) / (2.0 * h);
  };
  // typical: size of such derivatives; those that are much smaller are rounding.
  const auto fill = [&](VectorXd Sweep::Input::*part, Index place, double h, double typical, auto&& column) {
    std::optional<VectorXd> found = difference(part, place, h);
    for (int i = 0; i < most_finer; ++i) {
      std::optional<VectorXd> next = difference(part, place, h /= finer);
      if (found && next && (*found - *next).norm() <= same * std::max(typical, found->norm())) {
        column = *found;
        return true;
      }
      found = std::move(next);
    }
    return false;
  };
  ClusterDerivative result{MatrixXd::Zero(2 * size, 3 * size), MatrixXd::Zero(2 * size, nodes), {}};
  const double way = step_share * length, rate = way / step.h;
  for (Index k = 0; k < size; ++k) {
    if (!(given.mobility[k / 3] > 0.0)) continue;  // nothing of nodes whose motion is given changes
    if (!fill(&Sweep::Input::p, k, way, 1.0, result.by_state.col(k)) ||
        !fill(&Sweep::Input::v, k, rate, 1.0, result.by_state.col(size + k)) ||
        !fill(&Sweep::Input::free, k, rate, 1.0, result.by_state.col(2 * size + k)))
      return std::nullopt;
  }
  for (Index i = 0; i < nodes; ++i)
    if (const double own = given.mobility[i];
        own > 0.0 && !fill(&Sweep::Input::mobility, i, step_share * own, speed / own, result.by_mobility.col(i)))
      return std::nullopt;
  // Where surfaces move they would be elsewhere at the end of a longer step.
  const std::vector<Obstacle>& surfaces = model.contact.obstacles();
  if (std::none_of(surfaces.begin(), surfaces.end(), [](const Obstacle& each) { return each.moves(); })) {
    result.by_length.setZero(2 * size);
    if (!fill(&Sweep::Input::length, 0, step_share * step.h, speed, result.by_length)) result.by_length.resize(0);
  }
  return result;
}

}  // namespace springnet::learning
