#include "new_files.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <springnet/printable.hpp>

#include "common.hpp"

namespace springnet::tool {

namespace {

void refuse_existing(const std::vector<Planned>& files) {
  for (const Planned& planned : files) {
    std::error_code unknown;
    if (!std::filesystem::exists(std::filesystem::symlink_status(planned.file, unknown))) continue;
    throw Error(ErrorKind::input,
                fmt::format("{} already exists, and nothing was written; choose another folder with -o",
                            printable_message(planned.file.string())));
  }
}

// The outermost folder on the way to this one that is not there; empty if all are.
std::filesystem::path first_missing(const std::filesystem::path& folder) {
  std::filesystem::path missing;
  std::error_code unknown;
  for (std::filesystem::path each = folder; !each.empty() && !std::filesystem::exists(each, unknown);
       each = each.parent_path())
    missing = each;
  return missing;
}

// Removes folders from `folder` up to `outermost`, as far as they are empty.
void remove_empty(std::filesystem::path folder, const std::filesystem::path& outermost) {
  std::error_code ignored;
  for (; !outermost.empty() && folder.has_relative_path(); folder = folder.parent_path()) {
    std::filesystem::remove(folder, ignored);
    if (folder == outermost) return;
  }
}

[[noreturn]] void fail_to_write(const std::filesystem::path& file, const std::string& reason) {
  throw Error(
      ErrorKind::simulation,
      fmt::format("{}: cannot be written: {}; no file was left behind. Make room, or choose another folder with -o",
                  printable_message(file.string()), reason));
}

// Removes the file if writing fails.
void write_new(const Planned& planned) {
  std::error_code problem, ignored;
  if (!planned.source.empty()) {
    std::filesystem::copy_file(planned.source, planned.file, problem);  // fails if the file exists by now
    if (problem && problem != std::errc::file_exists) std::filesystem::remove(planned.file, ignored);
    if (problem) fail_to_write(planned.file, problem.message());
    return;
  }
  // "x": fails if the file exists, and does not follow a link.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(planned.file.c_str(), "wx"), &std::fclose);
  if (!out) fail_to_write(planned.file, std::error_code(errno, std::generic_category()).message());
  if (std::fwrite(planned.text.data(), 1, planned.text.size(), out.get()) != planned.text.size() ||
      std::fflush(out.get()) != 0) {
    const std::error_code reason(errno, std::generic_category());
    std::filesystem::remove(planned.file, ignored);
    fail_to_write(planned.file, reason.message());
  }
}

}  // namespace

void write_all(const std::filesystem::path& folder, const std::vector<Planned>& files) {
  refuse_existing(files);
  const std::filesystem::path created = first_missing(folder);
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) {
    remove_empty(folder, created);
    throw Error(ErrorKind::input, fmt::format("{}: the folder cannot be created: {}; choose another one with -o",
                                              printable_message(folder.string()), problem.message()));
  }
  std::vector<std::filesystem::path> written;
  try {
    for (const Planned& planned : files) {
      write_new(planned);
      written.push_back(planned.file);
    }
  } catch (const Error&) {
    // Half of them would block the next attempt.
    for (const std::filesystem::path& file : written) std::filesystem::remove(file, problem);
    remove_empty(folder, created);
    throw;
  }
  for (const std::filesystem::path& file : written) fmt::print("{}\n", printable_message(file.string()));
}

}  // namespace springnet::tool
