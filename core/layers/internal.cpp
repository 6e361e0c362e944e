#include "layers/internal.hpp"

#include <utility>

#include "layers/laws.hpp"

namespace springnet::layers {

InternalLayout::InternalLayout(const CompiledLaws& laws, const std::vector<std::uint32_t>& spring_order,
                               std::size_t spring_count, std::size_t element_count) {
  groups_.resize(laws.groups.size());
  bool any = false;
  for (const Group& group : laws.groups) any = any || group.state_count() > 0;
  if (!any) return;
  constexpr std::uint32_t none = 0xffffffffu;
  std::vector<std::uint32_t> springs(spring_count, none), elements(element_count, none);
  const auto place = [&](std::uint32_t& of, std::size_t group) {
    if (of == none && laws.groups[group].state_count() > 0) of = groups_[group].count++;
  };
  for (const std::uint32_t s : spring_order) place(springs[s], laws.group[s]);
  for (std::uint32_t e = 0; e < element_count; ++e) place(elements[e], laws.element_group[e]);
  spring_place_ = std::move(springs);
  element_place_ = std::move(elements);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    OfGroup& group = groups_[g];
    group.first = count_;
    for (const Law* const law : laws.groups[g].laws()) {
      for (std::size_t j = 0; j < law->state_count && group.count > 0; ++j) {
        ranges_.push_back({sizeof(springnet_internal_range), 0, count_, group.count, law->component->law().states[j],
                           law->component->description->id});
        count_ += group.count;
      }
      own_updates_ = own_updates_ || (law->state_count > 0 && law->reads_start);
    }
  }
}

}  // namespace springnet::layers
