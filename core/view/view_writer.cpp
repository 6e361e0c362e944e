#include <springnet/view.hpp>

#include "view/page_writer.hpp"

namespace springnet {

struct ViewWriter::Impl {
  Impl(const OutputFile& file, const Scene& scene, const ViewOptions& options)
      : state(scene.network), page(file, scene, options) {}

  Record state;
  view::PageWriter page;
};

ViewWriter::ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options)
    : impl_(std::make_unique<Impl>(file, scene, options)) {}
ViewWriter::~ViewWriter() = default;

void ViewWriter::record(const Simulation& simulation) {
  impl_->state.take(simulation);
  impl_->page.record(impl_->state);
}

void ViewWriter::record(const Simulation& simulation, const Simulation& start) {
  record(simulation);
  impl_->page.record_start(start);
}

void ViewWriter::failed(const std::string& reason) { impl_->page.failed(reason); }
void ViewWriter::close() { impl_->page.close(); }
const std::vector<std::string>& ViewWriter::left_out() const noexcept { return impl_->page.left_out(); }

}  // namespace springnet
