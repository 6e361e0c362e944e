#include <springnet/output_folder.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include <fmt/format.h>
#include <springnet/error.hpp>

namespace springnet {

namespace {

constexpr int folder_flags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;
constexpr mode_t all_may_read_and_write = 0666, all_may_enter = 0777;  // before the umask

[[noreturn]] void refuse_file(const std::filesystem::path& file, int reason) {
  if (reason == EISDIR) {
    throw Error(ErrorKind::input,
                fmt::format("{}: a folder has the name of this file; remove it, or choose another output folder",
                            file.string()));
  }
  throw Error(ErrorKind::input, fmt::format("{}: cannot be created: {}; choose another output folder", file.string(),
                                            std::strerror(reason)));
}

[[noreturn]] void refuse_folder(const std::filesystem::path& folder, const std::string& reason) {
  throw Error(ErrorKind::input,
              fmt::format("{}: the output folder cannot be created: {}; choose another one", folder.string(), reason));
}

std::string reason_of(int error) {
  return error == ENOTDIR || error == ELOOP || error == EEXIST ? "a file has this name" : std::strerror(error);
}

// A host may have closed its standard streams; a table on such a descriptor would receive what the host prints.
int above_standard_streams(int descriptor) {
  if (descriptor < 0 || descriptor > STDERR_FILENO) return descriptor;
  const int higher = fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return higher;
}

}  // namespace

OutputFile::OutputFile(std::shared_ptr<const OutputFolder> folder, std::string name)
    : path_(folder->path() / name), folder_(std::move(folder)), name_(std::move(name)) {}

OutputFile OutputFile::part() const {
  OutputFile part = *this;
  part.name_ = part_name(name_);
  return part;
}

std::string part_name(std::string_view name) { return std::string(name) + ".part"; }

OutputFolder::Pointer OutputFolder::make(const std::filesystem::path& path) {
  std::error_code failed;
  std::filesystem::create_directories(path, failed);
  // For a link this reports EEXIST; opening it shows whether it leads to a folder.
  const int descriptor = above_standard_streams(::open(path.c_str(), folder_flags));
  if (descriptor < 0) refuse_folder(path, failed ? reason_of(failed.value()) : reason_of(errno));
  return Pointer(new OutputFolder(path, descriptor));
}

OutputFolder::Pointer OutputFolder::find(const std::filesystem::path& path) {
  const int descriptor = above_standard_streams(::open(path.c_str(), folder_flags));
  return descriptor < 0 ? nullptr : Pointer(new OutputFolder(path, descriptor));
}

OutputFolder::Pointer OutputFolder::containing(const std::filesystem::path& file) {
  const std::filesystem::path path = file.has_parent_path() ? file.parent_path() : ".";
  const int descriptor = above_standard_streams(::open(path.c_str(), folder_flags));
  if (descriptor < 0) refuse_file(file, errno);
  return Pointer(new OutputFolder(path, descriptor));
}

OutputFolder::Pointer OutputFolder::make_inside(const Pointer& parent, const std::string& name) {
  if (parent->kind(name) == Kind::link) parent->remove(name);
  const bool made = mkdirat(parent->descriptor_, name.c_str(), all_may_enter) == 0;
  const int reason = errno;
  Pointer folder = find_inside(parent, name);
  if (!folder) refuse_folder(parent->path_ / name, reason_of(made ? errno : reason));
  return folder;
}

OutputFolder::Pointer OutputFolder::find_inside(const Pointer& parent, const std::string& name) {
  const int descriptor = above_standard_streams(::openat(parent->descriptor_, name.c_str(), folder_flags | O_NOFOLLOW));
  if (descriptor < 0) return nullptr;
  auto* const folder = new OutputFolder(parent->path_ / name, descriptor);
  folder->parent_ = parent;
  folder->name_ = name;
  return Pointer(folder);
}

OutputFolder::~OutputFolder() { ::close(descriptor_); }

void OutputFolder::lock() const {
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  throw Error(ErrorKind::input, fmt::format("{}: another run is writing to this folder; wait until it ends, or choose "
                                            "another output folder",
                                            path_.string()));
}

int OutputFolder::create(const std::string& name) const {
  // Another process may create the name in between; give up the second time.
  for (int tries = 0; tries < 3; ++tries) {
    if (unlinkat(descriptor_, name.c_str(), 0) != 0 && errno != ENOENT) break;
    const int made = ::openat(descriptor_, name.c_str(),
                              O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC | O_NOCTTY, all_may_read_and_write);
    const int descriptor = above_standard_streams(made);
    if (descriptor >= 0) return descriptor;
    if (errno != EEXIST) break;
  }
  refuse_file(path_ / name, errno);
}

void OutputFolder::require_no_folder(const std::string& name) const {
  if (kind(name) == Kind::folder) refuse_file(path_ / name, EISDIR);
}

bool OutputFolder::remove(const std::string& name) const noexcept {
  return unlinkat(descriptor_, name.c_str(), 0) == 0;
}

bool OutputFolder::remove_empty_folder(const std::string& name) const noexcept {
  return unlinkat(descriptor_, name.c_str(), AT_REMOVEDIR) == 0;
}

int OutputFolder::rename(const std::string& from, const std::string& to) const noexcept {
  return renameat(descriptor_, from.c_str(), descriptor_, to.c_str()) == 0 ? 0 : errno;
}

void OutputFolder::sync() const noexcept { [[maybe_unused]] const int failed = ::fsync(descriptor_); }

OutputFolder::Kind OutputFolder::kind(const std::string& name) const noexcept {
  struct stat found;
  if (fstatat(descriptor_, name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0) return Kind::none;
  if (S_ISREG(found.st_mode)) return Kind::file;
  if (S_ISLNK(found.st_mode)) return Kind::link;
  return S_ISDIR(found.st_mode) ? Kind::folder : Kind::other;
}

std::uintmax_t OutputFolder::size(const std::string& name) const noexcept {
  struct stat found;
  if (fstatat(descriptor_, name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(found.st_mode)) return 0;
  return static_cast<std::uintmax_t>(found.st_size);
}

std::vector<std::string> OutputFolder::names() const {
  std::vector<std::string> names;
  // A descriptor of its own, because reading moves the position in the folder.
  const int descriptor = ::openat(descriptor_, ".", folder_flags);
  DIR* const entries = descriptor < 0 ? nullptr : fdopendir(descriptor);
  if (entries == nullptr) {
    if (descriptor >= 0) ::close(descriptor);
    return names;
  }
  const std::unique_ptr<DIR, int (*)(DIR*)> closed(entries, closedir);
  while (const dirent* entry = readdir(entries)) names.emplace_back(entry->d_name);
  return names;
}

bool OutputFolder::has(const std::string& name, int descriptor) const noexcept {
  struct stat here, open;
  if (fstatat(descriptor_, name.c_str(), &here, AT_SYMLINK_NOFOLLOW) != 0 || fstat(descriptor, &open) != 0)
    return false;
  if (here.st_dev != open.st_dev || here.st_ino != open.st_ino) return false;
  return !parent_ || parent_->has(name_, descriptor_);
}

int open_output(const OutputFile& file) {
  if (file.folder()) return file.folder()->create(file.name());
  const int descriptor = above_standard_streams(
      ::open(file.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOCTTY, all_may_read_and_write));
  if (descriptor < 0) refuse_file(file.path(), errno);
  return descriptor;
}

void remove_output(const OutputFile& file) noexcept {
  if (file.folder()) {
    file.folder()->remove(file.name());
  } else {
    ::unlink(file.path().c_str());
  }
}

}  // namespace springnet
