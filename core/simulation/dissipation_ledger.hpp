// The energy that laws have dissipated: summed up over the committed steps.
#pragma once

#include "layers/dissipation.hpp"
#include "simulation/model.hpp"

namespace springnet {

class DissipationLedger {
 public:
  // Once the committed state is that from which the step goes on. Evaluates laws only if it is not that at which the
  // last step ended.
  void begin_step(const Model& model);
  // At the newly committed state, before what happens there: jumps of motions, ruptures, cuts.
  void end_step(const Model& model);

  [[nodiscard]] double total() const noexcept { return total_; }  // J
  void take_over(const DissipationLedger& before) noexcept { total_ = before.total_; }
  void archive(Archive& archive) {
    archive.number(total_);
    if (archive.reads()) revision_ = 0;
  }

 private:
  void evaluate(const Model& model, layers::Losses& losses) const;

  layers::Losses now_, before_;
  std::uint64_t revision_ = 0;  // of the model at now_; 0: now_ is not known
  double total_ = 0.0;
};

}  // namespace springnet
