#include "profile/stage.hpp"

#include "profile/recording.hpp"

namespace springnet::profile {

thread_local constinit Current current{nullptr, nullptr};

void Stage::begin(Kind kind, const char* name) noexcept {
  if (lane_->in_tile || !lane_->begin(kind, name)) lane_ = nullptr;
}
void Stage::end() noexcept { lane_->end(); }

void Tile::begin() noexcept {
  if (lane_->in_tile) {
    lane_ = nullptr;
    return;
  }
  lane_->in_tile = true;
  if (lane_->measures_next()) current.parts = lane_;
}
void Tile::end() noexcept {
  lane_->in_tile = false;
  current.parts = nullptr;
}

void Region::begin(unsigned threads) noexcept {
  stage_ = lane_->present();
  if (threads < 2 || lane_->in_tile || lane_->number() > 0 || !lane_->recording().prepare(threads) ||
      !lane_->begin_region()) {
    lane_ = nullptr;
    return;
  }
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
