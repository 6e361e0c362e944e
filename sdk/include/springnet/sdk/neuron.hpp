// Neurons in C++: net force to acceleration.
//
//   struct PointMass : springnet::sdk::Neuron {
//     static constexpr const char* id = "point_mass";
//     static constexpr const char* summary = "mass point: a = F / m";
//     static auto acceleration(const auto& n, const auto&) { return n.force / n.mass; }
//   };
//
// acceleration() gets a Node<Real> and Parameters<Real> and returns a Vector<Real>; Real is a dual number, without
// derivatives for the accelerations themselves. It must be pure, like a law: it reads only its arguments (and constant
// members, in a neuron of a host).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <springnet/sdk/component.hpp>
#include <springnet/sdk/kernel.hpp>
#include <springnet/sdk/math/members.hpp>

namespace springnet::sdk {

template <class Real>
struct Vector {
  Real x, y, z;

  friend SPRINGNET_INLINE constexpr Vector operator+(const Vector& a, const Vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend SPRINGNET_INLINE constexpr Vector operator-(const Vector& a, const Vector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend SPRINGNET_INLINE constexpr Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
  friend SPRINGNET_INLINE constexpr Vector operator*(const Real& s, const Vector& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  friend SPRINGNET_INLINE constexpr Vector operator*(const Vector& a, const Real& s) { return s * a; }
  // By the reciprocal: one division, which costs as much as the rest of a neuron.
  friend SPRINGNET_INLINE constexpr Vector operator/(const Vector& a, const Real& s) { return (Real(1.0) / s) * a; }
  friend SPRINGNET_INLINE constexpr Real dot(const Vector& a, const Vector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
};

// The inputs of a neuron, besides its parameters.
template <class Real>
struct Node {
  Vector<Real> force;     // net force, N
  Vector<Real> position;  // m
  Vector<Real> velocity;  // m/s
  Real mass;              // kg
  Real time;              // s
};

template <class Model>
class NeuronKernel {
  static constexpr std::size_t P = parameters_of<Model>().size();
  // Mass, time, parameters; so many derivatives are found by one evaluation.
  static constexpr std::size_t scalars = 2 + P, scalars_at_a_time = 4;

 public:
  struct Call {
    const Model* model;
    const springnet_neuron_batch* batch;
    std::uint32_t instruction_set;
  };
  SPRINGNET_INLINE static void run(const Call& call) {
    const springnet_neuron_batch& b = *call.batch;
    const detail::Streams<P> streams(b.parameters, b.parameter_strides, b.count);
    const std::array<double*, scalars> by_scalars = wanted_scalars(b);
    for (std::uint32_t begin = 0; begin < b.count; begin += detail::chunk_size) {
      Chunk chunk{};
      chunk.begin = begin;
      chunk.count = std::min(detail::chunk_size, b.count - begin);
      for (std::size_t j = 0; j < P; ++j) chunk.parameters[j] = streams.at(j, begin);
      chunk.by_scalars = by_scalars;
      if (streams.uniform()) {
        evaluate<true>(*call.model, b, chunk);
      } else {
        evaluate<false>(*call.model, b, chunk);
      }
    }
  }

 private:
  struct Chunk {
    std::uint32_t begin, count;
    std::array<const double*, P> parameters;
    std::array<double*, scalars> by_scalars;  // [node of the batch][3], or null
  };
  enum class By { force, position, velocity };

  // Where the derivatives by mass, time and parameters go; a host of ABI 2.0 does not ask for any.
  SPRINGNET_INLINE static std::array<double*, scalars> wanted_scalars(const springnet_neuron_batch& b) {
    std::array<double*, scalars> result{};
    if (!SPRINGNET_HAS_FIELD(springnet_neuron_batch, &b, acceleration_by_parameters)) return result;
    result[0] = b.acceleration_by_mass;
    result[1] = b.acceleration_by_time;
    for (std::size_t j = 0; b.acceleration_by_parameters != nullptr && j < P; ++j)
      result[2 + j] = b.acceleration_by_parameters[j];
    return result;
  }

  template <class Real>
  SPRINGNET_INLINE static Vector<Real> load(const springnet_const_vectors& v, std::size_t i) {
    return {v.x[i], v.y[i], v.z[i]};
  }
  template <class Real, bool uniform>
  SPRINGNET_INLINE static std::array<Real, P> parameters_at(const Chunk& c, std::size_t i) {
    std::array<Real, P> result{};
    for (std::size_t j = 0; j < P; ++j) result[j] = uniform ? *c.parameters[j] : c.parameters[j][i];
    return result;
  }
  template <class Real>
  SPRINGNET_INLINE static Node<Real> node_at(const springnet_neuron_batch& b, std::size_t k) {
    return {load<Real>(b.force, k), load<Real>(b.position, k), load<Real>(b.velocity, k), b.mass[k], b.time};
  }
  SPRINGNET_INLINE static springnet_const_vectors from(const springnet_const_vectors& v, std::size_t begin) {
    return {v.x + begin, v.y + begin, v.z + begin};
  }

  template <bool uniform>
  SPRINGNET_INLINE static void accelerations(const Model& model, const springnet_neuron_batch& batch, const Chunk& c) {
    // A copy, which outputs cannot overlap, from the chunk's first node on: the loop's index is that of the arrays.
    springnet_neuron_batch b = batch;
    b.force = from(batch.force, c.begin);
    b.position = from(batch.position, c.begin);
    b.velocity = from(batch.velocity, c.begin);
    b.mass = batch.mass + c.begin;
    double* __restrict x = batch.acceleration.x + c.begin;
    double* __restrict y = batch.acceleration.y + c.begin;
    double* __restrict z = batch.acceleration.z + c.begin;
    using Real = Dual<0>;
    const auto fixed = parameters_at<Real, uniform>(c, 0);
    const std::size_t count = c.count;
    SPRINGNET_INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) {
      const auto own = uniform ? fixed : parameters_at<Real, uniform>(c, i);
      const Vector<Real> a = model.acceleration(node_at<Real>(b, i), Parameters<Real>(own.data()));
      x[i] = a.x.value;
      y[i] = a.y.value;
      z[i] = a.z.value;
    }
  }
  // out[node][row][column] = d a_row / d (what)_column.
  template <By what, bool uniform>
  SPRINGNET_INLINE static void block(const Model& model, const springnet_neuron_batch& b, const Chunk& c, double* out) {
    using Real = Dual<3>;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const std::uint32_t k = c.begin + i;
      Node<Real> node = node_at<Real>(b, k);
      Vector<Real>& variables = what == By::force ? node.force : (what == By::position ? node.position : node.velocity);
      variables.x.derivatives[0] = 1.0;
      variables.y.derivatives[1] = 1.0;
      variables.z.derivatives[2] = 1.0;
      const auto own = parameters_at<Real, uniform>(c, i);
      const Vector<Real> a = model.acceleration(node, Parameters<Real>(own.data()));
      double* nine = out + 9 * std::size_t{k};
      for (std::size_t j = 0; j < 3; ++j) {
        nine[j] = a.x.derivatives[j];
        nine[3 + j] = a.y.derivatives[j];
        nine[6 + j] = a.z.derivatives[j];
      }
    }
  }

  // The scalar with a number: mass, time, parameters.
  template <std::size_t number, class Real>
  SPRINGNET_INLINE static Real& scalar(Node<Real>& node, std::array<Real, P>& parameters) {
    if constexpr (number == 0)
      return node.mass;
    else if constexpr (number == 1)
      return node.time;
    else
      return parameters[number - 2];
  }
  // out[node][row] = d a_row / d scalar for some scalars from number `first` on, if any of them is wanted.
  template <std::size_t first, bool uniform, std::size_t... j>
  SPRINGNET_INLINE static void by_scalars(const Model& model, const springnet_neuron_batch& b, const Chunk& c,
                                          std::index_sequence<j...>) {
    using Real = Dual<sizeof...(j)>;
    if (!(false || ... || (c.by_scalars[first + j] != nullptr))) return;
    for (std::uint32_t i = 0; i < c.count; ++i) {
      const std::uint32_t k = c.begin + i;
      Node<Real> node = node_at<Real>(b, k);
      auto own = parameters_at<Real, uniform>(c, i);
      ((scalar<first + j>(node, own).derivatives[j] = 1.0), ...);
      const Vector<Real> a = model.acceleration(node, Parameters<Real>(own.data()));
      const auto store = [&](double* out, std::size_t column) {
        if (out == nullptr) return;
        double* const three = out + 3 * std::size_t{k};
        three[0] = a.x.derivatives[column];
        three[1] = a.y.derivatives[column];
        three[2] = a.z.derivatives[column];
      };
      (store(c.by_scalars[first + j], j), ...);
    }
  }
  template <bool uniform, std::size_t... group>
  SPRINGNET_INLINE static void by_all_scalars(const Model& model, const springnet_neuron_batch& b, const Chunk& c,
                                              std::index_sequence<group...>) {
    (by_scalars<group * scalars_at_a_time, uniform>(
         model, b, c, std::make_index_sequence<std::min(scalars_at_a_time, scalars - group * scalars_at_a_time)>{}),
     ...);
  }

  template <bool uniform>
  SPRINGNET_INLINE static void evaluate(const Model& model, const springnet_neuron_batch& b, const Chunk& c) {
    if (b.acceleration.x != nullptr) accelerations<uniform>(model, b, c);
    if (b.acceleration_by_force != nullptr) block<By::force, uniform>(model, b, c, b.acceleration_by_force);
    if (b.acceleration_by_position != nullptr) block<By::position, uniform>(model, b, c, b.acceleration_by_position);
    if (b.acceleration_by_velocity != nullptr) block<By::velocity, uniform>(model, b, c, b.acceleration_by_velocity);
    constexpr std::size_t groups = (scalars + scalars_at_a_time - 1) / scalars_at_a_time;
    by_all_scalars<uniform>(model, b, c, std::make_index_sequence<groups>{});
  }
};

// springnet_neuron_model for a neuron's class. A context is an object of it; a null pointer stands for one without
// members.
template <class Model>
struct NeuronGlue {
  static_assert(
      requires(const Model& model, const Node<Dual<0>>& n, const Parameters<Dual<0>>& p) {
        Vector<Dual<0>>{model.acceleration(n, p)};
      },
      "a neuron needs: static auto acceleration(const auto& n, const auto& p), which returns a Vector");

  static constexpr std::uint64_t capabilities =
      SPRINGNET_HAS_DERIVATIVES | SPRINGNET_HAS_PARAMETER_DERIVATIVES |
      (Model::calling_thread_only ? SPRINGNET_CALLING_THREAD_ONLY : std::uint64_t{0});
  static constexpr std::uint64_t needs = 0;
  static constexpr std::uint32_t needs_minor = 0;

  static springnet_status evaluate(void* context, const springnet_neuron_batch* batch) noexcept {
    if (batch->struct_size < SPRINGNET_SIZE_TO(springnet_neuron_batch, message)) return SPRINGNET_FAILED;
    return detail::guarded(batch->message, [&]() -> springnet_status {
      detail::run<NeuronKernel<Model>>(
          typename NeuronKernel<Model>::Call{model(context), batch, batch->instruction_set});
      return SPRINGNET_OK;
    });
  }
  // With a context, which must outlive all uses.
  static constexpr springnet_neuron_model with(void* context) {
    return {sizeof(springnet_neuron_model), 0, context, &evaluate};
  }

 private:
  static constexpr springnet_neuron_model without_object() {
    static_assert(std::is_empty_v<Model> && std::is_default_constructible_v<Model>,
                  "a neuron of a plugin has no members, for there is no object of it; a program gives one with members "
                  "to springnet::neuron (host_laws.hpp)");
    return with(nullptr);
  }

 public:
  static constexpr springnet_neuron_model implementation = without_object();

 private:
  static const Model* model(void* context) noexcept {
    if constexpr (std::is_empty_v<Model> && std::is_default_constructible_v<Model>) {
      static constexpr Model without_members{};
      return &without_members;
    } else {
      return static_cast<const Model*>(context);
    }
  }
};

// Base of neurons; see the top of this file.
struct Neuron : ElementaryFunctions {
  static constexpr std::uint32_t kind = SPRINGNET_NEURON;
  static constexpr bool calling_thread_only = false;
  template <class Model>
  using Glue = NeuronGlue<Model>;
};

}  // namespace springnet::sdk
