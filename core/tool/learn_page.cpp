#include "learn_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/view.hpp>

#include "figure_page.hpp"
#include "learn_report.hpp"

namespace springnet::tool {

namespace {

using figure::Figure;
using figure::FigureCurve;
using figure::FigurePanel;

// Of each stage a curve: each learns from more of the motion. Weights of the guess that a rule tries share the last
// one; lines mark where another one begins. Learning while the net moves is one curve.
Figure search_course(const LearnedNet& learned) {
  Figure result{
      "Course of the search",
      {fmt::format("{} variables, {} observed values. {}", learned.variables, learned.observed, learned.reason)},
      {}};
  const std::vector<LearnProgress>& history = learned.history;
  if (history.empty()) return result;
  constexpr std::size_t most_markers = 60;  // that can be told apart
  const bool is_online = learned.method == "online";
  const bool has_stages = !is_online && history.front().share < 1.0;
  FigurePanel panel;
  panel.x_label = is_online ? "time step" : "iteration";
  panel.y_label = "log10 of the rms of weighted differences";
  panel.has_plain_lines = true;
  double share = -1.0;
  for (std::size_t k = 0; k < history.size(); ++k) {
    const LearnProgress& each = history[k];
    if (panel.curves.empty() || (has_stages && each.share != share)) {
      share = each.share;
      panel.curves.push_back({has_stages ? fmt::format("{:g} % of the time", 100.0 * share) : "",
                              {},
                              {},
                              false,
                              history.size() <= most_markers});
    }
    if (k > 0 && each.guess_weight != history[k - 1].guess_weight && each.share == history[k - 1].share)
      panel.marks.push_back({static_cast<double>(each.iteration), static_cast<double>(each.iteration), ""});
    panel.curves.back().x.push_back(each.iteration);
    panel.curves.back().y.push_back(std::log10(each.rms));
  }
  if (learned.guess_weight > 0.0)
    result.notes.push_back(
        fmt::format("The differences are those from the observations, without the part of the "
                    "guess. {}Its weight is {:.3g} at the end.",
                    panel.marks.empty() ? "" : "Vertical lines: another weight of the guess. ", learned.guess_weight));
  result.panels.push_back(std::move(panel));
  return result;
}

// What each weight of the guess has found: differences from the observations against the distance from the guess.
Figure weights_of_guess(const LearnedNet& learned) {
  Figure result{"Weight of the guess",
                {fmt::format("Each point is a search with another weight; {:.3g} was taken.", learned.guess_weight)},
                {}};
  FigurePanel panel;
  panel.x_label = "log10 of the rms of weighted differences";
  panel.y_label = "log10 of the rms of relative changes from the guess";
  panel.is_path = true;
  FigureCurve tried{"tried", {}, {}, false, true}, taken{"taken", {}, {}, false, true, false};
  for (const GuessPoint& each : learned.guess_curve) {
    for (FigureCurve* const curve : {&tried, &taken}) {
      if (curve == &taken && each.weight != learned.guess_weight) continue;
      curve->x.push_back(std::log10(each.rms));
      curve->y.push_back(std::log10(each.distance));
    }
  }
  panel.curves = {std::move(tried), std::move(taken)};
  result.panels.push_back(std::move(panel));
  return result;
}

// Both methods over the work, with the values of some parameters; no panels: they were not compared.
Figure comparison_of(const LearnedNet& learned) {
  constexpr std::size_t most_parameters = 4;
  Figure result{"Both methods from the same start",
                {"The cost of the whole motion with the values at that time. Work: a motion counts 1, and so does each "
                 "derivative of it by a variable, or backwards."},
                {}};
  const auto panel_of = [&](const std::string& y_label, const auto& value_at) {
    FigurePanel panel;
    panel.x_label = "work, whole motions";
    panel.y_label = y_label;
    panel.is_path = true;  // each point is one that was found
    for (const LearnCourse& course : learned.courses) {
      constexpr std::size_t most_markers = 40;  // that can be told apart
      FigureCurve curve{course.method, {}, {}, false, course.points.size() <= most_markers};
      for (const LearnCourse::Point& each : course.points) {
        curve.x.push_back(each.work);
        curve.y.push_back(value_at(each));
      }
      panel.curves.push_back(std::move(curve));
    }
    result.panels.push_back(std::move(panel));
  };
  if (learned.courses.empty()) return result;
  panel_of("log10 of the rms of weighted differences",
           [](const LearnCourse::Point& each) { return std::log10(each.rms); });
  const std::vector<std::size_t>& parameters = learned.courses.front().parameters;
  for (std::size_t k = 0; k < std::min(parameters.size(), most_parameters); ++k) {
    const LearnedParameter& each = learned.parameters[parameters[k]];
    panel_of(value_title(each),
             [k](const LearnCourse::Point& point) { return point.values[static_cast<Eigen::Index>(k)]; });
  }
  if (parameters.size() > most_parameters)
    result.notes.push_back(
        fmt::format("The values of the first {} variables; learning.json has more.", most_parameters));
  return result;
}

// Loads, gravity and friction have no place.
bool is_on_body(const LearnedParameter& parameter) {
  using Kind = LearnedValues::Kind;
  return parameter.kind != Kind::load && parameter.kind != Kind::gravity && parameter.kind != Kind::friction;
}

ViewValues::Of members_of(const LearnedParameter& parameter) {
  const std::string_view name = member_name(parameter.kind, parameter.of_elements);
  return name == "node"      ? ViewValues::Of::nodes
         : name == "element" ? ViewValues::Of::elements
                             : ViewValues::Of::springs;
}

std::string unit_in(const PluginHost& plugins, ComponentKind kind, const std::optional<LawUse>& use,
                    const std::string& parameter) {
  if (!use) return "";
  const auto component = use->component != nullptr ? use->component : plugins.find(kind, use->id);
  if (!component) return "";
  const std::ptrdiff_t k = parameter_index(*component->description, parameter);
  if (k < 0) return "";
  const std::string unit = component->description->parameters[k]->unit;
  return unit == "1" ? "" : unit;
}

std::string unit_of(const LearnedParameter& each, const Network& network, const PluginHost& plugins) {
  using Kind = LearnedValues::Kind;
  switch (each.kind) {
    case Kind::mass:
      return "kg";
    case Kind::initial_velocity:
      return "m/s";
    case Kind::rest_length:
      return each.of_elements ? std::string(springnet::unit_of(network.elements()[each.member].invariant)) : "m";
    case Kind::neuron_parameter:
      return unit_in(plugins, ComponentKind::neuron, network.neurons()[network.nodes()[each.member].neuron],
                     each.parameter);
    case Kind::gravity:
      return "m/s²";
    case Kind::load:
    case Kind::friction:
      return "";
    case Kind::spring_parameter:
    case Kind::viscosity_parameter:
      break;
  }
  const Material& material = network.materials()[each.of_elements ? network.elements()[each.member].material
                                                                  : network.springs()[each.member].material];
  return each.kind == Kind::spring_parameter
             ? unit_in(plugins, ComponentKind::spring_function, material.spring, each.parameter)
             : unit_in(plugins, ComponentKind::viscosity_function, material.viscosity, each.parameter);
}

// Values of one kind over their members, where these have values of their own: start, learned, intervals.
std::vector<Figure> values_of(const LearnedNet& learned, const Network& network, const PluginHost& plugins) {
  std::map<std::string, std::vector<const LearnedParameter*>> kinds;
  for (const LearnedParameter& each : learned.parameters)
    if (!each.together) kinds[name_of(each)].push_back(&each);
  std::vector<Figure> result;
  for (const auto& [name, list] : kinds) {
    if (list.size() < 2) continue;  // which the table tells
    const LearnedParameter& first = *list.front();
    const std::string unit = unit_of(first, network, plugins);
    FigurePanel panel;
    panel.x_label = fmt::format("number of the {}", member_name(first.kind, first.of_elements));
    panel.y_label = name + (unit.empty() ? "" : ", " + unit);
    FigureCurve value{"learned, with its 95 % interval", {}, {}, false, true, false};
    FigureCurve start{"start", {}, {}, true, true, false};
    std::size_t open = 0;
    for (const LearnedParameter* const each : list) {
      for (FigureCurve* const curve : {&start, &value}) curve->x.push_back(each->member);
      start.y.push_back(each->start);
      value.y.push_back(each->value);
      value.from.push_back(each->lower);
      value.to.push_back(each->upper);
      if (!std::isfinite(each->upper)) ++open;
    }
    panel.curves = {std::move(value), std::move(start)};
    Figure figure{name, {}, {}};
    if (open > 0)
      figure.notes.push_back(fmt::format(
          "{} of {} have no interval: {}.", open, list.size(),
          std::isfinite(first.determined) ? "the data do not determine them" : "what the data determine is not known"));
    figure.panels.push_back(std::move(panel));
    result.push_back(std::move(figure));
  }
  return result;
}

// Values of one name and unit, in the order in which they were asked for.
std::vector<ViewValues> painted(const LearnedNet& learned, const Network& network, const PluginHost& plugins) {
  std::vector<ViewValues> result;
  for (const LearnedParameter& each : learned.parameters) {
    if (!is_on_body(each)) continue;
    const ViewValues::Of of = members_of(each);
    const std::string name = name_of(each), unit = unit_of(each, network, plugins);
    auto found = std::find_if(result.begin(), result.end(), [&](const ViewValues& known) {
      return known.of == of && known.name == name && known.unit == unit;
    });
    if (found == result.end()) found = result.insert(result.end(), ViewValues{of, name, unit, {}});
    found->values.push_back({each.member, each.start, each.value, each.lower, each.upper, each.determined,
                             each.from_guess, std::isfinite(each.lower) && std::isfinite(each.upper)});
  }
  return result;
}

// Adds those that have a place or belong to a node.
void add_places(const Observations& observations, bool held_out, LearnedView& to) {
  using What = ViewPoint::What;
  const auto add = [&](const std::vector<Observations::VectorRow>& rows, What what, const char* name) {
    std::size_t incomplete = 0;
    for (const Observations::VectorRow& each : rows) {
      if (each.weight.minCoeff() > 0.0) {
        to.observed.push_back({each.time, each.value, each.node, what, held_out});
      } else if (each.weight.maxCoeff() > 0.0) {
        ++incomplete;
      }
    }
    if (incomplete > 0)
      to.notes.push_back(fmt::format("{} {}{} lack a coordinate and are not drawn", incomplete,
                                     held_out ? "held-out " : "observed ", name));
  };
  add(observations.positions, What::position, "positions");
  add(observations.velocities, What::velocity, "velocities");
  add(observations.reactions, What::force, "forces");
  for (const Observations::SurfacePoint& each : observations.surface_points)
    if (each.weight > 0.0) to.observed.push_back({each.time, each.point, ViewPoint::no_node, What::position, held_out});
  if (!observations.distances.empty())
    to.notes.push_back(
        fmt::format("{}distances are not drawn", held_out ? "of what was held out, " : "of what was observed, "));
}

// Advances until it fails; then it stays where it is.
bool advance(Simulation& simulation, double time, std::string& failure) {
  if (!failure.empty()) return false;
  try {
    simulation.advance_to(time);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::simulation) throw;
    failure = error.what();
  }
  return failure.empty();
}

// Records both motions to the end of the scene.
void play(const LearnedMotion& motion, const std::shared_ptr<const PluginHost>& plugins, ViewWriter& page) {
  const Scene& scene = motion.scene;
  Simulation after(scene.network, plugins, scene.options), before(*motion.before.network, plugins, scene.options);
  page.record(after, before);
  const double interval = std::max(scene.output.interval, scene.options.time_step);
  std::string failure, failure_before;
  for (std::size_t k = 1; failure.empty() && after.time() < scene.duration * (1.0 - 1e-9); ++k) {
    const double time = std::min(static_cast<double>(k) * interval, scene.duration);
    advance(before, time, failure_before);
    if (advance(after, time, failure)) page.record(after, before);
  }
  if (!failure.empty()) page.failed(failure);
}

}  // namespace

std::string value_title(const LearnedParameter& parameter) {
  const std::string name =
      name_of(parameter) + (parameter.body.empty() || !is_on_body(parameter) ? "" : "@" + parameter.body);
  if (parameter.together) return name + ":together";
  if (parameter.kind == LearnedValues::Kind::friction && !parameter.body.empty()) return name + "@" + parameter.body;
  if (parameter.kind == LearnedValues::Kind::gravity) return name;
  return fmt::format("{} of {} {}", name, member_name(parameter.kind, parameter.of_elements), parameter.member);
}

void write_learning_page(const OutputFile& file, const std::vector<LearnedMotion>& motions,
                         const std::shared_ptr<const PluginHost>& plugins, const LearnedNet& learned) {
  const Network& network = *motions.front().before.network;
  std::vector<Figure> figures{search_course(learned)};
  if (!learned.guess_curve.empty()) figures.push_back(weights_of_guess(learned));
  if (!learned.courses.empty()) figures.push_back(comparison_of(learned));
  for (Figure& each : values_of(learned, network, *plugins)) figures.push_back(std::move(each));
  const double size = motions.front().scene.output.view_size, share = 1.0 / static_cast<double>(motions.size());
  std::unique_ptr<ViewWriter> page;
  for (const LearnedMotion& motion : motions) {
    const auto view = std::make_shared<LearnedView>();
    view->values = painted(learned, network, *plugins);
    view->notes = learned.notes;
    if (!learned.fit.warning.empty()) view->notes.insert(view->notes.begin(), learned.fit.warning);
    add_places(motion.before.observations, false, *view);
    add_places(motion.before.held_out, true, *view);
    if (!page) view->below = learned_table(learned) + part_of_page(figures);
    const ViewOptions options{size, plugins, view, share};
    ViewWriter* to = page.get();
    if (page) {
      to = &page->add(motion.scene, options);
    } else {
      page = std::make_unique<ViewWriter>(file, motion.scene, options);
      to = page.get();
    }
    play(motion, plugins, *to);
  }
  page->close();
}

}  // namespace springnet::tool
