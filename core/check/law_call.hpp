// Calls of a law as a host makes them, for elements whose arguments are the columns of its matrix of derivatives.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>
#include <springnet/sdk/law/jacobian.hpp>

#include "check/memory.hpp"

namespace springnet::check {

// All that an element's law reads: a number for each column of sdk::JacobianLayout, those of the start of a step too.
using Point = std::vector<double>;

// Which of the references, parameters and inputs that are equal in all elements have the stride 0: a bit for each, see
// LawCall::sharing_bit. The others have an array with a number for each element.
inline constexpr std::uint64_t share_nothing = 0, share_all = ~std::uint64_t{0};

// How a law is called.
struct How {
  std::uint32_t instruction_set = SPRINGNET_GENERIC;
  bool derivatives = false;  // all that the law declares
  std::uint64_t shared = share_nothing;
  double time_step = 0.0;   // s; above 0: a step of the states
  std::uint32_t order = 1;  // of that step
  Memory::Layout layout = Memory::Layout::roomy;
  std::size_t offset = 0;             // numbers by which arrays are off a multiple of 64 bytes
  std::optional<std::size_t> only{};  // this output alone, of Answer::outputs; the others are null
};

// Answers for `count` elements. A cell is a row of the matrix of derivatives and one of its columns.
struct Answer {
  springnet_status status = SPRINGNET_OK;
  std::string message;
  std::size_t count = 0;
  std::size_t outputs = 0;                  // that there are, whether asked for or not
  std::vector<std::vector<double>> rows;    // [row][count]: forces, energy, margin, rates (or next states); or empty
  std::vector<std::vector<double>> matrix;  // [cell][count], of `derivatives`; or empty
  std::vector<std::vector<double>> named;   // the same of force_by_q and so on
};

class LawCall {
 public:
  // `table`: what the law prepared. The component must outlive this.
  explicit LawCall(const Component& component, const void* table = nullptr);

  [[nodiscard]] const Component& component() const noexcept { return component_; }
  [[nodiscard]] const springnet_law& law() const noexcept { return law_; }
  [[nodiscard]] const sdk::JacobianLayout& layout() const noexcept { return layout_; }
  [[nodiscard]] bool several() const noexcept { return law_.invariant == SPRINGNET_SEVERAL; }
  [[nodiscard]] bool is_viscosity() const noexcept { return component_.kind() == ComponentKind::viscosity_function; }
  [[nodiscard]] bool has(std::uint64_t capability) const noexcept {
    return (component_.description->capabilities & capability) != 0;
  }
  [[nodiscard]] bool reads_rate() const noexcept { return has(SPRINGNET_READS_RATE); }
  [[nodiscard]] bool reads_value(std::size_t invariant) const noexcept;
  [[nodiscard]] bool has_row(std::size_t row) const noexcept;
  // Whether the law reads the column, of a step (`of_update`) or else.
  [[nodiscard]] bool reads(std::size_t column, bool of_update) const noexcept;
  [[nodiscard]] std::string row_name(std::size_t row) const;        // "force", "rate of state 'flow'"
  [[nodiscard]] std::string column_name(std::size_t column) const;  // "the length", "parameter 'stiffness'"
  [[nodiscard]] std::size_t cell(std::size_t row, std::size_t column, bool of_update) const noexcept {
    return row * layout_.columns(of_update) + column;
  }
  // Of a reference, parameter or input in How::shared. Beyond 64 of them several have the same.
  [[nodiscard]] std::uint64_t sharing_bit(std::size_t column) const noexcept;

  // Does not throw if the law fails: its status is part of the answer.
  [[nodiscard]] Answer operator()(const std::vector<Point>& points, const How& how = {}) const;
  // One element; throws std::runtime_error if the law fails. [row]
  [[nodiscard]] std::vector<double> rows_at(const Point& point, const How& how = {}) const;
  // The number of `times` calls for the forces alone whose bits are not those of `expected`.
  [[nodiscard]] int different_calls(const std::vector<Point>& points, const Answer& expected, int times) const;
  // s for one of `times` calls for the forces alone of these elements.
  [[nodiscard]] double time_of(const std::vector<Point>& points, const How& how, int times) const;
  // The states at the start, by the law's `start` if it has one. Throws std::runtime_error if that fails.
  [[nodiscard]] std::vector<double> start_states(const Point& point, Memory::Layout layout) const;

 private:
  // Calls the law `times` times for the forces alone of these elements; `each` sees them after each call.
  template <class Each>
  void repeat(const std::vector<Point>& points, const How& how, int times, const Each& each) const;
  void set_inputs(const std::vector<Point>& points, const How& how, Memory& memory, springnet_law_batch& batch,
                  springnet_law_update& update) const;

  const Component& component_;
  const springnet_law& law_;
  sdk::JacobianLayout layout_;
  const void* table_;
};

// What a law makes of its tables.
class PreparedTable {
 public:
  PreparedTable() = default;
  // Throws std::runtime_error with the law's reason if it refuses them. tables: in the order of the law's.
  PreparedTable(const Component& component, const std::vector<std::vector<double>>& tables,
                const std::vector<double>& parameters);
  PreparedTable(const PreparedTable&) = delete;
  PreparedTable& operator=(const PreparedTable&) = delete;
  ~PreparedTable();
  [[nodiscard]] const void* get() const noexcept { return prepared_; }

 private:
  const springnet_law* law_ = nullptr;
  void* prepared_ = nullptr;
};

// Bit for bit, but one nan is as good as another.
[[nodiscard]] bool same_bits(double a, double b) noexcept;
// Empty if the answers are the same, else which number differs: "force of element 3 is 0.5 and 0.50000000000000011".
// first: the element of `whole` that is element 0 of `part`.
[[nodiscard]] std::string difference(const LawCall& call, const Answer& whole, const Answer& part, std::size_t first,
                                     bool of_update);

}  // namespace springnet::check
