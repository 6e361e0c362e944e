#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "text/archive.hpp"
#include "view/base64.hpp"
#include "view/frames.hpp"

using namespace springnet::view;

namespace {

std::string base64_text(std::string_view text) { return base64(std::as_bytes(std::span(text))); }

Frames frames_of(std::size_t records, std::size_t capacity) {
  Frames frames({.scalars = 1, .nodes = 9, .springs = 0, .surfaces = 0, .touches = 2}, capacity, records);
  for (std::size_t k = 0; k < records; ++k) {
    frames.begin();
    frames.scalars.last()[0] = static_cast<double>(k);
    frames.speeds.last()[8] = static_cast<float>(k);
    frames.touches.last()[13] = static_cast<float>(k);
    frames.contact.last()[1] = static_cast<std::uint8_t>(k % 256);
  }
  return frames;
}

}  // namespace

TEST_CASE("frames that are refused leave none, so that no page is written of them") {
  Frames frames = frames_of(5, 10);
  std::string bytes;
  springnet::Archive out(&bytes);
  frames.archive(out);
  // More frames than there are rows: their number is that after stride and records.
  std::string forged = bytes;
  forged[2 * sizeof(std::size_t)] = 9;
  Frames other = frames_of(0, 10);
  springnet::Archive in{std::string_view(forged)};
  CHECK_THROWS_AS(other.archive(in), springnet::Error);
  CHECK(other.count() == 0);
  Frames whole = frames_of(0, 10);
  springnet::Archive again{std::string_view(bytes)};
  whole.archive(again);
  CHECK(whole.count() == 5);
  CHECK(whole.speeds.numbers() == frames.speeds.numbers());
  CHECK(whole.touches.numbers() == frames.touches.numbers());
}

TEST_CASE("base64 of the examples of RFC 4648") {
  CHECK(base64_text("") == "");
  CHECK(base64_text("f") == "Zg==");
  CHECK(base64_text("fo") == "Zm8=");
  CHECK(base64_text("foo") == "Zm9v");
  CHECK(base64_text("foob") == "Zm9vYg==");
  CHECK(base64_text("fooba") == "Zm9vYmE=");
  CHECK(base64_text("foobar") == "Zm9vYmFy");
  CHECK(base64_text("\xFB\xEF\xBE\xFF") == "++++/w==");
}

TEST_CASE("records are kept as they are while they fit") {
  const Frames frames = frames_of(10, 10);
  CHECK(frames.count() == 10);
  CHECK(frames.stride() == 1);
  for (std::size_t k = 0; k < 10; ++k) CHECK(frames.scalars.numbers()[k] == static_cast<double>(k));
}

TEST_CASE("if there are more records, every second, fourth, … is kept, and always the first and the last") {
  for (const std::size_t capacity : std::vector<std::size_t>{2, 3, 7, 10, 64}) {
    for (const std::size_t records : std::vector<std::size_t>{1, 2, 11, 12, 100, 128, 129, 1000}) {
      CAPTURE(capacity);
      CAPTURE(records);
      const Frames frames = frames_of(records, capacity);
      REQUIRE(frames.count() >= 1);
      CHECK(frames.count() <= capacity);
      CHECK(frames.recorded() == records);
      // Never fewer than half of what would fit: else the page would be needlessly coarse.
      CHECK(2 * frames.count() >= std::min(capacity, records));
      for (std::size_t k = 0; k < frames.count(); ++k) {
        const std::size_t expected = k + 1 < frames.count() ? k * frames.stride() : records - 1;
        CHECK(frames.scalars.numbers()[k] == static_cast<double>(expected));
        CHECK(frames.speeds.numbers()[9 * k + 8] == static_cast<float>(expected));
        CHECK(frames.touches.numbers()[14 * k + 13] == static_cast<float>(expected));
        CHECK(frames.contact.numbers()[2 * k + 1] == expected % 256);
      }
    }
  }
}
