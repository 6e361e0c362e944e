// Pictures of a run for ParaView and other programs that read VTK's XML formats.
#pragma once

#include <cstdint>
#include <memory>

#include <springnet/export.hpp>
#include <springnet/network.hpp>
#include <springnet/output_folder.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Writes into a folder, which is created if necessary: for each record net_<number>.vtu, also surfaces_<number>.vtp if
// there are planes or instruments, and run.pvd, which lists them with their times and is complete after each record.
// core/docs/output.md lists the data.
class SPRINGNET_API VtkWriter {
 public:
  // Throws Error(input) if the folder or run.pvd cannot be created, Error(simulation) if it cannot be written.
  VtkWriter(const OutputFile& folder, const Network& network, const OutputOptions& options = {});
  ~VtkWriter();
  // Writes the present state of a simulation of the network. Throws Error(simulation) if that fails; the series then
  // ends with the previous record.
  void record(const Simulation& simulation);
  void close();
  [[nodiscard]] std::uintmax_t bytes() const noexcept;  // of all files

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace springnet
