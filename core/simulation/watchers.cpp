#include "simulation/watchers.hpp"

#include <utility>

#include "simulation/implementation.hpp"

namespace springnet {
namespace {

// Changes of the simulation are refused while this exists.
class InCallback {
 public:
  explicit InCallback(bool& flag) : flag_(flag) { flag_ = true; }
  ~InCallback() { flag_ = false; }
  InCallback(const InCallback&) = delete;
  InCallback& operator=(const InCallback&) = delete;

 private:
  bool& flag_;
};

}  // namespace

void Watchers::tell_events(const std::vector<Event>& events) {
  if (!on_event) {
    told = events.size();
    return;
  }
  const InCallback inside(are_called);
  while (told < events.size()) on_event(events[told++]);
}

void Watchers::tell_step(const StepReport& report) {
  if (!on_step) return;
  const InCallback inside(are_called);
  on_step(report);
}

void Simulation::Impl::publish() {
  if (!watchers.shelf->keeps()) return;
  const Model& model = engine.model();
  std::unique_ptr<Snapshot> snapshot = watchers.shelf->blank();
  snapshot->time = model.time;
  snapshot->steps = steps;
  snapshot->live_springs = model.layout.live_count();
  snapshot->events = model.journal.events().size();
  const std::vector<std::uint32_t>& columns = model.layout.ordering().engine;
  snapshot->positions.resize(3, static_cast<Eigen::Index>(columns.size()));
  snapshot->velocities.resize(3, static_cast<Eigen::Index>(columns.size()));
  const springnet_vectors &p = model.state.view.position, &v = model.state.view.velocity;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const std::uint32_t from = columns[k];
    const auto to = static_cast<Eigen::Index>(k);
    snapshot->positions.col(to) << p.x[from], p.y[from], p.z[from];
    snapshot->velocities.col(to) << v.x[from], v.y[from], v.z[from];
  }
  watchers.shelf->put(std::move(snapshot));
}

void Simulation::Impl::changed() {
  ++state_version;
  publish();
  watchers.tell_events(engine.model().journal.events());
}

void Simulation::Impl::stepped() {
  changed();
  watchers.tell_step(last);
}

void Simulation::on_event(std::function<void(const Event&)> callback) {
  Impl& impl = impl_->between_steps();
  impl.watchers.on_event = std::move(callback);
  impl.watchers.told = events().size();
}
void Simulation::on_step(std::function<void(const StepReport&)> callback) {
  impl_->between_steps().watchers.on_step = std::move(callback);
}
void Simulation::keep_snapshots(bool keep) {
  Impl& impl = impl_->between_steps();
  impl.watchers.shelf->keep(keep);
  impl.publish();
}
std::shared_ptr<const Snapshot> Simulation::snapshot() const { return others_->shelf->take(); }

}  // namespace springnet
