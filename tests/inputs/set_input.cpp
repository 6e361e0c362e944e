// Signals that the embedding program sets.
#include <springnet/error.hpp>

#include <doctest/doctest.h>

#include "laws.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

Network driven(const Signal& signal, const char* name = "drive") {
  Network net = oscillator({LawUse{"motor", {}}, std::nullopt}, 2.0, 0.5);
  Input input;
  input.input = "tension";
  input.name = name;
  input.springs = {0};
  input.signal = signal;
  net.add_input(input);
  return net;
}

}  // namespace

TEST_CASE("a program that sets a signal step by step gets the motion of a signal that holds") {
  const std::vector<double> times{0, 0.1, 0.25, 0.4}, values{3, -4, 1, 8};
  for (const LawUse& method : {recurrent(newton, 1e-12), recurrent(wavefront, 1e-12, {{"theta", 0.5}}), single_sweep(),
                               LawUse{"verlet", {}}, generalized_alpha(), cvode(1e-9)}) {
    CAPTURE(method.id);
    Simulation told = simulate_with_inputs(driven(constant(0)), method, 0.05);
    Simulation known = simulate_with_inputs(driven(table(times, values, Signal::Interpolation::hold)), method, 0.05);
    for (std::size_t k = 0; k < times.size(); ++k) {
      told.advance_to(times[k]);
      if (k % 2 == 0)
        told.set_input("drive", values[k]);
      else
        told.set_input(InputIndex{0}, values[k]);
      CHECK(told.input_value(0) == values[k]);
      CHECK(told.tension(0) == values[k]);
    }
    told.advance_to(0.6);
    known.advance_to(0.6);
    // At a jump only the bits of the times differ.
    CHECK(told.position(1)[0] == doctest::Approx(known.position(1)[0]).epsilon(method.id == "cvode" ? 1e-8 : 1e-13));
    CHECK(told.velocity(1)[0] == doctest::Approx(known.velocity(1)[0]).epsilon(method.id == "cvode" ? 1e-8 : 1e-12));
  }
}

TEST_CASE("values and names that do not fit are refused") {
  Simulation simulation = simulate_with_inputs(driven(constant(1)), recurrent(newton, 1e-9), 0.1);
  const auto refusal = [&](const auto& change) -> std::string {
    try {
      change();
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      return error.what();
    }
    return {};
  };
  CHECK(refusal([&] { simulation.set_input(0, 51); }).find("must be at most 50") != std::string::npos);
  CHECK(refusal([&] { simulation.set_input(0, std::numeric_limits<double>::quiet_NaN()); }).find("finite") !=
        std::string::npos);
  CHECK(refusal([&] { simulation.set_input(1, 0); }).find("the network has 1") != std::string::npos);
  CHECK(refusal([&] { simulation.set_input("drove", 0); }).find("'drive'") != std::string::npos);
  CHECK(refusal([&] { static_cast<void>(simulation.input_value(7)); }).find("does not exist") != std::string::npos);
  CHECK(simulation.input_value(0) == 1);
}

TEST_CASE("a network refuses signals that are none") {
  const auto refusal = [](Signal signal, std::string input = "tension", std::vector<SpringIndex> springs = {0}) {
    Network net = oscillator({LawUse{"motor", {}}, std::nullopt}, 2.0, 0.5);
    Input added;
    added.input = input;
    added.springs = springs;
    added.signal = signal;
    try {
      net.add_input(added);
      static_cast<void>(simulate_with_inputs(net, recurrent(newton, 1e-9), 0.1));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  using enum Signal::Interpolation;
  const auto says = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  CHECK(refusal(constant(2)).empty());
  CHECK(says(refusal(table({0, 1, 1}, {0, 1, 2}, linear)), "must increase"));
  CHECK(says(refusal(table({0, 1}, {0, 1, 2}, linear)), "equal numbers"));
  CHECK(says(refusal(table({0}, {0}, linear)), "two entries"));
  CHECK(says(refusal(table({0, 1}, {0, std::numeric_limits<double>::infinity()}, linear)), "entry 1"));
  CHECK(says(refusal(table({0, 1}, {0, 60}, linear)), "entry 1 of its table must be at most 50"));
  CHECK(says(refusal(table({0, 1}, {0, 1}, static_cast<Signal::Interpolation>(9))), "unknown interpolation 9"));
  CHECK(says(refusal(constant(2), ""), "give `input`"));
  CHECK(says(refusal(constant(2), "tensions"), "did you mean 'tension'"));
  CHECK(says(refusal(constant(2), "tension", {}), "for no spring"));
  CHECK(says(refusal(constant(2), "tension", {4}), "there are only 1 springs"));
  Signal wave;
  wave.mean = 10;
  wave.amplitude = 45;
  wave.frequency = 1;
  CHECK(says(refusal(wave), "greatest value"));
  wave.frequency = -1;
  CHECK(says(refusal(wave), "frequency"));
  wave.amplitude = 1;
  wave.frequency = 1e308;  // times 2 pi it is infinite
  CHECK(says(refusal(wave), "frequency"));
  CHECK(says(refusal(table({-1e308, 1e308}, {0, 1}, linear)), "too far apart"));
  CHECK(refusal(constant(2), "\x1b[2J").find('\x1b') == std::string::npos);
}
