#include "simulation/parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"

namespace springnet {
namespace {

constexpr std::uint32_t spring_parts[] = {SPRINGNET_PART_SPRINGS, SPRINGNET_PART_VISCOSITIES};
constexpr std::uint32_t element_parts[] = {SPRINGNET_PART_ELEMENTS, SPRINGNET_PART_ELEMENT_VISCOSITIES};
constexpr std::uint32_t all_parts = SPRINGNET_PART_SPRINGS | SPRINGNET_PART_VISCOSITIES | SPRINGNET_PART_ELEMENTS |
                                    SPRINGNET_PART_ELEMENT_VISCOSITIES | SPRINGNET_PART_GRAVITY | SPRINGNET_PART_LOADS;

void add(const springnet_vectors& to, std::uint32_t node, const Vector3& force) {
  to.x[node] += force[0];
  to.y[node] += force[1];
  to.z[node] += force[2];
}

// The state of an evaluation as layers read it, with the signals of inputs at its time.
struct At {
  At(Model& model, const springnet_evaluation& at)
      : time(at.time),
        internal(model.internal_for(at.internal)),
        external(model.external_at(at.time)),
        set(model.evaluator.instruction_set()) {
    internal.next = internal.rates = nullptr;
    nodes = node_arrays(at.position, at.velocity, internal);
  }
  double time;
  layers::InternalView internal;
  layers::NodeArrays nodes{};
  layers::ExternalForces external;
  InstructionSet set;
};

// Nodes of an element, and dq/dp of each: its corners, or those of its enclosure.
struct Gradients {
  layers::ElementState state{};
  std::span<const std::uint32_t> nodes;
  std::vector<Vector3> by;

  void find(const layers::Layout& layout, const At& at, std::uint32_t element) {
    const layers::ElementLayout& elements = layout.elements();
    nodes = elements.nodes(element);
    by.resize(nodes.size());
    if (elements.invariant(element) == Invariant::enclosed_volume) {
      for (const auto& enclosure : elements.enclosures()) {
        if (enclosure.element != element) continue;
        const auto values = enclosure.shape.partial_values(0, nodes.size(), at.nodes, by.data());
        state = {values.volume, values.rate};
      }
      return;
    }
    layers::Corners corners;
    layers::FirstOrder geometry;
    layers::gather(nodes.data(), nodes.size(), at.nodes, corners);
    layers::first_order(elements.invariant(element), corners, geometry);
    state = layers::element_state(layout, at.nodes, element);
    std::copy_n(geometry.gradient, nodes.size(), by.begin());
  }
};

// Calls what(springs, count, geometry, answers) for the live springs of each group, some at a time.
struct SpringAnswers {
  layers::SegmentGeometry geometry;
  layers::PairAnswers<layers::max_segment> laws;
};

layers::PairOutputs chosen(layers::PairOutputs out, std::uint32_t parts, const std::uint32_t* bits) {
  for (std::size_t k = 0; k < out.size(); ++k)
    if ((parts & bits[k]) == 0) out[k] = {};
  return out;
}

springnet_status add_springs(Model& model, const At& at, std::uint32_t parts, const springnet_vectors& force) {
  const layers::Layout& layout = model.layout;
  const auto answers = std::make_unique<SpringAnswers>();
  const layers::PairOutputs wanted = chosen(answers->laws.outputs(false, false), parts, spring_parts);
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const auto laws = layout.laws().groups[g].laws();
    const std::vector<std::uint32_t>& springs = layout.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += layers::max_segment) {
      const std::size_t count = std::min(layers::max_segment, springs.size() - begin);
      const std::uint32_t* const some = springs.data() + begin;
      const springnet_status status = layers::evaluate_springs(layout, at.set, at.time, at.nodes, g, some, count,
                                                               answers->geometry, wanted, model.journal.message);
      if (status != SPRINGNET_OK) return status;
      const layers::SegmentGeometry& n = answers->geometry;
      for (std::size_t k = 0; k < laws.size(); ++k) {
        if (!*laws[k] || wanted[k].force == nullptr) continue;
        for (std::size_t i = 0; i < count; ++i) {
          const Vector3 along =
              laws[k]->relative ? Vector3(n.sx[i], n.sy[i], n.sz[i]) : Vector3(n.nx[i], n.ny[i], n.nz[i]);
          const Vector3 pull = answers->laws.force[k][i] * along;
          add(force, layout.first(some[i]), -pull);
          add(force, layout.second(some[i]), pull);
        }
      }
    }
  }
  return SPRINGNET_OK;
}

// Of an element whose laws read several scalars.
springnet_status add_several(Model& model, const At& at, std::uint32_t parts, std::uint32_t element,
                             layers::SeveralQuery& query, const springnet_vectors& force) {
  const layers::Layout& layout = model.layout;
  const layers::Group& group = layout.laws().groups[layout.elements().group(element)];
  const springnet_status status = layers::evaluate_several_element(
      layout, at.set, at.time, at.nodes, element, layers::SeveralWanted::forces, query, model.journal.message);
  if (status != SPRINGNET_OK) return status;
  const double* q[2][layers::max_scalars];
  layers::forces_of(group, query.answers, q);
  for (std::size_t k = 0; k < 2; ++k)
    if ((parts & element_parts[k]) == 0) std::fill_n(q[k], layers::max_scalars, nullptr);
  double forces[3][layers::max_corners];
  layers::kernels_for(at.set).several.forces(group.scalars, query.geometry, 1, q, {forces[0], forces[1], forces[2], 1});
  const std::span<const std::uint32_t> nodes = layout.elements().nodes(element);
  for (std::size_t i = 0; i < nodes.size(); ++i) add(force, nodes[i], {forces[0][i], forces[1][i], forces[2][i]});
  return SPRINGNET_OK;
}

springnet_status add_elements(Model& model, const At& at, std::uint32_t parts, const springnet_vectors& force) {
  const layers::Layout& layout = model.layout;
  layers::PairAnswers<1> answers{};
  const layers::PairOutputs wanted = chosen(answers.outputs(false, false), parts, element_parts);
  Gradients gradients;
  std::unique_ptr<layers::SeveralQuery> query;  // of elements that read several scalars
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e)) continue;
    if (reads_several(layout.elements().invariant(e))) {
      if (!query) query = std::make_unique_for_overwrite<layers::SeveralQuery>();
      if (const springnet_status status = add_several(model, at, parts, e, *query, force); status != SPRINGNET_OK)
        return status;
      continue;
    }
    gradients.find(layout, at, e);
    const springnet_status status =
        layers::evaluate_element(layout, at.set, at.time, at.nodes, e, gradients.state, wanted, model.journal.message);
    if (status != SPRINGNET_OK) return status;
    const auto laws = layout.laws().groups[layout.elements().group(e)].laws();
    double sum = 0.0;
    for (std::size_t k = 0; k < laws.size(); ++k)
      if (*laws[k] && wanted[k].force != nullptr) sum += answers.force[k][0];
    for (std::size_t i = 0; i < gradients.nodes.size(); ++i) add(force, gradients.nodes[i], -sum * gradients.by[i]);
  }
  return SPRINGNET_OK;
}

void add_external(Model& model, const At& at, std::uint32_t parts, const springnet_vectors& force) {
  const layers::ExternalForces& external = at.external;
  const bool presses = external.pressure != nullptr && model.layout.loaded_faces().any_following();
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    if ((parts & SPRINGNET_PART_GRAVITY) != 0) add(force, k, model.mass[k] * external.gravity);
    if ((parts & SPRINGNET_PART_LOADS) == 0) continue;
    const layers::ForceArrays& loads = external.loads;
    if (loads.x != nullptr) add(force, k, {loads.x[k], loads.y[k], loads.z[k]});
    if (presses) add(force, k, model.layout.loaded_faces().force(k, at.nodes, external.pressure));
  }
}

// ---- one spring or element after another

struct PartAnswer {
  double force[2], by_q[2], by_rate[2];
};

// Fills what is wanted of member i of the view from the answers of its two laws.
void put(const springnet_element_view& view, std::size_t i, const layers::Group& group, const PartAnswer& answer) {
  const auto laws = group.laws();
  std::uint32_t relative = 0;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    const bool acts = *laws[k] && !laws[k]->relative;
    if (*laws[k] && laws[k]->relative) relative = 1;
    if (view.force != nullptr) view.force[2 * i + k] = acts ? answer.force[k] : 0.0;
    if (view.by_value != nullptr) view.by_value[2 * i + k] = acts ? answer.by_q[k] : 0.0;
    if (view.by_rate != nullptr) view.by_rate[2 * i + k] = acts ? answer.by_rate[k] : 0.0;
  }
  if (view.relative != nullptr) view.relative[i] = relative;
}
void put_removed(const springnet_element_view& view, std::size_t i) {
  for (double* const values : {view.value, view.rate, view.reference})
    if (values != nullptr) values[i] = 0.0;
  for (double* const pair : {view.force, view.by_value, view.by_rate})
    if (pair != nullptr) pair[2 * i] = pair[2 * i + 1] = 0.0;
  if (view.relative != nullptr) view.relative[i] = 0;
}
void put_state(const springnet_element_view& view, std::size_t i, double value, double rate, double reference) {
  if (view.value != nullptr) view.value[i] = value;
  if (view.rate != nullptr) view.rate[i] = rate;
  if (view.reference != nullptr) view.reference[i] = reference;
}

bool wants_laws(const springnet_element_view& view) {
  return view.force != nullptr || view.by_value != nullptr || view.by_rate != nullptr;
}
bool wants_derivatives(const springnet_element_view& view) {
  return view.by_value != nullptr || view.by_rate != nullptr;
}

class Places {
 public:
  explicit Places(springnet_element_view& view) : view_(view) { view.node_total = 0; }
  // Room for the nodes of member i. Null where the arrays are not wanted or too small.
  void begin(std::size_t i) {
    if (view_.node_start != nullptr) view_.node_start[i] = view_.node_total;
  }
  void add(std::uint32_t node, const Vector3& gradient) {
    if (view_.node_total < view_.node_capacity) {
      if (view_.nodes != nullptr) view_.nodes[view_.node_total] = node;
      if (view_.gradients != nullptr)
        for (Eigen::Index c = 0; c < 3; ++c)
          view_.gradients[3 * view_.node_total + static_cast<std::uint64_t>(c)] = gradient[c];
    }
    ++view_.node_total;
  }

 private:
  springnet_element_view& view_;
};

springnet_status view_springs(Model& model, const At& at, springnet_element_view& view, Places& places) {
  const layers::Layout& layout = model.layout;
  const auto geometry = std::make_unique<layers::SegmentGeometry>();
  layers::PairAnswers<1> answers{};
  layers::PairOutputs wanted{};
  if (wants_laws(view)) wanted = answers.outputs(wants_derivatives(view), false);
  for (std::size_t i = 0; i < view.count; ++i) {
    const auto s = static_cast<std::uint32_t>(view.first + i);
    places.begin(i);
    if (!layout.alive(s)) {
      put_removed(view, i);
      continue;
    }
    const std::size_t g = layout.laws().group[s];
    const springnet_status status =
        layers::evaluate_springs(layout, at.set, at.time, at.nodes, g, &s, 1, *geometry, wanted, model.journal.message);
    if (status != SPRINGNET_OK) return status;
    const Vector3 n(geometry->nx[0], geometry->ny[0], geometry->nz[0]);
    places.add(layout.first(s), n);
    places.add(layout.second(s), -n);
    const layers::Group& group = layout.laws().groups[g];
    put_state(view, i, geometry->length[0], geometry->rate[0], group.columns[0][layout.laws().row[s]]);
    put(view, i, group,
        {{answers.force[0][0], answers.force[1][0]},
         {answers.by_q[0][0], answers.by_q[1][0]},
         {answers.by_rate[0][0], answers.by_rate[1][0]}});
  }
  return SPRINGNET_OK;
}

springnet_status view_bodies(Model& model, const At& at, springnet_element_view& view, Places& places) {
  const layers::Layout& layout = model.layout;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr layers::PairAnswers<1> no_answers{{{nan}, {nan}}, {{nan}, {nan}}, {{nan}, {nan}}, {{nan}, {nan}}};
  layers::PairAnswers<1> answers{};
  layers::PairOutputs wanted{};
  if (wants_laws(view)) wanted = answers.outputs(wants_derivatives(view), false);
  Gradients gradients;
  for (std::size_t i = 0; i < view.count; ++i) {
    const auto e = static_cast<std::uint32_t>(view.first + i);
    places.begin(i);
    if (!layout.elements().alive(e)) {
      put_removed(view, i);
      continue;
    }
    gradients.find(layout, at, e);
    const bool several = reads_several(layout.elements().invariant(e));
    const springnet_status status = several ? springnet_status{SPRINGNET_OK}
                                            : layers::evaluate_element(layout, at.set, at.time, at.nodes, e,
                                                                       gradients.state, wanted, model.journal.message);
    if (status != SPRINGNET_OK) return status;
    if (several) answers = no_answers;
    for (std::size_t k = 0; k < gradients.nodes.size(); ++k) places.add(gradients.nodes[k], gradients.by[k]);
    put_state(view, i, gradients.state.value, gradients.state.rate, layout.elements().reference(e));
    put(view, i, layout.laws().groups[layout.elements().group(e)],
        {{answers.force[0][0], answers.force[1][0]},
         {answers.by_q[0][0], answers.by_q[1][0]},
         {answers.by_rate[0][0], answers.by_rate[1][0]}});
  }
  return SPRINGNET_OK;
}

}  // namespace

springnet_status part_forces(Model& model, const springnet_part_forces& request) {
  if ((request.parts & ~all_parts) != 0)
    throw Error(ErrorKind::plugin, fmt::format("parts is {}, which has unknown bits", request.parts));
  const At at(model, *request.at);
  for (double* const component : {request.force.x, request.force.y, request.force.z})
    std::fill_n(component, model.node_count(), 0.0);
  add_external(model, at, request.parts, request.force);
  if ((request.parts & (spring_parts[0] | spring_parts[1])) != 0)
    if (const springnet_status status = add_springs(model, at, request.parts, request.force); status != SPRINGNET_OK)
      return model.failed(status, at.time, at.nodes);
  if ((request.parts & (element_parts[0] | element_parts[1])) != 0)
    if (const springnet_status status = add_elements(model, at, request.parts, request.force); status != SPRINGNET_OK)
      return model.failed(status, at.time, at.nodes);
  return SPRINGNET_OK;
}

springnet_status view_elements(Model& model, springnet_element_view& view) {
  const std::size_t all = view.of_elements != 0 ? model.layout.elements().count() : model.layout.spring_count();
  if (view.first > all || view.count > all - view.first)
    throw Error(ErrorKind::plugin, fmt::format("{} {} from number {} on were asked for, the network has {}", view.count,
                                               view.of_elements != 0 ? "elements" : "springs", view.first, all));
  const At at(model, *view.at);
  Places places(view);
  const springnet_status status =
      view.of_elements != 0 ? view_bodies(model, at, view, places) : view_springs(model, at, view, places);
  if (status != SPRINGNET_OK) return model.failed(status, at.time, at.nodes);
  if (view.node_start != nullptr) view.node_start[view.count] = view.node_total;
  if ((view.nodes != nullptr || view.gradients != nullptr) && view.node_total > view.node_capacity)
    throw Error(ErrorKind::plugin,
                fmt::format("node_capacity is {}, {} nodes need room", view.node_capacity, view.node_total));
  return SPRINGNET_OK;
}

springnet_status balance(Model& model, springnet_balance& out) {
  const At at(model, *out.at);
  out.potential = layers::spring_energy(model.layout, at.set, at.time, at.nodes) +
                  layers::element_energy(model.layout, at.set, at.time, at.nodes);
  out.kinetic = 0.0;
  Vector3 momentum = Vector3::Zero(), spin = Vector3::Zero();
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    const double mass = model.mass[k];
    const Vector3 p = vector_at(out.at->position, k), v = vector_at(out.at->velocity, k);
    out.potential -= mass * model.loads.gravity().dot(p);
    out.kinetic += 0.5 * mass * v.squaredNorm();
    momentum += mass * v;
    spin += mass * p.cross(v);
  }
  Eigen::Map<Vector3>(out.momentum) = momentum;
  Eigen::Map<Vector3>(out.angular_momentum) = spin;
  return SPRINGNET_OK;
}

}  // namespace springnet
