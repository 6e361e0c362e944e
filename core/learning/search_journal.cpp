#include "learning/search_journal.hpp"

#include <cstdint>
#include <optional>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/version.hpp>

#include "learning/course.hpp"
#include "simulation/identity.hpp"
#include "text/digest.hpp"

namespace springnet::learning {

namespace {

constexpr std::string_view heading = "springnet search 2\n";
constexpr std::string_view again = "; learn from the start";

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, "the state of a search " + what); }

std::string text_of(const LawUse& integrator) {
  std::string text = integrator.id;
  for (const auto& [name, value] : integrator.parameters) text += fmt::format(", {} {}", name, value);
  return text;
}

// "120 values (8d36788c)"
std::string text_of(const Observations& observations) {
  Digest digest;
  const auto add_vectors = [&](const std::vector<Observations::VectorRow>& rows) {
    digest.add(rows.size());
    for (const Observations::VectorRow& row : rows) {
      digest.add(row.time);
      digest.add(row.node);
      for (int axis = 0; axis < 3; ++axis) {
        digest.add(row.value[axis]);
        digest.add(row.weight[axis]);
      }
    }
  };
  add_vectors(observations.positions);
  add_vectors(observations.velocities);
  add_vectors(observations.reactions);
  digest.add(observations.distances.size());
  for (const Observations::DistanceRow& row : observations.distances) {
    for (const double each : {row.time, row.distance, row.weight}) digest.add(each);
    digest.add(row.node);
    digest.add(row.other);
  }
  digest.add(observations.surface_points.size());
  for (const Observations::SurfacePoint& row : observations.surface_points)
    for (const double each : {row.time, row.point[0], row.point[1], row.point[2], row.weight}) digest.add(each);
  digest.add(observations.outlier_distance);
  return fmt::format("{} values ({:08x})", observations.value_count(), digest.value());
}

std::string text_of(const std::vector<Learnable>& learnables) {
  Digest digest;
  std::string names;
  for (const Learnable& each : learnables) {
    digest.add(each.values.kind);
    digest.add(each.values.of_elements);
    digest.add(std::string_view(each.values.parameter));
    digest.add(each.values.members);
    digest.add(each.together);
    digest.add(each.lower);
    digest.add(each.upper);
    digest.add(each.field_degree);
    digest.add(each.by_logarithm);
    digest.add(each.guess_widths.size());
    for (const double width : each.guess_widths) digest.add(width);
    names += fmt::format("{}{}{}{} of {}", names.empty() ? "" : ", ", each.values.of_elements ? "element." : "",
                         name_of(each.values.kind), each.values.parameter.empty() ? "" : "." + each.values.parameter,
                         each.values.members.size());
  }
  return fmt::format("{} ({:08x})", names, digest.value());
}

}  // namespace

Identity identity_of(const std::vector<Experiment>& experiments, const PluginHost& plugins,
                     const std::vector<Learnable>& learnables, const LearnOptions& options) {
  Identity identity{{"version of springnet", std::string(version())},
                    {"what is learned", text_of(learnables)},
                    {"optimiser", std::string(name_of(options.optimiser))},
                    {"most iterations", std::to_string(options.max_iterations)},
                    {"stages", std::to_string(options.stages)},
                    {"tolerance", fmt::format("{}", options.tolerance)},
                    {"weight of the guess", fmt::format("{}", options.guess_weight)},
                    {"smoothness", fmt::format("{}", options.smoothness)},
                    {"rule of the guess", std::to_string(static_cast<int>(options.guess_rule))},
                    {"starts", std::to_string(options.starts)},
                    {"factor of starts", fmt::format("{}", options.start_factor)},
                    {"seed of starts", std::to_string(options.seed)},
                    {"experiments", std::to_string(experiments.size())}};
  for (std::size_t k = 0; k < experiments.size(); ++k) {
    const Experiment& each = experiments[k];
    const std::string prefix = experiments.size() > 1 ? fmt::format("experiment {}: ", k + 1) : "";
    identity.emplace_back(prefix + "time step", fmt::format("{} s", each.options.time_step));
    identity.emplace_back(prefix + "integrator", text_of(each.options.integrator));
    identity.emplace_back(prefix + "observations", text_of(each.observations));
    for (auto& [name, value] : springnet::identity_of(*each.network, plugins))
      identity.emplace_back(prefix + name, std::move(value));
  }
  return identity;
}

SearchJournal::SearchJournal(Identity identity, std::string_view bytes) : identity_(std::move(identity)) {
  if (bytes.empty()) return;
  if (!bytes.starts_with(heading))
    refuse(fmt::format("is not one of springnet {}, which begins with '{}'", version(),
                       heading.substr(0, heading.size() - 1)));
  Archive archive(bytes.substr(heading.size()));
  std::uint32_t sum = 0;
  archive.number(sum);
  if (sum != checksum(bytes.substr(bytes.size() - archive.left())))
    refuse(fmt::format("is damaged: its checksum is another one{}", again));
  if (const std::optional<IdentityDifference> found = identity_difference(archive, identity_, "now"))
    refuse(found->is_of_values
               ? fmt::format("is of another search: {}; undo the change, or learn from the start", found->text)
               : fmt::format("is of another search, {}{}", found->text, again));
  archive_legs(archive);
  archive.text(present_);
  if (archive.left() > 0) refuse(fmt::format("is damaged: it goes on after its end{}", again));
}

void SearchJournal::archive_legs(Archive& archive) {
  legs_.resize(archive.count(legs_.size(), sizeof(std::uint64_t), "searches"));
  for (Minimum& each : legs_) {
    each.x.resize(static_cast<Eigen::Index>(
        archive.count(static_cast<std::size_t>(each.x.size()), sizeof(double), "variables of a search")));
    archive.numbers(each.x.data(), static_cast<std::size_t>(each.x.size()));
    archive.number(each.cost);
    archive.below(each.stop, static_cast<std::uint64_t>(Minimum::Stop::stuck) + 1, "the end of a search");
    archive.text(each.reason);
    archive_history(archive, each.history);
  }
}

std::optional<Minimum> SearchJournal::ended_leg() {
  if (next_ >= legs_.size()) return std::nullopt;
  return legs_[next_++];
}

std::string SearchJournal::present_leg() const { return next_ == legs_.size() ? present_ : std::string(); }

void SearchJournal::end_leg(const Minimum& minimum) {
  legs_.push_back(minimum);
  next_ = legs_.size();
  present_.clear();
}

std::string SearchJournal::with(std::string_view state) const {
  std::string content;
  Archive archive(&content);
  write_identity(archive, identity_);
  SearchJournal legs = *this;  // an archive that writes changes nothing
  legs.archive_legs(archive);
  std::string present(state);
  archive.text(present);
  std::string bytes(heading);
  std::uint32_t sum = checksum(content);
  Archive(&bytes).number(sum);
  return bytes + content;
}

}  // namespace springnet::learning
