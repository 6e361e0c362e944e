// Which observed places a page of a learned net shows in which record; what it refuses.
#include "view/learned.hpp"

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/view.hpp>

#include "refusal.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;

TEST_CASE("an observed place is in the record next to its time, one of each node, the nearest") {
  view::Selection selection;
  selection.node_place = {0, view::not_shown, 1};
  LearnedView learned;
  const auto seen = [&](double time, double x, NodeIndex node) {
    learned.observed.push_back({time, Vector3(x, 0, 0), node});
  };
  seen(0.14, 1, 2);
  seen(0.12, 2, 2);  // nearer to 0.1
  seen(0.16, 3, 2);  // in the record at 0.2
  seen(0.1, 4, 1);   // of a node that is not drawn
  seen(9.0, 5, 0);   // after the end: in the last record
  seen(0.11, 6, ViewPoint::no_node);
  seen(0.11, 7, ViewPoint::no_node);
  seen(0.08, 8, ViewPoint::no_node);  // farther than those at 0.11
  using What = ViewPoint::What;
  learned.observed.push_back({0.21, Vector3(9, 0, 0), 2, What::velocity});  // beside the place
  learned.observed.push_back({0.24, Vector3(10, 0, 0), 2, What::velocity});
  learned.observed.push_back({0.2, Vector3(11, 0, 0), 2, What::position, true});  // does not take the place of 3
  learned.observed.push_back({0.3, Vector3(12, 0, 0), 0, What::force, true});
  const view::ObservedFrames frames = view::observed_frames(learned, {0.0, 0.1, 0.2, 0.3}, selection);
  CHECK(frames.first == std::vector<std::uint32_t>{0, 0, 4, 7, 9});
  CHECK(frames.nodes ==
        std::vector<std::uint32_t>{view::not_shown, 1, view::not_shown, view::not_shown, 1, 1, 1, 0, 0});
  CHECK(frames.kinds == std::vector<std::uint8_t>{0, 0, 0, 0, 0, 1, 4, 0, 6});
  REQUIRE(frames.points.size() == 27);
  std::vector<float> x;
  for (std::size_t k = 0; k < 27; k += 3) x.push_back(frames.points[k]);
  CHECK(x == std::vector<float>{4, 2, 6, 7, 3, 9, 11, 5, 12});
}

TEST_CASE("a page of a learned net keeps its size, and refuses values of what is not there") {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::barely_bent();
  const auto learned = std::make_shared<LearnedView>();
  ViewValues values{ViewValues::Of::springs, "spring.stiffness", "N/m", {}};
  for (SpringIndex k = 0; k < scene.network.springs().size(); ++k)
    values.values.push_back({k, 1.0, 2.0, 1.5, 2.5, 1.0});
  learned->values.push_back(values);
  for (int record = 0; record < 40; ++record)
    for (NodeIndex k = 0; k < scene.network.nodes().size(); ++k)
      learned->observed.push_back({0.01 * record, Vector3::Zero(), k});
  int motions = 1;
  const auto size_of_page = [&](double size) {
    ViewWriter page(folder.path() / "page.html", scene, {size, testing::plugins(), learned, 1.0 / motions});
    for (int motion = 0; motion < motions; ++motion) {
      ViewWriter& to = motion == 0 ? page : page.add(scene, {size, testing::plugins(), learned, 1.0 / motions});
      Simulation simulation(scene.network, testing::plugins(), scene.options);
      to.record(simulation, simulation);
      for (int record = 1; record < 40; ++record) {
        simulation.advance_to(0.01 * record);
        to.record(simulation, simulation);
      }
    }
    page.close();
    return static_cast<double>(testing::read_text(folder.path() / "page.html").size());
  };
  const double whole = size_of_page(16e6), program = view::program_bytes(), limit = program + 0.4 * (whole - program);
  CHECK(size_of_page(limit) <= limit);
  motions = 3;
  const double of_three = size_of_page(16e6), limit_of_three = program + 0.4 * (of_three - program);
  CHECK(of_three > program + 2.5 * (whole - program));
  CHECK(size_of_page(limit_of_three) <= limit_of_three);
  motions = 1;
  learned->values.front().values.back().member = 1000000;
  CHECK(testing::refusal_of([&] { (void)size_of_page(16e6); }).find("spring 1000000") != std::string::npos);
  learned->values.clear();
  learned->observed.front().node = 1000000;
  CHECK(testing::refusal_of([&] { (void)size_of_page(16e6); }).find("node 1000000") != std::string::npos);
}
