// Simulation::save() and restore(): all that the coming steps depend on, as bytes.
//
// The bytes are a heading, their number and checksum, whose they are (version, network, laws, integrator), and then the
// parts of the engine, each by its function archive(). What is kept for speed alone is not among them.
#include <springnet/simulation.hpp>

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <zlib.h>

#include <springnet/printable.hpp>
#include <springnet/version.hpp>

#include "simulation/implementation.hpp"
#include "text/archive.hpp"

namespace springnet {
namespace {

constexpr std::string_view heading = "springnet state 1\n";

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}
template <class Number>
std::uint32_t checksum(const Number* values, std::size_t count) {
  return checksum({reinterpret_cast<const char*>(values), count * sizeof(Number)});
}

std::string component_text(const Component& component) {
  return fmt::format("{}@{} {}", component.description->id, component.plugin->id, component.plugin->version);
}

// What must be the same where a state is restored: name and value.
std::vector<std::pair<std::string, std::string>> identity(const Model& model, const Component& integrator) {
  const layers::Layout& layout = model.layout;
  std::vector<std::pair<std::string, std::string>> result{{"version of springnet", std::string(version())},
                                                          {"integrator", component_text(integrator)},
                                                          {"time step", fmt::format("{} s", model.time_step)}};
  const auto add = [&](const char* what, std::size_t count, std::uint32_t sum) {
    result.emplace_back(what, fmt::format("{} ({:08x})", count, sum));
  };
  add("nodes", model.node_count(), checksum(model.first_mass().data(), model.first_mass().size()));
  add("order of nodes", model.node_count(), checksum(layout.ordering().user.data(), layout.ordering().user.size()));
  std::vector<std::uint32_t> springs;
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
    springs.insert(springs.end(), {layout.first(s), layout.second(s), layout.first_group(s), layout.first_row(s)});
  add("springs", layout.spring_count(), checksum(springs.data(), springs.size()));
  std::string laws;
  for (std::size_t g = 0; g < layout.first_group_count(); ++g)
    for (const layers::Law* law : layout.laws().groups[g].laws())
      laws += (laws.empty() ? "" : ", ") + (*law ? component_text(*law->component) : std::string("none"));
  result.emplace_back("laws", laws);
  result.emplace_back("elements", fmt::format("{}", layout.elements().count()));
  result.emplace_back("rigid connections", fmt::format("{}", model.rigid.rods().size()));
  result.emplace_back("planes and instruments", fmt::format("{}", model.contact.obstacles().size()));
  return result;
}

}  // namespace

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
  if (archive.reads()) left_behind_ = {left.begin(), left.end()};
}

// The integrator, if it is another one than at the start.
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
  if (archive.reads()) restored = other ? use : first_integrator;
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
}

// Changed springs lie where they were; in a simulation that takes up the state they are laid out anew, and sums have
// another order.
void Simulation::Impl::lay_out_changes() {
  if (!engine.model().layout.has_changes()) return;
  std::string own;
  Archive out(&own);
  archive(out);
  Archive in{std::string_view(own)};
  archive(in);
}

std::string Simulation::save() {
  Impl& impl = impl_->between_steps();
  std::string memory = impl.integrator_memory();
  impl.lay_out_changes();
  // As in the simulation that takes up the bytes.
  impl.engine.contact_events().forget();
  if (memory.empty())
    impl.drop_history();
  else
    impl.set_integrator_memory(memory);
  std::string bytes;
  Archive archive(&bytes);
  for (auto& [name, value] :
       identity(impl.engine.model(), *impl.plugins->require(ComponentKind::integrator, impl.first_integrator.id))) {
    std::string copy = value;
    archive.text(copy);
  }
  impl.archive(archive);
  archive.text(memory);
  std::string result(heading);
  Archive around(&result);
  std::uint64_t size = bytes.size();
  std::uint32_t sum = checksum(bytes);
  around.number(size);
  around.number(sum);
  return result + bytes;
}

void Simulation::restore(std::string_view saved) {
  Impl& impl = impl_->between_steps();
  if (!saved.starts_with(heading))
    throw Error(ErrorKind::input, fmt::format("this is no state saved by springnet {}, which begins with '{}'",
                                              version(), heading.substr(0, heading.size() - 1)));
  Archive around(saved.substr(heading.size()));
  std::uint64_t size = 0;
  std::uint32_t sum = 0;
  around.number(size);
  around.number(sum);
  const std::string_view bytes = saved.substr(heading.size() + sizeof size + sizeof sum);
  if (size != bytes.size() || sum != checksum(bytes))
    throw Error(ErrorKind::input,
                fmt::format("the saved state is damaged: {}",
                            size != bytes.size() ? fmt::format("it has {} bytes in place of {}", bytes.size(), size)
                                                 : std::string("its checksum is another one")));
  Archive archive(bytes);
  for (const auto& [name, value] :
       identity(impl.engine.model(), *impl.plugins->require(ComponentKind::integrator, impl.first_integrator.id))) {
    std::string there;
    archive.text(there);
    if (there != value)
      throw Error(ErrorKind::input, fmt::format("the saved state is of another simulation: {}: {} there, {} here", name,
                                                printable(there), printable(value)));
  }
  std::string before;
  Archive keep(&before);
  impl.archive(keep);
  std::string memory;
  try {
    impl.archive(archive);
    archive.text(memory);
    if (archive.left() > 0) Archive::refuse("it is too long");
    if (!(*impl.restored == impl.options.integrator)) impl.exchange(*impl.restored);
  } catch (...) {
    Archive back{std::string_view(before)};
    impl.archive(back);
    throw;
  }
  impl.engine.contact_events().forget();
  if (memory.empty())
    impl.drop_history();
  else
    impl.set_integrator_memory(memory);
}

}  // namespace springnet
