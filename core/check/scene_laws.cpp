#include "check/scene_laws.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

namespace springnet::check {
namespace {

// Elements of a law that are checked; a scene may have millions.
constexpr std::size_t most_elements = 48;

std::shared_ptr<const Component> component_of(const LawUse& use, ComponentKind kind, const PluginHost& host) {
  return use.component != nullptr ? use.component : host.require(kind, use.id);
}

bool shares_law(const SceneLaw& law, const LawUse& use, ComponentKind kind) {
  if (law.kind != kind || law.use.id != use.id || law.use.component != use.component || law.use.tables != use.tables)
    return false;
  return use.tables.empty() || law.use.parameters == use.parameters;
}

double size_of(const UsedElement& element) {
  if (element.rest.empty()) return element.reference;
  double sum = 0.0;
  for (std::size_t k = 1; k < element.rest.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis) sum += std::pow(element.rest[k][axis] - element.rest[0][axis], 2);
  return std::sqrt(sum);
}

// Median, smallest, largest, then some in between.
std::vector<UsedElement> sample_of(std::vector<UsedElement> all) {
  std::stable_sort(all.begin(), all.end(),
                   [](const UsedElement& a, const UsedElement& b) { return size_of(a) < size_of(b); });
  if (all.empty()) return all;
  const std::size_t last = all.size() - 1;
  std::vector<UsedElement> sample{all[last / 2], all.front(), all.back()};
  const std::size_t others = std::min(most_elements, all.size());
  for (std::size_t k = 0; k < others; ++k) sample.push_back(all[others == 1 ? 0 : k * last / (others - 1)]);
  return sample;
}

// Collects the elements of each law; equal ones once.
class Collector {
 public:
  explicit Collector(const PluginHost& host) : host_(host) {}

  // Which law and which set of parameters a material's function is.
  std::optional<std::pair<std::size_t, std::size_t>> add(const std::optional<LawUse>& use, ComponentKind kind) {
    if (!use) return {};
    std::size_t k = 0;
    while (k < laws_.size() && !shares_law(laws_[k], *use, kind)) ++k;
    if (k == laws_.size()) {
      laws_.push_back({kind, *use, {}, {}});
      seen_.emplace_back();
      smallest_.emplace_back();
      largest_.emplace_back();
    }
    auto& sets = laws_[k].parameters;
    std::vector<double> values =
        complete_parameters(*component_of(*use, kind, host_)->description, use->parameters, "the scene");
    const auto found = std::find(sets.begin(), sets.end(), values);
    const auto set = static_cast<std::size_t>(found - sets.begin());
    if (found == sets.end()) sets.push_back(std::move(values));
    return std::pair(k, set);
  }
  void add_element(std::size_t law, UsedElement element) {
    std::vector<double> key{static_cast<double>(element.parameters), element.reference};
    for (const auto& corner : element.rest) key.insert(key.end(), corner.begin(), corner.end());
    std::vector<UsedElement>& kept = laws_[law].elements;
    // Beyond a number that is enough to choose from, only the smallest and the largest.
    constexpr std::size_t enough = 20'000;
    if (kept.empty()) smallest_[law] = largest_[law] = element;
    if (size_of(element) < size_of(smallest_[law])) smallest_[law] = element;
    if (size_of(element) > size_of(largest_[law])) largest_[law] = element;
    if (kept.size() < enough && seen_[law].insert(std::move(key)).second) kept.push_back(std::move(element));
  }
  [[nodiscard]] std::vector<SceneLaw> take() {
    for (std::size_t k = 0; k < laws_.size(); ++k) {
      std::vector<UsedElement>& elements = laws_[k].elements;
      if (!elements.empty()) elements.insert(elements.end(), {smallest_[k], largest_[k]});
      elements = sample_of(std::move(elements));
    }
    return std::move(laws_);
  }

 private:
  const PluginHost& host_;
  std::vector<SceneLaw> laws_;
  // [law]
  std::vector<std::set<std::vector<double>>> seen_;
  std::vector<UsedElement> smallest_, largest_;
};

// A size: an angle at rest may be 0 or negative.
double or_present(double reference, double present) {
  if (reference != 0.0) return std::abs(reference);
  return present != 0.0 ? std::abs(present) : 1.0;
}

}  // namespace

std::vector<SceneLaw> laws_of(const Network& network, const PluginHost& host) {
  Collector collector(host);
  using Place = std::optional<std::pair<std::size_t, std::size_t>>;
  std::vector<std::array<Place, 2>> places;
  for (const Material& material : network.materials())
    places.push_back({collector.add(material.spring, ComponentKind::spring_function),
                      collector.add(material.viscosity, ComponentKind::viscosity_function)});
  const auto add = [&](MaterialIndex material, UsedElement element) {
    for (const Place& place : places[material]) {
      if (!place) continue;
      element.parameters = place->second;
      collector.add_element(place->first, element);
    }
  };
  const std::vector<Vector3>& positions = network.nodes().positions();
  for (const Spring& spring : network.springs()) {
    UsedElement element;
    element.reference = or_present(spring.rest_length, (positions[spring.second] - positions[spring.first]).norm());
    add(spring.material, element);
  }
  for (const Element& each : network.elements()) {
    UsedElement element;
    if (reads_several(each.invariant)) {
      for (const Vector3& corner : each.rest) element.rest.push_back({corner.x(), corner.y(), corner.z()});
      element.direction = {each.direction.x(), each.direction.y(), each.direction.z()};
    } else {
      element.reference = or_present(each.reference, network.value_of(each));
    }
    add(each.material, element);
  }
  return collector.take();
}

}  // namespace springnet::check
