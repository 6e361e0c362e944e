#include "constraints/body_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet {
namespace {

using proximity::Group;

// Skin of the list of neighbours, in units of the mean length of the edges, or of the least diameter of balls.
constexpr double skin_share = 0.3;

constexpr std::size_t most_groups = 500;  // each is compared with each

// Which sides of which contacts a node is on: bit 2 c for the first side of contact c, 2 c + 1 for the second.
using Sides = std::vector<std::uint64_t>;

bool has(const Sides& sides, std::size_t bit) { return (sides[bit / 64] >> (bit % 64) & 1) != 0; }

// Primitives and groups from the contacts of a network. Nodes that are on the same sides form a group; those of balls
// and of surfaces are apart, because corners of triangles need no balls of their own against balls of other surfaces.
class Collection {
 public:
  Collection(const Network& network, const std::vector<std::uint32_t>& engine_number)
      : network_(network), engine_(engine_number), sides_(network.nodes().size()) {
    const std::size_t bits = 2 * network.contacts().size();
    for (Sides& sides : sides_) sides.assign((bits + 63) / 64, 0);
    for (std::size_t c = 0; c < network.contacts().size(); ++c) {
      const BodyContact& contact = network.contacts()[c];
      mark(contact.first, 2 * c);
      mark(contact.second.empty() ? contact.first : contact.second, 2 * c + 1);
    }
  }

  void collect() {
    std::vector<std::uint8_t> covered(sides_.size(), 0);
    for (const Body& body : network_.bodies()) add_surface(body, covered);
    for (const Body& body : network_.bodies()) add_balls(body, covered);
    check_groups();
    check_sides();
    for (const SpringList::Ends& ends : network_.springs().ends())
      lists.joined.push_back({engine_[ends[0]], engine_[ends[1]]});
    for (const Rigid& rod : network_.rigids()) lists.joined.push_back({engine_[rod.first], engine_[rod.second]});
  }

  proximity::PrimitiveLists lists;
  [[nodiscard]] std::size_t groups() const noexcept { return group_of_.size(); }
  // [group, group]
  std::vector<std::uint32_t> law_of_groups;
  double least_thickness = std::numeric_limits<double>::infinity();  // m

 private:
  void mark(const std::vector<NodeIndex>& nodes, std::size_t bit) {
    for (const NodeIndex node : nodes) sides_[node][bit / 64] |= std::uint64_t{1} << (bit % 64);
  }

  [[nodiscard]] static bool is_any(const Sides& sides) {
    return std::any_of(sides.begin(), sides.end(), [](std::uint64_t bits) { return bits != 0; });
  }

  Group group(const Sides& sides, bool is_ball) {
    const auto [place, is_new] = group_of_.try_emplace({sides, is_ball}, static_cast<Group>(group_of_.size()));
    if (!is_new) return place->second;
    members_.push_back({sides, is_ball});
    if (members_.size() > most_groups)
      throw Error(ErrorKind::input,
                  fmt::format("the contacts of bodies divide the nodes into more than {} sets: use fewer [[contact]]",
                              most_groups));
    return place->second;
  }

  void add_surface(const Body& body, std::vector<std::uint8_t>& covered) {
    if (!(body.thickness > 0.0)) return;
    for (std::size_t f = body.first_face; f < body.first_face + body.face_count; ++f) {
      const Face& face = network_.faces()[f];
      Sides sides = sides_[face[0]];
      for (std::size_t w = 0; w < sides.size(); ++w) sides[w] &= sides_[face[1]][w] & sides_[face[2]][w];
      if (!is_any(sides)) continue;
      for (const NodeIndex node : face) covered[node] = 1;
      lists.triangles.push_back(
          {{engine_[face[0]], engine_[face[1]], engine_[face[2]]}, 0.5 * body.thickness, group(sides, false)});
    }
  }

  // Nodes inside a surface are none, unless they have a radius.
  void add_balls(const Body& body, const std::vector<std::uint8_t>& covered) {
    if (body.thickness > 0.0 && body.face_count > 0 && !(body.radius > 0.0)) return;
    for (NodeIndex k = body.first_node; k < body.first_node + body.node_count; ++k)
      if (covered[k] == 0 && is_any(sides_[k]))
        lists.balls.push_back({engine_[k], body.radius, group(sides_[k], true)});
  }

  [[nodiscard]] std::string name_of(std::size_t contact) const {
    const std::string& name = network_.contacts()[contact].name;
    return name.empty() ? fmt::format("contact {} of bodies", contact) : fmt::format("contact '{}'", name);
  }

  // Bodies whose thickness is that of nothing.
  [[nodiscard]] std::string describe_bodies_without_faces() const {
    std::string result;
    for (const Body& body : network_.bodies())
      if (body.thickness > 0.0 && body.face_count == 0 && !(body.radius > 0.0))
        result += fmt::format("{} '{}'", result.empty() ? "; without faces are the bodies" : ",", body.name);
    return result;
  }

  // Each side needs something that can be touched.
  void check_sides() const {
    for (std::size_t c = 0; c < network_.contacts().size(); ++c)
      for (const std::size_t side : {0u, 1u}) {
        const bool any = std::any_of(members_.begin(), members_.end(),
                                     [&](const auto& each) { return has(each.first, 2 * c + side); });
        if (any) continue;
        throw Error(ErrorKind::input,
                    fmt::format("{}: the {} side has nothing that can be touched: select all corners of a face of a "
                                "body with 'surface_thickness', or nodes of a body with a 'radius'",
                                name_of(c), side == 0 ? "first" : "second"));
      }
  }

  // Edges and corners are on the sides of all faces that have them, and as thick as the thickest.
  void share_groups(std::vector<proximity::Ball>& corners) {
    std::map<NodeIndex, std::pair<Sides, double>> of_corner;
    std::map<std::array<NodeIndex, 2>, std::pair<Sides, double>> of_edge;
    const auto add = [](std::pair<Sides, double>& to, const Sides& sides, double radius) {
      to.first.resize(sides.size(), 0);
      for (std::size_t w = 0; w < sides.size(); ++w) to.first[w] |= sides[w];
      to.second = std::max(to.second, radius);
    };
    for (const proximity::Triangle& each : lists.triangles) {
      const Sides& sides = members_[each.group].first;
      for (std::size_t i = 0; i < 3; ++i) {
        add(of_corner[each.nodes[i]], sides, each.radius);
        const auto [low, high] = std::minmax(each.nodes[i], each.nodes[(i + 1) % 3]);
        add(of_edge[{low, high}], sides, each.radius);
      }
    }
    for (proximity::Ball& each : corners) {
      const auto& [sides, radius] = of_corner.at(each.node);
      each.group = group(sides, false);
      each.radius = radius;
    }
    for (proximity::Edge& each : lists.edges) {
      const auto [low, high] = std::minmax(each.nodes[0], each.nodes[1]);
      const auto& [sides, radius] = of_edge.at({low, high});
      each.group = group(sides, false);
      each.radius = radius;
    }
  }

  // After all triangles are known: edges and corners of them, and which groups are checked.
  void check_groups() {
    lists.edges = proximity::edges_of(lists.triangles);
    std::vector<proximity::Ball> corners = proximity::corners_of(lists.triangles);
    share_groups(corners);
    lists.balls.insert(lists.balls.end(), corners.begin(), corners.end());
    std::vector<double> least(groups(), std::numeric_limits<double>::infinity());  // radius, m
    const auto note = [&](Group g, double radius) { least[g] = std::min(least[g], radius); };
    for (const proximity::Triangle& each : lists.triangles) note(each.group, each.radius);
    for (const proximity::Ball& each : lists.balls) note(each.group, each.radius);
    for (const proximity::Edge& each : lists.edges) note(each.group, each.radius);
    const std::size_t n = groups();
    law_of_groups.assign(n * n, 0);
    for (Group a = 0; a < n; ++a) {
      for (Group b = a; b < n; ++b) {
        bool any = false;
        for (std::uint32_t c = 0; c < network_.contacts().size(); ++c) {
          const auto on = [&](Group g, std::size_t side) { return has(members_[g].first, 2 * std::size_t{c} + side); };
          if (!(on(a, 0) && on(b, 1)) && !(on(b, 0) && on(a, 1))) continue;
          any = true;
          law_of_groups[a * n + b] = law_of_groups[b * n + a] = c;
        }
        if (!any) continue;
        if (!(least[a] + least[b] > 0.0))
          throw Error(ErrorKind::input,
                      fmt::format("{}: bodies in contact with each other have neither 'surface_thickness', of their "
                                  "faces, nor 'radius', of nodes without faces: give one of them to a body of each "
                                  "pair{}",
                                  name_of(law_of_groups[a * n + b]), describe_bodies_without_faces()));
        least_thickness = std::min(least_thickness, least[a] + least[b]);
        const bool balls = members_[a].second && members_[b].second,
                   surfaces = !members_[a].second && !members_[b].second;
        lists.checked.push_back({a, b, balls, !balls, surfaces});
      }
    }
  }

  const Network& network_;
  const std::vector<std::uint32_t>& engine_;
  std::vector<Sides> sides_;  // [user's node]
  std::map<std::pair<Sides, bool>, Group> group_of_;
  std::vector<std::pair<Sides, bool>> members_;  // [group]
};

double skin_of(const proximity::PrimitiveLists& lists, const Network& network,
               const std::vector<std::uint32_t>& user_number) {
  const std::vector<Vector3>& p = network.nodes().positions();
  double sum = 0.0, least = std::numeric_limits<double>::infinity();
  for (const proximity::Edge& edge : lists.edges)
    sum += (p[user_number[edge.nodes[0]]] - p[user_number[edge.nodes[1]]]).norm();
  const double mean = lists.edges.empty() ? 0.0 : sum / static_cast<double>(lists.edges.size());
  if (mean > 0.0) return skin_share * mean;
  for (const proximity::Ball& ball : lists.balls)
    if (ball.radius > 0.0) least = std::min(least, 2.0 * ball.radius);
  return std::isfinite(least) ? skin_share * least : 1.0;
}

}  // namespace

BodyContacts::BodyContacts(const Network& network, const std::vector<std::uint32_t>& user_number,
                           const std::vector<std::uint32_t>& engine_number)
    : user_number_(user_number), contacts_(network.contacts()) {
  if (contacts_.empty()) return;
  any_rigid_ = are_any_rigid(network);
  Collection collection(network, engine_number);
  collection.collect();
  groups_ = collection.groups();
  law_of_groups_ = std::move(collection.law_of_groups);
  least_thickness_ = collection.least_thickness;
  const double skin = skin_of(collection.lists, network, user_number);
  list_ = std::make_unique<proximity::NeighbourList>(proximity::Primitives(std::move(collection.lists)), skin);
}

const BodyContact& BodyContacts::law_of(proximity::PairKind kind, proximity::Pair pair) const {
  const proximity::Primitives& all = primitives();
  const auto group_of = [&](std::uint32_t i, bool second) {
    if (kind == proximity::PairKind::edge_edge) return all.edges()[i].group;
    return kind == proximity::PairKind::node_triangle && second ? all.triangles()[i].group : all.balls()[i].group;
  };
  return contacts_[law_of_groups_[group_of(pair.first, false) * groups_ + group_of(pair.second, true)]];
}

proximity::Separation BodyContacts::separation_of(const PairTouch& touch, const proximity::Positions& x) const {
  const std::array<Vector3, 4> corners = primitives().corners(touch.kind, touch.pair, x);
  return touch.between == 0 ? separation(touch.kind, corners) : separation_between(touch.kind, corners, touch.between);
}

bool BodyContacts::touches(proximity::PairKind kind, proximity::Pair pair) const {
  const std::pair key(kind, pair);
  const auto place = std::lower_bound(touching_.begin(), touching_.end(), key,
                                      [](const PairTouch& touch, const auto& of) { return touch.key() < of; });
  return place != touching_.end() && place->key() == key;
}

void BodyContacts::set_located(bool located) {
  located_ = located && any();
  if (located_ && shared_ == nullptr) shared_ = std::make_unique<proximity::SharedFeatures>(primitives());
  if (located_) return;
  for (PairTouch& touch : touching_) touch.between = 0;
}

std::string BodyContacts::describe(proximity::PairKind kind, proximity::Pair pair) const {
  const std::array<NodeIndex, 4> nodes = primitives().nodes_of(kind, pair);
  const auto number = [&](std::size_t i) { return user_number_[nodes[i]]; };
  switch (kind) {
    case proximity::PairKind::node_node:
      return fmt::format("nodes {} and {}", number(0), number(1));
    case proximity::PairKind::node_triangle:
      return fmt::format("node {} and the face of nodes {}, {}, {}", number(0), number(1), number(2), number(3));
    case proximity::PairKind::edge_edge:
      break;
  }
  return fmt::format("the edges of nodes {}, {} and of nodes {}, {}", number(0), number(1), number(2), number(3));
}

void BodyContacts::archive(Archive& archive) {
  const std::size_t count = archive.count(touching_.size(), 122, "contacts of bodies");
  touching_.resize(count);
  archive.flag(located_);
  if (archive.reads()) set_located(located_);
  for (PairTouch& each : touching_) {
    archive.below(each.kind, 3, "a kind of contact");
    const auto all = [&](bool second) -> std::uint64_t {
      if (each.kind == proximity::PairKind::edge_edge) return primitives().edges().size();
      return each.kind == proximity::PairKind::node_triangle && second ? primitives().triangles().size()
                                                                       : primitives().balls().size();
    };
    archive.below(each.pair.first, any() ? all(false) : 0, "a part of a body in contact");
    archive.below(each.pair.second, any() ? all(true) : 0, "a part of a body in contact");
    archive.vector(each.force);
    archive.vector(each.guess);
    archive.flag(each.sticks);
    archive.flag(each.held);
    archive.below(each.phase, 3, "a phase of slip");
    archive.vector(each.slip);
    archive.below(each.between, proximity::all_features(each.kind) + 1, "where bodies touch");
    archive.number(each.held_gap);
    const unsigned firsts = (1u << proximity::first_nodes(each.kind)) - 1u;
    if (each.between != 0 && ((each.between & firsts) == 0 || (each.between & ~firsts) == 0))
      Archive::refuse("bodies touch nowhere");
    if (!each.force.allFinite() || !each.guess.allFinite() || !each.slip.allFinite() || !std::isfinite(each.held_gap))
      Archive::refuse("a force of bodies is not finite");
    if (!primitives().may_touch(each.kind, each.pair)) Archive::refuse("bodies touch that are not in contact");
  }
  if (archive.reads() && any()) list_->forget();
}

void BodyContacts::take_over(const BodyContacts& before, const layers::NumbersBefore& numbers) {
  if (before.touching_.empty()) return;
  std::map<NodeIndex, NodeIndex> now;
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) { now[old] = k; });
  // Places of the primitives by their nodes.
  using Key = std::vector<NodeIndex>;
  const auto places_of = [](const auto& primitives, const auto& nodes_of) {
    std::map<Key, std::uint32_t> places;
    for (std::uint32_t i = 0; i < primitives.size(); ++i) {
      Key key = nodes_of(primitives[i]);
      std::sort(key.begin(), key.end());
      places[std::move(key)] = i;
    }
    return places;
  };
  const auto all_nodes = [](const auto& of) { return Key(of.nodes.begin(), of.nodes.end()); };
  const auto balls = places_of(primitives().balls(), [](const proximity::Ball& ball) { return Key{ball.node}; });
  const auto edges = places_of(primitives().edges(), all_nodes);
  const auto triangles = places_of(primitives().triangles(), all_nodes);
  for (PairTouch touch : before.touching_) {
    const std::array<NodeIndex, 4> nodes = before.primitives().nodes_of(touch.kind, touch.pair);
    const auto place_of = [&](int begin, int count) -> std::uint32_t {
      Key key;
      for (int i = begin; i < begin + count; ++i) key.push_back(now.at(nodes[static_cast<std::size_t>(i)]));
      std::sort(key.begin(), key.end());
      return (count == 1 ? balls : count == 2 ? edges : triangles).at(key);
    };
    const int first = proximity::first_nodes(touch.kind);
    touch.pair = {place_of(0, first), place_of(first, proximity::second_nodes(touch.kind))};
    if (touch.kind != proximity::PairKind::node_triangle && touch.pair.first > touch.pair.second) {
      std::swap(touch.pair.first, touch.pair.second);
      touch.force = -touch.force;
      touch.guess = -touch.guess;
      touch.slip = -touch.slip;
    }
    // The order of a primitive's nodes may be another one.
    const std::array<NodeIndex, 4> places = primitives().nodes_of(touch.kind, touch.pair);
    const int count = first + proximity::second_nodes(touch.kind);
    unsigned between = 0;
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j)
        if ((touch.between >> i & 1u) != 0 &&
            places[static_cast<std::size_t>(j)] == now.at(nodes[static_cast<std::size_t>(i)]))
          between |= 1u << j;
    touch.between = static_cast<proximity::Features>(between);
    // Balls that a new spring joins touch no more.
    if (primitives().may_touch(touch.kind, touch.pair)) touching_.push_back(touch);
  }
  std::sort(touching_.begin(), touching_.end(),
            [](const PairTouch& a, const PairTouch& b) { return a.key() < b.key(); });
}

std::vector<StartingOverlap> starting_overlaps(const Network& network, std::size_t most) {
  std::vector<StartingOverlap> found;
  if (network.contacts().empty()) return found;
  std::vector<std::uint32_t> numbers(network.nodes().size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  const BodyContacts bodies(network, numbers, numbers);
  const std::vector<Vector3>& places = network.nodes().positions();
  std::array<std::vector<double>, 3> x;
  for (std::size_t c = 0; c < 3; ++c) {
    x[c].reserve(places.size());
    for (const Vector3& place : places) x[c].push_back(place[static_cast<Eigen::Index>(c)]);
  }
  const proximity::Positions positions{{x[0].data(), x[1].data(), x[2].data()}, places.size()};
  for (const proximity::NearPair& each : deepest_overlaps(bodies.primitives(), positions, most))
    // As near as a run leaves them, so that a scene of its end can be run.
    if (const double depth = -each.gap; depth > 2.0 * gap_tolerance * bodies.least_thickness())
      found.push_back({bodies.describe(each.kind, each.pair), depth});
  return found;
}

bool are_any_rigid(const Network& network) {
  std::vector<std::uint8_t> joined(network.nodes().size(), 0);
  for (const Rigid& rod : network.rigids()) joined[rod.first] = joined[rod.second] = 1;
  const auto is_joined = [&](NodeIndex node) { return joined[node] != 0; };
  return std::any_of(network.contacts().begin(), network.contacts().end(), [&](const BodyContact& contact) {
    return std::any_of(contact.first.begin(), contact.first.end(), is_joined) ||
           std::any_of(contact.second.begin(), contact.second.end(), is_joined);
  });
}

void check_apart(const Network& network) {
  const std::vector<StartingOverlap> found = starting_overlaps(network, 1);
  if (found.empty()) return;
  throw Error(ErrorKind::input,
              fmt::format("{} are {:.3g} m nearer than their thickness at the start, so that contact cannot keep them "
                          "apart: move the bodies apart, or make them thinner; springnet inspect lists such pairs",
                          found[0].pair, found[0].depth));
}

}  // namespace springnet
