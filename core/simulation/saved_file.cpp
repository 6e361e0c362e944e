// Simulation::save_to() and restore_from(): a saved state in a file.
#include <springnet/simulation.hpp>

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fmt/format.h>

#include <springnet/output_folder.hpp>

#include "files/input_file.hpp"
#include "files/whole_file.hpp"
#include "simulation/implementation.hpp"
#include "simulation/saved_state.hpp"

namespace springnet {
namespace {

// Bytes. Longer ones are of no simulation that fits into memory.
constexpr std::uint64_t longest_identity = 1 << 20;

[[noreturn]] void refuse_file(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorKind::input, fmt::format("{}: {}", file.string(), what));
}

// The file that is to be replaced: a link stays, what it leads to is written.
std::filesystem::path target_of(const std::filesystem::path& file) {
  if (!file.has_filename()) refuse_file(file, "the state cannot be saved: this names a folder; add the name of a file");
  std::error_code failed;
  std::filesystem::path target = file;
  constexpr int most_links = 40;  // as the system follows
  for (int links = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(target, failed)); ++links) {
    const std::filesystem::path next = std::filesystem::read_symlink(target, failed);
    if (failed || links == most_links)
      refuse_file(file, "the state cannot be saved: this link leads nowhere; remove it, or name another file");
    target = target.parent_path() / next;  // an absolute one replaces it
  }
  const std::filesystem::file_status status = std::filesystem::status(target, failed);
  if (std::filesystem::is_directory(status))
    refuse_file(file, "the state cannot be saved: a folder has this name; name another file");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    refuse_file(file,
                "the state cannot be saved: this is a device or a pipe, which cannot be replaced; name another file");
  return target;
}

}  // namespace

void Simulation::save_to(const std::filesystem::path& file) {
  const std::filesystem::path target = target_of(file);
  const std::string saved = save();
  try {
    WholeFile whole{OutputFile(target)};
    whole.stream() << saved;
    whole.finish(true);
  } catch (const Error& error) {  // they name the file, or that beside it
    throw Error(ErrorKind::input, fmt::format("{}: the state cannot be saved: {}", file.string(), error.what()));
  }
}

void Simulation::restore_from(const std::filesystem::path& file) {
  Impl& impl = impl_->between_steps();
  InputFile in(file);
  try {
    std::string bytes;
    const bool has_head = in.read(bytes, SavedHead::size);
    const SavedHead head(bytes);
    if (!has_head) Archive::refuse("it ends too early");
    if (in.size()) head.check_size(*in.size());
    if (head.identity_size > longest_identity) Archive::refuse("it tells too much of what it is of");
    // What it is of, before more is read.
    bytes.clear();
    if (!in.read(bytes, head.identity_size)) Archive::refuse("it ends too early");
    impl.check_identity(head, bytes);
    bytes.clear();
    if (!in.read(bytes, head.state_size)) Archive::refuse("it ends too early");
    std::string more;
    if (in.read(more, 1)) Archive::refuse("it is too long");
    impl.restore_state(head, bytes);
  } catch (const Error& error) {
    const std::string name = file.string() + ": ";
    const std::string text = error.what();
    throw Error(error.kind(), text.starts_with(name) ? text : name + text);
  } catch (const std::bad_alloc&) {
    refuse_file(file, "this state is too large for the memory of this machine");
  }
}

}  // namespace springnet
