// One element whose laws read several scalars, for integrators that solve element by element.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "simulation/parts.hpp"

namespace springnet {
namespace {

std::uint32_t kind_of(layers::Measure measure) {
  switch (measure) {
    case layers::Measure::length:
      return SPRINGNET_LENGTH;
    case layers::Measure::angle:
      return SPRINGNET_ANGLE;
    case layers::Measure::area:
      return SPRINGNET_AREA;
    case layers::Measure::volume:
      return SPRINGNET_VOLUME;
    case layers::Measure::dihedral:
      break;
  }
  return SPRINGNET_DIHEDRAL;
}

// Clears what is answered.
void clear(springnet_scalar_view& view) {
  springnet_scalar_view empty{};
  empty.struct_size = view.struct_size;
  empty.element = view.element;
  empty.at = view.at;
  view = empty;
}

}  // namespace

springnet_status view_scalars(Model& model, springnet_scalar_view& view) {
  const layers::Layout& layout = model.layout;
  const layers::ElementLayout& elements = layout.elements();
  if (view.element >= elements.count())
    throw Error(ErrorKind::plugin,
                fmt::format("element {} was asked for, the network has {}", view.element, elements.count()));
  if (!reads_several(elements.invariant(view.element)))
    throw Error(ErrorKind::plugin,
                fmt::format("the laws of element {} read one scalar; view_elements has it", view.element));
  clear(view);
  if (!elements.alive(view.element)) return SPRINGNET_OK;
  const layers::Group& group = layout.laws().groups[elements.group(view.element)];
  const layers::InternalView internal = model.internal_for(view.at->internal);
  const layers::NodeArrays nodes = node_arrays(view.at->position, view.at->velocity, internal);
  const auto query = std::make_unique_for_overwrite<layers::SeveralQuery>();
  const springnet_status status =
      layers::evaluate_several_element(layout, model.evaluator.instruction_set(), view.at->time, nodes, view.element,
                                       layers::SeveralWanted::tangent, *query, model.journal.message);
  if (status != SPRINGNET_OK) return model.failed(status, view.at->time, nodes);

  const std::span<const std::uint32_t> own = elements.nodes(view.element);
  view.node_count = static_cast<std::uint32_t>(own.size());
  std::copy(own.begin(), own.end(), view.nodes);
  view.scalar_count = static_cast<std::uint32_t>(group.scalars.count);
  for (std::size_t s = 0; s < group.scalars.count; ++s) {
    const layers::ElementScalar& scalar = group.scalars.scalar[s];
    view.kind[s] = kind_of(scalar.measure);
    view.reference_only[s] = scalar.reference_only ? 1 : 0;
    std::copy_n(scalar.corner.begin(), scalar.corner_count(), view.corners[s]);
    view.reference[s] = elements.rest(view.element).reference[s];
    if (scalar.reference_only) continue;
    view.value[s] = query->geometry.value[s][0];
    view.rate[s] = query->geometry.rate[s][0];
    for (std::size_t c = 0; c < scalar.corner_count(); ++c) {
      const Vector3 by = layers::gradient_of(scalar, query->geometry.gradient[s], c, 0);
      std::copy_n(by.data(), 3, view.gradient[s][scalar.corner[c]]);
    }
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const layers::Law& law = *group.laws()[k];
    for (std::size_t i = 0; law && i < law.scalar_count; ++i) {
      const std::size_t s = law.scalar[i];
      if (!law.reads[i]) continue;
      view.force[k][s] = query->answers.force[k][s][0];
      for (std::size_t j = 0; j < law.scalar_count; ++j) {
        const std::size_t t = law.scalar[j], at = layers::max_scalars * s + t;
        if (!law.reads[j]) continue;
        view.by_value[k][s][t] = query->answers.by_value[k][at][0];
        if (law.reads_rate) view.by_rate[k][s][t] = query->answers.by_rate[k][at][0];
      }
    }
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
