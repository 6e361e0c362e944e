// The outputs (P, U) of a step from (p, v) as what constraints make of V, the velocities that nodes would have without
// them: P = p + c v + w V, U = V of free nodes, something else of nodes on surfaces and in rigid clusters. Vectors have
// the engine's order, x of all nodes first.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "layers/linear/node_response.hpp"

namespace springnet::learning {

class ConstrainedOutputs {
 public:
  // All nodes are free. c, w: s, of the step.
  void begin(std::size_t nodes, double c, double w);
  // derivative: of (P, U) of these nodes by (p, v, V), [6 node][9 node]; x y z of the first node, then of the next.
  // by_mass: the same by the masses of these nodes, if they matter. by_times: by the times at which the step begins and
  // ends, [6 node][2]; if they are not known, none.
  void add(std::vector<std::uint32_t> nodes, Eigen::MatrixXd derivative, Eigen::MatrixXd by_mass = {},
           Eigen::MatrixXd by_times = {});
  // Of the block that was added last, a single node: by the friction of the first and second surface that it touches,
  // [6][2]; -1: there is no second one.
  void set_friction(std::int32_t first, std::int32_t second, const Eigen::Matrix<double, 6, 2>& by_friction);
  [[nodiscard]] bool any() const noexcept { return !blocks_.empty(); }
  // What a step makes of a change of V, as far as it moves them, of nodes without rigid connections, ascending: blocks
  // dP/dV / w, or their transposes.
  [[nodiscard]] std::vector<layers::NodeResponse> responses(bool transposed) const;

  // What follows from the start alone, and what from V: (dP, dU) of (dp, dv), and of dV.
  void from_start(const Eigen::VectorXd& dp, const Eigen::VectorXd& dv, Eigen::VectorXd& end_dp,
                  Eigen::VectorXd& end_dv) const;
  void from_free(const Eigen::VectorXd& free, Eigen::VectorXd& end_dp, Eigen::VectorXd& end_dv) const;
  // Clears V of nodes whose outputs do not follow it at all, as of those that stick to a surface: solving for it would
  // leave rounding in others.
  void clear_unused(Eigen::VectorXd& free) const;
  // Adds what follows from changes of masses, [node] kg.
  void add_masses(const Eigen::VectorXd& masses, Eigen::VectorXd& end_dp, Eigen::VectorXd& end_dv) const;
  // The same from changes of coefficients of friction, [surface].
  void add_friction(const Eigen::VectorXd& coefficients, Eigen::VectorXd& end_dp, Eigen::VectorXd& end_dv) const;
  // Of constrained nodes: writes (dP, dU) by the time at the start, or the end. Returns a node whose is not known.
  [[nodiscard]] std::optional<std::uint32_t> write_times(bool at_end, Eigen::VectorXd& end_dp,
                                                         Eigen::VectorXd& end_dv) const;
  // Their transposes: of weights of (P, U).
  void to_start(const Eigen::VectorXd& end_dp, const Eigen::VectorXd& end_dv, Eigen::VectorXd& dp,
                Eigen::VectorXd& dv) const;
  void to_free(const Eigen::VectorXd& end_dp, const Eigen::VectorXd& end_dv, Eigen::VectorXd& free) const;
  [[nodiscard]] Eigen::VectorXd to_masses(const Eigen::VectorXd& end_dp, const Eigen::VectorXd& end_dv) const;
  [[nodiscard]] Eigen::VectorXd to_friction(const Eigen::VectorXd& end_dp, const Eigen::VectorXd& end_dv,
                                            Eigen::Index surfaces) const;

 private:
  struct Block {
    std::vector<std::uint32_t> nodes;
    Eigen::MatrixXd derivative, by_mass, by_times;
    std::int32_t surfaces[2] = {-1, -1};
    Eigen::Matrix<double, 6, 2> by_friction = Eigen::Matrix<double, 6, 2>::Zero();
  };
  [[nodiscard]] Eigen::VectorXd gather(const Block& block, const Eigen::VectorXd& of) const;
  void scatter(const Block& block, const Eigen::Ref<const Eigen::VectorXd>& from, Eigen::VectorXd& to) const;

  std::size_t nodes_ = 0;
  double c_ = 0.0, w_ = 0.0;
  std::vector<Block> blocks_;
};

}  // namespace springnet::learning
