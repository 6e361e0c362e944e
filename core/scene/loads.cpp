// [[force]]: loads on nodes and on the faces of bodies, over time.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "scene/chosen.hpp"
#include "scene/lists.hpp"
#include "scene/parts.hpp"
#include "scene/time_table.hpp"

namespace springnet::scene {
namespace {

constexpr std::array<std::string_view, 4> kinds{"force", "total", "traction", "pressure"};

// The one of `kinds` that is given.
std::string_view kind_of(const Table& table) {
  std::string_view kind;
  for (const std::string_view key : kinds) {
    const auto value = table.find(key);
    if (!value) continue;
    if (!kind.empty()) value->fail(fmt::format("cannot be combined with '{}'; give each its own [[force]]", kind));
    kind = key;
  }
  if (kind.empty()) {
    table.fail(
        "does not say what acts; add force = [x, y, z] (N, on each node), total = [x, y, z] (N, shared), traction = "
        "[x, y, "
        "z] (Pa, on faces) or pressure = … (Pa, on faces)");
  }
  return kind;
}

void read_course(const Table& table, Course& course) {
  if (const auto rows = table.find("table")) {
    refuse_beside(table, {"sinusoid", "ramp"}, "table");
    read_time_table(*rows, "[t, factor]", 2, [&](double time, const std::vector<Value>& numbers) {
      course.times.push_back(time);
      course.factors.push_back(numbers[1].number());
    });
    if (std::all_of(course.factors.begin(), course.factors.end(), [](double factor) { return factor == 0.0; }))
      rows->fail("has only factors of 0; nothing would act");
    course.interpolation = read_interpolation(table);
    return;
  }
  if (const auto interpolation = table.find("interpolation")) interpolation->fail("requires 'table'; remove it");
  if (const auto sinusoid = table.find("sinusoid")) {
    refuse_beside(table, {"ramp"}, "sinusoid");
    const Table keys = sinusoid->table("force.sinusoid");
    course.frequency = keys.need("frequency").number_above_0("Hz");
    if (const auto phase = keys.find("phase")) course.phase = phase->number();
    if (const auto amplitude = keys.find("amplitude")) course.amplitude = amplitude->number();
    if (const auto mean = keys.find("mean")) course.mean = mean->number();
  }
  if (const auto ramp = table.find("ramp")) course.ramp = ramp->number_above_0("s");
}

// Adds the selected faces of bodies, with their areas, to the load.
void add_faces(const Value& selection, const Chosen& chosen, std::size_t index, Scene& scene, Load& load) {
  const Network& network = scene.network;
  load.faces = chosen.triangles(network);
  if (load.faces.empty()) {
    selection.fail(fmt::format(
        "has no triangle among the faces of a body, all of whose nodes are selected{}; select more, or use 'force' or "
        "'total', which act on nodes",
        chosen.by_groups() ? " and that is in one of the groups named" : ""));
  }
  double greatest = 0.0;
  for (const Face& face : load.faces) {
    load.areas.push_back(network.area_of(face));
    greatest = std::max(greatest, load.areas.back().norm());
  }
  if (!(greatest > 0.0)) selection.fail("has only triangles without an area; nothing would act on them");
  constexpr double negligible = 1e-12;  // relative to the greatest: rounding of coordinates
  const auto flat = std::count_if(load.areas.begin(), load.areas.end(),
                                  [&](const Vector3& area) { return area.norm() <= negligible * greatest; });
  if (flat > 0) {
    scene.notes.push_back(fmt::format("Force {}: {} of its {} faces have no area; nothing acts on them.", index, flat,
                                      load.faces.size()));
  }
}

// Listed faces, which need not be those of a body, with their areas if these are not those of the scene.
void read_faces(const Value& faces, const std::optional<Value>& areas, const Network& network, Load& load) {
  for (const Value& face : faces.elements()) load.faces.push_back(read_face(face, nullptr, network));
  if (load.faces.empty()) faces.fail("lists no face; give the nodes of one or more, as [[0, 1, 2], [1, 2, 3]]");
  if (areas)
    for (const Value& area : areas->elements(load.faces.size())) load.areas.push_back(area.vector());
}

// Whether each selected node is a corner of a selected face.
bool is_surface(const std::vector<NodeIndex>& nodes, const std::vector<Face>& faces) {
  std::vector<NodeIndex> corners;
  for (const Face& face : faces) corners.insert(corners.end(), face.begin(), face.end());
  std::sort(corners.begin(), corners.end());
  return std::includes(corners.begin(), corners.end(), nodes.begin(), nodes.end());
}

// Divides a total equally among nodes, or by area, as a traction.
void share_total(const Table& table, const Vector3& total, const Chosen& chosen, std::size_t index, Scene& scene,
                 Load& load) {
  const Value selection = table.need("select");
  std::vector<NodeIndex> nodes = select_nodes(selection, scene.network);
  const auto share = table.find("share");
  const bool by_area =
      share ? share->choice({"area", "nodes"}) == 0 : is_surface(nodes, chosen.triangles(scene.network));
  if (!by_area) {
    load.force = total / static_cast<double>(nodes.size());
    load.nodes = std::move(nodes);
    return;
  }
  add_faces(selection, chosen, index, scene, load);
  double area = 0.0;
  for (const Vector3& each : load.areas) area += each.norm();
  load.traction = total / area;
}

void read_force(const Table& table, const std::vector<Shape>& shapes, Scene& scene) {
  Network& network = scene.network;
  const std::size_t index = network.loads().size();
  const std::string_view kind = kind_of(table);
  const auto faces = table.find("faces");
  if (faces) refuse_beside(table, {"select", "force", "total"}, "faces");
  if (const auto areas = table.find("areas"); areas && !faces) areas->fail("requires 'faces'; remove it");
  const Value value = *table.find(kind), selection = faces ? *faces : table.need("select");
  if (kind != "total") {
    if (const auto share = table.find("share")) share->fail("requires 'total'; remove it");
  }
  if (kind != "pressure") {
    if (const auto follow = table.find("follow")) follow->fail("requires 'pressure'; remove it");
  }
  Load load;
  if (kind == "force") {
    load.force = value.vector();
    load.nodes = select_nodes(selection, network);
  } else {
    const std::optional<Chosen> chosen =
        faces ? std::nullopt : std::optional<Chosen>(std::in_place, selection, network, shapes);
    if (kind == "total") {
      share_total(table, value.vector(), *chosen, index, scene, load);
    } else {
      if (faces)
        read_faces(*faces, table.find("areas"), network, load);
      else
        add_faces(selection, *chosen, index, scene, load);
      if (kind == "traction") {
        load.traction = value.vector();
      } else {
        load.pressure = value.number();
        if (const auto follow = table.find("follow")) load.follow = follow->boolean();
      }
    }
  }
  if (const auto from = table.find("from")) load.from = from->number();
  if (const auto until = table.find("until")) load.until = until->number();
  read_course(table, load.course);
  (table.has("until") ? *table.find("until") : table.value()).at_this_place([&] { network.add_load(load); });
}

}  // namespace

void read_loads(const Table& root, const std::vector<Shape>& shapes, Scene& scene) {
  std::size_t selected = 0;
  for (const Value& value : root.tables("force")) {
    const Table table = value.table("force");
    read_force(table, shapes, scene);
    const Load& load = scene.network.loads().back();
    count_selected(table.value(), load.nodes.size() + load.faces.size(), selected);
  }
}

}  // namespace springnet::scene
