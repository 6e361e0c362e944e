#include "layers/law_pair.hpp"

#include <algorithm>
#include <limits>

#include <springnet/sdk/law/jacobian.hpp>

#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

// The input signals of the members of a batch of one law: one number where all have the same signal, else one each.
class InputValues {
 public:
  // column(index, stride): the numbers of the signals, one or one each.
  template <class Column>
  void read(const Law& law, const Signals& signals, std::size_t size, double time, double time_step,
            const Column& column) {
    for (std::size_t k = 0; k < law.input_count; ++k) {
      const double* const numbers = column(law.first_input_column + k, strides[k]);
      const auto signal = [&](std::size_t i) { return static_cast<std::uint32_t>(numbers[i]); };
      const std::size_t count = strides[k] == 0 ? 1 : size;
      for (std::size_t i = 0; i < count; ++i) now_[k][i] = signals.at(signal(i), time);
      now[k] = now_[k];
      if (!(time_step > 0.0)) continue;
      for (std::size_t i = 0; i < count; ++i) start_[k][i] = signals.at_start(signal(i), time, time_step);
      start[k] = start_[k];
    }
  }
  const double *now[max_inputs], *start[max_inputs];
  std::uint32_t strides[max_inputs];

 private:
  double now_[max_inputs][states_batch], start_[max_inputs][states_batch];
};

// The pointers of a call to a law over several scalars. Nothing of it is initialised before begin(): it is large, and
// most laws have no use for it.
class SeveralCall {
 public:
  void begin(const Law& law, const SeveralInputs& inputs, const LawOutputs& out) {
    law_ = &law;
    inputs_ = &inputs;
    out_ = &out;
    layout_ = jacobian_of(law);
    if (out.several_tangent) std::fill_n(matrix_.begin(), layout_.rows() * layout_.columns(false), nullptr);
  }
  // From member `begin` on.
  void set(std::size_t begin, springnet_law_batch& batch) {
    const auto at = [begin](auto* array) { return array == nullptr ? nullptr : array + begin; };
    for (std::size_t i = 0; i < law_->scalar_count; ++i) {
      const std::size_t s = law_->scalar[i];
      reference_[i] = at(inputs_->reference[s]);
      value_[i] = rate_[i] = nullptr;
      force_[i] = nullptr;
      if (!law_->reads[i]) continue;
      value_[i] = at(inputs_->value[s]);
      if (law_->reads_rate) rate_[i] = at(inputs_->rate[s]);
      if (out_->several != nullptr) force_[i] = at(out_->several->force[s]);
      for (std::size_t j = 0; out_->several_tangent && j < law_->scalar_count; ++j) {
        if (!law_->reads[j]) continue;
        const std::size_t from = max_scalars * s + law_->scalar[j];
        double** const row = matrix_.data() + layout_.force(i) * layout_.columns(false);
        row[layout_.value(j)] = at(out_->several->by_value[from]);
        row[layout_.rate(j)] = law_->reads_rate ? at(out_->several->by_rate[from]) : nullptr;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) direction_[c] = at(inputs_->direction[c]);
    batch.values = value_;
    batch.rates = law_->reads_rate ? rate_ : nullptr;
    batch.references = reference_;
    batch.direction = law_->reads_direction ? direction_ : nullptr;
    batch.forces = force_;
    batch.derivatives = out_->several_tangent ? matrix_.data() : nullptr;
  }

 private:
  const Law* law_;
  const SeveralInputs* inputs_;
  const LawOutputs* out_;
  sdk::JacobianLayout layout_;
  const double *value_[max_scalars], *rate_[max_scalars], *reference_[max_scalars], *direction_[3];
  double* force_[max_scalars];
  static constexpr sdk::JacobianLayout greatest{max_scalars, max_parameters, max_states, max_inputs};
  std::array<double*, greatest.rows() * greatest.columns(false)> matrix_;  // not initialised without derivatives
};

// Entries of the greatest Jacobian. Laws over several scalars make no steps of states.
constexpr sdk::JacobianLayout of_one{1, max_parameters, max_states, max_inputs};
constexpr sdk::JacobianLayout of_several{max_scalars, max_parameters, max_states, max_inputs};
constexpr std::size_t most_derivatives =
    std::max(of_one.rows() * of_one.columns(true), of_several.rows() * of_several.columns(false));

springnet_status evaluate_law(const LawBatch& laws, const Law& law, std::uint32_t instruction_set, double time,
                              const LawOutputs& out, springnet_message& message) {
  const Group& group = laws.group;
  const RowSelection& rows = laws.rows;
  const std::size_t count = laws.count;
  const double* q = law.relative ? laws.speed : laws.q;
  const double* rate = law.reads_rate ? laws.rate : nullptr;
  const double* parameters[max_parameters];
  std::uint32_t strides[max_parameters];
  const double* reference = nullptr;
  // Parameters that differ between members are copied to `expanded`, for some members at a time; the size of a batch
  // does not change the bits.
  constexpr std::size_t most_expanded = states_batch;
  alignas(64) double expanded[(max_parameters + 1) * most_expanded];
  const bool uniform = rows.columns == nullptr && (rows.rows == nullptr || group.row_count() == 1);
  const bool whole = (uniform || rows.columns != nullptr) && law.state_count == 0 && law.input_count == 0;
  const std::size_t batch_size = whole ? count : most_expanded;

  double* derivatives[most_derivatives];
  double* by_parameters[max_parameters];
  const std::size_t derivative_count =
      out.derivatives == nullptr
          ? 0
          : jacobian_of(law).rows() * jacobian_of(law).columns(steps_states(law, laws.internal.view));

  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.instruction_set = instruction_set;
  batch.time = time;
  batch.parameters = parameters;
  batch.parameter_strides = strides;
  SeveralCall several;
  if (law.scalar_count > 0) several.begin(law, *laws.several, out);
  if (law.prepared) batch.table = law.prepared->data();

  for (std::size_t begin = 0; begin < count; begin += batch_size) {
    const std::size_t size = count - begin < batch_size ? count - begin : batch_size;
    const auto column = [&](std::size_t index, std::size_t slot, std::uint32_t& stride) -> const double* {
      const Column<double>& values = group.columns[index];
      const bool is_listed = rows.columns != nullptr && rows.columns[index] != nullptr;
      if (uniform || (!is_listed && (rows.columns != nullptr || group.is_same(index)))) {
        stride = 0;
        return values.find(rows.rows == nullptr ? rows.row : 0);
      }
      stride = 1;
      if (is_listed) return rows.columns[index] + begin;
      double* copy = expanded + slot * most_expanded;
      for (std::size_t i = 0; i < size; ++i) copy[i] = values[rows.rows[begin + i]];
      return copy;
    };
    InputValues inputs;
    if (law.input_count > 0) {
      const InternalView* const view = law.state_count > 0 ? laws.internal.view : nullptr;
      inputs.read(law, *group.signals, size, time, view == nullptr ? 0.0 : view->time_step,
                  [&](std::size_t index, std::uint32_t& stride) { return column(index, 0, stride); });
      batch.inputs = inputs.now;
      batch.input_strides = inputs.strides;
    }
    reference = column(0, 0, batch.reference_stride);
    for (std::size_t k = 0; k < law.parameter_count; ++k)
      parameters[k] = column(law.first_column + k, k + 1, strides[k]);
    batch.count = static_cast<std::uint32_t>(size);
    if (law.scalar_count > 0) {
      several.set(begin, batch);
    } else {
      batch.q = q + begin;
      batch.rate = rate == nullptr ? nullptr : rate + begin;
      batch.reference = reference;
    }
    const auto at = [begin](double* array) { return array == nullptr ? nullptr : array + begin; };
    batch.force = at(out.force);
    batch.energy = at(out.energy);
    batch.force_by_q = at(out.by_q);
    batch.force_by_rate = at(out.by_rate);
    batch.margin = at(out.margin);
    batch.energy_by_q = at(out.energy_by_q);
    if (out.derivatives != nullptr) {
      for (std::size_t i = 0; i < derivative_count; ++i) derivatives[i] = at(out.derivatives[i]);
      batch.derivatives = derivatives;
    }
    if (out.by_parameters != nullptr) {
      for (std::size_t i = 0; i < law.parameter_count; ++i) by_parameters[i] = at(out.by_parameters[i]);
      batch.force_by_parameters = by_parameters;
    }
    const springnet_status status = call_component(
        *law.component, message,
        [&](springnet_message& own) {
          batch.message = &own;
          if (law.state_count > 0) return evaluate_with_states(laws.internal, law, begin, inputs.start, batch);
          const springnet_law& functions = law.component->law();
          return functions.evaluate(functions.context, &batch);
        },
        laws.members.part(static_cast<std::uint32_t>(begin), batch.count));
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace

springnet_status evaluate_laws(const LawBatch& batch, InstructionSet set, double time, const PairOutputs& out,
                               springnet_message& message) {
  const std::uint32_t instruction_set = abi_number(set);
  const auto fill = [&batch](double*& output, double value) {
    std::fill_n(output, batch.count, value);
    output = nullptr;
  };
  const std::array<const Law*, 2> laws = batch.group.laws();
  for (std::size_t k = 0; k < laws.size(); ++k) {
    const Law& law = *laws[k];
    if (!law || (out[k].force == nullptr && out[k].margin == nullptr && out[k].several == nullptr &&
                 out[k].derivatives == nullptr && out[k].by_parameters == nullptr))
      continue;
    LawOutputs own = out[k];
    if (law.scalar_count > 0 && batch.several == nullptr) {
      set_message(message, full_name(*law.component) + " reads several scalars, which are not known here");
      return SPRINGNET_FAILED;
    }
    if (own.several_tangent && require_derivatives(*law.component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
    if (own.by_q != nullptr && require_derivatives(*law.component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
    if (own.by_rate != nullptr && !law.reads_rate) fill(own.by_rate, 0.0);
    if (own.energy != nullptr && !law.can(SPRINGNET_HAS_ENERGY))
      fill(own.energy, std::numeric_limits<double>::quiet_NaN());
    if (own.margin != nullptr && !law.can(SPRINGNET_HAS_RUPTURE))
      fill(own.margin, std::numeric_limits<double>::infinity());
    const profile::Part part(law.component->description->id,
                             k == 0 ? profile::Kind::spring_function : profile::Kind::viscosity_function);
    const springnet_status status = evaluate_law(batch, law, instruction_set, time, own, message);
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
