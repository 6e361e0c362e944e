// A block that is torn.
#pragma once

#include "nets.hpp"
#include "uneven.hpp"

namespace springnet::testing {

// Springs that break, an angle and loaded faces along them, a cut at this time (s). with_memory: and at last two
// springs that are damaged until they break.
inline Network torn(double cut_time, bool with_memory) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 2, 2};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, {},
                  net.add_material({LawUse{"rupturing", {{"stiffness", 60.0}, {"strength", 9.0}}},
                                    LawUse{"linear", {{"damping", 0.4}}}}));
  make_uneven(net, 5, 0.04, 0.3, [](const Vector3& place) { return Vector3(1.2 * place.x(), 0, 0); });
  net.fix(0);
  if (with_memory) {
    const MaterialIndex damaged = net.add_material({LawUse{"damaging",
                                                           {{"stiffness", 40.0},
                                                            {"threshold_strain", 0.01},
                                                            {"softening_strain", 0.4},
                                                            {"relaxation_time", 0.05},
                                                            {"breaking_damage", 0.5}}},
                                                    std::nullopt});
    net.add_spring(0, 7, damaged);
    net.add_spring(1, 10, damaged);
  }
  const MaterialIndex bending =
      net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
  net.add_element(Invariant::angle, {1, 2, 7}, bending, 1.6);
  Load blown;
  blown.faces = net.faces();
  blown.pressure = 1.0;
  blown.follow = true;
  net.add_load(blown);
  net.add_cut({cut_time, {0, 5}, {}});
  return net;
}

}  // namespace springnet::testing
