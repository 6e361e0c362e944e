#include "view/description.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <springnet/version.hpp>

#include "view/energy.hpp"
#include "view/units.hpp"

namespace springnet::view {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Vector3& vector) { return {vector.x(), vector.y(), vector.z()}; }

std::string text_of(const Friction& friction) {
  switch (friction.kind) {
    case Friction::Kind::held:
      return "holds what touches it";
    case Friction::Kind::none:
      return "without friction";
    case Friction::Kind::coulomb:
      break;
  }
  return fmt::format("friction {:g}", friction.coefficient);
}

Json bodies_of(const Network& network) {
  Json bodies = Json::array();
  for (const Body& body : network.bodies()) {
    bodies.push_back({{"name", body.name},
                      {"first_node", body.first_node},
                      {"nodes", body.node_count},
                      {"first_spring", body.first_spring},
                      {"springs", body.spring_count}});
  }
  return bodies;
}

Json surfaces_of(const Network& network) {
  Json surfaces = Json::array();
  for (const Plane& plane : network.planes()) {
    surfaces.push_back({{"kind", "plane"},
                        {"name", plane.name},
                        {"point", json_of(plane.point)},
                        {"normal", json_of(plane.normal)},
                        {"friction", text_of(plane.friction)},
                        {"moves", plane.motion || plane.turn}});
  }
  for (const Instrument& instrument : network.instruments()) {
    if (instrument.box) {
      const Eigen::Quaterniond orientation(instrument.box->axes);
      surfaces.push_back({{"kind", "box"},
                          {"name", instrument.name},
                          {"point", json_of(instrument.first)},
                          {"size", json_of(instrument.box->size)},
                          {"orientation", {orientation.x(), orientation.y(), orientation.z(), orientation.w()}},
                          {"radius", instrument.box->radius},
                          {"friction", text_of(instrument.friction)},
                          {"moves", instrument.motion || instrument.turn}});
      continue;
    }
    surfaces.push_back({{"kind", instrument.first == instrument.second ? "sphere" : "capsule"},
                        {"name", instrument.name},
                        {"point", json_of(instrument.first)},
                        {"to", json_of(instrument.second)},
                        {"radius", instrument.radius},
                        {"friction", text_of(instrument.friction)},
                        {"moves", instrument.motion || instrument.turn}});
  }
  return surfaces;
}

Json elements_of(const Content& content) {
  const Network& network = content.scene.network;
  Json elements = Json::array();
  std::set<std::string> known;  // labels identify curves
  for (const ElementIndex k : content.elements) {
    const Element& element = network.elements()[k];
    const auto set =
        std::find_if(content.scene.elements.begin(), content.scene.elements.end(),
                     [&](const ElementSet& each) { return k >= each.first && k - each.first < each.count; });
    std::string kind(name_of(element.invariant));
    std::replace(kind.begin(), kind.end(), '_', ' ');
    const std::string name = set != content.scene.elements.end() ? set->name : "";
    std::string label = name.empty() ? kind : name + ", " + kind;
    if (element.invariant != Invariant::enclosed_volume || !known.insert(label).second) {
      label += fmt::format(" (element {})", k);
    }
    elements.push_back({{"label", label},
                        {"name", name},
                        {"kind", kind},
                        {"element", k},
                        {"unit", unit_of(element.invariant)},
                        {"reference", element.reference}});
  }
  return elements;
}

Json loads_of(const Content& content) {
  Json loads = Json::array();
  for (const DrawnLoad& each : content.forces.loads) {
    loads.push_back({{"nodes", each.nodes}, {"arrows", each.arrows}});
  }
  return loads;
}

// Colours of springs besides tension and speed, and which of them a spring of each material has.
Json states_of(const Content& content) {
  Json states = Json::array();
  for (const States::Of& each : content.states.all) states.push_back({{"label", each.label}, {"unit", each.unit}});
  return states;
}

const char* word_of(ViewValues::Of of) {
  switch (of) {
    case ViewValues::Of::nodes:
      return "nodes";
    case ViewValues::Of::elements:
      return "elements";
    case ViewValues::Of::springs:
      break;
  }
  return "springs";
}

// Null in the page of a run.
Json learned_of(const Content& content) {
  if (!content.learned) return nullptr;
  Json learned = Json::array();
  for (const ViewValues& each : content.learned->values)
    learned.push_back({{"name", each.name}, {"unit", each.unit}, {"of", word_of(each.of)}});
  return learned;
}

}  // namespace

std::string describe(const Content& content, bool rounded, const std::vector<std::string>& motions) {
  const Scene& scene = content.scene;
  const Network& network = scene.network;
  Json materials = Json::array();
  for (const Material& material : network.materials()) materials.push_back(text_of(content.plugins.get(), material));
  Json json{{"title", scene.title},
            {"version", version()},
            {"integrator", scene.options.integrator.id},
            {"time_step", scene.options.time_step},
            {"duration", scene.duration},
            {"gravity", json_of(network.gravity())},
            {"nodes", network.nodes().size()},
            {"springs", network.springs().size()},
            {"elements", network.elements().size()},
            {"shown_nodes", content.selection.nodes.size()},
            {"shown_springs", content.selection.springs.size()},
            {"frames", content.frames.count()},
            {"records", content.frames.recorded()},
            {"rounded", rounded},
            {"bodies", bodies_of(network)},
            {"materials", std::move(materials)},
            {"surfaces", surfaces_of(network)},
            {"curves", elements_of(content)},
            {"forces", content.forces.all},
            {"loads", loads_of(content)},
            {"states", states_of(content)},
            {"material_states", content.states.of_material},
            {"energy_leaves_out", left_out_of_energy(content)},
            {"failure", content.failure},
            {"learned", learned_of(content)},
            {"motions", motions},
            {"notes", content.notes}};
  std::string text = json.dump(1, ' ', true, Json::error_handler_t::replace);
  // A "</script>" in a title must not end the element.
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  return text;
}

}  // namespace springnet::view
