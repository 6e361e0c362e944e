// Forward sensitivities: how the motion of the reference integrator depends on parameters, as it goes on. That of steps
// of the recurrent network: MotionDerivatives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/learn.hpp>
#include <springnet/network.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// What a motion is differentiated by: a value of the network, or several together, which keep their ratios.
struct SensitivityColumn {
  std::string name;          // "spring.stiffness", "mass", "velocity.x"
  std::uint32_t member = 0;  // spring, element or node: the user's number; of several the first
  std::size_t values = 1;    // that go together
  double value = 0.0;        // of that member
};

// A motion and its derivatives by values of the network. In `cvode` both are integrated at a time, by CVODES; the
// right-hand side of the derivatives is analytic. Errors of a derivative times the value (times 1 in its unit where
// that is 0) are held below the tolerances of the motion, and below relative_tolerance of the derivative itself. Steps
// are those that both need, so that the motion is that of a Simulation up to the tolerances alone. Times at which loads
// switch and signals jump are passed; they do not depend on what is differentiated by.
class SPRINGNET_API ReferenceSensitivities {
 public:
  // A column for each value of `of`, or for each that is `together`; bounds are not used. Throws as Simulation(), and
  // Error(input) for an integrator without sensitivities, nets with rigid connections, cuts, changes at times or laws
  // with internal states, for loads and fields, and as select_learnable() for values that the network does not have, or
  // that are not learnable.
  ReferenceSensitivities(const std::shared_ptr<const Network>& network,
                         const std::shared_ptr<const PluginHost>& plugins, const SimulationOptions& options,
                         const std::vector<Learnable>& of);
  ~ReferenceSensitivities();
  ReferenceSensitivities(ReferenceSensitivities&&) noexcept;
  ReferenceSensitivities& operator=(ReferenceSensitivities&&) noexcept;
  ReferenceSensitivities(const ReferenceSensitivities&) = delete;
  ReferenceSensitivities& operator=(const ReferenceSensitivities&) = delete;

  [[nodiscard]] const std::vector<SensitivityColumn>& columns() const noexcept;

  // To a later time, s. Throws Error(simulation) where the motion has contact or a rupture, which is not
  // differentiated, or fails; the state is then one before. Throws Error(input) for a time that is not later.
  void advance_to(double time);
  [[nodiscard]] double time() const noexcept;  // s

  // m and m/s, [3][node] in the user's order.
  [[nodiscard]] Eigen::Matrix3Xd positions() const;
  [[nodiscard]] Eigen::Matrix3Xd velocities() const;
  // Their derivatives by the value of a column, per its unit, likewise. Throws Error(input) if there is no such column.
  [[nodiscard]] Eigen::Matrix3Xd position_changes(std::size_t column) const;
  [[nodiscard]] Eigen::Matrix3Xd velocity_changes(std::size_t column) const;

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

// The table sensitivity.csv: a line for each time, column and node.
class SPRINGNET_API SensitivityTable {
 public:
  // nodes: ascending; empty: all. Throws Error(input) if the file cannot be created.
  explicit SensitivityTable(const OutputFile& file, std::vector<NodeIndex> nodes = {});
  ~SensitivityTable();
  SensitivityTable(SensitivityTable&&) noexcept;
  SensitivityTable& operator=(SensitivityTable&&) noexcept;

  // Both throw Error(simulation) if the file cannot be written.
  void record(const ReferenceSensitivities& sensitivities);
  void close();

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace springnet
