#include "simulation/contact_notes.hpp"

#include <fmt/format.h>

#include "plugin_host/message.hpp"

namespace springnet {

void note_grazing_touch(Model& model, std::uint32_t node, std::size_t surface, double time) {
  if (model.journal.count("grazing_touches") > 1.0) return;
  model.journal.note(
      fmt::format("At {:g} s node {} touches {} so slowly that errors of integration decide when, and whether; such "
                  "touches are counted as grazing_touches.",
                  time, model.user_number(node), model.contact.name_of(surface)));
}

void note_grazing_slip(Model& model, std::uint32_t node, std::size_t surface, double time) {
  if (model.journal.count("grazing_slips") > 1.0) return;
  model.journal.note(
      fmt::format("At {:g} s node {} slips on {} so slowly that errors of integration decide when that begins or ends, "
                  "and whether; such slips are counted as grazing_slips.",
                  time, model.user_number(node), model.contact.name_of(surface)));
}

void note_unresolved(Model& model, std::uint32_t node, double time) {
  if (model.journal.count("unresolved_contacts") > 1.0) return;
  model.journal.note(fmt::format(
      "At {:g} s no contact forces were found that fit node {} and {}: one of them may pull, or friction exceed its "
      "limit; such moments are counted as unresolved_contacts.",
      time, model.user_number(node),
      model.rigid.is_joined(node) ? "the nodes rigidly connected to it" : "the bodies that touch there"));
}

void note_held_friction(Model& model, const std::string& pair, double time) {
  if (model.journal.count("held_friction") > 1.0) return;
  model.journal.note(
      fmt::format("At {:g} s friction between bodies did not settle and was held as it was: {} slip, although it is "
                  "within its limit; use a smaller time step. Such steps are counted as held_friction.",
                  time, pair));
}

springnet_status no_place(Model& model, std::uint32_t node, const std::vector<std::int32_t>& surfaces, double time,
                          const std::string& bodies) {
  const std::uint32_t* clusters = model.rigid.cluster_of();
  const bool rods = clusters != nullptr && clusters[node] != ConstraintRow::no_node;
  const std::string between =
      model.contact.names_of(surfaces) + (surfaces.empty() || bodies.empty() ? "" : " and ") + bodies;
  set_message(model.journal.message,
              fmt::format("At {:.9g} s there is no place left for node {}{} between {}{}: they have closed; stop their "
                          "motion earlier, or let the node escape",
                          time, model.user_number(node), rods ? " and the nodes rigidly connected to it" : "", between,
                          surfaces.size() < 2 && bodies.empty() ? " and what else holds it" : ""));
  return SPRINGNET_RECOVERABLE;
}

}  // namespace springnet
