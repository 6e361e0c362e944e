#include "mesh/source.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

namespace springnet::meshes {
namespace {

// Bytes. A sparse file may be larger than the memory and take no room on the disk.
constexpr std::uintmax_t largest_file = std::uintmax_t{4} << 30U;

}  // namespace

Source::Source(const std::filesystem::path& file, LoadingCallback loading, bool wants_cells)
    : name_(file.string()),
      loading_(std::move(loading)),
      stage_("reading " + printable(file.filename().string())),
      wants_cells_(wants_cells) {
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(file, failed);
  if (!std::filesystem::exists(status)) fail("there is no such mesh file; check the path");
  // Pipes and devices may never end.
  if (!std::filesystem::is_regular_file(status)) fail("this is not a file; name a mesh file");
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  std::ifstream in(file, std::ios::binary);
  if (failed || !in) fail(fmt::format("the file cannot be opened ({}); check its permissions", std::strerror(errno)));
  if (size > largest_file) fail("the file is larger than 4 GiB; use a coarser mesh");
  if (size < slow_to_load) loading_ = {};
  if (loading_) loading_({stage_, 0.0});
  text_.resize(static_cast<std::size_t>(size));
  in.read(text_.data(), static_cast<std::streamsize>(text_.size()));
  if (static_cast<std::uintmax_t>(in.gcount()) != size) fail("the file cannot be read to its end; copy it again");
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // of UTF-8; only text files begin with it
  if (text_.starts_with(byte_order_mark)) text_.erase(0, byte_order_mark.size());
  if (text_.empty()) fail("the file is empty; export the mesh again");
}

void Source::tell(Place place) const {
  if (!loading_) return;
  loading_({stage_, std::min(1.0, static_cast<double>(place.offset) / static_cast<double>(text_.size()))});
}

std::ptrdiff_t Source::line_of(Place place) const {
  const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(place.offset, text_.size()));
  return 1 + std::count(text_.begin(), end, '\n');
}

std::string Source::description(Place place) const {
  return place.binary ? fmt::format("byte {}", place.offset) : fmt::format("line {}", line_of(place));
}

void Source::fail(Place place, std::string_view message) const {
  if (place.binary) throw Error(ErrorKind::input, fmt::format("{}: byte {}: {}", name_, place.offset, message));
  throw Error(ErrorKind::input, fmt::format("{}:{}: {}", name_, line_of(place), message));
}

void Source::fail(std::string_view message) const {
  throw Error(ErrorKind::input, fmt::format("{}: {}", name_, message));
}

bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace springnet::meshes
