#include "vtk/vtk_series.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <springnet/vtk.hpp>

#include "files/output_error.hpp"

namespace springnet {

namespace {

constexpr const char* index_name = "run.pvd";
constexpr std::string_view index_begin =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
    "  <Collection>\n";
constexpr std::string_view index_close = "  </Collection>\n</VTKFile>\n";
constexpr std::string_view net_stem = "net_", surface_stem = "surfaces_";

std::string net_name(std::size_t record) { return fmt::format("{}{:06}.vtu", net_stem, record); }
std::string surface_name(std::size_t record) { return fmt::format("{}{:06}.vtp", surface_stem, record); }

// Of a name of one of these; the greatest number for one that is too long.
std::size_t number_of(std::string_view name) {
  const char* const digits = name.data() + name.find_first_of("0123456789");
  std::size_t number = 0;
  const auto read = std::from_chars(digits, name.data() + name.size(), number);
  return read.ec == std::errc() ? number : std::numeric_limits<std::size_t>::max();
}

std::string entry(double time, int part, std::string_view name, std::string_view file) {
  return fmt::format("    <DataSet timestep=\"{}\" part=\"{}\" name=\"{}\" file=\"{}\"/>\n", time, part, name, file);
}

OutputFolder::Pointer make(const OutputFile& folder) {
  return folder.folder() ? OutputFolder::make_inside(folder.folder(), folder.name())
                         : OutputFolder::make(folder.path());
}

std::vector<LawStates> states_of(const OutputOptions& options) {
  return options.states ? options.law_states : std::vector<LawStates>();
}

}  // namespace

std::string vtk_index_name() { return fmt::format("{}/{}", vtk_folder, index_name); }

std::vector<std::string> vtk_series_files(const OutputFolder& folder) {
  std::vector<std::string> files;
  for (const std::string& name : folder.names()) {
    const auto is = [&](std::string_view stem, std::string_view ending) {
      if (!name.starts_with(stem) || !name.ends_with(ending) || name.size() <= stem.size() + ending.size())
        return false;
      const std::string_view digits =
          std::string_view(name).substr(stem.size(), name.size() - stem.size() - ending.size());
      return digits.find_first_not_of("0123456789") == std::string_view::npos;
    };
    // The index first, so that no run that is killed while it removes them leaves one that lists missing pictures.
    if (name == index_name)
      files.insert(files.begin(), name);
    else if (is(net_stem, ".vtu") || is(surface_stem, ".vtp"))
      files.push_back(name);
  }
  return files;
}

double vtk_record_bytes(const Network& network, const OutputOptions& options) {
  const VtkSurfaces surfaces(network);
  double bytes = static_cast<double>(vtk_bytes(VtkNet(network, states_of(options)).file(options.precision)));
  if (!surfaces.empty()) bytes += static_cast<double>(vtk_bytes(surfaces.file(options.precision)));
  return bytes;
}

double vtk_index_bytes(const Network& network, double records) {
  constexpr double time = -2.2250738585072014e-308;  // the longest decimal
  // File names have more digits from a million records on.
  double record = static_cast<double>(entry(time, 0, "net", net_name(99'999'999)).size());
  if (network.planes().size() + network.instruments().size() > 0) {
    record += static_cast<double>(entry(time, 1, "surfaces", surface_name(99'999'999)).size());
  }
  return records * record + static_cast<double>(index_begin.size() + index_close.size());
}

VtkSeries::VtkSeries(const OutputFile& folder, const Network& network, const OutputOptions& options, bool resumes)
    : folder_(make(folder)), precision_(options.precision), net_(network, states_of(options)), surfaces_(network) {
  if (resumes) return;
  index_.emplace(OutputFile(folder_, index_name));
  index_->write(index_begin.data(), index_begin.size());
  index_end_ = index_begin.size();
  index_->write(index_close.data(), index_close.size());
  index_->flush();
  bytes_ = index_end_ + index_close.size();
}

void VtkSeries::archive(Archive& archive) {
  CheckedFile::End end;
  if (!archive.reads()) end = index_->flushed_end();
  end.archive(archive);
  archive.number(index_end_);
  archive.number(bytes_);
  archive.number(records_);
  archive.number(last_);
  if (!archive.reads()) return;
  index_.emplace(OutputFile(folder_, index_name), end);
}

void VtkSeries::go_on() {
  index_->go_on();
  // The end may be that of a later entry.
  index_->restore_end(index_end_, index_close);
  for (const std::string& name : vtk_series_files(*folder_))
    if (name != index_name && number_of(name) >= records_) folder_->remove(name);
}

void VtkSeries::record(const Record& record) {
  try {
    write_pictures(record);
  } catch (const Error& error) {
    drop_last();
    throw OutputError(error.what(), last_);
  } catch (...) {
    drop_last();
    throw;
  }
  last_ = record.time();
  ++records_;
}

// A picture that is not in the index would be taken for part of the series.
void VtkSeries::drop_last() {
  folder_->remove(net_name(records_));
  folder_->remove(surface_name(records_));
  index_->restore_end(index_end_, index_close);
}

void VtkSeries::write_pictures(const Record& record) {
  net_.take(record);
  const VtkFile net = net_.file(precision_);
  write_vtk({folder_, net_name(records_)}, net);
  std::uintmax_t bytes = vtk_bytes(net);
  std::string entries = entry(record.time(), 0, "net", net_name(records_));
  if (!surfaces_.empty()) {
    surfaces_.take(record);
    const VtkFile surfaces = surfaces_.file(precision_);
    write_vtk({folder_, surface_name(records_)}, surfaces);
    bytes += vtk_bytes(surfaces);
    entries += entry(record.time(), 1, "surfaces", surface_name(records_));
  }
  // Replaces the closing tags and appends them again in one write, so that a reader always finds a complete document.
  const std::size_t added = entries.size();
  entries += index_close;
  index_->seek(index_end_);
  index_->write(entries.data(), entries.size());
  index_->flush();
  index_end_ += added;
  bytes_ += bytes + added;
}

struct VtkWriter::Impl {
  Impl(const OutputFile& folder, const Network& network, const OutputOptions& options)
      : state(network), series(folder, network, options) {}

  Record state;
  VtkSeries series;
};

VtkWriter::VtkWriter(const OutputFile& folder, const Network& network, const OutputOptions& options)
    : impl_(std::make_unique<Impl>(folder, network, options)) {}
VtkWriter::~VtkWriter() = default;

void VtkWriter::record(const Simulation& simulation) {
  impl_->state.take(simulation);
  impl_->series.record(impl_->state);
}

void VtkWriter::close() { impl_->series.close(); }
std::uintmax_t VtkWriter::bytes() const noexcept { return impl_->series.bytes(); }

}  // namespace springnet
