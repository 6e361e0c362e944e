#include "simulation/dissipation_ledger.hpp"

#include <utility>

#include "profile/stage.hpp"

namespace springnet {

void DissipationLedger::evaluate(const Model& model, layers::Losses& losses) const {
  const profile::Stage stage("dissipation");
  layers::evaluate_losses(model.layout, model.evaluator.instruction_set(), model.time, model.state.nodes(), losses);
}

void DissipationLedger::begin_step(const Model& model) {
  if (revision_ == model.revision) return;
  evaluate(model, now_);
  revision_ = model.revision;
}

void DissipationLedger::end_step(const Model& model) {
  std::swap(now_, before_);
  evaluate(model, now_);
  total_ += layers::known_dissipation(model.layout, before_, now_);
  revision_ = model.revision;
}

}  // namespace springnet
