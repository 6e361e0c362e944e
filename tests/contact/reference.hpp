// An independent solution of point masses with linear springs, gravity and loads, in contact with planes, spheres and
// capsules that may move: Dormand and Prince's Runge-Kutta pair of order 5 between events, events by bisection. It
// reads a Network as plain data and shares no code with the engine; a node is in contact with one surface at a time.
#pragma once

#include <cstddef>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::testing {

// Displacement, velocity and acceleration of a motion at a time: a sinusoid, or a linear table (derivatives from the
// right). m, m/s, m/s^2
struct Shift {
  Vector3 place = Vector3::Zero(), velocity = Vector3::Zero(), acceleration = Vector3::Zero();
};

class Reference {
 public:
  enum class Mode { free, sticking, sliding };
  enum class Change { touched, released, slipped, stuck };
  struct Event {
    Change change;
    double time;  // s
    NodeIndex node;
  };

  struct Gap {
    double distance;  // m
    Vector3 normal;
    int piece;         // of a capsule: -1 and 1 its ends, 0 its side
    Vector3 relative;  // velocity to the surface, m/s
    double bending;    // relative' H relative, H the Hessian of the distance, m/s^2
  };

  // tolerance: of a step, in m and m/s. Elements, rigid connections, moved nodes, smooth tables are not supported.
  explicit Reference(const Network& net, double tolerance = 1e-13);
  void advance_to(double time);

  [[nodiscard]] double time() const noexcept { return time_; }
  [[nodiscard]] Vector3 position(NodeIndex node) const { return now_[node].p; }
  [[nodiscard]] Vector3 velocity(NodeIndex node) const { return now_[node].v; }
  // Force of the surface on the node, N; its integral over time, and the sum of the impulses of touches, N s.
  [[nodiscard]] Vector3 reaction(NodeIndex node) const;
  [[nodiscard]] Vector3 reaction_integral(NodeIndex node) const { return now_[node].pushed; }
  [[nodiscard]] Vector3 impulse(NodeIndex node) const { return contacts_[node].impulse; }
  [[nodiscard]] Mode mode(NodeIndex node) const { return contacts_[node].mode; }
  [[nodiscard]] const std::vector<Event>& events() const noexcept { return events_; }
  // The gap between a node at p with velocity v and a surface; surfaces are planes, then instruments.
  [[nodiscard]] Gap gap(int surface, double time, const Vector3& p, const Vector3& v) const;
  [[nodiscard]] int surface_count() const noexcept { return static_cast<int>(surfaces_.size()); }
  // Time of the n-th change of a kind, s; nan where there are fewer.
  [[nodiscard]] double time_of(Change change, std::size_t n = 0) const;

 private:
  struct Body {
    Vector3 p, v, pushed;  // m, m/s, N s
  };
  using Bodies = std::vector<Body>;
  struct Contact {
    Mode mode = Mode::free;
    int surface = -1;
    int piece = 0;
    bool starting = false;  // slip begins: its direction is that of the sliding acceleration
    Vector3 direction = Vector3::Zero();
    Vector3 impulse = Vector3::Zero();  // N s
    Vector3 anchor = Vector3::Zero();   // where it sticks, relative to the surface, m
  };
  struct Surface {
    bool plane;
    Vector3 first, second, normal;
    double radius;
    Friction friction;
    const Motion* motion;
  };
  struct Push {
    double normal;  // N, < 0: the surface would have to pull
    Vector3 along;  // N, the force that holds it (sticking), or friction (sliding)
  };

  [[nodiscard]] Vector3 force(NodeIndex node, double time, const Bodies& bodies) const;
  [[nodiscard]] Push push(NodeIndex node, double time, const Bodies& bodies) const;
  [[nodiscard]] Vector3 reaction_at(NodeIndex node, double time, const Bodies& bodies) const;
  [[nodiscard]] Bodies rates(double time, const Bodies& bodies) const;
  [[nodiscard]] Bodies stepped(double h, double& error) const;
  [[nodiscard]] bool event_occurred(NodeIndex node, double time, const Bodies& bodies) const;
  void commit(double time, Bodies&& bodies);
  void respond(NodeIndex node);
  void touch(NodeIndex node, int surface);
  [[nodiscard]] bool presses(NodeIndex node, int surface);
  void settle(NodeIndex node, bool touching = false);
  void jump();
  void note(Change change, NodeIndex node) { events_.push_back({change, time_, node}); }

  const Network net_;
  std::vector<Surface> surfaces_;
  std::vector<double> stops_;
  double tolerance_;  // m, m/s
  double slip_ends_;  // m/s: an error of the tolerance could reverse slower slip
  double time_ = 0.0, h_ = 1e-4;
  Bodies now_;
  std::vector<Contact> contacts_;
  std::vector<Event> events_;
};

// The surfaces of a network alone, to ask for gaps.
[[nodiscard]] Reference surfaces_of(const Network& net);

}  // namespace springnet::testing
