// The host functions that came with ABI 2.1.
#include "simulation/host_calls.hpp"
#include "simulation/host_table.hpp"
#include "simulation/loop.hpp"
#include "simulation/parts.hpp"
#include "simulation/requests.hpp"

namespace springnet {
namespace {

using namespace host_calls;

springnet_status part_forces(void* context, const springnet_part_forces* request) {
  return outside_of_sweeps(context, "part_forces", [&](Engine& engine) {
    const springnet_part_forces& parts = SPRINGNET_REQUEST(springnet_part_forces, request, force);
    static_cast<void>(checked(parts.at));
    require_vectors(parts.force, "force");
    return springnet::part_forces(engine.model(), parts);
  });
}
springnet_status view_elements(void* context, springnet_element_view* request) {
  return outside_of_sweeps(context, "view_elements", [&](Engine& engine) {
    springnet_element_view& view = SPRINGNET_REQUEST(springnet_element_view, request, relative);
    static_cast<void>(checked(view.at));
    return springnet::view_elements(engine.model(), view);
  });
}
springnet_status view_scalars(void* context, springnet_scalar_view* request) {
  return outside_of_sweeps(context, "view_scalars", [&](Engine& engine) {
    springnet_scalar_view& view = SPRINGNET_REQUEST(springnet_scalar_view, request, by_rate);
    static_cast<void>(checked(view.at));
    return springnet::view_scalars(engine.model(), view);
  });
}
springnet_status balance(void* context, springnet_balance* request) {
  return outside_of_sweeps(context, "balance", [&](Engine& engine) {
    springnet_balance& balance = SPRINGNET_REQUEST(springnet_balance, request, angular_momentum);
    static_cast<void>(checked(balance.at));
    return springnet::balance(engine.model(), balance);
  });
}
springnet_status parallel_for(void* context, const springnet_loop* request) {
  return outside_of_sweeps(context, "parallel_for", [&](Engine& engine) {
    const springnet_loop& loop = SPRINGNET_REQUEST(springnet_loop, request, user);
    require_array(reinterpret_cast<const void*>(loop.body), "body");
    return run_loop(engine.model(), loop);
  });
}
springnet_status system_rows(void* context, springnet_system_rows* request) {
  return outside_of_sweeps(context, "system_rows", [&](Engine& engine) {
    return engine.linear().rows(SPRINGNET_REQUEST(springnet_system_rows, request, low_rank_w));
  });
}
springnet_status stop(void* context, springnet_stop* request) {
  return guarded(context, "stop", [&](Engine& engine) -> springnet_status {
    springnet_stop& answer = SPRINGNET_REQUEST(springnet_stop, request, reason);
    const Deadline& deadline = engine.model().deadline;
    answer.reason = deadline.is_asked()     ? SPRINGNET_STOP_ASKED
                    : deadline.has_passed() ? SPRINGNET_STOP_DEADLINE
                                            : SPRINGNET_GO_ON;
    return SPRINGNET_OK;
  });
}

}  // namespace

void add_functions_2_1(springnet_host& host) {
  host.part_forces = part_forces;
  host.view_elements = view_elements;
  host.view_scalars = view_scalars;
  host.balance = balance;
  host.parallel_for = parallel_for;
  host.system_rows = system_rows;
  host.stop = stop;
}

}  // namespace springnet
