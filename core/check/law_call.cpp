#include "check/law_call.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include <springnet/printable.hpp>

namespace springnet::check {
namespace {

constexpr double not_written = -1.234567890123e300;  // what outputs are filled with

std::string reason(const springnet_message& message, springnet_status status) {
  const std::string text = printable({message.text, strnlen(message.text, sizeof message.text)}, 300);
  return text.empty() ? fmt::format("it returns the status {} without a reason", status) : text;
}

const springnet_parameter& at(const springnet_parameter* const* list, std::size_t i) { return *list[i]; }

}  // namespace

LawCall::LawCall(const Component& component, const void* table)
    : component_(component),
      law_(component.law()),
      layout_{law_.invariant == SPRINGNET_SEVERAL ? law_.invariant_count : 1, component.description->parameter_count,
              law_.state_count, law_.input_count},
      table_(table) {}

bool LawCall::reads_value(std::size_t invariant) const noexcept {
  return !several() || (law_.invariants[invariant]->flags & SPRINGNET_REFERENCE_ONLY) == 0;
}

bool LawCall::has_row(std::size_t row) const noexcept {
  if (row < layout_.invariants) return reads_value(row);
  if (row == layout_.energy()) return has(SPRINGNET_HAS_ENERGY);
  if (row == layout_.margin()) return has(SPRINGNET_HAS_RUPTURE);
  return true;
}

bool LawCall::reads(std::size_t column, bool of_update) const noexcept {
  const sdk::JacobianLayout& l = layout_;
  const auto within = [column](std::size_t first, std::size_t count) {
    return column >= first && column < first + count;
  };
  if (within(l.value(), l.invariants)) return reads_value(column);
  if (within(l.rate(), l.invariants)) return reads_rate() && reads_value(column - l.rate());
  if (column == l.time()) return has(SPRINGNET_READS_TIME);
  if (within(l.direction(0), 3)) return several() && law_.reads_direction != 0;
  if (!of_update) return column < l.columns(false);
  if (within(l.start_value(), l.invariants)) return reads_value(column - l.start_value());
  if (within(l.start_rate(), l.invariants)) return reads_rate() && reads_value(column - l.start_rate());
  return column < l.columns(true);
}

std::uint64_t LawCall::sharing_bit(std::size_t column) const noexcept {
  const sdk::JacobianLayout& l = layout_;
  // The reference, the parameters, the inputs; the states are between the last two.
  const std::size_t place = column < l.parameter(0) ? 0
                            : column < l.state(0)   ? 1 + column - l.parameter(0)
                                                    : 1 + l.parameters + column - l.input(0);
  return std::uint64_t{1} << (place % 64);
}

std::string LawCall::row_name(std::size_t row) const {
  const sdk::JacobianLayout& l = layout_;
  if (row < l.invariants) return several() ? fmt::format("force {}", row) : "force";
  if (row == l.energy()) return "energy";
  if (row == l.margin()) return "margin";
  return fmt::format("rate of state '{}'", at(law_.states, row - l.state_row(0)).name);
}

std::string LawCall::column_name(std::size_t column) const {
  const sdk::JacobianLayout& l = layout_;
  const auto numbered = [&](const char* what, std::size_t i) {
    return several() ? fmt::format("{} {}", what, i) : std::string(what);
  };
  if (column < l.rate()) return numbered("invariant", column);
  if (column < l.reference()) return numbered("rate", column - l.rate());
  if (column < l.parameter(0)) return numbered("reference", column - l.reference());
  if (column < l.state(0))
    return fmt::format("parameter '{}'", at(component_.description->parameters, column - l.parameter(0)).name);
  if (column < l.input(0)) return fmt::format("state '{}'", at(law_.states, column - l.state(0)).name);
  if (column < l.time()) return fmt::format("input '{}'", at(law_.inputs, column - l.input(0)).name);
  if (column == l.time()) return "the time";
  if (column < l.start_value()) return fmt::format("direction {}", column - l.direction(0));
  if (column < l.start_rate()) return numbered("invariant at the start", column - l.start_value());
  if (column < l.start_input(0)) return numbered("rate at the start", column - l.start_rate());
  return fmt::format("input '{}' at the start", at(law_.inputs, column - l.start_input(0)).name);
}

// Fills in all that the law reads.
void LawCall::set_inputs(const std::vector<Point>& points, const How& how, Memory& memory, springnet_law_batch& batch,
                         springnet_law_update& update) const {
  const sdk::JacobianLayout& l = layout_;
  const auto array = [&](std::size_t column, bool one, const std::string& name) -> const double* {
    std::vector<double> values;
    for (const Point& point : points) values.push_back(point[column]);
    if (one) values.resize(1);
    return memory.input(values, name);
  };
  const auto is_shared = [&](std::size_t column) {
    return (how.shared & sharing_bit(column)) != 0 && std::all_of(points.begin(), points.end(), [&](const Point& p) {
             return same_bits(p[column], points.front()[column]);
           });
  };
  // A list of arrays, with its strides if it has any.
  const auto list = [&](std::size_t first, std::size_t count, bool may_share, const std::string& name,
                        const auto& is_read, std::vector<std::uint32_t>* strides) -> const double* const* {
    std::vector<const double*> arrays;
    for (std::size_t i = 0; i < count; ++i) {
      const bool one = may_share && is_shared(first + i);
      if (strides != nullptr) strides->push_back(one ? 0 : 1);
      arrays.push_back(is_read(i) ? array(first + i, one, column_name(first + i)) : nullptr);
    }
    return memory.input(arrays, name);
  };
  const auto all = [](std::size_t) { return true; };
  const auto those_read = [this](std::size_t i) { return reads_value(i); };
  batch.struct_size = sizeof batch;
  batch.count = static_cast<std::uint32_t>(points.size());
  batch.instruction_set = how.instruction_set;
  batch.time = points.front()[l.time()];
  batch.table = table_;
  std::vector<std::uint32_t> parameter_strides, input_strides;
  batch.parameters = list(l.parameter(0), l.parameters, true, "the list of parameters", all, &parameter_strides);
  batch.parameter_strides = memory.input(parameter_strides, "the strides of parameters");
  batch.states = list(l.state(0), l.states, false, "the list of states", all, nullptr);
  batch.inputs = list(l.input(0), l.inputs, true, "the list of inputs", all, &input_strides);
  batch.input_strides = memory.input(input_strides, "the strides of inputs");
  if (several()) {
    batch.values = list(l.value(), l.invariants, false, "the list of values", those_read, nullptr);
    if (reads_rate()) batch.rates = list(l.rate(), l.invariants, false, "the list of rates", those_read, nullptr);
    batch.references = list(l.reference(), l.invariants, false, "the list of references", all, nullptr);
    if (law_.reads_direction != 0)
      batch.direction = list(l.direction(0), 3, false, "the list of directions", all, nullptr);
  } else {
    batch.q = array(l.value(), false, column_name(l.value()));
    if (reads_rate()) batch.rate = array(l.rate(), false, "rate");
    const bool one = is_shared(l.reference());
    batch.reference_stride = one ? 0 : 1;
    batch.reference = array(l.reference(), one, "reference");
  }
  if (how.time_step <= 0.0) return;
  update.struct_size = sizeof update;
  update.order = how.order;
  update.time_step = how.time_step;
  if (several()) {
    update.start_values = list(l.start_value(), l.invariants, false, "the list of start values", those_read, nullptr);
    if (reads_rate())
      update.start_rates = list(l.start_rate(), l.invariants, false, "the list of start rates", those_read, nullptr);
  } else {
    update.start_q = array(l.start_value(), false, "start_q");
    if (reads_rate()) update.start_rate = array(l.start_rate(), false, "start_rate");
  }
  // With the strides of the inputs at the end.
  std::vector<const double*> starts;
  for (std::size_t i = 0; i < l.inputs; ++i)
    starts.push_back(array(l.start_input(i), input_strides[i] == 0, column_name(l.start_input(i))));
  update.start_inputs = memory.input(starts, "the list of start inputs");
}

Answer LawCall::operator()(const std::vector<Point>& points, const How& how) const {
  const sdk::JacobianLayout& l = layout_;
  const bool of_update = how.time_step > 0.0;
  const std::size_t count = points.size(), S = l.states, P = l.parameters;
  Memory memory(how.layout, how.offset);
  springnet_law_batch batch{};
  springnet_law_update update{};
  set_inputs(points, how, memory, batch, update);

  // Where answers are: [row], [cell].
  std::vector<double*> rows(l.rows(), nullptr), matrix(l.rows() * l.columns(of_update), nullptr),
      named(l.rows() * l.columns(of_update), nullptr);
  std::size_t outputs = 0;
  const auto output = [&](const std::string& name) -> double* {
    const bool is_wanted = !how.only || *how.only == outputs;
    ++outputs;
    return is_wanted ? memory.output(count, name, not_written) : nullptr;
  };
  // Null if none of its arrays is wanted.
  const auto output_list = [&](const std::vector<double*>& arrays, const std::string& name) -> double* const* {
    const bool is_empty = std::all_of(arrays.begin(), arrays.end(), [](const double* each) { return each == nullptr; });
    return is_empty ? nullptr : memory.input(arrays, name);
  };
  for (std::size_t row = 0; row < l.rows(); ++row)
    if (has_row(row)) rows[row] = output(row_name(row));
  if (several()) {
    batch.forces = output_list({rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(l.invariants)}, "forces");
  } else {
    batch.force = rows[0];
  }
  batch.energy = rows[l.energy()];
  batch.margin = rows[l.margin()];
  const std::vector<double*> of_states(rows.begin() + static_cast<std::ptrdiff_t>(l.state_row(0)), rows.end());
  double* const* const state_answers = S == 0 ? nullptr : output_list(of_states, "the list of states' answers");
  if (of_update) {
    update.next = state_answers;
  } else {
    batch.state_rates = state_answers;
  }
  const auto named_output = [&](std::size_t row, std::size_t column, const std::string& name) {
    return named[cell(row, column, of_update)] = output(name);
  };
  if (how.derivatives && !several()) {
    const auto by_columns = [&](std::size_t row, std::size_t first, std::size_t n, const std::string& name) {
      std::vector<double*> arrays;
      for (std::size_t j = 0; j < n; ++j) arrays.push_back(named_output(row, first + j, name));
      return n == 0 ? nullptr : output_list(arrays, "the list " + name);
    };
    const auto by_rows = [&](std::size_t column, std::size_t n, const std::string& name) {
      std::vector<double*> arrays;
      for (std::size_t i = 0; i < S; ++i)
        for (std::size_t j = 0; j < n; ++j) arrays.push_back(named_output(l.state_row(i), column + j, name));
      return arrays.empty() ? nullptr : output_list(arrays, "the list " + name);
    };
    if (has(SPRINGNET_HAS_DERIVATIVES)) {
      batch.force_by_q = named_output(0, l.value(), "force_by_q");
      if (reads_rate()) batch.force_by_rate = named_output(0, l.rate(), "force_by_rate");
      batch.force_by_states = by_columns(0, l.state(0), S, "force_by_states");
      if (!of_update && has(SPRINGNET_HAS_ENERGY)) {
        batch.energy_by_q = named_output(l.energy(), l.value(), "energy_by_q");
        batch.energy_by_states = by_columns(l.energy(), l.state(0), S, "energy_by_states");
      }
      auto& by_q = of_update ? update.next_by_q : batch.rates_by_q;
      auto& by_rate = of_update ? update.next_by_rate : batch.rates_by_rate;
      auto& by_states = of_update ? update.next_by_states : batch.rates_by_states;
      by_q = by_rows(l.value(), 1, "the states' answers by q");
      if (reads_rate()) by_rate = by_rows(l.rate(), 1, "the states' answers by the rate");
      by_states = by_rows(l.state(0), S, "the states' answers by states");
    }
    if (has(SPRINGNET_HAS_PARAMETER_DERIVATIVES)) {
      batch.force_by_parameters = by_columns(0, l.parameter(0), P, "force_by_parameters");
      auto& by_parameters = of_update ? update.next_by_parameters : batch.rates_by_parameters;
      by_parameters = by_rows(l.parameter(0), P, "the states' answers by parameters");
    }
  }
  if (how.derivatives && has(SPRINGNET_HAS_ALL_DERIVATIVES)) {
    for (std::size_t row = 0; row < l.rows(); ++row) {
      if (!has_row(row)) continue;
      for (std::size_t column = 0; column < l.columns(of_update); ++column)
        matrix[cell(row, column, of_update)] = output("the matrix of derivatives");
    }
    batch.derivatives = output_list(matrix, "the list of derivatives");
  }
  springnet_message* const message = memory.output(1, "the message", springnet_message{});
  batch.message = message;
  const std::vector<springnet_law_batch> one_batch{batch};
  const springnet_law_batch* const given = memory.input(one_batch, "the batch");
  update.batch = given;
  const std::vector<springnet_law_update> one_update{update};
  const springnet_law_update* const given_update = of_update ? memory.input(one_update, "the update") : nullptr;
  memory.protect();

  Answer answer;
  answer.count = count;
  answer.outputs = outputs;
  answer.status = of_update ? law_.update(law_.context, given_update) : law_.evaluate(law_.context, given);
  if (answer.status != SPRINGNET_OK) {
    answer.message = reason(*message, answer.status);
    return answer;
  }
  const auto collect = [count](const std::vector<double*>& from, std::vector<std::vector<double>>& to) {
    to.resize(from.size());
    for (std::size_t k = 0; k < from.size(); ++k)
      if (from[k] != nullptr) to[k].assign(from[k], from[k] + count);
  };
  collect(rows, answer.rows);
  collect(matrix, answer.matrix);
  collect(named, answer.named);
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (const double value : answer.rows[row])
      if (value == not_written) {
        answer.status = SPRINGNET_FAILED;
        answer.message = fmt::format("it leaves the {} unwritten: write it where its array is not null", row_name(row));
      }
  return answer;
}

std::vector<double> LawCall::rows_at(const Point& point, const How& how) const {
  const Answer answer = (*this)({point}, how);
  if (answer.status != SPRINGNET_OK) throw std::runtime_error("the law fails: " + answer.message);
  std::vector<double> rows;
  for (const auto& row : answer.rows) rows.push_back(row.empty() ? std::numeric_limits<double>::quiet_NaN() : row[0]);
  return rows;
}

template <class Each>
void LawCall::repeat(const std::vector<Point>& points, const How& how, int times, const Each& each) const {
  Memory memory(how.layout);
  springnet_law_batch batch{};
  springnet_law_update none{};
  set_inputs(points, how, memory, batch, none);
  std::vector<double*> forces;
  for (std::size_t i = 0; i < layout_.invariants; ++i)
    forces.push_back(reads_value(i) ? memory.output(points.size(), "force", 0.0) : nullptr);
  if (several()) {
    batch.forces = forces.data();
  } else {
    batch.force = forces[0];
  }
  for (int k = 0; k < times; ++k) {
    if (law_.evaluate(law_.context, &batch) != SPRINGNET_OK) throw std::runtime_error("the law fails");
    each(forces);
  }
}

double LawCall::time_of(const std::vector<Point>& points, const How& how, int times) const {
  double seconds = 0.0;
  auto last = std::chrono::steady_clock::now();
  int calls = -1;
  // From the end of the first call on, which warms the caches up.
  repeat(points, how, times + 1, [&](const std::vector<double*>&) {
    if (++calls == 0) last = std::chrono::steady_clock::now();
    if (calls == times) seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - last).count();
  });
  return seconds / times;
}

int LawCall::different_calls(const std::vector<Point>& points, const Answer& expected, int times) const {
  int different = 0;
  repeat(points, {}, times, [&](const std::vector<double*>& forces) {
    bool same = true;
    for (std::size_t i = 0; i < forces.size(); ++i)
      for (std::size_t k = 0; forces[i] != nullptr && k < points.size(); ++k)
        same = same && same_bits(forces[i][k], expected.rows[i][k]);
    if (!same) ++different;
  });
  return different;
}

std::vector<double> LawCall::start_states(const Point& point, Memory::Layout layout) const {
  std::vector<double> declared;
  for (std::size_t i = 0; i < layout_.states; ++i) declared.push_back(law_.states[i]->default_value);
  if (law_.start == nullptr || layout_.states == 0) return declared;
  Point from = point;
  std::copy(declared.begin(), declared.end(), from.begin() + static_cast<std::ptrdiff_t>(layout_.state(0)));
  Memory memory(layout);
  springnet_law_batch batch{};
  springnet_law_update none{};
  set_inputs({from}, {}, memory, batch, none);
  springnet_message* const message = memory.output(1, "the message", springnet_message{});
  batch.message = message;
  std::vector<double*> out;
  for (std::size_t i = 0; i < layout_.states; ++i) out.push_back(memory.output(1, "a state at the start", not_written));
  springnet_law_start start{};
  start.struct_size = sizeof start;
  start.batch = memory.input(std::vector<springnet_law_batch>{batch}, "the batch");
  start.states = memory.input(out, "the list of states at the start");
  const springnet_law_start* const given = memory.input(std::vector<springnet_law_start>{start}, "the start");
  memory.protect();
  const springnet_status status = law_.start(law_.context, given);
  if (status != SPRINGNET_OK) throw std::runtime_error("its `start` fails: " + reason(*message, status));
  for (std::size_t i = 0; i < layout_.states; ++i) declared[i] = *out[i];
  return declared;
}

PreparedTable::PreparedTable(const Component& component, const std::vector<std::vector<double>>& tables,
                             const std::vector<double>& parameters) {
  const springnet_law& law = component.law();
  if (law.table_count == 0) return;
  std::vector<const double*> arrays;
  std::vector<std::uint64_t> lengths;
  for (const auto& table : tables) {
    arrays.push_back(table.data());
    lengths.push_back(table.size());
  }
  springnet_message message{};
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.table_count = law.table_count;
  preparation.tables = arrays.data();
  preparation.lengths = lengths.data();
  preparation.parameters = parameters.data();
  preparation.message = &message;
  const springnet_status status = law.prepare(law.context, &preparation);
  if (status != SPRINGNET_OK) throw std::runtime_error(reason(message, status));
  law_ = &law;
  prepared_ = preparation.prepared;
}

PreparedTable::~PreparedTable() {
  if (law_ == nullptr) return;
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.prepared = prepared_;
  static_cast<void>(law_->release(law_->context, &preparation));
}

bool same_bits(double a, double b) noexcept {
  return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b));
}

std::string difference(const LawCall& call, const Answer& whole, const Answer& part, std::size_t first,
                       bool of_update) {
  if (whole.status != part.status)
    return fmt::format("one call returns the status {}, another {}", whole.status, part.status);
  const std::size_t columns = call.layout().columns(of_update);
  const auto compare = [&](const auto& a, const auto& b, const auto& name) -> std::string {
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      for (std::size_t i = 0; i < std::min(b[k].size(), part.count); ++i)
        if (!same_bits(a[k][first + i], b[k][i]))
          return fmt::format("{} of an element is {} and {}", name(k), a[k][first + i], b[k][i]);
    return {};
  };
  const auto cell_name = [&](std::size_t k) {
    return fmt::format("derivative of the {} by {}", call.row_name(k / columns), call.column_name(k % columns));
  };
  std::string text = compare(whole.rows, part.rows, [&](std::size_t row) { return call.row_name(row); });
  if (text.empty()) text = compare(whole.matrix, part.matrix, cell_name);
  if (text.empty()) text = compare(whole.named, part.named, cell_name);
  return text;
}

}  // namespace springnet::check
