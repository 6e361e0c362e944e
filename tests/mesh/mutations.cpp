// Files that are truncated or damaged anywhere give an error of input or a sound mesh.
#include <doctest/doctest.h>

#include <random>

#include <springnet/error.hpp>

#include "repetitions.hpp"
#include "samples.hpp"
#include "soundness.hpp"

namespace springnet::testing {
namespace {

void check_sound(const Mesh& mesh) {
  CHECK(is_sound(mesh));
  CHECK(hinges_of(surface_of(mesh)).size() <= edges_of(mesh, {.face_diagonals = true}).size());
}

class Damage {
 public:
  explicit Damage(const std::string& name) : file_(folder_.path() / name), name_(name) {}

  // Whether the file can still be read.
  bool is_read(const std::string& bytes) {
    folder_.write(name_, bytes);
    try {
      check_sound(read_mesh(file_));
      return true;
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      CHECK(std::string_view(error.what()).starts_with(file_.string() + ":"));
      return false;
    }
  }

 private:
  TemporaryFolder folder_;
  std::filesystem::path file_;
  std::string name_;
};

TEST_CASE("truncated files") {
  for (const Sample& sample : all_samples()) {
    CAPTURE(sample.name);
    Damage damage(sample.name);
    REQUIRE(damage.is_read(sample.bytes));
    // Without its first half none has a cell.
    const std::size_t step = std::max<std::size_t>(sample.bytes.size() / 150, 1);
    for (std::size_t size = 0; size < sample.bytes.size(); size += step) {
      CAPTURE(size);
      const bool is_read = damage.is_read(sample.bytes.substr(0, size));
      if (size < sample.bytes.size() / 3) CHECK(!is_read);
    }
  }
}

TEST_CASE("damaged files") {
  std::mt19937 random(1);  // gives the same numbers everywhere
  const std::uint64_t tries_each = repetitions("SPRINGNET_MESH_MUTATIONS", 200);
  std::size_t refused = 0, tries = 0;
  for (const Sample& sample : all_samples()) {
    CAPTURE(sample.name);
    Damage damage(sample.name);
    for (std::uint64_t k = 0; k < tries_each; ++k) {
      std::string bytes = sample.bytes;
      for (auto flips = 1 + random() % 3; flips > 0; --flips) {
        char& byte = bytes[random() % bytes.size()];
        switch (random() % 4) {
          case 0:
            byte = static_cast<char>(byte ^ static_cast<char>(1U << random() % 8));
            break;
          case 1:
            byte = static_cast<char>('0' + random() % 10);
            break;
          case 2:
            byte = '-';
            break;
          default:
            byte = static_cast<char>(random() % 256);
        }
      }
      CAPTURE(k);
      ++tries;
      if (!damage.is_read(bytes)) ++refused;
    }
  }
  // Some changes hit a name or a coordinate and do no harm; far from all do.
  CHECK(refused > tries / 4);
  CHECK(refused < tries);
  MESSAGE(tries << " damaged files, " << refused << " refused, the others sound");
}

}  // namespace
}  // namespace springnet::testing
