// What a mesh holds, and which unit its coordinates are in.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/material.hpp>
#include <springnet/mesh_summary.hpp>

using namespace springnet;

namespace {

// A box of 3 x 2 x 1 cells of 10 x 10 x 20, with its lower face as a group, and its corner points as another.
Mesh box() {
  Mesh mesh = mesh_of({.nodes = {4, 3, 2}, .spacing = Vector3(10, 10, 20)});
  MeshGroup bottom{"bottom", {}, {}};
  for (std::uint32_t j = 0; j < 2; ++j) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t k = i + 4 * j;
      bottom.cells.push_back(static_cast<std::uint32_t>(mesh.cell_count()));
      mesh.add_cell(CellType::quadrilateral, std::array{k, k + 1, k + 5, k + 4});
    }
  }
  for (std::uint32_t k = 0; k < 12; ++k) bottom.points.push_back(k);
  mesh.groups = {bottom, {"corners", {}, {0, 3}}};
  return mesh;
}

// The faces of a tetrahedron.
Mesh shell(bool open) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {0.06, 0, 0}, {0, 0.06, 0}, {0, 0, 0.06}};
  mesh.add_cell(CellType::triangle, std::array{0U, 2U, 1U});
  mesh.add_cell(CellType::triangle, std::array{0U, 1U, 3U});
  mesh.add_cell(CellType::triangle, std::array{3U, 1U, 2U});  // the opposite orientation: neighbours need not agree
  if (!open) mesh.add_cell(CellType::triangle, std::array{0U, 3U, 2U});
  return mesh;
}

}  // namespace

TEST_CASE("counts, sizes, edges and groups of a solid") {
  const MeshSummary summary = summarise(box());
  const MeshExtent& whole = summary.whole;
  CHECK(whole.dimension == 3);
  CHECK(whole.points == 24);
  CHECK(whole.cells == 12);
  CHECK(whole.cells_of[static_cast<std::size_t>(CellType::hexahedron)] == 6);
  CHECK(whole.cells_of[static_cast<std::size_t>(CellType::quadrilateral)] == 6);
  CHECK(whole.measure == doctest::Approx(30.0 * 20.0 * 20.0));
  CHECK(whole.size() == 30.0);
  CHECK(whole.upper == Vector3(30, 20, 20));
  CHECK(whole.edges == 46);  // along x 3 * 6, along y 2 * 8, along z 12
  CHECK(whole.shortest == 10.0);
  CHECK(whole.median == 10.0);
  CHECK(whole.longest == 20.0);
  CHECK(whole.closed == true);
  CHECK_FALSE(whole.enclosed);  // it is filled
  REQUIRE(summary.groups.size() == 2);
  const MeshExtent& bottom = summary.groups[0];
  CHECK(bottom.name == "bottom");
  CHECK(bottom.dimension == 2);
  CHECK(bottom.points == 12);
  CHECK(bottom.cells == 6);
  CHECK(bottom.measure == doctest::Approx(600.0));
  CHECK(bottom.closed == false);
  CHECK(bottom.edges == 17);
  const MeshExtent& corners = summary.groups[1];
  CHECK(corners.dimension == -1);
  CHECK(corners.points == 2);
  CHECK(corners.edges == 0);
  CHECK(corners.upper == Vector3(30, 0, 0));
  CHECK_FALSE(corners.closed);
}

TEST_CASE("a surface is closed or open, and a closed one encloses a volume") {
  const MeshExtent closed = summarise(shell(false)).whole;
  CHECK(closed.dimension == 2);
  CHECK(closed.closed == true);
  REQUIRE(closed.enclosed);
  CHECK(*closed.enclosed == doctest::Approx(0.06 * 0.06 * 0.06 / 6.0));
  const MeshExtent open = summarise(shell(true)).whole;
  CHECK(open.closed == false);
  CHECK_FALSE(open.enclosed);
}

TEST_CASE("the unit is guessed from the size; where that is ambiguous, the summary says so") {
  struct Guess {
    double size, scale;
    bool sure;
  };
  for (const Guess& guess :
       {Guess{0.08, 1.0, true}, Guess{1.8, 1.0, true}, Guess{5.0, 1.0, false}, Guess{83.0, 1e-3, true},
        Guess{1800.0, 1e-3, true}, Guess{80000.0, 1e-6, false}, Guess{2e-4, 1.0, false}, Guess{0.0, 1.0, false}}) {
    CAPTURE(guess.size);
    const UnitGuess found = guess_unit(guess.size);
    CHECK(found.scale == guess.scale);
    CHECK(found.sure == guess.sure);
    CHECK_FALSE(found.reason.empty());
  }
  CHECK(summarise(box()).unit.unit == "millimetres");
  CHECK(summarise(shell(true)).unit.unit == "metres");
}

TEST_CASE("the JSON has the whole summary") {
  const auto json = nlohmann::json::parse(to_json(summarise(box())));
  CHECK(json["points"] == 24);
  CHECK(json["cell_types"]["hexahedron"] == 6);
  CHECK(json["longest_edge"] == 20.0);
  CHECK(json["closed"] == true);
  CHECK(json["enclosed_volume"].is_null());
  CHECK(json["unit"]["scale"] == 1e-3);
  CHECK(json["groups"][0]["name"] == "bottom");
  CHECK(json["groups"][0]["dimension"] == 2);
  CHECK(json["groups"][1]["dimension"].is_null());
  CHECK(json["notes"].empty());
}
