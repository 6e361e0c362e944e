// The network at its start, at rest and without obstacles: forces and derivatives of its laws, and the engine on which
// integrators report their limits.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "layers/layout.hpp"
#include "simulation/limit_survey.hpp"

namespace springnet {

// Forces and derivatives of a spring's laws; nan where unknown.
struct SpringAtStart {
  double length;           // m
  double tension;          // N
  double stiffness;        // N/m: dQ/dq of the spring function
  double axial_damping;    // N s/m: dQ/dq' of laws that read a rate
  double general_damping;  // N s/m: of laws that read the relative speed

  [[nodiscard]] double damping() const { return axial_damping + general_damping; }
};

struct ElementAtStart {
  double force;                   // Q
  double stiffness, damping;      // dQ/dq, dQ/dq'; nan where unknown, as force
  double scale;                   // of q: 1 rad, or the area or volume
  std::vector<NodeIndex> nodes;   // each once
  std::vector<Vector3> gradient;  // dq/dp, [node]
  std::vector<Vector3> across;    // [node] for a straight angle the second direction in which it bends, else 0
  // Of elements of all kinds; those above have no meaning where laws read several scalars.
  std::vector<double> own_stiffness, own_damping;  // [node] greatest of its own block, N/m, N s/m; nan where unknown
  std::vector<std::vector<Vector3>> directions{};  // [.][node] in which the element resists
  bool definite = false;                           // certainly feeds no energy into any motion
};

class StartingNetwork {
 public:
  // Throws Error(plugin) for a component that is missing or not supported by the engine, Error(input) for wrong
  // parameters. `network` must outlive it.
  StartingNetwork(const Network& network, const PluginHost& plugins);

  [[nodiscard]] const Network& network() const noexcept { return network_; }
  [[nodiscard]] const std::vector<SpringAtStart>& springs() const noexcept { return springs_; }
  [[nodiscard]] const std::vector<ElementAtStart>& elements() const noexcept { return elements_; }
  // Neither fixed nor moved.
  [[nodiscard]] bool is_free(NodeIndex node) const { return free_[node] != 0; }
  // The engine's layout of springs, elements, rigid connections and loaded faces, in its own order of nodes.
  [[nodiscard]] const layers::Layout& layout() const noexcept { return *layout_; }
  [[nodiscard]] std::uint32_t engine_node(NodeIndex user) const { return layout_->ordering().engine[user]; }
  [[nodiscard]] bool has_neighbours(NodeIndex user) const;
  // Null if the engine cannot start; failure() has the reason.
  [[nodiscard]] LimitSurvey* survey() const noexcept { return survey_.get(); }
  [[nodiscard]] const std::string& failure() const noexcept { return failure_; }

 private:
  void linearise_springs();
  void linearise_elements();
  void linearise_several(std::uint32_t e, ElementAtStart& element);

  const Network& network_;
  std::vector<std::uint8_t> free_;
  std::unique_ptr<LimitSurvey> survey_;
  std::string failure_;
  std::unique_ptr<layers::Layout> own_layout_;  // without an engine
  const layers::Layout* layout_;
  std::vector<double> coordinates_[3], zero_;  // [engine's node]
  layers::NodeArrays nodes_{};
  std::vector<SpringAtStart> springs_;
  std::vector<ElementAtStart> elements_;
};

}  // namespace springnet
