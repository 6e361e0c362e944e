#include "inspection/suspicions.hpp"

#include <algorithm>
#include <cmath>

namespace springnet {

namespace {

// Values of springs; nan where a spring has none.
class SpringValues {
 public:
  explicit SpringValues(const Network& network) : network_(network), values_(network.springs().size(), std::nan("")) {}
  double& operator[](std::size_t spring) { return values_[spring]; }

  [[nodiscard]] UnusualSprings above_median() const {
    UnusualSprings result;
    std::vector<double> sorted;
    std::copy_if(values_.begin(), values_.end(), std::back_inserter(sorted), [](double v) { return v > 0.0; });
    if (sorted.empty()) return result;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    result.median = *middle;
    result.bound = unusual_factor * result.median;
    collect(result);
    return result;
  }
  [[nodiscard]] UnusualSprings above(double bound) const {
    UnusualSprings result;
    result.bound = bound;
    collect(result);
    return result;
  }

 private:
  void collect(UnusualSprings& result) const {
    std::vector<SpringIndex> found;
    for (std::size_t s = 0; s < values_.size(); ++s) {
      if (values_[s] > result.bound) found.push_back(static_cast<SpringIndex>(s));
    }
    result.count = found.size();
    const std::size_t listed = std::min(found.size(), listed_at_most);
    std::partial_sort(
        found.begin(), found.begin() + static_cast<std::ptrdiff_t>(listed), found.end(),
        [&](SpringIndex a, SpringIndex b) { return values_[a] != values_[b] ? values_[a] > values_[b] : a < b; });
    for (std::size_t i = 0; i < listed; ++i) {
      const Spring& spring = network_.springs()[found[i]];
      result.worst.push_back({found[i], spring.first, spring.second, values_[found[i]]});
    }
  }

  const Network& network_;
  std::vector<double> values_;
};

}  // namespace

Suspicions find_suspicions(const StartingNetwork& start) {
  const Network& network = start.network();
  Suspicions result;
  SpringValues stiffness(network), damping(network), elastic_rate(network), viscous_rate(network), strain(network);
  for (std::size_t s = 0; s < start.springs().size(); ++s) {
    const SpringAtStart& law = start.springs()[s];
    const Spring& spring = network.springs()[s];
    double inverse_mass = 0.0;
    for (const NodeIndex end : {spring.first, spring.second}) {
      if (start.is_free(end)) inverse_mass += 1.0 / network.nodes()[end].mass;
    }
    const double d = law.damping();
    stiffness[s] = std::abs(law.stiffness);
    damping[s] = d;
    elastic_rate[s] = std::abs(law.stiffness) * inverse_mass;
    viscous_rate[s] = d * inverse_mass;
    if (network.materials()[spring.material].spring && spring.rest_length > 0.0) {
      strain[s] = std::abs(law.length - spring.rest_length) / spring.rest_length;
    }
    result.springs_without_direction += law.length > 0.0 ? 0 : 1;
    result.springs_that_soften += law.stiffness < 0.0 ? 1 : 0;
  }
  result.stiffness = stiffness.above_median();
  result.damping = damping.above_median();
  result.elastic_rate = elastic_rate.above_median();
  result.viscous_rate = viscous_rate.above_median();
  result.strain = strain.above(unusual_strain);

  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    if (!start.has_neighbours(k) && result.nodes_without_springs.size() < listed_at_most) {
      result.nodes_without_springs.push_back(k);
    }
    if (!start.is_free(k)) continue;
    const auto mass = [&](NodeIndex node) { return network.nodes()[node].mass; };
    if (!result.lightest || mass(k) < mass(*result.lightest)) result.lightest = k;
    if (!result.heaviest || mass(k) > mass(*result.heaviest)) result.heaviest = k;
  }
  if (result.lightest &&
      network.nodes()[*result.heaviest].mass <= unusual_mass_ratio * network.nodes()[*result.lightest].mass) {
    result.lightest = result.heaviest = std::nullopt;
  }
  return result;
}

}  // namespace springnet
