// Collects the records of a run and writes the page; see springnet/view.hpp for what is kept and what is left out.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>
#include <springnet/view.hpp>

#include "record/record.hpp"
#include "view/content.hpp"

namespace springnet::view {

class PageWriter {
 public:
  // Writes a page that says that the run has not ended. Throws Error(input) if it cannot be created.
  // resumes: no page is written before go_on().
  PageWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options, bool resumes = false);
  // Of a further motion, for add().
  PageWriter(const Scene& scene, const ViewOptions& options);
  ~PageWriter();  // closes it, and ignores errors
  PageWriter(const PageWriter&) = delete;
  PageWriter& operator=(const PageWriter&) = delete;

  // A further motion of this page, which must be there when it is closed.
  void add(PageWriter& motion) { others_.push_back(&motion); }
  void record(const Record& record);
  // Of the motion before learning, after record() at that time.
  void record_start(const Simulation& simulation);
  // What it has kept of the records so far.
  void archive(Archive& archive);
  // Of one that resumes, once its records are there: the page is that of a run that has not ended.
  void go_on();
  void failed(const std::string& reason) { content_.failure = reason; }
  void close();  // throws OutputError
  [[nodiscard]] const std::vector<std::string>& left_out() const noexcept { return left_out_; }

 private:
  void take_events(const Simulation& simulation);
  void take_scalars(const Record& record);
  void take_nodes(const Simulation& simulation, const std::vector<BodyTouch>& touches);
  void take_positions(const Simulation& simulation, std::span<float> out) const;
  void take_springs(const Record& record);
  void take_surfaces(const Simulation& simulation);
  void note_omissions(const std::optional<Ranges>& rounded);
  [[nodiscard]] Motion finished();

  std::optional<OutputFile> file_;  // none: of a further motion
  double size_;                     // bytes, of the program and of this motion
  Content content_;
  std::array<std::uint64_t, 9> counts_{};  // of each kind of event
  std::size_t events_read_ = 0;            // events of the simulation that were read so far
  std::uint64_t most_touches_ = 0;         // with a force, in a record
  std::vector<std::string> left_out_;
  std::vector<PageWriter*> others_;
  bool closed_ = false;
};

}  // namespace springnet::view
