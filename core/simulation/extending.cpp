// Simulation::extend(): a new engine of a network to which something was added, which goes on where the one before was.
#include <springnet/simulation.hpp>

#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "network/spacing.hpp"
#include "simulation/implementation.hpp"

namespace springnet {
namespace {

[[noreturn]] void refuse_extension(const std::string& what) {
  throw Error(ErrorKind::input, fmt::format("extend: {}; it may only add", what));
}

template <class List, class Same>
void check_list(const List& before, const List& now, const char* what, const Same& same) {
  if (now.size() < before.size())
    refuse_extension(fmt::format("there are {} {} in place of {}", now.size(), what, before.size()));
  for (std::size_t i = 0; i < before.size(); ++i)
    if (!same(before[i], now[i])) refuse_extension(fmt::format("number {} of the {} was changed", i, what));
}

// What is there has to stay as it is. (A motion of a node fixes it.)
void check_only_added(const Network& before, const Network& now) {
  check_list(before.nodes(), now.nodes(), "nodes", [](const Node& a, const Node& b) {
    return a.position == b.position && a.mass == b.mass && a.neuron == b.neuron &&
           (a.fixed == b.fixed ? a.velocity == b.velocity : b.fixed);
  });
  for (std::size_t k = 0; k < before.nodes().size(); ++k) {
    if (before.nodes()[k].fixed == now.nodes()[k].fixed) continue;
    bool moves = false;
    for (std::size_t m = before.moves().size(); m < now.moves().size(); ++m)
      for (const NodeIndex node : now.moves()[m].nodes) moves = moves || node == k;
    if (!moves) refuse_extension(fmt::format("node {} was fixed: use set_fixed of the simulation", k));
  }
  check_list(before.springs(), now.springs(), "springs", [](const Spring& a, const Spring& b) {
    return a.first == b.first && a.second == b.second && a.material == b.material && a.rest_length == b.rest_length;
  });
  check_list(before.elements(), now.elements(), "elements", [](const Element& a, const Element& b) {
    return a.invariant == b.invariant && a.nodes == b.nodes && a.material == b.material && a.reference == b.reference &&
           a.rest == b.rest && a.direction == b.direction;
  });
  const auto any = [](const auto&, const auto&) { return true; };  // nothing of Network changes these
  check_list(before.faces(), now.faces(), "faces", any);
  check_list(before.bodies(), now.bodies(), "bodies",
             [](const Body& a, const Body& b) { return a.thickness == b.thickness && a.radius == b.radius; });
  check_list(before.loads(), now.loads(), "loads", any);
  check_list(before.planes(), now.planes(), "planes", any);
  check_list(before.instruments(), now.instruments(), "instruments", any);
  check_list(before.contacts(), now.contacts(), "contacts of bodies", any);
  check_list(before.moves(), now.moves(), "motions", any);
  check_list(before.rigids(), now.rigids(), "rigid connections", any);
  check_list(before.cuts(), now.cuts(), "cuts", any);
  check_list(before.changes(), now.changes(), "changes", any);
  check_list(before.inputs(), now.inputs(), "inputs", any);
  if (before.gravity() != now.gravity()) refuse_extension("gravity was changed: use set_gravity of the simulation");
}

// The nodes where they are now.
Network present(const Network& network, const Model& model) {
  Network now = network;
  std::vector<Vector3> positions;
  const std::vector<std::uint32_t>& engine = model.layout.ordering().engine;
  for (NodeIndex k = 0; k < network.nodes().size(); ++k)
    positions.push_back(vector_at(model.state.view.position, engine[k]));
  now.move_nodes(positions);
  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    Node node = now.nodes()[k];
    node.velocity = vector_at(model.state.view.velocity, engine[k]);
    node.mass = model.mass[engine[k]];
    now.set_node(k, node);
  }
  return now;
}

}  // namespace

Simulation::Impl::Impl(std::shared_ptr<const Network> extended, const Impl& before)
    : network(std::move(extended)),
      plugins(before.plugins),
      options(before.options),
      component(before.component),
      engine(*network, *plugins, options, &before.engine),
      host(make_host_table(engine)),
      first_integrator(before.first_integrator),
      last(before.last),
      steps(before.steps),
      sweeps(before.sweeps),
      grid_start(before.grid_start),
      grid_steps(before.grid_steps) {
  create_integrator();
  exchange_due();
}

void Simulation::extend(const std::function<void(Network&)>& add) {
  Impl& impl = impl_->between_steps();
  auto next = std::make_shared<Network>(present(*impl.network, impl.engine.model()));
  const Network before = *next;
  {
    struct Guard {
      bool& in_step;
      ~Guard() { in_step = false; }
    } const guard{impl.in_step};
    impl.in_step = true;  // what it adds to must not go on meanwhile
    add(*next);
  }
  check_only_added(before, *next);
  check_spacing(*next, {before.springs().size(), before.elements().size(), before.rigids().size()});
  auto extended = std::make_unique<Impl>(std::move(next), impl);
  extended->watchers.take_over(impl.watchers);
  extended->engine.model().deadline.share(impl.engine.model().deadline.flag());
  impl_ = std::move(extended);
  impl_->changed();
}

}  // namespace springnet
