#include "profile/stage.hpp"

#include "profile/recording.hpp"

namespace springnet::profile {

thread_local constinit Current current{nullptr, nullptr};
constinit std::atomic<std::uint32_t> open_scopes{0};

void Stage::begin(Kind kind, const char* name) noexcept {
  Lane* const lane = current.stages;
  if (lane != nullptr && !lane->in_tile && lane->begin(kind, name)) lane_ = lane;
}
void Stage::end() noexcept { lane_->end(); }

void Region::begin(unsigned threads) noexcept {
  Lane* const lane = current.stages;
  if (lane == nullptr || threads < 2 || lane->in_tile || lane->number() > 0) return;
  stage_ = lane->present();
  if (!lane->recording().prepare(threads) || !lane->begin_region()) return;
  lane_ = lane;
  region_ = lane_->present();
}

void Share::begin(const Region& region, std::uint32_t thread, std::uint32_t threads) noexcept {
  lane_ = &region.lane_->recording().lane(thread);
  stage_ = region.stage_;
  if (!lane_->begin_share(region.region_, threads)) {
    lane_ = nullptr;
    return;
  }
  if (thread > 0) current = {lane_, nullptr};
}
void Share::end() noexcept {
  lane_->end_share(stage_);
  if (lane_->number() > 0) current = {};
}

}  // namespace springnet::profile
