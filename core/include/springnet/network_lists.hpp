// The nodes and springs of a network: plain structs to the user, stored as one array for each quantity, of which those
// that are the same for all take no memory. A node takes 24 bytes and a spring 16, if all have the same mass, velocity,
// neuron and material.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/column.hpp>

namespace springnet {

using Vector3 = Eigen::Vector3d;
using NodeIndex = std::uint32_t;
using SpringIndex = std::uint32_t;
using MaterialIndex = std::uint32_t;

template <>
struct detail::SameBits<Vector3> {
  [[nodiscard]] static bool of(const Vector3& a, const Vector3& b) {
    const auto same = [&](Eigen::Index i) { return SameBits<double>::of(a[i], b[i]); };
    return same(0) && same(1) && same(2);
  }
};

struct Node {
  Vector3 position = Vector3::Zero();  // m
  Vector3 velocity = Vector3::Zero();  // m/s
  double mass = 1.0;                   // kg
  std::uint32_t neuron = 0;            // index into Network::neurons()
  bool fixed = false;
};

struct Spring {
  NodeIndex first;
  NodeIndex second;
  MaterialIndex material;
  double rest_length;  // m
};

// Iterator over a list whose operator[] returns its elements by value.
template <class List>
class ListIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using iterator_concept = std::random_access_iterator_tag;
  using value_type = typename List::value_type;
  using difference_type = std::ptrdiff_t;
  using reference = value_type;
  using pointer = void;

  ListIterator() = default;
  ListIterator(const List* list, std::size_t at) : list_(list), at_(static_cast<difference_type>(at)) {}
  [[nodiscard]] value_type operator*() const { return (*list_)[static_cast<std::size_t>(at_)]; }
  [[nodiscard]] value_type operator[](difference_type n) const { return *(*this + n); }
  ListIterator& operator++() { return *this += 1; }
  ListIterator operator++(int) { return std::exchange(*this, *this + 1); }
  ListIterator& operator--() { return *this += -1; }
  ListIterator operator--(int) { return std::exchange(*this, *this + -1); }
  ListIterator& operator+=(difference_type n) {
    at_ += n;
    return *this;
  }
  ListIterator& operator-=(difference_type n) { return *this += -n; }
  friend ListIterator operator+(ListIterator i, difference_type n) { return i += n; }
  friend ListIterator operator+(difference_type n, ListIterator i) { return i += n; }
  friend ListIterator operator-(ListIterator i, difference_type n) { return i -= n; }
  friend difference_type operator-(const ListIterator& a, const ListIterator& b) { return a.at_ - b.at_; }
  friend bool operator==(const ListIterator& a, const ListIterator& b) { return a.at_ == b.at_; }
  friend auto operator<=>(const ListIterator& a, const ListIterator& b) { return a.at_ <=> b.at_; }

 private:
  const List* list_ = nullptr;
  difference_type at_ = 0;
};

// Reads as std::vector<Node> does, except that elements are values, not references.
class NodeList {
 public:
  using value_type = Node;
  using const_iterator = ListIterator<NodeList>;

  [[nodiscard]] std::size_t size() const noexcept { return positions_.size(); }
  [[nodiscard]] bool empty() const noexcept { return positions_.empty(); }
  [[nodiscard]] Node operator[](std::size_t k) const {
    return {positions_[k], velocity_[k], mass_[k], neuron_[k], fixed_[k] != 0};
  }
  [[nodiscard]] Node front() const { return (*this)[0]; }
  [[nodiscard]] Node back() const { return (*this)[size() - 1]; }
  [[nodiscard]] const_iterator begin() const { return {this, 0}; }
  [[nodiscard]] const_iterator end() const { return {this, size()}; }

  [[nodiscard]] const std::vector<Vector3>& positions() const noexcept { return positions_; }  // m

 private:
  friend class Network;
  void push_back(const Node& node) {
    positions_.push_back(node.position);
    velocity_.push_back(node.velocity);
    mass_.push_back(node.mass);
    neuron_.push_back(node.neuron);
    fixed_.push_back(node.fixed ? 1 : 0);
  }
  // Appends nodes like `prototype`, whose positions are to be written where the result points to.
  [[nodiscard]] Vector3* append(std::size_t count, const Node& prototype) {
    positions_.resize(positions_.size() + count);
    velocity_.append(count, prototype.velocity);
    mass_.append(count, prototype.mass);
    neuron_.append(count, prototype.neuron);
    fixed_.append(count, prototype.fixed ? 1 : 0);
    return positions_.data() + (positions_.size() - count);
  }
  void set(std::size_t k, const Node& node) {
    positions_[k] = node.position;
    velocity_.set(k, node.velocity);
    mass_.set(k, node.mass);
    neuron_.set(k, node.neuron);
    fixed_.set(k, node.fixed ? 1 : 0);
  }
  void reserve(std::size_t count) {
    reserve_huge(positions_, count);
    velocity_.reserve(count);
    mass_.reserve(count);
    neuron_.reserve(count);
    fixed_.reserve(count);
  }

  std::vector<Vector3> positions_;  // m
  Column<Vector3> velocity_;        // m/s
  Column<double> mass_;             // kg
  Column<std::uint32_t> neuron_;
  Column<std::uint8_t> fixed_;
};

class SpringList {
 public:
  using value_type = Spring;
  using const_iterator = ListIterator<SpringList>;
  using Ends = std::array<NodeIndex, 2>;

  [[nodiscard]] std::size_t size() const noexcept { return ends_.size(); }
  [[nodiscard]] bool empty() const noexcept { return ends_.empty(); }
  [[nodiscard]] Spring operator[](std::size_t s) const {
    return {ends_[s][0], ends_[s][1], material_[s], rest_length_[s]};
  }
  [[nodiscard]] Spring front() const { return (*this)[0]; }
  [[nodiscard]] Spring back() const { return (*this)[size() - 1]; }
  [[nodiscard]] const_iterator begin() const { return {this, 0}; }
  [[nodiscard]] const_iterator end() const { return {this, size()}; }

  [[nodiscard]] const std::vector<Ends>& ends() const noexcept { return ends_; }
  [[nodiscard]] const Column<MaterialIndex>& materials() const noexcept { return material_; }
  [[nodiscard]] const Column<double>& rest_lengths() const noexcept { return rest_length_; }  // m

 private:
  friend class Network;
  void push_back(const Spring& spring) {
    ends_.push_back({spring.first, spring.second});
    material_.push_back(spring.material);
    rest_length_.push_back(spring.rest_length);
  }
  // Appends springs of one material, whose ends are to be written where the result points to.
  [[nodiscard]] Ends* append(std::size_t count, MaterialIndex material) {
    ends_.resize(ends_.size() + count);
    material_.append(count, material);
    return ends_.data() + (ends_.size() - count);
  }
  void reserve(std::size_t count) {
    reserve_huge(ends_, count);
    material_.reserve(count);
    rest_length_.reserve(count);
  }

  std::vector<Ends> ends_;
  Column<MaterialIndex> material_;
  Column<double> rest_length_;  // m
};

}  // namespace springnet
