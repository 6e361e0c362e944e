// view.html: a self-contained page that plays a run in a browser. core/docs/view.md describes it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

struct ViewOptions {
  double size = 16e6;                                   // largest size of the page, bytes
  std::shared_ptr<const PluginHost> plugins = nullptr;  // of the run, for the units of laws; null: no units
};

// Collects the records of a run and writes the page. The size of the page bounds the memory: once there are more
// records than fit, every second one is dropped, evenly over the run; of a network with more springs than can be drawn,
// some are left out. The page and left_out() report both. The first and the last record are always there.
class SPRINGNET_API ViewWriter {
 public:
  // Writes a page that says that the run has not ended. Throws Error(input) if it cannot be created. The scene must
  // outlive the writer.
  ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options = {});
  ~ViewWriter();
  ViewWriter(const ViewWriter&) = delete;
  ViewWriter& operator=(const ViewWriter&) = delete;

  // Records the present state and the events since the last call.
  void record(const Simulation& simulation);
  // Call it if the run failed: the page will begin with the reason, plain text of any length. The last call counts.
  void failed(const std::string& reason);
  // Writes the page with what was recorded, also after a failure. If that is not possible, throws Error(simulation) and
  // leaves no file. The destructor calls it if necessary, and ignores errors.
  void close();

  // Notes on what the page leaves out or rounds; complete after close().
  [[nodiscard]] const std::vector<std::string>& left_out() const noexcept;

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

// Upper bound for the size of a run's page, bytes; 0 if the scene requests none.
[[nodiscard]] SPRINGNET_API double estimate_view(const Scene& scene);

}  // namespace springnet
