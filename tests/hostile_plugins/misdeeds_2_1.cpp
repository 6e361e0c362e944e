// Misuse of the host functions that came with ABI 2.1.
#include <cstdint>
#include <vector>

#include "misdeeds.hpp"

namespace springnet::testing {
namespace {

// Calls a function with a request that is valid but for what `spoil` makes of it.
template <class Request, class Spoil>
Case spoilt(const char* name, springnet_status (*springnet_host::*function)(void*, Request*), const Spoil& spoil,
            bool refused = true) {
  return {name,
          [=](const StepContext& h) {
            const springnet_evaluation at = h.at();
            auto request = sdk::sized<std::remove_const_t<Request>>();
            if constexpr (requires { request.at; }) request.at = &at;
            if constexpr (requires { request.force.x; }) request.force = h.state->force;
            spoil(request, h);
            return (h.host->*function)(h.context, &request);
          },
          refused};
}
template <class Request>
Case without_request(const char* name, springnet_status (*springnet_host::*function)(void*, Request*)) {
  return {name, [=](const StepContext& h) { return (h.host->*function)(h.context, nullptr); }};
}

}  // namespace

std::vector<Case> cases_2_1() {
  constexpr auto large = ~std::uint64_t{0};
  return {
      without_request("asks for no parts", &springnet_host::part_forces),
      without_request("views nothing", &springnet_host::view_elements),
      without_request("views no scalars", &springnet_host::view_scalars),
      spoilt("views scalars of an element that there is not", &springnet_host::view_scalars,
             [](springnet_scalar_view& r, const StepContext&) { r.element = 1000; }),
      spoilt("views scalars in a small struct", &springnet_host::view_scalars,
             [](springnet_scalar_view& r, const StepContext&) { r.struct_size = 64; }),
      spoilt("views scalars at no state", &springnet_host::view_scalars,
             [](springnet_scalar_view& r, const StepContext&) { r.at = nullptr; }),
      without_request("asks for no balance", &springnet_host::balance),
      without_request("loops over nothing", &springnet_host::parallel_for),
      without_request("asks for no rows", &springnet_host::system_rows),
      without_request("asks no question", &springnet_host::stop),
      spoilt("asks for parts that there are not", &springnet_host::part_forces,
             [](springnet_part_forces& r, const StepContext&) { r.parts = 1024; }),
      spoilt("wants parts nowhere", &springnet_host::part_forces,
             [](springnet_part_forces& r, const StepContext&) { r.force.y = nullptr; }),
      spoilt("wants parts at no state", &springnet_host::part_forces,
             [](springnet_part_forces& r, const StepContext&) { r.at = nullptr; }),
      spoilt("asks for parts in a small struct", &springnet_host::part_forces,
             [](springnet_part_forces& r, const StepContext&) { r.struct_size = 16; }),
      spoilt("views springs beyond the last one", &springnet_host::view_elements,
             [](springnet_element_view& r, const StepContext& h) { r.first = h.network().spring_count + 1; }),
      spoilt("views more springs than numbers", &springnet_host::view_elements,
             [=](springnet_element_view& r, const StepContext&) {
               r.first = 1;
               r.count = large;
             }),
      spoilt("views elements that there are not", &springnet_host::view_elements,
             [](springnet_element_view& r, const StepContext&) {
               r.of_elements = 1;
               r.count = 1000;
             }),
      spoilt("has no room for the nodes of springs", &springnet_host::view_elements,
             [](springnet_element_view& r, const StepContext& h) {
               r.count = 2;
               r.gradients = h.state->force.x;
               r.node_capacity = 1;
             }),
      spoilt("wants the balance at no state", &springnet_host::balance,
             [](springnet_balance& r, const StepContext&) { r.at = nullptr; }),
      spoilt("loops without a body", &springnet_host::parallel_for,
             [](springnet_loop& r, const StepContext&) { r.count = 5; }),
      spoilt("linearises within a loop", &springnet_host::parallel_for,
             [](springnet_loop& r, const StepContext& h) {
               r.count = 3;
               r.part = 1;
               r.user = const_cast<StepContext*>(&h);
               r.body = [](void* user, std::uint64_t, std::uint64_t) {
                 const auto& own = *static_cast<const StepContext*>(user);
                 const springnet_evaluation at = own.at();
                 return own.linearise(&at);
               };
             }),
      spoilt("loops within a loop", &springnet_host::parallel_for,
             [](springnet_loop& r, const StepContext& h) {
               r.count = 3;
               r.user = const_cast<StepContext*>(&h);
               r.body = [](void* user, std::uint64_t, std::uint64_t) -> springnet_status {
                 const auto& own = *static_cast<const StepContext*>(user);
                 auto inner = sdk::sized<springnet_loop>();
                 inner.body = [](void*, std::uint64_t, std::uint64_t) -> springnet_status { return SPRINGNET_OK; };
                 return own.host->parallel_for(own.context, &inner);
               };
             }),
      spoilt("asks for the rows in a small struct", &springnet_host::system_rows,
             [](springnet_system_rows& r, const StepContext&) { r.struct_size = 8; }),
      spoilt("asks whether to stop in a small struct", &springnet_host::stop,
             [](springnet_stop& r, const StepContext&) { r.struct_size = 4; }),
  };
}

}  // namespace springnet::testing
