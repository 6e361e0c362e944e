// An integrator, right but for one mistake, which MISTAKE_… chooses. Of first order, with the acceleration of the step
// before:
//   v' = v + h (3 a - a_before) / 2,   p' = p + h v'
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <springnet/sdk/integrator.hpp>

namespace {
using namespace springnet::sdk;

#ifdef MISTAKE_OPTION
constexpr int least_parts = 0;
#else
constexpr int least_parts = 1;
#endif

class Broken : public Integrator {
 public:
  static constexpr const char* id = "broken";
  static constexpr const char* summary = "right but for one mistake";
  static constexpr Parameter parameters[] = {
      integer("parts", "of a time step").preset(1).at_least(least_parts).at_most(100)};
#ifdef MISTAKE_STATES
  static constexpr bool integrates_states = true;
#endif
#ifdef MISTAKE_EVENTS
  static constexpr bool locates_events = true;
#endif

  Broken(Host host, Options options)
      : host_(host),
        next_(host.make_state()),
        parts_(options.integer("parts")),
        now_(3 * host.network().node_count),
        before_(3 * host.network().node_count) {
#ifdef MISTAKE_REPEATS
    static int runs = 0;
    factor_ += 1e-15 * ++runs;
#endif
#ifdef MISTAKE_LIVES
    left_ = new double[50];
#endif
  }

  springnet_status advance(double until, springnet_step_report& report) {
    const double start = host_.committed().time;
    for (std::int64_t part = 1; part <= parts_; ++part) {
      const double to = part == parts_ ? until : start + (until - start) * double(part) / double(parts_);
      step(host_.committed().time, to);
      ++report.steps;
    }
    report.outcome = SPRINGNET_SETTLED;
    report.residual = std::numeric_limits<double>::quiet_NaN();
    return SPRINGNET_OK;
  }

#ifdef MISTAKE_FORGET
  void forget() {}
#else
  void forget() { revision_ = none; }
#endif
  void save(const ByteSink& sink) const {
    sink.put(std::uint8_t{revision_ == host_.network().revision});
#ifdef MISTAKE_SAVE
    sink.put_all(std::span<const double>(before_).first(before_.size() / 2));
#else
    sink.put_all(std::span<const double>(before_));
#endif
  }
  void restore(std::span<const std::byte> bytes) {
#ifdef MISTAKE_RESTORE
    if (bytes.empty() || bytes.size() < before_.size()) throw Failure("too short");
    bytes = bytes.first(std::min(bytes.size(), 1 + before_.size() * sizeof(double)));
    std::memcpy(before_.data(), bytes.data() + 1, bytes.size() - 1);
    revision_ = host_.network().revision;
#else
    forget();
    ByteSource source(bytes);
    std::uint8_t is_known = 0;
    source.get(is_known);
#ifdef MISTAKE_SAVE
    source.get_all(std::span<double>(before_).first(before_.size() / 2));
#else
    source.get_all(std::span<double>(before_));
#endif
    if (!source.is_empty()) throw Failure("the memory is longer than this network's");
    if (is_known != 0) revision_ = host_.network().revision;
#endif
  }

 private:
  static constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();

  void step(double from, double to) {
    const double h = to - from;
#ifdef MISTAKE_STEPS
    static double* kept = nullptr;
    kept = new double[20]{h};
    static_cast<void>(kept);
#endif
    host_.begin_step(from, to);
    const std::uint64_t revision = host_.network().revision;
    const bool is_known = revision_ == revision;
    const springnet_state& now = host_.committed().state;
    auto sweep = sized<springnet_sweep>();
    sweep.time = to;
    sweep.time_constant = h;
    sweep.start_position = sweep.position = view(now.position);
    sweep.start_velocity = sweep.velocity = view(now.velocity);
    sweep.next_position = next_->position;
    sweep.next_velocity = next_->velocity;
    sweep.force = next_->force;
    const auto run = [&] {
      host_.sweep(sweep, [&](const springnet_node_batch& batch) {
        const std::size_t n = now_.size() / 3;
        const double *const a[] = {batch.acceleration.x, batch.acceleration.y, batch.acceleration.z},
                            *const v[] = {now.velocity.x, now.velocity.y, now.velocity.z},
                            *const p[] = {now.position.x, now.position.y, now.position.z};
        double *const to_v[] = {next_->velocity.x, next_->velocity.y, next_->velocity.z}, *const to_p[] = {
                                                                                              next_->position.x,
                                                                                              next_->position.y,
                                                                                              next_->position.z};
        for (std::uint32_t i = 0; i < batch.count; ++i) {
          const std::uint32_t k = batch.first + i;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            double mean = a[axis][i];
#ifdef MISTAKE_ORDER
            mean *= 0.98;
#endif
#ifdef MISTAKE_MOMENTUM
            if (k == 1 && axis == 0) mean += 1e-4;
#endif
#ifdef MISTAKE_THREADS
            mean *= 1.0 + 1e-15 * double(std::hash<std::thread::id>()(std::this_thread::get_id()) % 101);
#endif
            now_[axis * n + k] = mean;
            if (is_known) mean = 1.5 * mean - 0.5 * before_[axis * n + k];
            to_v[axis][k] = v[axis][k] + h * mean * factor_;
            to_p[axis][k] = p[axis][k] + h * to_v[axis][k];
          }
        }
      });
    };
    run();
#if defined(MISTAKE_CONTACT) || defined(MISTAKE_RIGID)
    // Moves nodes as if nothing restricted them.
    for (std::size_t k = 0; k < now_.size() / 3; ++k) {
#ifdef MISTAKE_CONTACT
      if (host_.network().surface_count == 0) break;
#else
      if (host_.network().rigid_count == 0) break;
#endif
      next_->velocity.z[k] = now.velocity.z[k] + h * now_[2 * (now_.size() / 3) + k];
      next_->position.z[k] = now.position.z[k] + h * next_->velocity.z[k];
      next_->velocity.y[k] = 0.5 * now.velocity.y[k];
      next_->position.y[k] = now.position.y[k];
    }
#endif
#if defined(MISTAKE_REFUSALS)
    for (bool refused = true; refused;) {  // until the host takes it
      try {
        host_.commit(to, *next_);
        refused = false;
      } catch (const Failure&) {
      }
    }
#elif defined(MISTAKE_SILENT)
    try {
      host_.commit(to, *next_);
    } catch (const Failure&) {
      throw Failure("", SPRINGNET_UNSETTLED);
    }
#else
    host_.commit(to, *next_);
#endif
    before_.swap(now_);
    revision_ = revision;
  }

  Host host_;
  State next_;
  std::int64_t parts_;
  std::vector<double> now_, before_;  // accelerations, x of all nodes first
  std::uint64_t revision_ = none;     // that `before_` belongs to
  double factor_ = 1.0;
#ifdef MISTAKE_LIVES
  double* left_;
#endif
};

}  // namespace

SPRINGNET_PLUGIN("org.example.broken_integrator", "1.0", "a test", "MIT", Broken);
