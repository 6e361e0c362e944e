// One tree of stages from those of all threads.
//
// A stage takes the time of the thread that runs the simulation. In a parallel region of T threads a part takes the
// mean of theirs, t_1 + … + t_T over T, and what the region takes beyond the mean of its threads is spent waiting for
// the last one. So own times add up to the whole, whatever the number of threads.

#include <algorithm>
#include <numeric>

#include "profile/recording.hpp"

namespace springnet::profile {
namespace {

struct Merged {
  ProfileStage stage;
  std::vector<Merged> parts;

  Merged& part(Kind kind, const std::string& name) {
    const auto found = std::find_if(parts.begin(), parts.end(), [&](const Merged& each) {
      return each.stage.kind == kind && each.stage.name == name;
    });
    if (found != parts.end()) return *found;
    Merged& made = parts.emplace_back();
    made.stage.kind = kind;
    made.stage.name = name;
    return made;
  }
};

class Merge {
 public:
  explicit Merge(const std::vector<std::unique_ptr<Lane>>& lanes) : lanes_(lanes), now_(now()) {
    // Stages that have not ended.
    const Lane& first = *lanes.front();
    for (std::uint32_t k = first.present(); k != 0; k = first.nodes()[k].parent) open_.push_back(k);
  }

  // Adds the parts of a node to those of a stage. scale: of their times.
  void add_parts(const Lane& lane, std::uint32_t node, double scale, Merged& to) const {
    for (std::uint32_t k = lane.nodes()[node].first_child; k != none; k = lane.nodes()[k].next) {
      const Node& part = lane.nodes()[k];
      if (part.region) {
        add_region(k, to);
      } else if (part.team == 0) {
        Merged& merged = to.part(part.kind, part.name);
        merged.stage.seconds += scale * seconds(lane, k);
        merged.stage.calls += part.calls;
        merged.stage.estimated = merged.stage.estimated || part.estimated;
        add_parts(lane, k, scale, merged);
      }
    }
  }

 private:
  [[nodiscard]] double seconds(const Lane& lane, std::uint32_t k) const {
    const Node& node = lane.nodes()[k];
    Nanoseconds time = node.time;
    if (lane.number() == 0 && std::find(open_.begin(), open_.end(), k) != open_.end()) time += now_ - node.started;
    return 1e-9 * static_cast<double>(time);
  }

  void add_region(std::uint32_t region, Merged& to) const {
    double working = 0.0;
    for (const std::unique_ptr<Lane>& lane : lanes_) {
      for (std::uint32_t k = 0; k < lane->nodes().size(); ++k) {
        const Node& share = lane->nodes()[k];
        if (share.team == 0 || share.of_region != region) continue;
        working += seconds(*lane, k) / share.team;
        add_parts(*lane, k, 1.0 / share.team, to);
      }
    }
    Merged& waiting = to.part(Kind::stage, "wait for threads");
    waiting.stage.seconds += std::max(0.0, seconds(*lanes_.front(), region) - working);
    waiting.stage.calls += lanes_.front()->nodes()[region].calls;
  }

  const std::vector<std::unique_ptr<Lane>>& lanes_;
  Nanoseconds now_;
  std::vector<std::uint32_t> open_;
};

double sum_of(const std::vector<Merged>& parts) {
  return std::accumulate(parts.begin(), parts.end(), 0.0,
                         [](double sum, const Merged& part) { return sum + part.stage.seconds; });
}

void shrink(Merged& stage, double factor) {
  stage.stage.seconds *= factor;
  for (Merged& part : stage.parts) shrink(part, factor);
}

// Estimates may be greater than the whole that they are of.
void settle(Merged& stage) {
  double estimated = 0.0;
  for (const Merged& part : stage.parts)
    if (part.stage.estimated) estimated += part.stage.seconds;
  const double sum = sum_of(stage.parts), excess = sum - stage.stage.seconds;
  if (excess > 0.0 && estimated > 0.0) {
    const double factor = std::max(0.0, 1.0 - excess / estimated);
    for (Merged& part : stage.parts)
      if (part.stage.estimated) shrink(part, factor);
  }
  stage.stage.own_seconds = std::max(0.0, stage.stage.seconds - sum_of(stage.parts));
  for (Merged& part : stage.parts) settle(part);
}

void list(std::vector<Merged>& parts, std::ptrdiff_t parent, std::vector<ProfileStage>& to) {
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Merged& a, const Merged& b) { return a.stage.seconds > b.stage.seconds; });
  for (Merged& part : parts) {
    const auto index = static_cast<std::ptrdiff_t>(to.size());
    to.push_back(std::move(part.stage));
    to.back().parent = parent;
    list(part.parts, index, to);
  }
}

}  // namespace

Profile Recording::merged() const {
  Merged root;
  Merge(lanes_).add_parts(*lanes_.front(), 0, 1.0, root);
  root.stage.seconds = sum_of(root.parts);
  settle(root);
  Profile profile;
  profile.seconds = root.stage.seconds;
  list(root.parts, -1, profile.stages);
  return profile;
}

}  // namespace springnet::profile
