#include <springnet/profile.hpp>

#include "profile/recording.hpp"
#include "profile/stage.hpp"

namespace springnet {

std::string_view name_of(ProfileStage::Kind kind) noexcept {
  switch (kind) {
    case ProfileStage::Kind::stage:
      return "stage";
    case ProfileStage::Kind::integrator:
      return "integrator";
    case ProfileStage::Kind::spring_function:
      return "spring function";
    case ProfileStage::Kind::viscosity_function:
      return "viscosity function";
    case ProfileStage::Kind::neuron:
      return "neuron";
    case ProfileStage::Kind::output:
      return "output";
  }
  return "unknown";
}

std::string label_of(const ProfileStage& stage) {
  const bool component = stage.kind != ProfileStage::Kind::stage && stage.kind != ProfileStage::Kind::output;
  return component ? std::string(name_of(stage.kind)) + " " + stage.name : stage.name;
}

Profiler::Profiler(std::size_t trace_events)
    : recording_(std::make_unique<profile::Recording>(trace_events, profile::measured_part_cost())) {}
Profiler::~Profiler() = default;
Profiler::Profiler(Profiler&&) noexcept = default;
Profiler& Profiler::operator=(Profiler&&) noexcept = default;

Profile Profiler::profile() const { return recording_->merged(); }

void Profiler::clear() {
  if (!recording_->in_use) recording_->clear();
}

Profiler::Scope::Scope(Profiler* profiler, const char* name) noexcept
    : recording_(profiler == nullptr ? nullptr : profiler->recording_.get()) {
  if (recording_ == nullptr) return;
  profile::Lane& lane = recording_->first();
  const profile::Current outer = profile::current;
  if (outer.stages != &lane) {
    if (recording_->in_use.exchange(true)) {  // by another thread, or further out in this one
      recording_ = nullptr;
      return;
    }
    entered_ = true;
    ++profile::open_scopes;
    outer_stages_ = outer.stages;
    outer_parts_ = outer.parts;
    profile::current = {&lane, nullptr};
  }
  begun_ = !lane.in_tile && lane.begin(ProfileStage::Kind::stage, name);
}

Profiler::Scope::~Scope() {
  if (recording_ == nullptr) return;
  if (begun_) recording_->first().end();
  if (!entered_) return;
  profile::current = {static_cast<profile::Lane*>(outer_stages_), static_cast<profile::Lane*>(outer_parts_)};
  recording_->in_use = false;
  --profile::open_scopes;
}

}  // namespace springnet
