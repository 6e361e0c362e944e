#include "sensitivities.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

#include <springnet/sdk/host.hpp>

#include "linear_solver.hpp"

namespace springnet::cvode {
namespace {

int rates_of_columns(int, double time, N_Vector y, N_Vector, N_Vector* changes, N_Vector* rates, void* user_data,
                     N_Vector, N_Vector) {
  return static_cast<Callbacks*>(user_data)->sensitivities->rates(time, y, changes, rates);
}

void check(int status, const char* what) {
  if (status == CV_MEM_FAIL) throw std::bad_alloc();
  if (status < 0) throw sdk::Failure(std::string("cvode: sensitivities: ") + what);
}

}  // namespace

void Sensitivities::begin(std::span<const springnet_sensitivity* const> columns, const Context& context) {
  std::vector<Column> made;
  const std::size_t n = equations_.node_count();
  for (const springnet_sensitivity* const each : columns) {
    if (!(each->scale > 0.0) || !std::isfinite(each->scale))
      throw sdk::Failure("cvode: the scale of a sensitivity must be a finite number above 0");
    Column column{{each->sets, each->sets + each->set_count},
                  each->scale,
                  make_vector(static_cast<sunindextype>(equations_.size()), context)};
    double* change = data(column.change.get());
    for (const double* const from : {each->position, each->velocity}) {
      if (from == nullptr)
        std::fill_n(change, 3 * n, 0.0);
      else
        std::copy_n(from, 3 * n, change);
      change += 3 * n;
    }
    made.push_back(std::move(column));
  }
  columns_ = std::move(made);
  changes_.clear();
  for (const Column& each : columns_) changes_.push_back(each.change.get());
}

void Sensitivities::attach(void* memory, bool fixed_point, const Context& context) {
  if (!any()) return;
  const int columns = static_cast<int>(count());
  check(CVodeSensInit(memory, columns, CV_STAGGERED, &rates_of_columns, changes_.data()), "cannot be begun");
  if (fixed_point) {
    fixed_point_.reset(SUNNonlinSol_FixedPointSens(columns, changes_.front(), 0, context.get()));
    if (!fixed_point_) throw std::bad_alloc();
    check(CVodeSetNonlinearSolverSensStg(memory, fixed_point_.get()), "have no solver");
  }
  check(CVodeSetSensErrCon(memory, SUNTRUE), "have no error test");
  set_tolerances(memory);
}

void Sensitivities::restart(void* memory) {
  if (!any()) return;
  check(CVodeSensReInit(memory, CV_STAGGERED, changes_.data()), "cannot be begun anew");
  set_tolerances(memory);
}

// As those of the motion, for a change of the scalar by its scale.
void Sensitivities::set_tolerances(void* memory) {
  const Equations::Tolerances& motion = equations_.tolerances();
  const std::size_t n = equations_.node_count();
  std::vector<Vector> absolute(count());
  std::vector<N_Vector> vectors;
  for (std::size_t j = 0; j < count(); ++j) {
    absolute[j].reset(N_VClone(changes_[j]));
    if (!absolute[j]) throw std::bad_alloc();
    std::fill_n(data(absolute[j].get()), 3 * n, motion.position / columns_[j].scale);
    std::fill_n(data(absolute[j].get()) + 3 * n, 3 * n, motion.velocity / columns_[j].scale);
    vectors.push_back(absolute[j].get());
  }
  check(CVodeSensSVtolerances(memory, motion.relative, vectors.data()), "have no tolerances");
}

void Sensitivities::keep(void* memory, double time) {
  if (any()) check(CVodeGetSensDky(memory, time, 0, changes_.data()), "are not known there");
}

void Sensitivities::read(std::uint32_t column, double* position, double* velocity) const {
  if (column >= count())
    throw sdk::Failure("cvode: there is no sensitivity " + std::to_string(column) + ": there are " +
                       std::to_string(count()));
  const std::size_t n = equations_.node_count();
  const double* const change = data(changes_[column]);
  std::copy_n(change, 3 * n, position);
  std::copy_n(change + 3 * n, 3 * n, velocity);
}

bool Sensitivities::is_linearised(double time, N_Vector y) const noexcept {
  return time == time_ && linearisations_ == equations_.work().linearisations &&
         std::equal(y_.begin(), y_.end(), data(y));
}

int Sensitivities::rates(double time, N_Vector y, N_Vector* changes, N_Vector* rates) noexcept {
  if (!is_linearised(time, y)) {
    time_ = std::numeric_limits<double>::quiet_NaN();
    if (const int status = equations_.linearise(time, y, 0.0); status != 0) return status;
    try {
      y_.assign(data(y), data(y) + equations_.size());
    } catch (const std::bad_alloc&) {
      return -1;
    }
    time_ = time;
    linearisations_ = equations_.work().linearisations;
  }
  for (std::size_t j = 0; j < count(); ++j)
    if (const int status = equations_.change_rate(time, y, columns_[j].sets, data(changes[j]), data(rates[j]));
        status != 0)
      return status;
  return 0;
}

}  // namespace springnet::cvode
