#include <springnet/view.hpp>

#include <utility>

#include "view/page_writer.hpp"

namespace springnet {

struct ViewWriter::Impl {
  Impl(const OutputFile& file, const Scene& scene, const ViewOptions& options)
      : state(scene.network), page(file, scene, options) {}
  Impl(const Scene& scene, const ViewOptions& options) : state(scene.network), page(scene, options) {}

  Record state;
  std::vector<std::unique_ptr<ViewWriter>> others;
  view::PageWriter page;  // closed before the others are gone
};

ViewWriter::ViewWriter(const OutputFile& file, const Scene& scene, const ViewOptions& options)
    : impl_(std::make_unique<Impl>(file, scene, options)) {}
ViewWriter::ViewWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ViewWriter::~ViewWriter() = default;

ViewWriter& ViewWriter::add(const Scene& scene, const ViewOptions& options) {
  impl_->others.push_back(std::unique_ptr<ViewWriter>(new ViewWriter(std::make_unique<Impl>(scene, options))));
  impl_->page.add(impl_->others.back()->impl_->page);
  return *impl_->others.back();
}

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
