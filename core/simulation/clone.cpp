// Simulation::clone(): a simulation whose engine shares with this one what neither changes (layers::Shared), and that
// takes up all else from the bytes of a saved state.
#include <springnet/simulation.hpp>

#include <string>
#include <utility>

#include "simulation/implementation.hpp"
#include "text/archive.hpp"

namespace springnet {
namespace {

SimulationOptions without_profiler(SimulationOptions options) {
  options.profiler = nullptr;
  return options;
}

}  // namespace

Simulation::Simulation(std::unique_ptr<Impl> impl)
    : impl_(std::move(impl)), others_(std::make_unique<const OtherThreads>(*impl_)) {}

Simulation::Impl::Impl(Impl& other, std::string_view state)
    : network(other.network),
      plugins(other.plugins),
      options(without_profiler(other.options)),
      component(other.component),
      engine(other.engine, *network, options),
      host(make_host_table(engine)),
      first_integrator(other.first_integrator),
      identity(other.identity),
      identity_of_network(other.identity_of_network) {
  Archive archive(state);
  this->archive(archive);
  std::string memory;
  archive.text(memory);
  // At the state from which it goes on.
  create_integrator();
  try {
    settle_history(memory);
  } catch (...) {
    destroy_integrator();
    throw;
  }
}

Simulation Simulation::clone() {
  Impl& impl = impl_->between_steps();
  const std::string state = impl.state();
  return Simulation(std::make_unique<Impl>(impl, state));
}

}  // namespace springnet
