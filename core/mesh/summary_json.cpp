#include <nlohmann/json.hpp>
#include <springnet/mesh_summary.hpp>

namespace springnet {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Vector3& vector) { return Json::array({vector.x(), vector.y(), vector.z()}); }

template <class Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const MeshExtent& extent) {
  Json types = Json::object();
  for (std::size_t type = 0; type < cell_type_count; ++type) {
    if (extent.cells_of[type] > 0) types[std::string(name_of(static_cast<CellType>(type)))] = extent.cells_of[type];
  }
  return {{"name", extent.name},
          {"dimension", extent.dimension < 0 ? Json(nullptr) : Json(extent.dimension)},
          {"points", extent.points},
          {"cells", extent.cells},
          {"cell_types", types},
          {"measure", extent.measure},
          {"lower", json_of(extent.lower)},
          {"upper", json_of(extent.upper)},
          {"edges", extent.edges},
          {"shortest_edge", extent.shortest},
          {"median_edge", extent.median},
          {"longest_edge", extent.longest},
          {"closed", json_of(extent.closed)},
          {"enclosed_volume", json_of(extent.enclosed)}};
}

}  // namespace

std::string to_json(const MeshSummary& summary) {
  Json document = json_of(summary.whole);
  document.erase("name");
  document["unit"] = {{"unit", summary.unit.unit},
                      {"scale", summary.unit.scale},
                      {"sure", summary.unit.sure},
                      {"reason", summary.unit.reason}};
  document["groups"] = Json::array();
  for (const MeshExtent& group : summary.groups) document["groups"].push_back(json_of(group));
  document["notes"] = summary.notes;
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
