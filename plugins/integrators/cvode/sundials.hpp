// RAII for SUNDIALS, and the only place that depends on its version: 6 and 7 differ in the creation of a context and in
// error reports. Nothing is printed; the last error is kept as text.
#pragma once

// SUNDIALS 7 may include mpi.h, whose C++ bindings would have to be linked.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1

#include <memory>
#include <new>
#include <string>
#include <type_traits>

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

static_assert(std::is_same_v<sunrealtype, double>, "springnet needs a SUNDIALS built for double precision");
static_assert(SUNDIALS_VERSION_MAJOR >= 6, "springnet needs SUNDIALS 6 or newer");

namespace springnet::cvode {

template <auto function>
struct Destroy {
  template <class T>
  void operator()(T* object) const noexcept {
    function(object);
  }
};
template <class Handle, auto function>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Destroy<function>>;

using Vector = Owned<N_Vector, N_VDestroy>;
using Matrix = Owned<SUNMatrix, SUNMatFreeEmpty>;
using CustomLinearSolver = Owned<SUNLinearSolver, SUNLinSolFreeEmpty>;
using LinearSolver = Owned<SUNLinearSolver, SUNLinSolFree>;
using NonlinearSolver = Owned<SUNNonlinearSolver, SUNNonlinSolFree>;
inline void free_memory(void* memory) noexcept { CVodeFree(&memory); }
using Memory = std::unique_ptr<void, Destroy<free_memory>>;

// The context of all SUNDIALS objects of an integrator; receives their errors. Its address must not change.
class Context {
 public:
  Context() {
#if SUNDIALS_VERSION_MAJOR >= 7
    const int status = SUNContext_Create(SUN_COMM_NULL, &context_);
#else
    const int status = SUNContext_Create(nullptr, &context_);
#endif
    if (status != 0 || context_ == nullptr) throw std::bad_alloc();
#if SUNDIALS_VERSION_MAJOR >= 7
    SUNContext_ClearErrHandlers(context_);
    SUNContext_PushErrHandler(context_, &Context::keep_error, this);
#endif
  }
  ~Context() { SUNContext_Free(&context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  // Directs errors of this CVODE object to last_error(), too.
  void watch([[maybe_unused]] void* memory) {
#if SUNDIALS_VERSION_MAJOR < 7
    CVodeSetErrHandlerFn(memory, &Context::keep_error, this);
#endif
  }

  [[nodiscard]] SUNContext get() const noexcept { return context_; }
  [[nodiscard]] const std::string& last_error() const noexcept { return last_error_; }
  void clear_error() noexcept { last_error_.clear(); }

 private:
  void keep(int code, const char* text) noexcept {
    if (code >= 0) return;  // a warning
    try {
      last_error_ = text;
    } catch (const std::bad_alloc&) {
      last_error_.clear();
    }
  }
#if SUNDIALS_VERSION_MAJOR >= 7
  static void keep_error(int, const char*, const char*, const char* text, SUNErrCode code, void* self, SUNContext) {
    static_cast<Context*>(self)->keep(code, text);
  }
#else
  static void keep_error(int code, const char*, const char*, char* text, void* self) {
    static_cast<Context*>(self)->keep(code, text);
  }
#endif

  SUNContext context_ = nullptr;
  std::string last_error_;
};

[[nodiscard]] inline Vector make_vector(sunindextype length, const Context& context) {
  Vector vector(N_VNew_Serial(length, context.get()));
  if (!vector) throw std::bad_alloc();
  return vector;
}

[[nodiscard]] inline double* data(N_Vector vector) noexcept { return N_VGetArrayPointer(vector); }

}  // namespace springnet::cvode
