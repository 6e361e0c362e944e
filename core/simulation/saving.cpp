// Simulation::save() and restore(): all that the coming steps depend on, as bytes (saved_state.hpp), the parts of the
// engine each by its function archive(). What is kept for speed alone is not among them.
#include <springnet/simulation.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/version.hpp>

#include "simulation/implementation.hpp"
#include "simulation/saved_state.hpp"
#include "text/archive.hpp"
#include "text/digest.hpp"

namespace springnet {

void Engine::archive(Archive& archive) {
  topology_.archive(archive);
  model_.archive(archive);
  changes_.archive(archive);
  ledger_.archive(archive);
  bool any = dissipation_ != nullptr;
  archive.flag(any);
  if (any != (dissipation_ != nullptr))
    Archive::refuse("one of both sums up the dissipated energy, the other one does not");
  if (dissipation_) dissipation_->archive(archive);
  archive.flag(energy_noted_);
  archive.number(committed_events_);
  if (archive.reads() && committed_events_ > model_.journal.events().size()) Archive::refuse("events are missing");
  std::vector<std::uint64_t> left(left_behind_.begin(), left_behind_.end());
  left.resize(archive.count(left.size(), sizeof(std::uint64_t), "notes"));
  archive.numbers(left.data(), left.size());
  if (!archive.reads()) return;
  left_behind_ = {left.begin(), left.end()};
  sweep_.pairs().begin_step();
}

// The integrator, if it is another one than at the start. It is exchanged before anything else is taken up, which an
// exchange would change.
void Simulation::Impl::archive_integrator(Archive& archive) {
  bool other = !(options.integrator == first_integrator);
  archive.flag(other);
  LawUse use = options.integrator;
  if (other) {
    archive.text(use.id);
    std::vector<std::pair<std::string, double>> values(use.parameters.begin(), use.parameters.end());
    values.resize(archive.count(values.size(), sizeof(std::uint64_t), "parameters of the integrator"));
    for (auto& [name, value] : values) {
      archive.text(name);
      archive.number(value);
    }
    use.parameters = {values.begin(), values.end()};
  }
  if (!archive.reads()) return;
  const LawUse& wanted = other ? use : first_integrator;
  if (!(wanted == options.integrator)) exchange(wanted);
}

void Simulation::Impl::archive(Archive& archive) {
  archive_integrator(archive);
  engine.archive(archive);
  archive.number(steps);
  archive.number(sweeps);
  archive.number(grid_start);
  archive.number(grid_steps);
  archive.flag(state_is_of_step);
  archive.below(last.outcome, 5, "an outcome");
  for (std::uint64_t* each : {&last.steps, &last.sweeps, &last.substeps, &last.stages}) archive.number(*each);
  for (double* each : {&last.force_difference, &last.residual, &last.position_error}) archive.number(*each);
  archive.number(last.node);
  archive.number(last.start_node);
  const std::int64_t nodes = engine.model().node_count();
  if ((last.node != 0 && last.node >= nodes) || last.start_node < -1 || last.start_node >= nodes)
    Archive::refuse("a node does not exist");
  // Where the next step ends; at once, up to rounding, where the last one ended with an exception after its commit.
  const double next = grid_start + static_cast<double>(grid_steps + 1) * options.time_step;
  const double ahead = next - engine.model().time;
  if (!(ahead >= -1e-6 * options.time_step && ahead <= 2.0 * options.time_step))
    Archive::refuse("its next step ends at another time");
}

// Changed springs lie where they were, and units with few springs left may have been laid out on the way; in a
// simulation that takes up the state they are laid out anew, and sums have another order.
void Simulation::Impl::lay_out_changes() {
  const layers::Layout& layout = engine.model().layout;
  if (!layout.has_changes() && layout.is_as_removed_at_once()) return;
  std::string own;
  Archive out(&own);
  archive(out);
  Archive in{std::string_view(own)};
  archive(in);
}

const Identity& Simulation::Impl::network_identity() {
  if (identity_of_network != network) {
    identity = std::make_shared<const Identity>(identity_of(*network, *plugins));
    identity_of_network = network;
  }
  return *identity;
}

Identity Simulation::Impl::present_identity() {
  // An integrator that has been exchanged since belongs to the state.
  const std::shared_ptr<const Component> first = plugins->require(ComponentKind::integrator, first_integrator.id);
  const std::vector<double> parameters =
      complete_parameters(*first->description, first_integrator.parameters, first_integrator.id);
  Identity result{{"version of springnet", std::string(version())},
                  {"integrator", identity_text(*first)},
                  {"parameters of the integrator", parameters_text(*first, parameters)},
                  {"time step", fmt::format("{} s", options.time_step)},
                  {"nodes are renumbered", options.renumber ? "yes" : "no"},
                  {"dissipated energy is summed up", options.dissipated_energy ? "yes" : "no"}};
  const Identity& of_network = network_identity();
  result.insert(result.end(), of_network.begin(), of_network.end());
  return result;
}

SavedHead::SavedHead(std::string_view saved) {
  if (!saved.starts_with(heading)) {
    constexpr std::string_view family = "springnet state ";
    if (saved.starts_with(family))
      throw Error(ErrorKind::input,
                  fmt::format("the saved state has format {}, this is springnet {}, which reads format {}: restore it "
                              "with the version that saved it",
                              printable(saved.substr(family.size(), saved.substr(family.size()).find('\n'))), version(),
                              heading.substr(family.size(), heading.size() - family.size() - 1)));
    throw Error(ErrorKind::input, fmt::format("this is no state saved by springnet {}, which begins with '{}'",
                                              version(), heading.substr(0, heading.size() - 1)));
  }
  Archive archive(saved.substr(heading.size()));
  this->archive(archive);
}

void SavedHead::archive(Archive& archive) {
  archive.number(identity_size);
  archive.number(identity_sum);
  archive.number(state_size);
  archive.number(state_sum);
}

void SavedHead::check_size(std::uint64_t bytes) const {
  // The sum may overflow in a damaged head.
  if (bytes >= size && identity_size <= bytes - size && state_size == bytes - size - identity_size) return;
  throw Error(ErrorKind::input, fmt::format("the saved state is damaged: it has {} bytes in place of those that it "
                                            "announces",
                                            bytes));
}

void Simulation::Impl::check_identity(const SavedHead& head, std::string_view bytes) {
  if (head.identity_sum != checksum(bytes))
    throw Error(ErrorKind::input, "the saved state is damaged: its checksum is another one");
  Archive archive(bytes);
  if (const std::optional<IdentityDifference> found = identity_difference(archive, present_identity()))
    throw Error(ErrorKind::input, found->is_of_values
                                      ? "the saved state is of another simulation: " + found->text
                                      : "the saved state is of another version of springnet, " + found->text);
  if (archive.left() > 0) Archive::refuse("it tells more than what it is of");
}

void Simulation::Impl::restore_state(const SavedHead& head, std::string_view bytes) {
  if (head.state_sum != checksum(bytes))
    throw Error(ErrorKind::input, "the saved state is damaged: its checksum is another one");
  take_up(bytes);
}

// The integrator's memory goes with the rest: either both are taken up, or the simulation is as it was.
void Simulation::Impl::take_up(std::string_view bytes) {
  std::string before;
  Archive keep(&before);
  archive(keep);
  try {
    Archive archive(bytes);
    this->archive(archive);
    std::string memory;
    archive.text(memory);
    if (archive.left() > 0) Archive::refuse("it is too long");
    settle_history(memory);
  } catch (...) {
    Archive back{std::string_view(before)};
    archive(back);
    drop_history();
    throw;
  }
  watchers.told = engine.model().journal.events().size();  // what happened before is no news
  changed();
}

void Simulation::Impl::settle_history(std::string_view memory) {
  engine.contact_events().forget();
  if (memory.empty())
    drop_history();
  else
    set_integrator_memory(memory);
}

std::string Simulation::Impl::state() {
  std::string memory = integrator_memory();
  // As in the simulation that takes up the bytes.
  lay_out_changes();
  settle_history(memory);
  engine.model().stale.reactions = engine.model().stale.pair_forces =
      true;  // those found before a motion was told may be others
  std::string bytes;
  Archive archive(&bytes);
  this->archive(archive);
  archive.text(memory);
  return bytes;
}

std::string Simulation::save() {
  Impl& impl = impl_->between_steps();
  const std::string state = impl.state();
  std::string told;
  Archive archive(&told);
  write_identity(archive, impl.present_identity());
  SavedHead head;
  head.identity_size = told.size();
  head.identity_sum = checksum(told);
  head.state_size = state.size();
  head.state_sum = checksum(state);
  std::string result(SavedHead::heading);
  result.reserve(SavedHead::size + told.size() + state.size());
  Archive around(&result);
  head.archive(around);
  return result.append(told).append(state);
}

void Simulation::restore(std::string_view saved) {
  Impl& impl = impl_->between_steps();
  const SavedHead head(saved);
  head.check_size(saved.size());
  impl.check_identity(head, saved.substr(SavedHead::size, head.identity_size));
  impl.restore_state(head, saved.substr(SavedHead::size + head.identity_size));
}

}  // namespace springnet
