#include "layers/prepared.hpp"

#include <algorithm>
#include <compare>
#include <functional>
#include <utility>

#include <springnet/error.hpp>

#include "plugin_host/call.hpp"

namespace springnet::layers {

Prepared::Prepared(std::shared_ptr<const Component> component, const std::vector<double>& parameters,
                   const std::vector<std::span<const double>>& tables)
    : component_(std::move(component)) {
  std::vector<const double*> starts;
  std::vector<std::uint64_t> lengths;
  for (const std::span<const double> table : tables) {
    starts.push_back(table.empty() ? nullptr : table.data());
    lengths.push_back(table.size());
  }
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.table_count = static_cast<std::uint32_t>(tables.size());
  preparation.tables = starts.data();
  preparation.lengths = lengths.data();
  preparation.parameters = parameters.data();
  const springnet_law& law = component_->law();
  springnet_message message;
  const springnet_status status = call_component(*component_, message, [&](springnet_message& own) {
    preparation.message = &own;
    return law.prepare(law.context, &preparation);
  });
  if (status != SPRINGNET_OK) throw Error(ErrorKind::input, text_of(message));
  data_ = preparation.prepared;
}

Prepared::~Prepared() {
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.prepared = data_;
  springnet_message ignored;
  const springnet_law& law = component_->law();
  call_component(*component_, ignored, [&](springnet_message& own) {
    preparation.message = &own;
    return law.release(law.context, &preparation);
  });
}

// Equal tables count as one wherever they are stored; -0 and 0 are different.
bool PreparedTables::Key::operator<(const Key& other) const {
  if (component != other.component) return std::less<>()(component, other.component);
  const auto before = [](double a, double b) { return std::strong_order(a, b) < 0; };
  const auto compare = [&](std::span<const double> a, std::span<const double> b) {
    if (a.data() == b.data() && a.size() == b.size()) return 0;
    if (std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), before)) return -1;
    return std::lexicographical_compare(b.begin(), b.end(), a.begin(), a.end(), before) ? 1 : 0;
  };
  if (const int order = compare(parameters, other.parameters); order != 0) return order < 0;
  for (std::size_t k = 0; k < tables.size(); ++k)
    if (const int order = compare(tables[k], other.tables[k]); order != 0) return order < 0;
  return false;
}

std::shared_ptr<const Prepared> PreparedTables::of(const std::shared_ptr<const Component>& component,
                                                   const std::vector<double>& parameters,
                                                   const std::vector<std::span<const double>>& tables) {
  if (component->law().prepare == nullptr) return nullptr;
  std::shared_ptr<const Prepared>& known = known_[{component.get(), parameters, tables}];
  if (!known) known = std::make_shared<const Prepared>(component, parameters, tables);
  return known;
}

}  // namespace springnet::layers
