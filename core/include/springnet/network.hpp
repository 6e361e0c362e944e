// A network as the user describes it: nodes and springs in the user's numbers, bodies, loads, obstacles, cuts. It is
// plain data; Simulation converts it to the engine's memory layout.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/network_lists.hpp>
#include <springnet/parameters.hpp>
#include <springnet/signal.hpp>

namespace springnet {

using RigidIndex = std::uint32_t;
using ElementIndex = std::uint32_t;

struct Component;

// A component by id, with the parameters that differ from their defaults.
struct LawUse {
  std::string id;
  ParameterValues parameters;
  TableValues tables{};  // of a law that declares some
  // The component itself, of a law given as a formula (formula.hpp); else null, and a plugin host has it by its id.
  std::shared_ptr<const Component> component{};
  friend bool operator==(const LawUse&, const LawUse&) = default;
};

// The functions of a spring. Both: elastic and viscous; viscosity function only: a viscous connection.
struct Material {
  std::optional<LawUse> spring;
  std::optional<LawUse> viscosity;
  friend bool operator==(const Material&, const Material&) = default;
};

// The scalar q of an element's nodes that a law reads in place of the length of a spring. Laws that read a length (and
// its rate) can be used on any of them. Their units change with q: a stiffness in N/m becomes N m/rad on an angle,
// N/m^3 on an area, N/m^5 on a volume.
enum class Invariant {
  angle,     // three nodes a, b, c: the angle at b between the directions to a and c, 0 to pi, rad
  dihedral,  // four: the edge a b, then the tips c and d of the triangles (a, b, c) and (b, a, d): the angle between
             // their normals, 0: flat, > 0: the tips lie on the side opposite to the normals; rad
  area,      // three: area of the triangle, m^2
  volume,    // four: signed volume (b - a) . ((c - a) x (d - a)) / 6 of the tetrahedron, m^3
  enclosed_volume,  // three a triangle of a closed surface, counterclockwise seen from outside: enclosed volume, m^3
  // For laws that read several scalars of the nodes: which ones, the law says. As the value of such an element counts
  // the angle, area, dihedral angle or volume of its nodes.
  chain,       // three nodes, as an angle
  triangle,    // three, as an area
  hinge,       // four, as a dihedral
  tetrahedron  // four, as a volume
};
[[nodiscard]] SPRINGNET_API std::string_view name_of(Invariant invariant) noexcept;  // "angle", …
[[nodiscard]] SPRINGNET_API std::string_view unit_of(Invariant invariant) noexcept;  // "rad", "m^2", "m^3"
// Whether elements are for laws that read several scalars.
[[nodiscard]] constexpr bool reads_several(Invariant invariant) noexcept { return invariant >= Invariant::chain; }

// A law on an invariant of some nodes: bending, area, enclosed volume. The nodes get the forces -Q dq/dp.
struct Element {
  Invariant invariant;
  std::vector<NodeIndex> nodes;
  MaterialIndex material;
  double reference;  // rest value, in the unit of the invariant
  // For laws over several scalars: the nodes' positions at rest, m, up to a rigid motion, from which the reference
  // values of all scalars follow; and a direction of the material in that configuration, of length 1, or 0.
  std::vector<Vector3> rest{};
  Vector3 direction = Vector3::Zero();
};

// A triangle of a body's surface, counterclockwise seen from outside, for display, selections and loads. It has no
// mechanical effect itself.
using Face = std::array<NodeIndex, 3>;

// A named set of nodes, such as a physical group of a mesh, for selections.
struct NodeGroup {
  std::string name;
  std::vector<NodeIndex> nodes;  // ascending, unique
};

// Nodes [first_node, first_node + node_count), springs, elements and faces likewise.
struct Body {
  std::string name;
  NodeIndex first_node;
  NodeIndex node_count;
  SpringIndex first_spring;
  SpringIndex spring_count;
  ElementIndex first_element = 0;
  ElementIndex element_count = 0;
  std::size_t first_face = 0;
  std::size_t face_count = 0;
  std::vector<NodeGroup> groups{};
  // What it is in contact with other bodies: its faces are this thick, m; nodes without such faces are balls of this
  // radius, m.
  double thickness = 0.0;
  double radius = 0.0;
};

// A connection of constant length, to a relative accuracy of 1e-8. At the start the distance of its ends must equal the
// length.
struct Rigid {
  NodeIndex first;
  NodeIndex second;
  double length;  // m
};

// A displacement over time, m, relative to the start position: a table or a sinusoid.
struct Motion {
  // linear: straight between entries, where the velocity jumps. smooth: cubic between entries with continuous velocity,
  // without overshoot (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980), each coordinate separately.
  enum class Interpolation { linear, smooth };
  Interpolation interpolation = Interpolation::smooth;
  std::vector<double> times;           // s, increasing; at rest before the first and after the last entry
  std::vector<Vector3> displacements;  // m, one for each time; empty: no table

  // amplitude (sin(2 pi frequency (t - from) + phase) - sin(phase)) while from <= t < until, at rest before and after.
  Vector3 amplitude = Vector3::Zero();  // m
  double frequency = 0.0;               // Hz
  double phase = 0.0;                   // rad
  double from = 0.0;                    // s
  double until = std::numeric_limits<double>::infinity();
};

// Time course of a load: a factor, 1 unless a table, sinusoid or ramp is given. Times are relative to the start of the
// load if that is finite, else to 0 s; times of a table are simulation times.
struct Course {
  std::vector<double> times;    // s, increasing; the factor is constant before the first and after the last entry
  std::vector<double> factors;  // one for each time; empty: no table
  Motion::Interpolation interpolation = Motion::Interpolation::smooth;

  double frequency = 0.0;  // Hz; above 0: mean + amplitude sin(2 pi frequency (t - start) + phase)
  double phase = 0.0;      // rad
  double amplitude = 1.0;
  double mean = 0.0;

  double ramp = 0.0;  // s; above 0: linear from 0 at the start to 1 at start + ramp, then 1
};

// Forces on nodes and faces while from <= time < until; they add up. Each node of a face gets a third of its force. A
// load on a face ends when the face is removed: with a spring along one of its sides, or by a cutting polygon.
struct Load {
  std::vector<NodeIndex> nodes;
  Vector3 force = Vector3::Zero();  // N, on each of the nodes
  double from = -std::numeric_limits<double>::infinity();
  double until = std::numeric_limits<double>::infinity();
  std::vector<Face> faces{};
  Vector3 traction = Vector3::Zero();  // Pa, on the area at the time of add_load; constant direction
  double pressure = 0.0;               // Pa, > 0 pushes against the outward normal
  bool follow = false;  // pressure acts on the area and normal: true: at present; false: at the time of add_load
  Course course{};
  // Areas of the faces along their outward normals, m^2, [face]; empty: add_load takes them from the present positions.
  std::vector<Vector3> areas{};
};

// Nodes with prescribed motion, as by an instrument's tip or a grip. They count as fixed.
struct Move {
  std::vector<NodeIndex> nodes;
  Motion motion;
};

// Friction of an obstacle on nodes in contact.
struct Friction {
  enum class Kind {
    held,    // the paper's rule: held where it touched until a reverse force occurs
    none,    // slides
    coulomb  // sticks up to `coefficient` times the normal force, beyond slides against that force
  };
  Kind kind = Kind::held;
  double coefficient = 0.0;  // 1
};

// A rotation over time about an axis of fixed direction: at a constant rate, or a table of angles.
struct Turn {
  Vector3 axis = Vector3::UnitZ();  // any length but 0, normalised when added; angles are counterclockwise seen from
                                    // its tip
  // m: a point of the axis at the start; it moves with the surface. None: a plane's point, an instrument's `first`.
  std::optional<Vector3> through{};

  double rate = 0.0;  // rad/s while from <= t < until, at rest before and after
  double from = 0.0;  // s
  double until = std::numeric_limits<double>::infinity();

  std::vector<double> times;   // s, increasing; at rest before the first and after the last entry
  std::vector<double> angles;  // rad, one for each time; empty: no table
  Motion::Interpolation interpolation = Motion::Interpolation::smooth;
};

// An obstacle; the half space on the side of its normal is free. A node that crosses it is held where it touched until
// a reverse force occurs (the paper's rule), or slides with friction.
struct Plane {
  std::string name;
  Vector3 point = Vector3::Zero();    // m
  Vector3 normal = Vector3::UnitZ();  // any length but 0; normalised by add_plane
  Friction friction{};
  std::optional<Motion> motion{};
  std::optional<Turn> turn{};
  // Newton's coefficient of restitution, 0 to 1: the share of the normal velocity after an impact.
  double restitution = 0.0;
};

// Contact of nodes of `first` with those of `second`, which may have some in common; `second` empty: of `first` with
// itself. A face belongs to a side that has its corners. Edges and corners of faces touch with them; springs do not.
struct BodyContact {
  std::string name;
  std::vector<NodeIndex> first, second;  // ascending
  Friction friction{};
  double restitution = 0.0;  // as for planes
};

// The shape of a box instrument. Contact rounds its edges by at least a millionth of the smallest size: only from the
// curvature of an edge does it follow that a node sliding over it separates.
struct BoxShape {
  Vector3 size = Vector3::Ones();                      // m, from face to face, rounding included
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // columns: directions of its edges, a rotation
  double radius = 0.0;  // m, of edges and corners, at most half the smallest size; 0: sharp
};

// An obstacle: a sphere or capsule (all points within `radius` of the segment from `first` to `second`), or a box
// centred at `first` (`second` and `radius` are not read). Nodes stay outside. Force and torque on it (about `first`)
// are outputs.
struct Instrument {
  std::string name;
  Vector3 first = Vector3::Zero();   // m
  Vector3 second = Vector3::Zero();  // m; equal to first: a sphere
  double radius = 1.0;               // m
  Friction friction{};
  std::optional<Motion> motion{};
  std::optional<Turn> turn{};
  double restitution = 0.0;  // as for planes
  std::optional<BoxShape> box{};
};

// Springs removed at a time: those listed, and those that cross the polygon (planar, three corners or more, need not be
// convex) at that time.
struct Cut {
  double time = 0.0;  // s
  std::vector<SpringIndex> springs;
  std::vector<Vector3> polygon;  // m
};

// A change at a time of springs, elements and nodes, as Simulation's functions make it (set_parameter, …): parameters
// and inputs of laws, by name; rest lengths (m) and references, or factors of them as they are then; masses (kg).
// `remove`: springs, elements and nodes are removed, after the other changes. The integrator is that from then on.
struct Change {
  double time = 0.0;  // s
  std::vector<SpringIndex> springs;
  std::vector<ElementIndex> elements;
  std::vector<NodeIndex> nodes;
  ParameterValues spring{}, viscosity{};                 // of springs and elements that have such a law
  ParameterValues spring_inputs{}, viscosity_inputs{};   // likewise
  ParameterValues neuron{};                              // of nodes
  std::optional<double> reference{}, reference_scale{};  // of springs and elements
  std::optional<double> mass{};                          // of nodes
  bool remove = false;
  std::optional<LawUse> integrator{};
};

enum class Diagonals { none, face, space, all };

// A box of nodes: node (i, j, k) at origin + spacing (i, j, k) has the number i + nodes[0] (j + nodes[1] k) in its
// body. Springs along the axes, and along the diagonals of the cells' faces, the cells, or both.
struct Lattice {
  std::array<std::uint32_t, 3> nodes{2, 2, 2};
  Vector3 spacing = Vector3::Ones();  // m
  Vector3 origin = Vector3::Zero();   // m
  Diagonals diagonals = Diagonals::none;
};

class Network {
 public:
  // Neuron 0 is "point_mass" with its defaults; material 0 does not exist until it is added.
  SPRINGNET_API Network();

  // Equal descriptions get the same index. Throw Error(input) for an empty id, a parameter or a row of a table that is
  // not finite, a material without any function, or more than 50 million values in the tables of all materials.
  // Simulation checks them against the plugins.
  SPRINGNET_API std::uint32_t add_neuron(const LawUse& neuron);
  SPRINGNET_API MaterialIndex add_material(const Material& material);

  // Throws Error(input) for a non-finite number, a mass that is not above 0 or a neuron that does not exist. A fixed
  // node has no velocity.
  SPRINGNET_API NodeIndex add_node(const Node& node);
  // Rest length: the distance of the nodes unless given. Throws Error(input) for a node that does not exist, a node
  // joined to itself, a distance of 0 without a rest length, a rest length that is negative or not finite, a material
  // that does not exist.
  SPRINGNET_API SpringIndex add_spring(NodeIndex first, NodeIndex second, MaterialIndex material,
                                       std::optional<double> rest_length = std::nullopt);
  // Reference: the present value of the invariant unless given. Throws Error(input) for a number of nodes that does not
  // match the invariant, a node that does not exist or occurs twice in an angle, hinge, triangle or tetrahedron, a
  // surface that is not closed or not consistently oriented (every edge must belong to two triangles, once in each
  // direction), a material that does not exist, or a reference that is not finite.
  SPRINGNET_API ElementIndex add_element(Invariant invariant, std::vector<NodeIndex> nodes, MaterialIndex material,
                                         std::optional<double> reference = std::nullopt);
  // The same for laws over several scalars: shape is one that reads several. rest: positions of the nodes at rest, m;
  // empty: those at present. direction: of the material in the configuration at rest, of any length; zero: none. In a
  // triangle its part in the plane counts. Throws Error(input) as above, for a number of positions that is not that of
  // the nodes, numbers that are not finite, and a direction normal to a triangle.
  SPRINGNET_API ElementIndex add_element(Invariant shape, std::vector<NodeIndex> nodes, MaterialIndex material,
                                         std::vector<Vector3> rest, const Vector3& direction = Vector3::Zero());
  // Throws Error(input) for a node that does not exist or occurs twice.
  SPRINGNET_API void add_face(const Face& face);
  // Adds a group to the body begun last. Throws Error(input) outside of a body, for a name that is empty or taken in
  // the body, and for a node that does not exist or belongs to another body.
  SPRINGNET_API void add_group(const std::string& name, std::vector<NodeIndex> nodes);
  // Nodes, springs, elements and faces added between these two calls form a body. Names are unique; throws Error(input)
  // otherwise.
  SPRINGNET_API void begin_body(const std::string& name);
  SPRINGNET_API void end_body();
  // Make room for so many nodes or springs in all, so that adding them one by one does not copy those before.
  SPRINGNET_API void reserve_nodes(std::size_t count);
  SPRINGNET_API void reserve_springs(std::size_t count);
  // Adds a body from a lattice. `prototype` gives mass, neuron and velocity. Springs of one direction have bitwise
  // equal rest lengths. Its faces are its boundary, outward. Throws Error(input) for 0 nodes in a direction, a spacing
  // that is not above 0, or more nodes or springs than there are numbers or than fit into memory.
  SPRINGNET_API void add_lattice(const std::string& name, const Lattice& lattice, const Node& prototype,
                                 MaterialIndex material);

  SPRINGNET_API void fix(NodeIndex node);
  // These throw Error(input) for a node or spring that does not exist, a number that is not finite (the ends of a
  // load's window may be infinite), an empty window, a normal of length 0, a name that is taken, a polygon with fewer
  // than three corners or that is not planar; for a face with a node that does not exist or occurs twice, a traction or
  // pressure without faces, a course of more than one kind or whose times do not increase. A node listed twice in a
  // load counts once; a face listed twice is loaded twice.
  SPRINGNET_API void add_load(const Load& load);
  SPRINGNET_API void add_plane(const Plane& plane);
  // Planes and instruments share one set of unique names. Throw Error(input) as above, and for a radius or a box's size
  // that is not above 0, a box whose axes are not a rotation or whose radius is more than half its smallest size, a
  // negative coefficient of friction, a restitution outside of 0 to 1; for an invalid motion: neither table nor
  // sinusoid, or both, times that do not increase, tables of different lengths, a negative frequency; and for an
  // invalid turn.
  SPRINGNET_API void add_instrument(const Instrument& instrument);
  // What a body is in contact with others, m: see Body. Throws Error(input) for a body that does not exist, and for
  // numbers that are negative or not finite.
  SPRINGNET_API void set_extent(std::size_t body, double thickness, double radius);
  // Throws Error(input) for no nodes on the first side, a node that does not exist or is not of a body, friction and
  // restitution as above, and a name that another contact has.
  SPRINGNET_API void add_contact(const BodyContact& contact);
  // A node can have only one motion; it counts as fixed, and its own velocity is ignored.
  SPRINGNET_API void add_move(const Move& move);
  // Length: the distance of the nodes unless given. Throws Error(input) for a node that does not exist or is joined to
  // itself, two connections between the same nodes, a length that is not above 0 or differs from the distance by more
  // than 1e-8 of it.
  SPRINGNET_API RigidIndex add_rigid(NodeIndex first, NodeIndex second, std::optional<double> length = std::nullopt);
  SPRINGNET_API void add_cut(const Cut& cut);
  // Throws Error(input) for a time below 0 or not finite, what does not exist, or nothing that changes. Simulation
  // checks names and values against the laws.
  SPRINGNET_API void add_change(const Change& change);
  // Throws Error(input) for an empty input, a name that is taken, a spring or element that does not exist, no spring
  // and no element, or an invalid signal. Simulation checks that a law of one of them has the input, and that the
  // signal stays within the bounds which the laws declare.
  SPRINGNET_API InputIndex add_input(const Input& input);
  SPRINGNET_API void set_gravity(const Vector3& acceleration);  // m/s^2

  [[nodiscard]] const NodeList& nodes() const noexcept { return nodes_; }
  [[nodiscard]] const SpringList& springs() const noexcept { return springs_; }
  [[nodiscard]] const std::vector<Element>& elements() const noexcept { return elements_; }
  [[nodiscard]] const std::vector<Face>& faces() const noexcept { return faces_; }
  [[nodiscard]] const std::vector<Material>& materials() const noexcept { return materials_; }
  [[nodiscard]] const std::vector<LawUse>& neurons() const noexcept { return neurons_; }
  [[nodiscard]] const std::vector<Body>& bodies() const noexcept { return bodies_; }
  [[nodiscard]] const std::vector<Load>& loads() const noexcept { return loads_; }
  [[nodiscard]] const std::vector<Plane>& planes() const noexcept { return planes_; }
  [[nodiscard]] const std::vector<Instrument>& instruments() const noexcept { return instruments_; }
  [[nodiscard]] const std::vector<BodyContact>& contacts() const noexcept { return contacts_; }
  [[nodiscard]] const std::vector<Move>& moves() const noexcept { return moves_; }
  [[nodiscard]] const std::vector<Rigid>& rigids() const noexcept { return rigids_; }
  [[nodiscard]] const std::vector<Cut>& cuts() const noexcept { return cuts_; }
  [[nodiscard]] const std::vector<Change>& changes() const noexcept { return changes_; }
  [[nodiscard]] const std::vector<Input>& inputs() const noexcept { return inputs_; }
  [[nodiscard]] const Vector3& gravity() const noexcept { return gravity_; }

  // Change what was added, with the same checks. A node with prescribed motion keeps it. The new position of a rigidly
  // connected node must keep the lengths.
  SPRINGNET_API void set_node(NodeIndex index, const Node& node);
  // Positions of all nodes at once, m, [node], which keep the lengths of rigid connections to a millionth.
  SPRINGNET_API void move_nodes(const std::vector<Vector3>& positions);
  SPRINGNET_API void set_spring_material(SpringIndex spring, MaterialIndex material);
  SPRINGNET_API void set_rest_length(SpringIndex spring, double rest_length);
  // Not of elements whose laws read several scalars.
  SPRINGNET_API void set_reference(ElementIndex element, double reference);
  // Of those: positions of the nodes at rest, and the direction of the material there, as in add_element.
  SPRINGNET_API void set_rest(ElementIndex element, std::vector<Vector3> rest, const Vector3& direction);

  // The same without planes, instruments and rigid connections: what springs, elements and loads alone do.
  [[nodiscard]] SPRINGNET_API Network without_constraints() const;

  // The invariant of an element at the nodes' positions in this network, in its unit.
  [[nodiscard]] SPRINGNET_API double value_of(const Element& element) const;
  // Area vector of a face, along its outward normal, at the nodes' positions in this network, m^2.
  [[nodiscard]] SPRINGNET_API Vector3 area_of(const Face& face) const;

 private:
  void check_node(const Node& node, NodeIndex index) const;
  void check_spring(SpringIndex spring) const;
  ElementIndex add_checked(Invariant invariant, std::vector<NodeIndex> nodes, MaterialIndex material,
                           std::optional<double> reference);
  void check_material(MaterialIndex material) const;
  void check_lengths(NodeIndex node, const Vector3& position) const;
  void check_ends(NodeIndex first, NodeIndex second, std::string_view what) const;
  template <class PlaneOrInstrument>
  void check_obstacle(std::string_view what, const PlaneOrInstrument& obstacle) const;

  NodeList nodes_;
  SpringList springs_;
  std::vector<Element> elements_;
  std::vector<Face> faces_;
  std::vector<Material> materials_;
  std::vector<LawUse> neurons_;
  std::vector<Body> bodies_;
  std::vector<Load> loads_;
  std::vector<Plane> planes_;
  std::vector<Instrument> instruments_;
  std::vector<BodyContact> contacts_;
  std::vector<Move> moves_;
  std::vector<Rigid> rigids_;
  std::vector<Cut> cuts_;
  std::vector<Change> changes_;
  std::vector<Input> inputs_;
  Vector3 gravity_ = Vector3::Zero();
  std::size_t table_values_ = 0;  // of all materials
  bool in_body_ = false;
  std::unordered_set<NodeIndex> moving_nodes_;    // nodes of all moves
  std::unordered_set<std::uint64_t> rigid_ends_;  // lower node number 2^32 + upper one
  std::unordered_set<std::string> body_names_;
  std::unordered_set<std::string> input_names_;
  std::unordered_set<std::string> group_names_;                  // of the last body that has groups
  std::unordered_map<std::string, std::uint32_t> neuron_index_;  // by a string that identifies the use
  std::unordered_map<std::string, MaterialIndex> material_index_;
};

}  // namespace springnet
