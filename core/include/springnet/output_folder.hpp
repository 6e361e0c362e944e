// Safe output: whatever is in the folder, only the intended files are changed.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/export.hpp>

namespace springnet {

class OutputFolder;

// The file that a writer creates.
class OutputFile {
 public:
  // The file of this path, as the shell's '>' opens it: an existing file is truncated, a link is followed. Its folder
  // must exist.
  template <class Path>
  requires std::convertible_to<const Path&, std::filesystem::path> OutputFile(const Path& path) : path_(path) {}

  // A new file in the folder. Anything of that name, a link for instance, is removed first, never written through.
  SPRINGNET_API OutputFile(std::shared_ptr<const OutputFolder> folder, std::string name);

  // This file while it is incomplete: "<name>.part" in the folder. Messages name the file itself.
  [[nodiscard]] SPRINGNET_API OutputFile part() const;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }                    // for messages
  [[nodiscard]] const std::shared_ptr<const OutputFolder>& folder() const noexcept { return folder_; }  // or null
  [[nodiscard]] const std::string& name() const noexcept { return name_; }                              // in the folder

 private:
  std::filesystem::path path_;
  std::shared_ptr<const OutputFolder> folder_;
  std::string name_;
};

// A folder for output, held open, so that renaming or replacing its path does not redirect files. The folder that the
// user names may be a link. Its contents are not trusted: no link in it is followed, and only regular files are opened.
class SPRINGNET_API OutputFolder {
 public:
  using Pointer = std::shared_ptr<const OutputFolder>;

  // Opens the folder; creates it and its parents if they are missing. Throws Error(input) if it cannot.
  [[nodiscard]] static Pointer make(const std::filesystem::path& path);
  // Opens an existing folder; null if there is none or it cannot be opened.
  [[nodiscard]] static Pointer find(const std::filesystem::path& path);
  // The folder of a file of this path. Throws Error(input) if it does not exist.
  [[nodiscard]] static Pointer containing(const std::filesystem::path& file);
  // Opens a folder in `parent`; creates it if it is missing. A link of that name is removed, not followed. Throws
  // Error(input) if it cannot.
  [[nodiscard]] static Pointer make_inside(const Pointer& parent, const std::string& name);
  // Opens an existing folder in `parent`; null if there is none. A link does not count as one.
  [[nodiscard]] static Pointer find_inside(const Pointer& parent, const std::string& name);

  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Locks out other runs until this is destroyed or the process ends, however it ends. Throws Error(input) if another
  // run holds the lock. Has no effect on file systems that cannot lock a folder.
  void lock() const;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }  // for messages

  // Creates a regular file and returns a descriptor open for writing. Throws Error(input) if it cannot.
  [[nodiscard]] int create(const std::string& name) const;
  // Throws Error(input) if a folder has this name, which a file will need later.
  void require_no_folder(const std::string& name) const;
  // Removes a file or a link, not a folder. Returns whether it did.
  bool remove(const std::string& name) const noexcept;
  bool remove_empty_folder(const std::string& name) const noexcept;
  // Replaces an entry of the new name. Returns 0 or errno.
  [[nodiscard]] int rename(const std::string& from, const std::string& to) const noexcept;
  // Waits until the names in it are on the disk, where the file system can tell.
  void sync() const noexcept;

  enum class Kind { none, file, link, folder, other };
  [[nodiscard]] Kind kind(const std::string& name) const noexcept;
  [[nodiscard]] std::uintmax_t size(const std::string& name) const noexcept;  // of a regular file, else 0
  [[nodiscard]] std::vector<std::string> names() const;                       // of all entries
  // Whether the open file still has this name in the folder, and the folder its own.
  [[nodiscard]] bool has(const std::string& name, int descriptor) const noexcept;

 private:
  OutputFolder(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_;
  Pointer parent_;  // null for one that was opened by its path
  std::string name_;
};

// Name of a file while it is incomplete: "<name>.part".
[[nodiscard]] SPRINGNET_API std::string part_name(std::string_view name);

// Writes a file that gets its name only once it is complete. Throws Error(simulation) if it cannot be written; an
// earlier file of that name then stays.
SPRINGNET_API void write_whole(const OutputFile& file, std::string_view text);

// Opens the file for writing, on a descriptor above those of the standard streams. Throws Error(input) if it cannot.
[[nodiscard]] SPRINGNET_API int open_output(const OutputFile& file);
// Does nothing unless it is a file or a link.
SPRINGNET_API void remove_output(const OutputFile& file) noexcept;

}  // namespace springnet
