#include "inspection/vibration.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>
#include <springnet/sdk/limits.hpp>

#include "simulation/dominant.hpp"

namespace springnet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

// Motions without stiffness are found before the first vibration; with more of them the search would take too long.
constexpr std::size_t max_free_motions = 24;
// Relative to the greatest eigenvalue: keeps the factorisation regular, and is small beside a slow vibration (1e-8 for
// a beam of 100 cells).
constexpr double shift = 1e-10;
// Relative asymmetry above which frequencies make no sense.
constexpr double asymmetry = 1e-9;

bool is_within_reach(const StartingNetwork& start, const Mobility& mobility) {
  if (start.survey() == nullptr || !mobility.known || !start.network().rigids().empty()) return false;
  if (mobility.mechanisms + mobility.rigid_body_motions > max_free_motions) return false;
  return start.layout().elements().live_enclosures() == 0;
}

// -da/dp and -da/dv of the free nodes, in coordinates scaled by the root of the mass.
class Matrices {
 public:
  explicit Matrices(Engine& engine) : engine_(engine), column_(engine.model().mass.size(), -1) {
    const std::vector<std::uint8_t>& constrained = engine.model().contact.constrained();
    for (std::size_t k = 0; k < column_.size(); ++k) {
      if (constrained[k] != 0) continue;
      column_[k] = size_;
      size_ += 3;
    }
  }
  [[nodiscard]] int size() const { return size_; }
  // scale: approximate size of the entries, so that the 1 on the host's diagonal does not hide them.
  [[nodiscard]] Matrix stiffness(double scale) const { return reduced(0.0, 1.0 / scale); }
  [[nodiscard]] Matrix damping(double scale) const { return reduced(1.0 / scale, 0.0); }

 private:
  [[nodiscard]] Matrix reduced(double velocity_weight, double position_weight) const {
    const double weight = velocity_weight + position_weight;
    const std::vector<double>& mass = engine_.model().mass;
    std::vector<Eigen::Triplet<double>> entries;
    engine_.linear().matrices().for_each_entry(
        velocity_weight, position_weight, [&](int row, int column, double value) {
          const auto i = static_cast<std::size_t>(row / 3), j = static_cast<std::size_t>(column / 3);
          if (column_[i] < 0 || column_[j] < 0) return;
          const double entry = value - (row == column ? 1.0 : 0.0);
          entries.emplace_back(column_[i] + row % 3, column_[j] + column % 3,
                               entry / weight * std::sqrt(mass[i] / mass[j]));
        });
    Matrix result(size_, size_);
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  }

  Engine& engine_;
  std::vector<int> column_;
  int size_ = 0;
};

}  // namespace

std::optional<Vibration> slowest_vibration(const StartingNetwork& start, const Mobility& mobility) {
  if (!is_within_reach(start, mobility)) return std::nullopt;
  const std::size_t free_motions = mobility.mechanisms + mobility.rigid_body_motions;
  const sdk::Host host(start.survey()->table());
  const Matrices matrices(start.survey()->engine());
  if (static_cast<std::size_t>(matrices.size()) <= free_motions) return std::nullopt;
  double guess = 0.0;  // s
  try {
    const auto [time, state] = host.committed();
    host.begin_interval(time, time + 1.0);
    host.linearise(sdk::evaluation_at(time, state));
    guess = sdk::LinearisedNetwork(host).first_guess().value_or(0.0);
  } catch (const sdk::Failure&) {  // a law without derivatives
    return std::nullopt;
  }
  if (!(guess > 0.0)) return std::nullopt;
  const Matrix stiffness = matrices.stiffness(1.0 / (guess * guess)), damping = matrices.damping(1.0 / guess);
  const double greatest = Eigen::VectorXd(stiffness.diagonal()).maxCoeff();
  if (!(greatest > 0.0) || !std::isfinite(greatest)) return std::nullopt;
  if (!(Matrix(stiffness - Matrix(stiffness.transpose())).norm() <= asymmetry * stiffness.norm())) return std::nullopt;

  Matrix shifted = stiffness;
  for (int k = 0; k < matrices.size(); ++k) shifted.coeffRef(k, k) += shift * greatest;
  const Eigen::SimplicialLDLT<Matrix> factors(shifted);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0.0)) return std::nullopt;

  // Inverse iteration: the greatest eigenvalues of the inverse are those of the motions without stiffness, which are
  // removed one by one, then that of the slowest vibration.
  std::vector<Eigen::VectorXd> found_modes;
  const auto remove_found_modes = [&](Eigen::VectorXd& x) {
    for (int pass = 0; pass < 2; ++pass)
      for (const Eigen::VectorXd& motion : found_modes) x -= motion.dot(x) * motion;
  };
  const std::vector<double> scattered = sdk::scattered_vector(static_cast<std::size_t>(matrices.size()));
  Dominant found;
  while (found_modes.size() <= free_motions) {
    Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(scattered.data(), matrices.size());
    remove_found_modes(x);
    DominantOptions options;
    // Remainders of motions without stiffness would be amplified many times.
    options.tolerance = found_modes.size() < free_motions ? 1e-10 : 1e-4;
    found = dominant_eigenvalue(
        [&](Eigen::VectorXd& values) {
          remove_found_modes(values);
          values = factors.solve(values).eval();
          remove_found_modes(values);
        },
        x, options);
    found_modes.push_back(found.real.normalized());
  }
  const double value = 1.0 / found.value.real() - shift * greatest;
  // Not distinguishable from the motions that nothing resists.
  if (!(value > 10.0 * shift * greatest)) return std::nullopt;
  const Eigen::VectorXd& mode = found_modes.back();
  const double frequency = std::sqrt(value);  // rad/s
  return Vibration{2.0 * std::acos(-1.0) / frequency, mode.dot(damping * mode) / (2.0 * frequency)};
}

}  // namespace springnet
