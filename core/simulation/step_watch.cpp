#include "simulation/step_watch.hpp"

#include <utility>

namespace springnet {
namespace {

thread_local constinit StepWatch* watching = nullptr;

}  // namespace

StepWatch::Scope::Scope(StepWatch& watch) noexcept : before_(std::exchange(watching, &watch)) {}
StepWatch::Scope::~Scope() { watching = before_; }
StepWatch* StepWatch::current() noexcept { return watching; }

}  // namespace springnet
