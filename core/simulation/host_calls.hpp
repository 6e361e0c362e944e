// How functions of the host's table are run: what all of them do before and after their work.
#pragma once

#include <cstddef>
#include <exception>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/sdk/message.hpp>

#include "profile/stage.hpp"
#include "simulation/engine.hpp"
#include "simulation/requests.hpp"

namespace springnet::host_calls {

inline Engine& engine_of(void* context) { return *static_cast<Engine*>(context); }

// Runs the action of one host function on behalf of an integrator.
template <class Action>
springnet_status guarded(void* context, const char* function, const Action& action) noexcept {
  if (context == nullptr) return SPRINGNET_FAILED;
  Engine& engine = engine_of(context);
  const auto refuse = [&](const char* reason, bool misuse) noexcept {
    try {
      engine.calls().refuse(misuse ? fmt::format("springnet_host::{}: {}", function, reason) : std::string(reason),
                            misuse);
    } catch (const std::exception&) {
      sdk::detail::write_message(&engine.model().journal.message, "out of memory");
    }
  };
  try {
    return action(engine);
  } catch (const Error& error) {
    refuse(error.what(), error.kind() == ErrorKind::plugin);
  } catch (const std::exception& error) {
    refuse(error.what(), false);
  } catch (...) {
    refuse("unknown failure in the host", false);
  }
  return SPRINGNET_FAILED;
}

// The same for functions that change the engine or use its buffers. Each is a stage of a profile, by its own name
// unless another one is given.
template <class Action>
springnet_status outside_of_sweeps(void* context, const char* function, const char* stage_name,
                                   const Action& action) noexcept {
  return guarded(context, function, [&](Engine& engine) -> springnet_status {
    engine.calls().require_no_callback();
    const profile::Stage stage(stage_name);
    return action(engine);
  });
}
template <class Action>
springnet_status outside_of_sweeps(void* context, const char* function, const Action& action) noexcept {
  return outside_of_sweeps(context, function, function, action);
}

// The same for functions of the derivatives, which need a call of linearise first.
template <class Action>
springnet_status linearised(void* context, const char* function, const Action& action) noexcept {
  return outside_of_sweeps(context, function, [&](Engine& engine) -> springnet_status {
    if (!engine.linear().known()) throw Error(ErrorKind::plugin, "derivatives were asked for before linearise");
    return action(engine);
  });
}

// A request, which carries its own size; `last`: its last field in ABI 2.0.
#define SPRINGNET_REQUEST(type, request, last) sized_request(request, #type, SPRINGNET_SIZE_TO(type, last))
template <class Request>
Request& sized_request(Request* request, const char* name, std::size_t min_size) {
  if (request == nullptr) throw Error(ErrorKind::plugin, fmt::format("the {} is a null pointer", name));
  require_size(request->struct_size, name, min_size);
  return *request;
}

}  // namespace springnet::host_calls
