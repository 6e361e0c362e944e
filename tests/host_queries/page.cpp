// The blocks of examples/host/README.md, one after the other on one simulation.

#include <doctest/doctest.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <thread>

#include <springnet/scene_writer.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using springnet::testing::cube;
using springnet::testing::newton;
using springnet::testing::plugins;
using springnet::testing::recurrent;
using springnet::testing::simulate;
using springnet::testing::TemporaryFolder;

TEST_CASE("the blocks of the page do what it says") {
  const std::shared_ptr<const springnet::PluginHost> plugins = springnet::testing::plugins();
  springnet::Simulation simulation = simulate(cube(3.0, 2.0, 9.81, 0.02), recurrent(newton, 1e-9), 0.005);
  simulation.advance_to(0.03);
  {
#include "maps.inl"
    CHECK(mine.col(5) == simulation.position(5));
    CHECK(reactions.cols() == 64);
    CHECK(lowest > 0.0);
    CHECK(tensions[tightest] == doctest::Approx(simulation.tension(static_cast<springnet::SpringIndex>(tightest))));
    CHECK(mechanical == doctest::Approx(simulation.kinetic_energy() + simulation.potential_energy()));
  }
  {
#include "where.inl"
    CHECK(nearest == springnet::NodeIndex{16});
    CHECK(spring->distance < 0.1);
    CHECK(around.size() == 6);  // on an edge of the cube
    CHECK(touched.empty());
  }
  {
#include "callbacks.inl"
    CHECK(hit_nodes.size() == 16);
    CHECK(steps == 20);
  }
  {
#include "progress.inl"
    CHECK(simulation.time() == doctest::Approx(start + 0.1));
  }
  {
#include "snapshots.inl"
    CHECK(simulation.snapshot() == nullptr);
  }
  {
#include "limits.inl"
  }
  const TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  {
#include "scene.inl"
    CHECK(again.node_count() == 64);
    CHECK(read.network.nodes()[7].position == simulation.position(7));
  }
  std::filesystem::current_path(before);
}
