// What laws make of their tables before a run.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet::layers {

// Immutable data of a law, which frees it.
class Prepared {
 public:
  // Throws Error(input) if the law refuses the tables or the parameters of the material. Both have the order in which
  // the component declares them; tables that are not given are empty.
  Prepared(std::shared_ptr<const Component> component, const std::vector<double>& parameters,
           const std::vector<std::span<const double>>& tables);
  ~Prepared();
  Prepared(const Prepared&) = delete;
  Prepared& operator=(const Prepared&) = delete;

  [[nodiscard]] const void* data() const noexcept { return data_; }

 private:
  std::shared_ptr<const Component> component_;
  void* data_ = nullptr;
};

// Each distinct combination of a law, its parameters and its tables is prepared once. The tables must outlive this.
class PreparedTables {
 public:
  // Null for a law that prepares nothing.
  [[nodiscard]] std::shared_ptr<const Prepared> of(const std::shared_ptr<const Component>& component,
                                                   const std::vector<double>& parameters,
                                                   const std::vector<std::span<const double>>& tables);

 private:
  struct Key {
    const Component* component;
    std::vector<double> parameters;
    std::vector<std::span<const double>> tables;
    bool operator<(const Key& other) const;
  };
  std::map<Key, std::shared_ptr<const Prepared>> known_;
};

}  // namespace springnet::layers
