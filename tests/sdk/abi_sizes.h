/* Where the structs of ABI 2.0 end on a 64-bit platform: the last field of each, and the bytes up to its end. Fields
 * are only ever added behind them, so no number here may change. */
#include <springnet/sdk/plugin.h>

/* clang-format off */
#define SPRINGNET_ENDS_2_0(check)                       \
  check(springnet_message, text, 512)                   \
  check(springnet_vectors, z, 24)                       \
  check(springnet_const_vectors, z, 24)                 \
  check(springnet_call, message, 16)                    \
  check(springnet_parameter, choices, 80)               \
  check(springnet_law_batch, message, 216)              \
  check(springnet_law_update, next_by_parameters, 88)   \
  check(springnet_law_start, states, 24)                \
  check(springnet_preparation, message, 48)             \
  check(springnet_table, largest, 56)                   \
  check(springnet_law, release, 120)                    \
  check(springnet_neuron_batch, message, 176)           \
  check(springnet_neuron_model, evaluate, 24)           \
  check(springnet_state, reserved, 96)                  \
  check(springnet_internal, rates, 40)                  \
  check(springnet_internal_range, law, 40)              \
  check(springnet_network, internal_range_count, 184)   \
  check(springnet_evaluation, free_acceleration, 176)   \
  check(springnet_node_batch, reserved, 96)             \
  check(springnet_sweep, internal, 296)                 \
  check(springnet_dense_output, velocity, 64)           \
  check(springnet_impact_search, time, 72)              \
  check(springnet_network_query, network, 16)           \
  check(springnet_state_creation, state, 16)            \
  check(springnet_committed, state, 24)                 \
  check(springnet_interval, until, 24)                  \
  check(springnet_linearisation, elimination, 24)       \
  check(springnet_jacobian_product, out, 32)            \
  check(springnet_internal_change, acceleration, 48)    \
  check(springnet_diagonal_blocks, out, 32)             \
  check(springnet_factorisation, position_weight, 24)   \
  check(springnet_solve, x, 24)                         \
  check(springnet_linear_system, at, 40)                \
  check(springnet_linear_solve, iterations, 48)         \
  check(springnet_linear_image, x, 16)                  \
  check(springnet_eigenvalue_search, applications, 112) \
  check(springnet_event_values, directions, 32)         \
  check(springnet_event_firing, fired, 32)              \
  check(springnet_discontinuity, time, 24)              \
  check(springnet_commitment, state, 24)                \
  check(springnet_number_report, value, 24)             \
  check(springnet_user_note, text, 16)                  \
  check(springnet_projection, values, 24)               \
  check(springnet_state_projection, velocity, 64)       \
  check(springnet_deadline, time_left, 16)              \
  check(springnet_host, deadline, 248)                  \
  check(springnet_step_report, position_error, 72)      \
  check(springnet_limit, reason, 48)                    \
  check(springnet_limits, tell, 24)                     \
  check(springnet_integrator_creation, integrator, 32)  \
  check(springnet_advance, report, 24)                  \
  check(springnet_integrator, forget, 56)               \
  check(springnet_component, implementation, 72)        \
  check(springnet_plugin, components, 72)               \
  check(springnet_note, reserved, 40)

/* The same for what ABI 2.1 added. */
#define SPRINGNET_ENDS_2_1(check)                                \
  check(springnet_law_batch, derivatives, 264)                   \
  check(springnet_law_update, start_rates, 104)                  \
  check(springnet_invariant, reserved, 32)                       \
  check(springnet_law, reserved_2, 144)                          \
  check(springnet_neuron_batch, acceleration_by_parameters, 200) \
  check(springnet_network, input_count, 208)                     \
  check(springnet_transposed_product, by_velocity, 32)           \
  check(springnet_event_values, surfaces, 56)                    \
  check(springnet_parameter_set, values, 40)                     \
  check(springnet_parameter_product, internal, 48)               \
  check(springnet_event_derivative, by_time, 56)                 \
  check(springnet_part_forces, force, 40)                        \
  check(springnet_element_view, relative, 128)                   \
  check(springnet_scalar_view, by_rate, 2728)                    \
  check(springnet_balance, angular_momentum, 80)                 \
  check(springnet_loop, user, 40)                                \
  check(springnet_system_rows, low_rank_w, 64)                   \
  check(springnet_stop, reason, 8)                               \
  check(springnet_host, view_scalars, 336)                       \
  check(springnet_byte_sink, write, 24)                          \
  check(springnet_bytes, count, 24)                              \
  check(springnet_integrator, interpolate, 80)                   \
  check(springnet_integrator, sensitivity, 96)                   \
  check(springnet_sensitivity, scale, 40)                        \
  check(springnet_sensitivities, columns, 16)                    \
  check(springnet_sensitivity_values, velocity, 24)
/* clang-format on */

#ifdef __cplusplus
extern "C"
#endif
    /* Number of structs that end elsewhere for the C compiler. */
    unsigned
    springnet_ends_wrong_in_c(void);
