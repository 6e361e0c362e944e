#include "learning/touching_cluster.hpp"

#include <algorithm>
#include <utility>

#include <springnet/sdk/host.hpp>

#include "constraints/vectors.hpp"
#include "learning/at_scope_end.hpp"
#include "learning/rod_lengths.hpp"
#include "learning/settled_difference.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The sweep settles to 1e-13 of the connections' length: differences over steps of this share of it are good to some
// 1e-8.
constexpr double step_share = 2e-5;
// A time in which all moves by that, or at most this share of a step that is short.
constexpr double part_of_step = 0.1;

class Sweep {
 public:
  Sweep(Model& model, std::size_t cluster, const std::shared_ptr<const Placement>& start, const StepPlacement& step,
        double until, const std::vector<StepContact>& contacts)
      : model_(model), cluster_(cluster), start_(start), step_(step), until_(until), contacts_(contacts) {
    for (std::vector<double>& each : arrays_) each.resize(3 * model.node_count());
  }

  struct Input {
    VectorXd p, v, free, mobility;
    double from = 0.0, until = 0.0;  // s, by how much later the step begins and ends
  };
  struct Output {
    VectorXd both;  // (P, U)
    std::vector<Touch> touches;
  };
  [[nodiscard]] std::optional<Output> operator()(const std::vector<std::uint32_t>& nodes, const Input& input) {
    const Contact& contact = model_.contact;
    const double h = step_.h + input.until - input.from;
    const std::shared_ptr<const Placement> start = start_of(input);
    const std::shared_ptr<const Placement> other_end =
        input.until == 0.0 ? nullptr : contact.at(just_before(until_ + input.until, h));
    begin(nodes, input, start);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto at = static_cast<Index>(3 * i);
      const Vector3 p = input.p.segment<3>(at), v = input.v.segment<3>(at), free = input.free.segment<3>(at);
      put(0, nodes[i], p);
      put(1, nodes[i], v);
      put(2, nodes[i], p + h * ((1.0 - step_.theta) * v + step_.theta * free));
      put(3, nodes[i], free);
    }
    auto sweep = sdk::sized<springnet_sweep>();
    sweep.time = until_ + input.until;
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
    if (model_.rigid.constrain(other_end ? *other_end : step_.end, cluster_, sweep, message) != SPRINGNET_OK)
      return std::nullopt;
    Output output;
    output.both.resize(static_cast<Index>(6 * nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      output.both.segment<3>(static_cast<Index>(3 * i)) = vector_at(vectors(2), nodes[i]);
      output.both.segment<3>(static_cast<Index>(3 * (nodes.size() + i))) = vector_at(vectors(3), nodes[i]);
      output.touches.push_back(model_.contact.now(nodes[i]));
    }
    return output;
  }
  // Of surfaces where the step begins.
  [[nodiscard]] std::shared_ptr<const Placement> start_of(const Input& input) const {
    return input.from == 0.0 ? start_ : model_.contact.at(just_after(until_ - step_.h + input.from));
  }

 private:
  // Contacts as they were committed at the start.
  void begin(const std::vector<std::uint32_t>& nodes, const Input& input,
             const std::shared_ptr<const Placement>& start) {
    Contact& contact = model_.contact;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::uint32_t k = nodes[i];
      const auto own =
          std::find_if(contacts_.begin(), contacts_.end(), [k](const StepContact& each) { return each.node == k; });
      const Touch before = own == contacts_.end() ? Touch{} : own->before;
      contact.touch(k, before, Vector3::Zero());
      if (before.surface < 0 || !before.slides) continue;
      const auto at = static_cast<Index>(3 * i);
      const Vector3 slip = contact.slip_vector(*start, k, static_cast<std::size_t>(before.surface),
                                               input.p.segment<3>(at), input.v.segment<3>(at));
      contact.set_slip(k, slip.norm() > 0.0 ? Vector3(slip.normalized()) : Vector3(Vector3::Zero()));
    }
    contact.begin_step(start);
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

}  // namespace

std::optional<ClusterDerivative> output_differences(Model& model, std::size_t cluster,
                                                    const std::shared_ptr<const Placement>& start,
                                                    const StepPlacement& step, double until,
                                                    const std::vector<StepContact>& contacts,
                                                    const ClusterOverStep& given) {
  Sweep sweep(model, cluster, start, step, until, contacts);
  const Sweep::Input input{given.p, given.v, given.free, given.mobility};
  const std::optional<Sweep::Output> base = sweep(given.nodes, input);
  const Index size = given.p.size(), nodes = given.mobility.size();
  // As where there are no surfaces: steps have settled to the tolerance of the integrator only.
  constexpr double tolerance = 1e-4, rounding = 1e-9;
  const double speed = given.v.norm() + given.U.norm() + (given.free - given.v).norm();
  if (!base || !((base->both.tail(size) - given.U).norm() <= tolerance * speed) ||
      !((base->both.head(size) - given.P).norm() <= tolerance * step.h * speed + rounding * given.P.norm()))
    return std::nullopt;
  double length = 0.0;
  for (const ClusterRod& rod : given.rods) length = std::max(length, rod.length);

  // change(input, h): moves it along what the column is by.
  const auto fill = [&](const auto& change, double h, double typical, auto&& column) {
    const auto at = [&](double way) -> std::optional<VectorXd> {
      Sweep::Input other = input;
      change(other, way);
      std::optional<Sweep::Output> found = sweep(given.nodes, other);
      if (!found || found->touches != base->touches) return std::nullopt;
      return std::move(found->both);
    };
    const std::optional<VectorXd> found = settled_difference(at, base->both, h, typical);
    if (found) column = *found;
    return found.has_value();
  };
  // With the connections' lengths, and nodes on the surfaces that they touch where the step begins: what is left of a
  // gap would be closed at its length over that of the step.
  const auto allow = [&](Sweep::Input& to) {
    const std::shared_ptr<const Placement> placed = sweep.start_of(to);
    std::vector<ClusterGap> on;
    for (const StepContact& each : contacts)
      for (const std::int32_t surface : each.before.surfaces()) {
        if (surface < 0) continue;
        const auto j = static_cast<std::size_t>(surface);
        const auto node = std::find(given.nodes.begin(), given.nodes.end(), each.node) - given.nodes.begin();
        on.push_back({node, [&model, placed, j](const Vector3& at) { return model.contact.gap(*placed, j, at); },
                      [&model, placed, j](const Vector3& at) { return model.contact.normal(*placed, j, at); }});
      }
    to.p = with_lengths(given.rods, given.mobility, std::move(to.p), on);
  };
  ClusterDerivative result{MatrixXd::Zero(2 * size, 3 * size), MatrixXd::Zero(2 * size, nodes), {}};
  const double way = step_share * length;
  const double rate = speed > 0.0 ? std::min(way / step.h, step_share * speed) : way / step.h;
  const double time = std::min(part_of_step * step.h, way / std::max(speed, way / step.h));  // s
  for (Index k = 0; k < size; ++k) {
    if (!(given.mobility[k / 3] > 0.0)) continue;  // nothing of nodes whose motion is given changes
    const auto place = [&](Sweep::Input& to, double h) {
      to.p[k] += h;
      allow(to);
    };
    if (!fill(place, way, 1.0, result.by_state.col(k)) ||
        !fill([k](Sweep::Input& to, double h) { to.v[k] += h; }, rate, 1.0, result.by_state.col(size + k)) ||
        !fill([k](Sweep::Input& to, double h) { to.free[k] += h; }, rate, 1.0, result.by_state.col(2 * size + k)))
      return std::nullopt;
  }
  for (Index i = 0; i < nodes; ++i)
    if (const double own = given.mobility[i];
        own > 0.0 && !fill([i](Sweep::Input& to, double h) { to.mobility[i] += h; }, step_share * own, speed / own,
                           result.by_mobility.col(i)))
      return std::nullopt;
  if (!given.timed) return result;
  result.by_times.setZero(2 * size, 2);
  const auto later_start = [&](Sweep::Input& to, double h) {
    to.from += h;
    allow(to);
  };
  if (!fill(later_start, time, speed, result.by_times.col(0)) ||
      !fill([](Sweep::Input& to, double h) { to.until += h; }, time, speed, result.by_times.col(1)))
    result.by_times.resize(0, 0);
  return result;
}

}  // namespace springnet::learning
