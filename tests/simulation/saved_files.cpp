// Simulation::save_to() and restore_from(), and what of another simulation is refused.

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <csignal>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/simulation.hpp>

#include "facts.hpp"
#include "saved_states.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using namespace springnet::testing;
namespace fs = std::filesystem;

namespace {

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return "no error";
}

SimulationOptions options() { return with(recurrent(newton, 0.0), 0.02); }

Network small_net() {
  Network net = chain(3, {0, 0, 0}, {1, 0, 0}, damped(40.0, 0.5));
  net.fix(0);
  net.set_gravity({0, 0, -10});
  return net;
}

// The bytes with another identity or state, and checksums that fit.
std::string with_parts(const std::string& saved, const std::function<void(std::string&, std::string&)>& change) {
  const std::size_t head = std::strlen("springnet state 5\n");
  std::uint64_t sizes[2];
  std::uint32_t sums[2];
  const auto place = [&](int k) { return head + 12 * static_cast<std::size_t>(k); };
  for (int k = 0; k < 2; ++k) std::memcpy(&sizes[k], saved.data() + place(k), 8);
  std::string identity = saved.substr(head + 24, sizes[0]), state = saved.substr(head + 24 + sizes[0]);
  change(identity, state);
  std::string result = saved.substr(0, head + 24);
  const std::string* const parts[2] = {&identity, &state};
  for (int k = 0; k < 2; ++k) {
    sizes[k] = parts[k]->size();
    sums[k] = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(parts[k]->data()), static_cast<z_size_t>(parts[k]->size())));
    std::memcpy(result.data() + place(k), &sizes[k], 8);
    std::memcpy(result.data() + place(k) + 8, &sums[k], 4);
  }
  return result + identity + state;
}

}  // namespace

TEST_CASE("a file has the bytes of save(), and takes the place of the one before") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "run.state";
  Simulation own(eventful(), plugins(), options()), other(eventful(), plugins(), options());
  for (int i = 0; i < 4; ++i) own.step();
  own.save_to(file);
  CHECK(read_text(file) == own.save());
  own.step();
  own.save_to(file);
  other.restore_from(file);
  CHECK(difference(own, other) == "");
  own.step();
  other.step();
  CHECK(difference(own, other) == "");
  CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
  // What was left by a run that was killed while it wrote is in nobody's way.
  folder.write("run.state.part", "half");
  own.save_to(file);
  CHECK(!fs::exists(folder.path() / "run.state.part"));

  // A link stays one; what it leads to is replaced.
  fs::create_directory(folder.path() / "elsewhere");
  fs::create_symlink("elsewhere/real.state", folder.path() / "link.state");
  own.save_to(folder.path() / "link.state");
  CHECK(fs::is_symlink(folder.path() / "link.state"));
  CHECK(read_text(folder.path() / "elsewhere/real.state") == own.save());
  other.restore_from(folder.path() / "link.state");
  CHECK(difference(own, other) == "");
  // In the working folder.
  const fs::path home = fs::current_path();
  fs::current_path(folder.path());
  own.save_to("plain.state");
  other.restore_from("plain.state");
  fs::current_path(home);
  CHECK(difference(own, other) == "");
}

TEST_CASE("files that cannot be written or read") {
  const TemporaryFolder folder;
  Simulation own(small_net(), plugins(), options());
  own.step();
  const std::string state = own.save();
  const auto save_error = [&](const fs::path& file) {
    const std::string text = message_of([&] { own.save_to(file); });
    CHECK(text.starts_with(file.string() + ": the state cannot be saved"));
    return text;
  };
  const auto read_error = [&](const fs::path& file) {
    const std::string text = message_of([&] { own.restore_from(file); });
    CHECK(text.starts_with(file.string() + ": "));
    CHECK(own.save() == state);
    return text;
  };
  CHECK(has(save_error(folder.path()), "a folder has this name; name another file"));
  CHECK(has(save_error(folder.path() / ""), "add the name of a file"));
  CHECK(has(save_error(folder.path() / "none" / "x.state"), "No such file or directory"));
  CHECK(has(save_error("/dev/null"), "this is a device"));
  fs::create_symlink("b", folder.path() / "a");
  fs::create_symlink("a", folder.path() / "b");
  CHECK(has(save_error(folder.path() / "a"), "leads nowhere"));
  CHECK(has(read_error(folder.path() / "a"), "cannot be read"));
  CHECK(has(read_error(folder.path()), "it is a folder"));
  CHECK(has(read_error(folder.path() / "none"), "No such file or directory"));
  CHECK(has(read_error("/dev/zero"), "this is no state saved by springnet"));
  CHECK(has(read_error("/dev/null"), "this is no state saved by springnet"));
  if (geteuid() != 0) {
    fs::create_directory(folder.path() / "closed");
    fs::permissions(folder.path() / "closed", fs::perms::owner_read | fs::perms::owner_exec);
    CHECK(has(save_error(folder.path() / "closed" / "x.state"), "Permission denied"));
    fs::permissions(folder.path() / "closed", fs::perms::owner_all);
    folder.write("secret", state);
    fs::permissions(folder.path() / "secret", fs::perms::none);
    CHECK(has(read_error(folder.path() / "secret"), "Permission denied"));
  }

  // No room: what was there stays, whole.
  const fs::path file = folder.path() / "run.state";
  own.save_to(file);
  {
    void (*const handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    const rlimit none{1000, limit.rlim_max};
    setrlimit(RLIMIT_FSIZE, &none);
    const std::string text = save_error(file);
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, handler);
    CHECK(has(text, "make room"));
  }
  CHECK(read_text(file) == state);
  CHECK(!fs::exists(folder.path() / "run.state.part"));

  // A terabyte of nothing, announced or not: refused before it is read.
  for (const bool announced : {false, true}) {
    folder.write("huge.state", state);
    const std::uint64_t size = std::uint64_t{1} << 40;
    if (announced) {
      std::string head = state;
      const std::size_t place = std::strlen("springnet state 5\n") + 12;
      std::uint64_t identity = 0;
      std::memcpy(&identity, head.data() + place - 12, 8);
      const std::uint64_t rest = size - (place + 12) - identity;
      std::memcpy(head.data() + place, &rest, 8);
      // Of another simulation, which is seen before the rest is read.
      head[place + 12 + 60] = 'x';
      folder.write("huge.state", head);
    }
    fs::resize_file(folder.path() / "huge.state", size);
    CHECK(has(read_error(folder.path() / "huge.state"), "damaged"));
  }
}

TEST_CASE("a file that is cut anywhere, or has any byte changed, is refused and changes nothing") {
  const TemporaryFolder folder;
  Simulation own(small_net(), plugins(), options());
  own.step();
  const std::string saved = own.save();
  CHECK(saved.size() < 20'000);
  std::size_t refused = 0;
  const auto is_refused = [&](const std::string& bytes) {
    const std::string text = message_of([&] { own.restore(bytes); });
    refused += has(text, "this is no state") || has(text, "damaged") || has(text, "has format") ? 1 : 0;
  };
  for (std::size_t size = 0; size < saved.size(); ++size) is_refused(saved.substr(0, size));
  CHECK(refused == saved.size());
  refused = 0;
  for (std::size_t place = 0; place < saved.size(); ++place) {
    std::string changed = saved;
    changed[place] = static_cast<char>(changed[place] ^ (1 << (place % 8)));
    is_refused(changed);
  }
  CHECK(refused == saved.size());
  refused = 0;
  is_refused(saved + "x");
  CHECK(refused == 1);
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{30}, std::size_t{60}, saved.size() - 1}) {
    folder.write("cut.state", saved.substr(0, size));
    CHECK(message_of([&] { own.restore_from(folder.path() / "cut.state"); }).starts_with(folder.path().string()));
  }
  folder.write("longer.state", saved + "x");
  CHECK(has(message_of([&] { own.restore_from(folder.path() / "longer.state"); }), "damaged"));
  CHECK(own.save() == saved);
}

TEST_CASE("a pipe can be restored from, too") {
  const TemporaryFolder folder;
  Simulation own(small_net(), plugins(), options()), other(small_net(), plugins(), options());
  own.step();
  const std::string saved = own.save();
  const fs::path pipe = folder.path() / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  std::FILE* const writer = std::fopen(pipe.c_str(), "r+");
  REQUIRE(std::fwrite(saved.data(), 1, saved.size(), writer) == saved.size());
  std::fflush(writer);
  // The writer is still there: the end would have to be waited for.
  CHECK(has(message_of([&] { other.save_to(pipe); }), "a device or a pipe"));
  std::fclose(writer);
}

TEST_CASE("an error says what of another simulation is another one") {
  Simulation own(eventful(), plugins(), options());
  own.step();
  const std::string saved = own.save();
  const auto error_with = [&](const Network& net, const SimulationOptions& other = options()) {
    Simulation simulation(net, plugins(), other);
    return message_of([&] { simulation.restore(saved); });
  };
  const auto refused = [&](const std::string& what, const std::function<void(Network&)>& change) {
    CAPTURE(what);
    Network net = eventful();
    change(net);
    const std::string text = error_with(net);
    CAPTURE(text);
    CHECK(text.starts_with("the saved state is of another simulation: " + what + ": "));
    CHECK(has(text, " there, "));
  };
  CHECK(error_with(eventful()) == "no error");
  refused("positions of nodes at the start", [](Network& net) {
    Node node = net.nodes()[5];
    node.position[0] += 1e-12;
    net.set_node(5, node);
  });
  refused("velocities of nodes at the start", [](Network& net) {
    Node node = net.nodes()[5];
    node.velocity[2] = 0.1;
    net.set_node(5, node);
  });
  refused("masses of nodes", [](Network& net) {
    Node node = net.nodes()[5];
    node.mass *= 2.0;
    net.set_node(5, node);
  });
  refused("fixed nodes", [](Network& net) { net.fix(5); });
  refused("nodes", [](Network& net) { net.add_node(point({20, 0, 0})); });
  refused("springs", [](Network& net) { net.add_spring(0, 63, 0); });
  refused("materials of springs", [](Network& net) { net.set_spring_material(7, 1); });
  refused("rest lengths of springs", [](Network& net) { net.set_rest_length(7, 1.01); });
  refused("the laws", [](Network& net) { net.add_material({{}, LawUse{"linear", {{"damping", 1.0}}}}); });
  refused("elements", [](Network& net) { net.add_element(Invariant::angle, {0, 1, 2}, 0); });
  refused("rigid connections", [](Network& net) { net.add_rigid(0, 63); });
  refused("planes", [](Network& net) { net.add_plane({"wall", {99, 0, 0}, {-1, 0, 0}}); });
  refused("instruments", [](Network& net) { net.add_instrument({"ball 2", {50, 50, 50}, {50, 50, 50}, 0.5}); });
  refused("loads", [](Network& net) {
    Load load;
    load.nodes = {1};
    load.force = {0, 0, 1};
    net.add_load(load);
  });
  refused("gravity", [](Network& net) { net.set_gravity({0, 0, -9.0}); });
  refused("cuts", [](Network& net) { net.add_cut({9.0, {3}, {}}); });
  refused("input signals", [](Network& net) {
    Input input = net.inputs()[0];
    input.name = "drive 2";
    input.signal.mean = 0.5;
    net.add_input(input);
  });
  // A node that moves is a fixed one, too.
  Network held = eventful(), moved = held;
  held.fix(0);
  Move move = held.moves()[0];
  move.nodes = {0};
  moved.add_move(move);
  Simulation holds(held, plugins(), options()), moves(moved, plugins(), options());
  CHECK(has(message_of([&] { moves.restore(holds.save()); }), "prescribed motions of nodes: 1 ("));
  // Names and faces have no mechanical effect.
  Network named = eventful();
  named.add_face({0, 1, 5});
  CHECK(error_with(named) == "no error");

  CHECK(has(error_with(eventful(), with(recurrent(newton, 0.0), 0.01)), "time step: 0.02 s there, 0.01 s here"));
  CHECK(has(error_with(eventful(), with({"verlet", {}}, 0.02)), "integrator: recurrent@"));
  CHECK(has(error_with(eventful(), with(recurrent(newton, 1e-6), 0.02)), "parameters of the integrator: "));
  SimulationOptions ordered = options();
  ordered.renumber = false;
  CHECK(has(error_with(eventful(), ordered), "nodes are renumbered: yes there, no here"));
  SimulationOptions summed = options();
  summed.dissipated_energy = true;
  CHECK(has(error_with(eventful(), summed), "dissipated energy is summed up: no there, yes here"));

  // Other versions, of the library, of a plugin, of the format.
  const auto replaced = [&](const std::string& from, const std::string& to) {
    const std::string changed = with_parts(saved, [&](std::string& identity, std::string&) {
      const std::size_t at = identity.find(from);
      REQUIRE(at != std::string::npos);
      identity.replace(at, from.size(), to);
    });
    return message_of([&] { own.restore(changed); });
  };
  CHECK(replaced("time step", "time step") == "no error");
  CHECK(has(replaced("linear@", "linear#"), "): linear#"));
  CHECK(has(replaced("recurrent@", "recurrent#"), "integrator: recurrent#"));
  CHECK(has(replaced("time step", "tame step"), "another version of springnet"));
  std::string older = saved;
  older[std::strlen("springnet state ")] = '1';
  CHECK(has(message_of([&] { own.restore(older); }), "has format 1, this is springnet "));
}

TEST_CASE("formulas tell themselves apart") {
  const auto net_of = [](const std::string& force, double stiffness) {
    LawFormula formula;
    formula.force = force;
    formula.parameters = {{"stiffness", "N/m"}};
    Network net;
    const MaterialIndex material = net.add_material({law_of(formula, {{"stiffness", stiffness}}), std::nullopt});
    net.add_spring(net.add_node(point({0, 0, 0})), net.add_node(point({1, 0, 0})), material, 0.9);
    return net;
  };
  Simulation own(net_of("stiffness * e", 3.0), plugins(), options());
  own.step();
  const std::string saved = own.save();
  const auto error_with = [&](const Network& net) {
    Simulation other(net, plugins(), options());
    return message_of([&] { other.restore(saved); });
  };
  CHECK(error_with(net_of("stiffness * e", 3.0)) == "no error");
  CHECK(has(error_with(net_of("2 * stiffness * e", 3.0)), "): formula@formula "));
  CHECK(has(error_with(net_of("stiffness * e", 4.0)),
            "parameters of the laws: formula: stiffness 3 there, formula: stiffness 4 here"));
}

TEST_CASE("a state with an integrator's memory that is refused changes nothing") {
  Simulation own(eventful(), plugins(), with(generalized_alpha(), 0.02));
  own.step();
  const std::string early = own.save();
  own.step();
  Simulation same = own.clone();
  const std::string bad = with_parts(early, [](std::string&, std::string& state) {
    const std::size_t at = state.rfind("generalized_alpha@");
    REQUIRE(at != std::string::npos);
    state[at] = 'x';
  });
  CHECK(has(message_of([&] { own.restore(bad); }), "the memory is not of integrator generalized_alpha@"));
  CHECK(difference(own, same) == "");
}
