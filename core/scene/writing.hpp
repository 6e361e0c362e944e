// Parts of the writer of scenes, in the order of what they write.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <springnet/scene_writer.hpp>

#include "scene/toml_text.hpp"
#include "scene/write_values.hpp"

namespace springnet::scene {

[[nodiscard]] inline bool same_bits(double a, double b) { return detail::SameBits<double>::of(a, b); }
[[nodiscard]] inline bool same_bits(const Vector3& a, const Vector3& b) { return detail::SameBits<Vector3>::of(a, b); }

// "{ type = "linear", stiffness = 3.0 }", or with the law's formula. `name_key`: "type", or "name" of an integrator;
// mass: of a neuron.
[[nodiscard]] std::string text_of(const LawUse& use, ComponentKind kind, const PluginHost& plugins,
                                  std::string_view name_key = "type", std::optional<double> mass = {});
// A value of a parameter: a choice by its name.
[[nodiscard]] std::string text_of(const springnet_parameter& parameter, double value);
// The keys spring and viscosity. with_none: also where there is none, for what replaces another.
void write_material(const Material& material, const PluginHost& plugins, bool with_none, toml_text::Document& out);

// What is written as a [[body]].
struct Block {
  std::string name;
  NodeIndex first_node, node_count;
  SpringIndex first_spring, spring_count;
  std::size_t first_face, face_count;
  const Body* body;  // null: nodes of no body
};
// Bodies, connections, rigid connections, and nodes and springs that differ from the rest of their body.
void write_bodies(const Network& network, const PluginHost& plugins, const ValueFiles& values,
                  toml_text::Document& out);
void write_node_changes(const Network& network, const PluginHost& plugins, ValueFiles& values,
                        toml_text::Document& out);

// [[element]], and the names of the tables.
class WrittenElements {
 public:
  WrittenElements(const Scene& scene, const PluginHost& plugins, ValueFiles& values);
  void write(toml_text::Document& out) const;
  // The names of the tables that have these elements, ascending, and no others. Throws Error(input) if there are none
  // such; `what` asks.
  [[nodiscard]] std::string names_of(std::vector<ElementIndex> elements, std::string_view what) const;

 private:
  struct Piece {
    ElementIndex first, count;
    std::string name;
  };
  const Network& network_;
  const PluginHost& plugins_;
  ValueFiles& values_;
  std::vector<Piece> pieces_;
};

void write_loads(const Network& network, toml_text::Document& out);
// [[cut]], [[move]], [[plane]], [[instrument]]
void write_surroundings(const Network& network, toml_text::Document& out);
void write_inputs(const Network& network, const WrittenElements& elements, toml_text::Document& out);
void write_changes(const Network& network, const PluginHost& plugins, const WrittenElements& elements,
                   toml_text::Document& out);

}  // namespace springnet::scene
