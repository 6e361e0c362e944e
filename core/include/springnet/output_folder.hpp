// Where files are written, and how: so that nothing else than what is meant is written, whatever stands in the folder.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springnet {

class OutputFolder;

// Which file a writer writes.
class OutputFile {
 public:
  // The file of this path, as a shell's '>' writes it: a file that is there is emptied, and what a link names is
  // written. Its folder has to be there.
  template <class Path>
  requires std::convertible_to<const Path&, std::filesystem::path> OutputFile(const Path& path) : path_(path) {}

  // A new file of the folder. What has the name, a link for instance, is removed first and never written through.
  OutputFile(std::shared_ptr<const OutputFolder> folder, std::string name);

  // This file while it is not whole: of the folder, with ".part" behind its name. Messages name the file itself.
  [[nodiscard]] OutputFile part() const;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }                    // for messages
  [[nodiscard]] const std::shared_ptr<const OutputFolder>& folder() const noexcept { return folder_; }  // or null
  [[nodiscard]] const std::string& name() const noexcept { return name_; }                              // in the folder

 private:
  std::filesystem::path path_;
  std::shared_ptr<const OutputFolder> folder_;
  std::string name_;
};

// A folder that files are written to, held open: what happens to its path meanwhile does not send a file elsewhere. The
// folder that the user names may be a link. What stands in it was put there by others, too: no link in it is followed,
// and nothing but a regular file is opened.
class OutputFolder {
 public:
  using Pointer = std::shared_ptr<const OutputFolder>;

  // Opens the folder, and makes it and those above it where they are missing. Throws Error(input) if it cannot.
  [[nodiscard]] static Pointer make(const std::filesystem::path& path);
  // The folder as it is, or null where it is not there or cannot be opened.
  [[nodiscard]] static Pointer find(const std::filesystem::path& path);
  // The folder that a file of this path stands in. Throws Error(input) if it is not there.
  [[nodiscard]] static Pointer containing(const std::filesystem::path& file);
  // A folder in `above`, made where it is missing. A link in its place is removed, not followed. Throws Error(input).
  [[nodiscard]] static Pointer make_inside(const Pointer& above, const std::string& name);
  // The folder in `above`, or null where there is none; a link is none.
  [[nodiscard]] static Pointer find_inside(const Pointer& above, const std::string& name);

  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Keeps other runs out until this is destroyed or the process ends, however it ends. Throws Error(input) if another
  // one is in it. File systems that cannot lock a folder keep nobody out.
  void lock() const;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }  // for messages

  // A descriptor of a new regular file, open for writing. Throws Error(input) if it cannot be made.
  [[nodiscard]] int create(const std::string& name) const;
  // Throws Error(input) where a folder has the name of a file that is to be written later.
  void require_no_folder(const std::string& name) const;
  // A file or a link, not a folder.
  bool remove(const std::string& name) const noexcept;
  bool remove_empty_folder(const std::string& name) const noexcept;
  // In place of what is there. Returns 0, or the reason.
  [[nodiscard]] int rename(const std::string& from, const std::string& to) const noexcept;

  enum class Kind { none, file, link, folder, other };
  [[nodiscard]] Kind kind(const std::string& name) const noexcept;
  [[nodiscard]] std::uintmax_t size(const std::string& name) const noexcept;  // of a regular file, else 0
  [[nodiscard]] std::vector<std::string> names() const;                       // of all that is in it
  // Whether the open file still has the name here, and this folder its own.
  [[nodiscard]] bool has(const std::string& name, int descriptor) const noexcept;

 private:
  OutputFolder(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_;
  Pointer above_;  // null for one that was opened by its path
  std::string name_;
};

// Name of a file while it is not whole.
[[nodiscard]] std::string part_name(std::string_view name);

// Writes a file that has its name only once it is whole. Throws Error(simulation) if it cannot be written; what was
// there before then stays.
void write_whole(const OutputFile& file, std::string_view text);

// Opens the file for writing; a descriptor above those of the standard streams. Throws Error(input).
[[nodiscard]] int open_output(const OutputFile& file);
// If it is a file or a link.
void remove_output(const OutputFile& file) noexcept;

}  // namespace springnet
