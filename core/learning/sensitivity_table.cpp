#include <utility>
#include <vector>

#include <springnet/sensitivities.hpp>

#include "tables/csv_file.hpp"

namespace springnet {

struct SensitivityTable::Impl {
  Impl(const OutputFile& path, std::vector<NodeIndex> rows)
      : file(path, "time,parameter,member,node,dx,dy,dz,dvx,dvy,dvz"), nodes(std::move(rows)) {}
  CsvFile file;
  std::vector<NodeIndex> nodes;
};

SensitivityTable::SensitivityTable(const OutputFile& file, std::vector<NodeIndex> nodes)
    : impl_(std::make_unique<Impl>(file, std::move(nodes))) {}
SensitivityTable::~SensitivityTable() = default;
SensitivityTable::SensitivityTable(SensitivityTable&&) noexcept = default;
SensitivityTable& SensitivityTable::operator=(SensitivityTable&&) noexcept = default;

void SensitivityTable::record(const ReferenceSensitivities& sensitivities) {
  CsvFile& file = impl_->file;
  file.drop_unfinished();
  for (std::size_t j = 0; j < sensitivities.columns().size(); ++j) {
    const SensitivityColumn& column = sensitivities.columns()[j];
    const Eigen::Matrix3Xd position = sensitivities.position_changes(j), velocity = sensitivities.velocity_changes(j);
    const auto row = [&](NodeIndex node) {
      file << sensitivities.time() << ',' << std::string_view(column.name) << ',';
      if (column.values == 1) file << column.member;
      file << ',' << node;
      for (const Eigen::Matrix3Xd* const each : {&position, &velocity})
        for (Eigen::Index axis = 0; axis < 3; ++axis) file << ',' << (*each)(axis, static_cast<Eigen::Index>(node));
      file << '\n';
    };
    if (!impl_->nodes.empty())
      for (const NodeIndex node : impl_->nodes) row(node);
    else
      for (Eigen::Index node = 0; node < position.cols(); ++node) row(static_cast<NodeIndex>(node));
  }
  file.end_record(sensitivities.time());
}

void SensitivityTable::close() { impl_->file.close(); }

}  // namespace springnet
