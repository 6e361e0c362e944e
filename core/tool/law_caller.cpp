#include "law_caller.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "plugin_host/calling.hpp"

namespace springnet::tool {

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

// A batch, and the lists of pointers that it has.
struct LawCall {
  LawCall(const LawSetting& setting, const void* prepared, std::size_t count) {
    const Component& component = *setting.component;
    const springnet_law& law = component.law();
    for (const double& value : setting.parameters) parameters.push_back(&value);
    for (const double& value : setting.inputs) inputs.push_back(&value);
    strides.assign(std::max(parameters.size(), inputs.size()), 0);
    batch.struct_size = sizeof batch;
    batch.count = static_cast<std::uint32_t>(count);
    batch.instruction_set = SPRINGNET_GENERIC;
    batch.parameters = parameters.data();
    batch.parameter_strides = strides.data();
    batch.inputs = inputs.data();
    batch.input_strides = strides.data();
    batch.table = prepared;
    batch.message = &message;
    if (law.invariant != SPRINGNET_SEVERAL) {
      batch.reference = setting.references[0].data();
      return;
    }
    // References of several invariants, and directions, have a number for each member.
    for (const Numbers& each : setting.references) own.emplace_back(count, each[0]);
    for (std::size_t c = 0; c < 3; ++c) own.emplace_back(count, c == 0 ? 1.0 : 0.0);
    for (const Numbers& each : own) references.push_back(each.data());
    batch.references = references.data();
    if (law.reads_direction != 0) batch.direction = references.data() + setting.references.size();
  }
  LawCall(const LawCall&) = delete;
  LawCall& operator=(const LawCall&) = delete;

  springnet_law_batch batch{};
  springnet_message message{};
  std::vector<const double*> parameters, inputs, references, values, rates, states;
  std::vector<std::uint32_t> strides;
  std::vector<Numbers> own;
  std::vector<double*> forces;
};

std::vector<double*> addresses_of(std::vector<Numbers>& lists, std::size_t first) {
  std::vector<double*> result;
  for (Numbers& each : lists) result.push_back(each.data() + first);
  return result;
}

}  // namespace

// An exception, which the ABI forbids, counts as a failure.
template <class Function>
bool LawCaller::call(const Function& function) {
  springnet_message message{};
  try {
    const Calling calling(component());
    if (function(message) == SPRINGNET_OK) return true;
  } catch (const std::exception& error) {
    failure_ = printable(error.what(), 300);
    return false;
  } catch (...) {
  }
  message.text[sizeof message.text - 1] = '\0';
  failure_ = message.text[0] != '\0' ? printable(message.text, 300) : "it gives no reason";
  return false;
}

LawCaller::LawCaller(LawSetting setting) : setting_(std::move(setting)) {
  if (law().prepare == nullptr) return;
  std::vector<const double*> starts;
  std::vector<std::uint64_t> lengths;
  for (const Numbers& table : setting_.tables) {
    starts.push_back(table.empty() ? nullptr : table.data());
    lengths.push_back(table.size());
  }
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.table_count = static_cast<std::uint32_t>(starts.size());
  preparation.tables = starts.data();
  preparation.lengths = lengths.data();
  preparation.parameters = setting_.parameters.data();
  const bool prepared = call([&](springnet_message& message) {
    preparation.message = &message;
    return law().prepare(law().context, &preparation);
  });
  if (!prepared) throw Error(ErrorKind::input, std::string(component().id()) + ": its tables are refused: " + failure_);
  prepared_ = preparation.prepared;
}

LawCaller::~LawCaller() {
  if (law().prepare == nullptr || law().release == nullptr || prepared_ == nullptr) return;
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.prepared = prepared_;
  static_cast<void>(call([&](springnet_message& message) {
    preparation.message = &message;
    return law().release(law().context, &preparation);
  }));
}

std::size_t LawCaller::invariant_count() const {
  return law().invariant == SPRINGNET_SEVERAL ? law().invariant_count : 1;
}

LawCurves LawCaller::evaluate(const std::vector<Numbers>& values, const std::vector<Numbers>& rates) {
  const std::size_t count = values[0].size();
  const bool several = law().invariant == SPRINGNET_SEVERAL;
  LawCurves curves;
  curves.forces.assign(invariant_count(), Numbers(count, no_number));
  if (!several && can(SPRINGNET_HAS_DERIVATIVES)) curves.by_value.assign(count, no_number);
  if (!several && can(SPRINGNET_HAS_DERIVATIVES) && can(SPRINGNET_READS_RATE)) curves.by_rate.assign(count, no_number);
  if (can(SPRINGNET_HAS_ENERGY)) curves.energy.assign(count, no_number);
  if (can(SPRINGNET_HAS_RUPTURE)) curves.margin.assign(count, no_number);
  std::vector<Numbers> states;
  for (const double state : law().state_count > 0 ? start(reference(), 0.0) : Numbers())
    states.emplace_back(count, state);
  const auto evaluate_part = [&](std::size_t first, std::size_t size) {
    LawCall one(setting_, prepared_, size);
    springnet_law_batch& batch = one.batch;
    for (const Numbers& each : values) one.values.push_back(each.data() + first);
    for (const Numbers& each : rates) one.rates.push_back(each.data() + first);
    for (const Numbers& each : states) one.states.push_back(each.data() + first);
    one.forces = addresses_of(curves.forces, first);
    const bool reads_rate = can(SPRINGNET_READS_RATE);
    batch.states = one.states.data();
    const auto at = [first](Numbers& list) { return list.empty() ? nullptr : list.data() + first; };
    batch.energy = at(curves.energy);
    batch.margin = at(curves.margin);
    if (several) {
      for (std::uint32_t i = 0; i < law().invariant_count; ++i)
        if ((law().invariants[i]->flags & SPRINGNET_REFERENCE_ONLY) != 0)
          one.values[i] = one.rates[i] = one.forces[i] = nullptr;
      batch.values = one.values.data();
      if (reads_rate) batch.rates = one.rates.data();
      batch.forces = one.forces.data();
    } else {
      batch.q = one.values[0];
      if (reads_rate) batch.rate = one.rates[0];
      batch.force = one.forces[0];
      batch.force_by_q = at(curves.by_value);
      batch.force_by_rate = at(curves.by_rate);
    }
    return call([&](springnet_message& message) {
      batch.message = &message;
      return law().evaluate(law().context, &batch);
    });
  };
  if (evaluate_part(0, count)) return curves;
  for (std::size_t k = 0; k < count; ++k) {
    if (evaluate_part(k, 1)) continue;
    for (Numbers& force : curves.forces) force[k] = no_number;
    for (Numbers* list : {&curves.by_value, &curves.by_rate, &curves.energy, &curves.margin})
      if (!list->empty()) (*list)[k] = no_number;
  }
  return curves;
}

Numbers LawCaller::start(double value, double rate) {
  std::vector<Numbers> states;
  for (std::uint32_t k = 0; k < law().state_count; ++k) states.emplace_back(1, law().states[k]->default_value);
  Numbers result;
  const Numbers declared = [&] {
    Numbers all;
    for (const Numbers& each : states) all.push_back(each[0]);
    return all;
  }();
  if (law().start != nullptr) {
    LawCall one(setting_, prepared_, 1);
    for (const double& each : declared) one.states.push_back(&each);
    one.batch.states = one.states.data();
    one.batch.q = &value;
    if (can(SPRINGNET_READS_RATE)) one.batch.rate = &rate;
    std::vector<double*> out = addresses_of(states, 0);
    springnet_law_start request{};
    request.struct_size = sizeof request;
    request.batch = &one.batch;
    request.states = out.data();
    static_cast<void>(call([&](springnet_message& message) {
      one.batch.message = &message;
      return law().start(law().context, &request);
    }));
  }
  for (const Numbers& each : states) result.push_back(each[0]);
  return result;
}

bool LawCaller::step(double time, double time_step, const End& from, const End& to, Numbers& states, double& force,
                     double& margin) {
  LawCall one(setting_, prepared_, 1);
  Numbers next(states.size());
  std::vector<double*> out;
  for (const double& each : states) one.states.push_back(&each);
  for (double& each : next) out.push_back(&each);
  const bool reads_rate = can(SPRINGNET_READS_RATE);
  margin = 1.0;
  one.batch.time = time;
  one.batch.states = one.states.data();
  one.batch.q = &to.value;
  one.batch.force = &force;
  if (reads_rate) one.batch.rate = &to.rate;
  if (can(SPRINGNET_HAS_RUPTURE)) one.batch.margin = &margin;
  springnet_law_update update{};
  update.struct_size = sizeof update;
  update.order = std::min(law().update_order, 2u);
  update.batch = &one.batch;
  update.time_step = time_step;
  update.start_q = &from.value;
  if (reads_rate) update.start_rate = &from.rate;
  update.start_inputs = one.inputs.data();
  update.next = out.data();
  const bool stepped = call([&](springnet_message& message) {
    one.batch.message = &message;
    return law().update(law().context, &update);
  });
  if (stepped) states = next;
  return stepped;
}

}  // namespace springnet::tool
