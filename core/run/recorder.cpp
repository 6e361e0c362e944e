#include "run/recorder.hpp"

#include <exception>

#include "files/output_error.hpp"
#include "profile/stage.hpp"

namespace springnet {

Recorder::Recorder(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                   const OutputFolder::Pointer& folder, bool resumes) {
  if (!resumes) remove_earlier(folder);
  for (const auto& output : outputs()) {
    if (output->wanted(scene)) entries_.push_back({output->open(scene, plugins, folder, resumes)});
  }
}

void Recorder::archive(Archive& archive) {
  for (Entry& entry : entries_) {
    archive.number(entry.kept_until);
    entry.sink->archive(archive);
  }
}

void Recorder::go_on() {
  for (Entry& entry : entries_) entry.sink->go_on();
}

template <class Work>
void Recorder::each(const Work& work) {
  std::exception_ptr first;
  for (Entry& entry : entries_) {
    if (entry.failed) continue;
    const profile::Stage stage(entry.sink->file().c_str(), profile::Kind::output);
    try {
      work(entry);
    } catch (const OutputError& error) {
      entry.failed = true;
      entry.lost = error.lost();
      entry.kept_until = error.kept_until();
      if (!first) first = std::current_exception();
    } catch (...) {  // out of memory, for instance
      entry.failed = true;
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

void Recorder::record(const Record& record) {
  each([&](Entry& entry) {
    entry.sink->record(record);
    entry.kept_until = record.time();
  });
}

void Recorder::finish(const Record& record) {
  each([&](Entry& entry) { entry.sink->finish(record); });
}

void Recorder::failed(const std::string& reason) {
  for (const Entry& entry : entries_) entry.sink->failed(reason);
}

std::vector<std::string> Recorder::notes() const {
  std::vector<std::string> all;
  for (const Entry& entry : entries_) {
    const std::vector<std::string> notes = entry.sink->notes();
    all.insert(all.end(), notes.begin(), notes.end());
  }
  return all;
}

void Recorder::close() {
  // Failed ones too, so that complete records in their buffers are written.
  for (const Entry& entry : entries_) {
    if (!entry.failed) continue;
    try {
      entry.sink->close();
    } catch (...) {  // its first failure has been reported
    }
  }
  each([](Entry& entry) { entry.sink->close(); });
}

std::vector<std::string> Recorder::files() const {
  std::vector<std::string> names;
  for (const Entry& entry : entries_) {
    if (!entry.lost && entry.sink->exists()) names.push_back(entry.sink->file());
  }
  return names;
}

std::vector<CutShort> Recorder::cut_short() const {
  std::vector<CutShort> files;
  for (const Entry& entry : entries_) {
    if (entry.failed && !entry.lost && entry.sink->exists()) files.push_back({entry.sink->file(), entry.kept_until});
  }
  return files;
}

std::uintmax_t Recorder::bytes() const {
  std::uintmax_t sum = 0;
  for (const Entry& entry : entries_) sum += entry.sink->bytes();
  return sum;
}

}  // namespace springnet
