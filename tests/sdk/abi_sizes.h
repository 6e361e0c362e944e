/* Where the structs of ABI 1.0 end on a 64-bit platform: the last field of each, and the bytes up to its end. Fields
 * are only ever added behind them, so no number here may change. */
#include <springnet/sdk/plugin.h>

/* clang-format off */
#define SPRINGNET_ENDS_1_0(check)                     \
  check(springnet_message, text, 512)                 \
  check(springnet_vectors, z, 24)                     \
  check(springnet_const_vectors, z, 24)               \
  check(springnet_parameter, choices, 80)             \
  check(springnet_component, implementation, 56)      \
  check(springnet_plugin, components, 64)             \
  check(springnet_law_batch, message, 168)            \
  check(springnet_table_source, array, 24)            \
  check(springnet_law, release, 56)                   \
  check(springnet_neuron_batch, message, 176)         \
  check(springnet_neuron_model, evaluate, 16)         \
  check(springnet_state, internal, 88)                \
  check(springnet_network, neighbours, 120)           \
  check(springnet_evaluation, internal_rate, 128)     \
  check(springnet_node_batch, acceleration, 64)       \
  check(springnet_sweep, user, 208)                   \
  check(springnet_host, message, 168)                 \
  check(springnet_step_report, start_node, 48)        \
  check(springnet_integrator, advance, 32)
/* What ABI 1.1 added behind them. */
#define SPRINGNET_ENDS_1_1(check)                        \
  check(springnet_network, rigid_count, 144)             \
  check(springnet_evaluation, energy, 152)               \
  check(springnet_node_batch, acceleration_by_position, 80) \
  check(springnet_sweep, constraint_force, 272)          \
  check(springnet_host, note, 200)                       \
  check(springnet_step_report, stages, 64)
/* And ABI 1.2. */
#define SPRINGNET_ENDS_1_2(check)                        \
  check(springnet_network, load_revision, 152)           \
  check(springnet_host, begin_interval, 208)
/* And ABI 1.3. */
#define SPRINGNET_ENDS_1_3(check)                        \
  check(springnet_network, status, 160)                  \
  check(springnet_sweep, reserved, 280)                  \
  check(springnet_impact_search, user, 64)               \
  check(springnet_host, time_of_impact, 216)
/* And ABI 1.4. */
#define SPRINGNET_ENDS_1_4(check)                        \
  check(springnet_eigenvalue_search, applications, 112)  \
  check(springnet_limit, reason, 48)                     \
  check(springnet_limits, tell, 24)                      \
  check(springnet_integrator, limits, 40)                \
  check(springnet_host, dominant_eigenvalue, 232)
/* And ABI 1.5. */
#define SPRINGNET_ENDS_1_5(check)                        \
  check(springnet_evaluation, free_acceleration, 176)    \
  check(springnet_node_batch, nodes, 88)                 \
  check(springnet_sweep, reserved_2, 288)                \
  check(springnet_network, connection_revision, 168)     \
  check(springnet_linear_system, at, 40)                 \
  check(springnet_linear_solve, iterations, 48)          \
  check(springnet_integrator, forget, 48)                \
  check(springnet_host, time_left, 256)                  \
  check(springnet_step_report, position_error, 72)
/* And ABI 1.6. */
#define SPRINGNET_ENDS_1_6(check)                        \
  check(springnet_state, is_swept, 92)                   \
  check(springnet_node_batch, instruction_set, 92)       \
  check(springnet_host, network_with_neighbours, 264)
/* clang-format on */

#ifdef __cplusplus
extern "C"
#endif
    /* Number of structs that end elsewhere for the C compiler. */
    unsigned
    springnet_ends_wrong_in_c(void);
