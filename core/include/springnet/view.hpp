// view.html: one page that plays a run in a browser, with nothing to install and nothing fetched when it is opened.
// core/docs/view.md says what it shows.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

struct ViewOptions {
  double size = 16e6;                                   // bytes that the page should not exceed
  std::shared_ptr<const PluginHost> plugins = nullptr;  // those of the run, for the units of laws; null: no units
};

// Collects the records of a run and writes the page. What is kept in memory is bounded by the size of the page: where a
// run has more records than fit, every second one is dropped, evenly over the run; where a network has more springs
// than can be drawn, some are left out. Both are told on the page and by left_out(). The first and the last record
// always stand in it.
class ViewWriter {
 public:
  // Replaces the file by a page that says that the run goes on. Throws Error(input) if it cannot be created. The scene
  // has to outlive the writer.
  ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options = {});
  ~ViewWriter();
  ViewWriter(const ViewWriter&) = delete;
  ViewWriter& operator=(const ViewWriter&) = delete;

  // The state now, and what happened since the last call.
  void record(const Simulation& simulation);
  // The run failed: the page begins with the reason, plain text of any length. Of several calls the last one counts.
  void failed(const std::string& reason);
  // Writes the page with what was recorded, also after a failure. Where it cannot be written, throws Error(simulation)
  // and there is no file. The destructor does the same where it was not called, but is silent.
  void close();

  // What the page leaves out or rounds, in plain sentences; complete after close().
  [[nodiscard]] const std::vector<std::string>& left_out() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// How large the page of a run becomes at most, bytes; 0 if the scene asks for none.
[[nodiscard]] double estimate_view(const Scene& scene);

}  // namespace springnet
