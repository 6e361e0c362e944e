#include "run/checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <springnet/version.hpp>
#include <springnet/view.hpp>

#include "files/input_file.hpp"
#include "files/whole_file.hpp"
#include "run/outputs.hpp"
#include "run/record_times.hpp"
#include "text/archive.hpp"
#include "text/digest.hpp"

namespace springnet {

namespace {

constexpr std::string_view heading = "springnet checkpoint 3\n";

[[noreturn]] void refuse(const OutputFolder& folder, const std::string& what) {
  throw Error(ErrorKind::input, fmt::format("{}: {}", (folder.path() / checkpoint_file).string(), what));
}

// Whatever files there are: tables, and pictures since the checkpoint before.
void sync_files(const OutputFolder& folder) {
  const int descriptor = ::open(folder.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // what cannot be opened is told when a file is written
  [[maybe_unused]] const int failed = ::syncfs(descriptor);
  ::close(descriptor);
}

// "12 (8d36788c): 0, 3, 4, …": with a checksum, as a list may be long.
std::string list_text(const std::vector<std::uint32_t>& numbers, std::string_view none) {
  if (numbers.empty()) return std::string(none);
  const std::string_view bytes(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(std::uint32_t));
  std::string text = fmt::format("{} ({:08x})", numbers.size(), checksum(bytes));
  constexpr std::size_t most = 20;
  for (std::size_t k = 0; k < std::min(most, numbers.size()); ++k)
    text += fmt::format("{} {}", k == 0 ? ":" : ",", numbers[k]);
  return numbers.size() > most ? text + ", …" : text;
}

std::string names_of(const Scene& scene) {
  std::string text;
  const auto add = [&text](const std::string& name) { text += (text.empty() ? "" : ", ") + name; };
  for (const Body& each : scene.network.bodies()) add(each.name);
  for (const ElementSet& each : scene.elements) add(each.name);
  for (const Plane& each : scene.network.planes()) add(each.name);
  for (const Instrument& each : scene.network.instruments()) add(each.name);
  return text;
}

}  // namespace

Identity identity_of(const Scene& scene) {
  const OutputOptions& output = scene.output;
  Identity identity{{"version of springnet", std::string(version())},
                    {"duration", fmt::format("{} s", scene.duration)},
                    {"time step", fmt::format("{} s", scene.options.time_step)},
                    {"output.interval", fmt::format("{} s", record_interval(scene))},
                    {"output.vtk_interval", fmt::format("{} s", output.vtk_interval)},
                    {"output.view_size", fmt::format("{} bytes", output.view_size)},
                    {"output.precision", output.precision == OutputOptions::Precision::float64 ? "64" : "32"}};
  identity.emplace_back("title", scene.title);
  std::string files;
  Identity forms;
  for (const auto& each : outputs()) {
    if (!each->wanted(scene)) continue;
    auto [file, form] = each->form(scene);
    files += (files.empty() ? "" : ", ") + file;
    if (!form.empty()) forms.emplace_back("columns of " + file, std::move(form));
  }
  identity.emplace_back("output files", files);
  // A table goes on under the header that it has.
  identity.insert(identity.end(), forms.begin(), forms.end());
  identity.emplace_back("output.nodes", list_text(output.nodes, "all"));
  identity.emplace_back("output.springs", list_text(output.springs, "none"));
  identity.emplace_back("output.elements", list_text(output.element_numbers, "all"));
  identity.emplace_back("names of bodies, elements and surfaces", names_of(scene));
  const auto count = [](std::size_t nodes) { return std::to_string(nodes); };
  identity.emplace_back("nodes", count(scene.network.nodes().size()));
  identity.emplace_back("springs", count(scene.network.springs().size()));
  return identity;
}

void write_checkpoint(const OutputFolder::Pointer& folder, const Identity& identity, std::string_view content) {
  sync_files(*folder);
  std::string bytes;
  Archive archive(&bytes);
  write_identity(archive, identity);
  bytes += content;
  std::string head(heading);
  Archive around(&head);
  std::uint64_t size = bytes.size();
  std::uint32_t sum = checksum(bytes);
  around.number(size);
  around.number(sum);
  WholeFile file({folder, checkpoint_file});
  file.stream() << head << bytes;
  file.finish(true);
}

std::string read_checkpoint(const OutputFolder::Pointer& folder, const Identity& identity) {
  const OutputFolder::Kind kind = folder->kind(checkpoint_file);
  if (kind == OutputFolder::Kind::none)
    refuse(*folder,
           "there is none: the run has reached its end, or was stopped before the first one, or was run without "
           "--checkpoint; "
           "run without --resume");
  if (kind != OutputFolder::Kind::file) refuse(*folder, "is no regular file; remove it, and run without --resume");
  InputFile in(folder->path() / checkpoint_file);
  constexpr std::size_t head_size = heading.size() + sizeof(std::uint64_t) + sizeof(std::uint32_t);
  std::string head, bytes;
  in.read(head, head_size);
  if (head.size() < head_size || !head.starts_with(heading))
    refuse(*folder, fmt::format("is no checkpoint of springnet {}, which begins with '{}'", version(),
                                heading.substr(0, heading.size() - 1)));
  Archive around(std::string_view(head).substr(heading.size()));
  std::uint64_t size = 0;
  std::uint32_t sum = 0;
  around.number(size);
  around.number(sum);
  in.read(bytes, size);
  if (bytes.size() != size || checksum(bytes) != sum)
    refuse(*folder, fmt::format("is damaged: {}; run without --resume",
                                bytes.size() != size ? fmt::format("it has {} bytes in place of {}", bytes.size(), size)
                                                     : std::string("its checksum is another one")));
  Archive archive{std::string_view(bytes)};
  if (const std::optional<IdentityDifference> found = identity_difference(archive, identity, "now"))
    refuse(*folder,
           found->is_of_values
               ? fmt::format("is of another run: {}; undo the change, or run without --resume", found->text)
               : fmt::format("is of another run or version of springnet, {}; run without --resume", found->text));
  return bytes.substr(bytes.size() - archive.left());
}

double checkpoint_bytes(const Scene& scene) {
  constexpr double per_node = 9.0 * sizeof(double);  // positions, velocities, forces
  const double page = scene.output.view ? std::min<double>(scene.output.view_size, estimate_view(scene)) : 0.0;
  return 2.0 * (per_node * static_cast<double>(scene.network.nodes().size()) + page);
}

}  // namespace springnet
