// Steps of a graph as statements of the SDK.
#pragma once

#include <string>
#include <vector>

#include <springnet/sdk/law/jacobian.hpp>

#include "formula/graph.hpp"

namespace springnet::formula {

// What the arguments of a law are called in C++.
struct SourceNames {
  sdk::JacobianLayout layout;
  bool several = false;  // a law over several scalars
  std::size_t curve_count = 0;
  std::vector<std::string> parameters, states, inputs, scalars, tables;  // enumerators

  [[nodiscard]] bool has(const std::string& name) const;
};

// 1.5, 2.0, std::numeric_limits<double>::infinity()
[[nodiscard]] std::string number_text(double value);

// The body of a function that returns a number, or a list of them.
[[nodiscard]] std::vector<std::string> statements_of(const Graph& graph, const std::vector<Node>& roots, bool is_list,
                                                     const SourceNames& names);

}  // namespace springnet::formula
