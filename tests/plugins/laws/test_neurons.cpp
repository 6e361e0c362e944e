// The shipped neurons against their formulas.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>

#include "shipped.hpp"

using namespace springnet::test;

namespace {

struct Answer {
  std::array<double, 3> acceleration;
  std::array<double, 9> by_force, by_position, by_velocity;
  std::array<double, 3> by_mass, by_parameter;
};

Answer evaluate(const char* id, const std::array<double, 3>& force, const std::array<double, 3>& velocity, double mass,
                const double* parameter, std::uint32_t set) {
  const std::array<double, 3> position{0.1, 0.2, 0.3};
  const std::uint32_t stride = 0;
  Answer answer{};
  springnet_neuron_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.instruction_set = set;
  batch.force = {&force[0], &force[1], &force[2]};
  batch.position = {&position[0], &position[1], &position[2]};
  batch.velocity = {&velocity[0], &velocity[1], &velocity[2]};
  batch.mass = &mass;
  batch.parameters = &parameter;
  batch.parameter_strides = &stride;
  batch.acceleration = {&answer.acceleration[0], &answer.acceleration[1], &answer.acceleration[2]};
  batch.acceleration_by_force = answer.by_force.data();
  batch.acceleration_by_position = answer.by_position.data();
  batch.acceleration_by_velocity = answer.by_velocity.data();
  double* const by_parameters[] = {answer.by_parameter.data()};
  batch.acceleration_by_mass = answer.by_mass.data();
  batch.acceleration_by_parameters = by_parameters;
  const auto& model = *static_cast<const springnet_neuron_model*>(shipped(SPRINGNET_NEURON, id).implementation);
  REQUIRE(model.evaluate(model.context, &batch) == SPRINGNET_OK);
  return answer;
}

constexpr std::array<double, 9> diagonal(double value) { return {value, 0, 0, 0, value, 0, 0, 0, value}; }

}  // namespace

TEST_CASE("point_mass: a = F / m") {
  for (const std::uint32_t set : instruction_sets()) {
    const Answer answer = evaluate("point_mass", {2.0, -4.0, 8.0}, {1.0, 2.0, 3.0}, 4.0, nullptr, set);
    CHECK(answer.acceleration == std::array<double, 3>{0.5, -1.0, 2.0});
    CHECK(answer.by_force == diagonal(0.25));
    CHECK(answer.by_position == diagonal(0.0));
    CHECK(answer.by_velocity == diagonal(0.0));
    CHECK(answer.by_mass == std::array<double, 3>{-0.125, 0.25, -0.5});  // -F / m^2
  }
}

TEST_CASE("dragged: a = (F - drag v) / m") {
  const double drag = 2.0;
  for (const std::uint32_t set : instruction_sets()) {
    const Answer answer = evaluate("dragged", {2.0, -4.0, 8.0}, {1.0, 2.0, 3.0}, 4.0, &drag, set);
    CHECK(answer.acceleration == std::array<double, 3>{0.0, -2.0, 0.5});
    CHECK(answer.by_force == diagonal(0.25));
    CHECK(answer.by_position == diagonal(0.0));
    CHECK(answer.by_velocity == diagonal(-0.5));
    CHECK(answer.by_mass == std::array<double, 3>{0.0, 0.5, -0.125});         // -(F - drag v) / m^2
    CHECK(answer.by_parameter == std::array<double, 3>{-0.25, -0.5, -0.75});  // -v / m
  }
}
