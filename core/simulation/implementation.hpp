// What a simulation consists of, for the sources of Simulation's functions.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "network/checks.hpp"
#include "plugin_host/call.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"
#include "simulation/identity.hpp"
#include "simulation/torn_faces.hpp"
#include "simulation/watchers.hpp"

namespace springnet {

struct SavedHead;

struct Simulation::Impl {
  Impl(std::shared_ptr<const Network> given_network, std::shared_ptr<const PluginHost> plugin_host,
       const SimulationOptions& given)
      : network(std::move(given_network)),
        plugins(std::move(plugin_host)),
        options(given),
        component(plugins->require(ComponentKind::integrator, given.integrator.id)),
        engine(*network, *plugins, given),
        host(make_host_table(engine)),
        first_integrator(given.integrator) {
    create_integrator();
    exchange_due();
  }
  // A copy that is to go on by itself: see clone.cpp. state: of `other`.
  Impl(Impl& other, std::string_view state);
  // Goes on from `before` with a network to which something was added.
  Impl(std::shared_ptr<const Network> extended, const Impl& before);
  ~Impl() { destroy_integrator(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // How a call of the integrator ended. `broken`: it violated plugin.h.
  struct Ending {
    springnet_status status = SPRINGNET_FAILED;
    bool broken = false;
    std::string text;  // why, unless the status is OK
    // Only the text of an exception crosses the C ABI.
    [[nodiscard]] bool out_of_memory() const {
      return status != SPRINGNET_OK && (text == std::bad_alloc().what() || text == "out of memory");
    }
  };
  template <class Function>
  Ending call(const Function& function);
  // For steps and changes, which laws and integrators must not ask for while they are called.
  Impl& between_steps() {
    if (in_step)
      throw Error(
          ErrorKind::input,
          "a simulation cannot be stepped or changed within its own step, by a law, neuron or integrator: do it "
          "between two steps");
    if (watchers.are_called)
      throw Error(ErrorKind::input,
                  "a simulation cannot be stepped or changed by its own callbacks of events and steps: they may read "
                  "it, and note what is to be done after the call of step() or advance_to()");
    ++state_version;
    return *this;
  }
  // For what leaves the state as it is, which callbacks may ask for too.
  Impl& outside_of_steps() { return in_step ? between_steps() : *this; }
  // To be called when a change of positions, velocities, springs or elements is complete, and after each step: keeps a
  // snapshot, and tells the callbacks, which may throw.
  void changed();
  void stepped();
  void publish();
  [[nodiscard]] std::string broken_by(std::string_view what) const {
    return fmt::format("{}: {}", full_name_with_file(*component), what);
  }
  void create_integrator();
  void destroy_integrator() noexcept;
  // Goes on with another integrator, as at the start; what was kept of the present one is lost.
  void exchange(const LawUse& next);
  // The scene's exchanges up to now.
  void exchange_due();
  void drop_history();
  [[nodiscard]] std::string integrator_memory();
  void set_integrator_memory(std::string_view memory);
  [[nodiscard]] std::optional<Simulation::Between> between(double time);
  void archive(Archive& archive);
  // Saved states: see saving.cpp. state(): what archive() writes, and the integrator's memory; take_up() reads it.
  [[nodiscard]] std::string state();
  void take_up(std::string_view bytes);
  void settle_history(std::string_view memory);
  [[nodiscard]] const Identity& network_identity();
  [[nodiscard]] Identity present_identity();
  void check_identity(const SavedHead& head, std::string_view bytes);
  void restore_state(const SavedHead& head, std::string_view bytes);
  void lay_out_changes();
  // The model for a change of the committed state, which is then not where the last step ended.
  Model& changed_state() {
    Model& model = between_steps().engine.model();
    state_is_of_step = false;
    return model;
  }
  void require_abilities() const;
  void advance(double until);  // with the scene's exchanges of the integrator
  // The same for a step of the program, after which the callbacks are told.
  template <class Finish>
  void make_step(double until, const Finish& finish) {
    try {
      advance(until);
    } catch (...) {
      changed();  // events until then have happened
      throw;
    }
    finish();
    stepped();
  }
  void advance_to(double until, const std::function<bool()>* go_on);
  void advance_part(double until);  // with one integrator
  void archive_integrator(Archive& archive);
  [[nodiscard]] std::uint32_t engine_node(NodeIndex node) const {
    if (node >= engine.model().layout.node_count())
      throw Error(ErrorKind::input, fmt::format("node {} does not exist: the network has nodes 0 to {}", node,
                                                std::int64_t{engine.model().layout.node_count()} - 1));
    return engine.model().layout.ordering().engine[node];
  }
  const layers::CompiledLaws::SignalInput& input(InputIndex number) const {
    const auto& inputs = engine.model().layout.laws().inputs;
    if (number >= inputs.size())
      throw Error(ErrorKind::input,
                  fmt::format("input signal {} does not exist: the network has {}", number, inputs.size()));
    return inputs[number];
  }
  void check_spring(SpringIndex spring) const {
    if (spring >= engine.model().layout.spring_count())
      throw Error(ErrorKind::input, fmt::format("spring {} does not exist: the network has springs 0 to {}", spring,
                                                static_cast<std::int64_t>(engine.model().layout.spring_count()) - 1));
  }
  // Of the element of a group at this place.
  [[nodiscard]] std::vector<double> internal_states(std::size_t group, std::uint32_t place) const {
    const layers::Layout& layout = engine.model().layout;
    const layers::InternalLayout::OfGroup& own = layout.internal().group(group);
    std::vector<double> states;
    for (std::size_t j = 0; j < layout.laws().groups[group].state_count(); ++j)
      states.push_back(engine.model().state.view.internal[own.first + j * own.count + place]);
    return states;
  }
  void check_element(ElementIndex element) const {
    if (element >= engine.model().layout.elements().count())
      throw Error(ErrorKind::input, fmt::format("element {} does not exist: the network has {} elements", element,
                                                engine.model().layout.elements().count()));
  }
  void check_surface_index(std::size_t surface) const {
    if (surface >= engine.model().contact.obstacles().size())
      throw Error(ErrorKind::input, fmt::format("surface {} does not exist: the network has {} planes and instruments",
                                                surface, engine.model().contact.obstacles().size()));
  }
  void check_arrival(const Vector3& position, double until) const {
    if (!position.allFinite() || !std::isfinite(until) || !(until > engine.model().time))
      throw Error(ErrorKind::input,
                  fmt::format("a motion to ({}, {}, {}) that ends at {}: the position must be finite, and the time "
                              "after {}, which is now",
                              position[0], position[1], position[2], checks::seconds(until),
                              checks::seconds(engine.model().time)));
  }
  // Of a local force model, s.
  [[nodiscard]] double local_time(double over) const {
    constexpr double longest = 1e100;  // s
    if (!(over >= 0.0 && over <= longest))
      throw Error(ErrorKind::input, fmt::format("local force model: over must be 0 (the time step) to 1e100 s, is {}",
                                                checks::seconds(over)));
    return over > 0.0 ? over : options.time_step;
  }
  [[nodiscard]] const Obstacle& surface(std::size_t index) const {
    check_surface_index(index);
    return engine.model().contact.obstacles()[index];
  }
  // At the present time.
  [[nodiscard]] Pose pose(std::size_t index) const { return surface(index).at(engine.model().now()); }
  template <class Visit>
  void for_each_touching(std::size_t index, Visit visit) const {
    check_surface_index(index);
    for (std::uint32_t k = 0; k < engine.model().layout.node_count(); ++k)
      if (engine.model().contact.committed(k).has(static_cast<std::int32_t>(index))) visit(k);
  }
  [[nodiscard]] ConstNodeMap map(const springnet_vectors& v) const {
    const std::uint32_t n = engine.model().layout.node_count();
    return {v.x, 3, static_cast<Eigen::Index>(n), Eigen::OuterStride<>(static_cast<Eigen::Index>(pitch_of(n)))};
  }

  std::shared_ptr<const Network> network;  // as it was given
  std::shared_ptr<const PluginHost> plugins;
  SimulationOptions options;
  std::shared_ptr<const Component> component;
  mutable Engine engine;  // evaluates forces on demand
  springnet_host host;
  void* integrator = nullptr;
  LawUse first_integrator;  // of the options given
  StepReport last;
  std::uint64_t steps = 0, sweeps = 0;
  bool in_step = false;           // a call of the integrator
  bool state_is_of_step = false;  // the committed state is where the last step ended: nobody has changed it since
  // Of the network as it was given; null: nobody has asked for it yet. Clones share it.
  std::shared_ptr<const Identity> identity;
  std::shared_ptr<const Network> identity_of_network;
  // The next step ends at grid_start + (grid_steps + 1) time_step, so that rounding does not add up.
  double grid_start = 0.0;
  std::uint64_t grid_steps = 0;
  Watchers watchers;
  std::uint64_t state_version = 1;  // increases whenever the state may change
  mutable KeptNumbers kept_reactions, kept_tensions, kept_energies;
  mutable TornFaces torn_faces;
};

// What other threads may use at any time, also while extend() puts another Impl in the place of this one.
struct Simulation::OtherThreads {
  explicit OtherThreads(const Impl& impl) : shelf(impl.watchers.shelf), asked(impl.engine.model().deadline.flag()) {}
  std::shared_ptr<const SnapshotShelf> shelf;
  std::shared_ptr<Deadline::Flag> asked;
};

}  // namespace springnet
