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
constexpr std::array<EventText, 7> texts{{{"cut", "spring"},
                                          {"ruptured", "spring"},
                                          {"touched", "node"},
                                          {"released", "node"},
                                          {"slipped", "node"},
                                          {"stuck", "node"},
                                          {"jammed", "node"}}};

void write(const Event& event, const Simulation& simulation, TableFile& file) {
  const EventText& text = texts.at(static_cast<std::size_t>(event.kind));
  file.row(event.time);
  file << text.event << (event.element ? "element" : text.subject) << event.index
       << (event.surface >= 0 ? label_of(simulation, static_cast<std::size_t>(event.surface)) : "") << event.impulse;
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
            "finite force keeps the node out of the surface: an impulse stops it)",
            Columns::Cell::text},
           {{"element"}, "", "what it happened to: `spring`, `element`, `node`", Columns::Cell::text},
           {{"index"}, "", "its number", Columns::Cell::count},
           {{"surface"}, "", "the surface at which it happened to a node, as in `surfaces.csv`", Columns::Cell::text},
           {{"jx", "jy", "jz"}, "N s", "impulse that the surface gave the node at the event"}},
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
