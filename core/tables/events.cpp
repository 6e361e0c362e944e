#include <array>
#include <memory>

#include "tables/names.hpp"
#include "tables/table.hpp"

namespace springnet::tables {

Table events();

namespace {

struct EventText {
  std::string_view event, subject;
};
// By Event::Kind.
constexpr std::array<EventText, 9> texts{{{"cut", "spring"},
                                          {"ruptured", "spring"},
                                          {"touched", "node"},
                                          {"released", "node"},
                                          {"slipped", "node"},
                                          {"stuck", "node"},
                                          {"jammed", "node"},
                                          {"met", "node"},
                                          {"parted", "node"}}};

void write(const Event& event, const Simulation& simulation, TableFile& file) {
  const EventText& text = texts.at(static_cast<std::size_t>(event.kind));
  file.row(event.time);
  file << text.event << (event.element ? "element" : text.subject) << event.index
       << (event.surface >= 0 ? label_of(simulation, static_cast<std::size_t>(event.surface)) : "") << event.impulse
       << event.position << event.velocity << event.normal << event.value << event.force
       << pair_of(event.pair, event.pair_first, event.pair_count);
}

}  // namespace

Table events() {
  return {
      .name = "events",
      .content = "cuts, ruptures, contacts",
      .columns =
          {{{"event"},
            "",
            "springs and elements that were `cut` or `ruptured`; nodes that `touched` a surface or were "
            "`released` from it, that `slipped` against friction or `stuck` again, that `jammed` (with friction, no "
            "finite force keeps the node out of the surface: an impulse stops it); bodies that `met` or `parted`, in "
            "`cvode` also that `slipped` or `stuck`",
            Columns::Cell::text},
           {{"element"}, "", "what it happened to: `spring`, `element`, `node`", Columns::Cell::text},
           {{"index"}, "", "its number", Columns::Cell::count},
           {{"surface"}, "", "the surface at which it happened to a node, as in `surfaces.csv`", Columns::Cell::text},
           {{"jx", "jy", "jz"}, "N s", "impulse that the surface, or the other body, gave the node at the event"},
           {{"x", "y", "z"},
            "m",
            "where the node was at the event, or the middle of the nodes of the spring or element"},
           {{"vx", "vy", "vz"}, "m/s", "its velocity just before"},
           {{"nx", "ny", "nz"}, "", "direction from the surface to the node, of length 1; 0 for springs and elements"},
           {{"value"},
            "",
            "just before, of a spring its length, of an element its angle, area or volume: m, rad, m², m³; `nan` for a "
            "node"},
           {{"force"},
            "",
            "likewise the tension, N, or the generalised force of the element: N m, N/m, Pa; `nan` for a node"},
           {{"pair"},
            "",
            "of events of bodies the nodes of both: `3; 8 9 12` is node 3 and a face, `3 4; 8 9` two edges",
            Columns::Cell::text}},
      .wanted = [](const Network&, const OutputOptions&) { return true; },
      .leave_out_hint = "",
      .writer = [](const Network&, const OutputOptions&) -> RowWriter {
        const auto written = std::make_shared<std::uint64_t>(0);
        return {[written](const Record& record, TableFile& file) {
                  const std::vector<Event>& events = record.simulation().events();
                  for (; *written < events.size(); ++*written) write(events[*written], record.simulation(), file);
                },
                [written](Archive& archive) { archive.number(*written); }};
      },
  };
}

}  // namespace springnet::tables
