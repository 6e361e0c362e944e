// Identification: parameters of a net from what was observed of its motion, with what is known about them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/motion_derivatives.hpp>
#include <springnet/observations.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Values that are learned, each by itself or together.
struct Learnable {
  LearnedValues values;
  // One variable for all: they are equal, or keep their ratios if they differ at first.
  bool together = false;
  // Beside the bounds of the law's or neuron's metadata; masses and rest lengths stay above 0. Values that have to are
  // searched by their logarithm, others as they are: forces of most laws are linear in them.
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  // 0 or above: a smooth field. The variables are coefficients of Bernstein polynomials of this degree in each
  // direction over the box of the members' places at the start (of nodes, middles of springs, centroids of elements).
  // Values are their start times the field, or its exponential where they are searched by their logarithm; if some
  // start at 0, or have another sign, the field is added. Bounds of all values hold for each coefficient: a field stays
  // between its least and greatest one. Start velocities have a field for each axis. Not together with `together`.
  int field_degree = -1;
  // Searched by their logarithm also where they may be 0; those that start above it.
  bool by_logarithm = false;
  // [value] How far off the value at the start may be as a guess: the standard deviation of its logarithm where it is
  // searched by that, else as a share of it. In these units LearnOptions::guess_weight draws values to the guess; 1 is
  // its weight beside observations whose weights are 1/s^2. 0: not known, in the unit of the value itself; empty: of
  // all. See GuessedValues.
  std::vector<double> guess_widths{};
  // "bar" or "bar/top": the body or group that select_learnable() was given, for titles; empty: all, or no text.
  std::string body{};
};

// "spring.stiffness", "viscosity.damping", "element.spring.stiffness", "element.viscosity.damping", "neuron.drag",
// "rest_length", "reference", "mass", "velocity" (of nodes that are not fixed), of all or, "mass@NAME", of a body; each
// by itself, or, "mass:together", as one, or, "mass:field=2", as a field of this degree (masses then of fixed nodes,
// too: their weight is part of their reactions); "load" or, "load@2", one by its number; "gravity" or, "gravity@z", one
// component, or, "gravity:together", its strength; "friction" or, "friction@table", that of one surface. Throws
// Error(input) that tells what there is.
[[nodiscard]] SPRINGNET_API Learnable select_learnable(const Network& network, const PluginHost& plugins,
                                                       std::string_view text);
// Several of them. Throws Error(input) also if two have a value in common, and names both.
[[nodiscard]] SPRINGNET_API std::vector<Learnable> select_learnables(const Network& network, const PluginHost& plugins,
                                                                     const std::vector<std::string>& texts);

// A net with loads and start of its own whose motion was observed. All have the same springs, elements and nodes; the
// search begins with the values of the first one, and all move with the same values, start velocities, gravity and
// friction that are learned included.
struct Experiment {
  std::shared_ptr<const Network> network;
  SimulationOptions options;   // time step and integrator, see MotionDerivatives
  Observations observations;   // learned from; none: the experiment only judges
  Observations held_out = {};  // of the same motion: judge what was learned, which does not know them
  std::string name{};          // for messages: the scene's file, for instance; empty: its number
};

struct LearnProgress {
  int iteration = 0;         // of all stages
  double share = 1.0;        // of the observed time that is learned from
  double cost = 0.0;         // 1/2 sum of weighted squares of residuals, with those of the guess and of smoothness
  double rms = 0.0;          // root mean square of the weighted differences from the observations alone
  Eigen::VectorXd values{};  // the best so far, as of MotionDerivatives
  int start = 0;             // see LearnOptions::starts
  double done = 0.0;         // share of the iterations that there are at most
  // Time steps made since this call began, and those of derivatives: one for each of a motion, backwards, or forwards
  // by a variable. Not those made to check the input, nor again for want of memory. 0 in LearnedNet::history.
  double work = 0.0;
  double guess_weight = 0.0;  // of this part of the search: rules try several
};

// How the cost of the whole motion falls on the way of a search: the same measure for each method.
struct LearnCourse {
  struct Point {
    double work = 0.0;  // as of LearnProgress, in whole motions
    double cost = 0.0;  // 1/2 sum of the weighted squares of all differences; nan: a motion with these values fails
    double rms = 0.0;   // their root mean square
    Eigen::VectorXd values;  // of `parameters`
  };
  std::string method;
  std::vector<std::size_t> parameters;  // of LearnedNet::parameters: the first of each variable, or field, up to 12
  std::vector<Point> points;            // the first has the values of the network
};

enum class Optimiser : std::uint8_t {
  // Gauss-Newton steps with damping: fewest iterations. Jacobians of up to 2000 variables, else products with them.
  levenberg_marquardt,
  // Quasi-Newton steps from gradients alone: an iteration takes one motion and one way back, mostly, however many
  // variables there are.
  lbfgs,
  // The paper's gradient descent with momentum. No step raises the cost, but it needs far more iterations.
  descent
};
// "levenberg", "lbfgs", "descent"
[[nodiscard]] SPRINGNET_API std::string_view name_of(Optimiser optimiser) noexcept;

// How the weight of the guess is found; see LearnedNet::guess_curve.
enum class GuessRule : std::uint8_t {
  given,        // LearnOptions::guess_weight
  widths,       // 1 where Learnable::guess_widths and weights that differ from 1, so of 1/s^2, can be compared; else 0
  discrepancy,  // the greatest with which differences are within the standard deviations, all weights being 1/s^2
  l_curve       // where smaller ones move values away from the guess without getting nearer to the observations
};

// Of the differences from observations that were held out.
struct HeldOut {
  std::size_t observed = 0;           // values
  double start_rms = 0.0, rms = 0.0;  // of the weighted differences, with the values at the start and those learned
  // Estimate of what it is with half the time step, learned with it, too (LearnedParameter::by_time_step); nan: not
  // known. If it is far less, the time step limits how well the motion is told, and not the model.
  double half_step_rms = std::numeric_limits<double>::quiet_NaN();
};

// What a search with one weight of the guess has found.
struct GuessPoint {
  double weight = 0.0;
  double rms = 0.0;       // of the weighted differences from the observations
  double distance = 0.0;  // rms of the changes from the guess, of the logarithm or relative, see guess_weight
};

// Whether what is left of the differences looks like noise.
struct FitQuality {
  // Of the motion that was observed, seen from where the network starts (of reactions: of their size; if points of the
  // surface alone were observed, of the differences with the values at the start): root of the sum of weighted squares.
  double share_of_motion = std::numeric_limits<double>::quiet_NaN();
  // Of the differences of a value from one observation to the next: near 0 for noise that is independent. nan: nothing
  // was observed often enough.
  double correlation_in_time = std::numeric_limits<double>::quiet_NaN();
  std::string warning{};  // what is wrong, and what to do; empty: nothing
};

struct LearnOptions {
  Optimiser optimiser = Optimiser::levenberg_marquardt;
  // Of the last stage of each start; of the stages before, and of each weight that a rule tries, at most 30 of them.
  int max_iterations = 100;
  // Values are learned from the first part of the motion at first, of which each stage doubles the length: later motion
  // depends on them so much that a search from far away ends at a wrong minimum. 1: at once from all.
  int stages = 4;
  double tolerance = 1e-10;  // relative: of the cost from iteration to iteration, of the step, of the gradient
  // Residuals sqrt(guess_weight) (x - x0) towards the values at the start, of the logarithm where that is searched by,
  // else relative to the value: what the data do not determine stays there. 0: none.
  double guess_weight = 0.0;
  // Bytes that the states of all motions may take, see MotionDerivatives::set_memory(); as many again for the first
  // stages, and for the motions at half the time step.
  std::size_t memory = std::size_t{1} << 30;
  // Searches, each through all stages; the best is kept. The first starts with the values of the network, the others
  // with each value times a factor at random, uniform in its logarithm from 1/start_factor to start_factor, within its
  // bounds; values of 0 stay. Where a motion fails there, the start is moved towards the first one.
  int starts = 1;
  double start_factor = 3.0;  // above 1
  std::uint64_t seed = 1;     // of the factors
  // Threads in all; 0: as many as the machine has. Experiments run side by side, simulations whose own number of
  // threads is open (0) share what is left. The results are the same, bit for bit.
  unsigned threads = 0;
  GuessRule guess_rule = GuessRule::given;  // another: guess_weight has no meaning
  // A penalty on jumps of the accelerations of nodes from one step to the next: their standard deviation, m/s^2, in
  // each direction. It counts in the search, not in rms and intervals, which are of what was observed. Infinite: it
  // does not matter.
  double smoothness = std::numeric_limits<double>::infinity();
  // Of more variables than have intervals (2000): products with the sensitivities, each of which takes about two
  // motions, from which singular values and LearnedParameter::from_guess are told. Each finds at most one more
  // direction that the data determine.
  int certainty_products = 60;
  // Called after each iteration; false ends the search with the best so far.
  std::function<bool(const LearnProgress&)> on_iteration{};
  // Before that, bytes with which learn() of the same experiments, learnables and options goes on there, to the same
  // bits as if it had not been disturbed, in this version on a machine of the same kind. It then throws Error(input)
  // for bytes that are damaged, and for other experiments, learnables or options, and says which.
  std::function<void(const std::string& state)> on_state{};
  std::string state{};  // to go on from; empty: the start
};

// A value that was learned.
struct LearnedParameter {
  LearnedValues::Kind kind{};
  bool of_elements = false;
  std::string parameter;     // as of LearnedValues
  std::uint32_t member = 0;  // spring, element or node
  int axis = -1;             // of an initial velocity
  // Which drive it, one after another: values of the same one are learned together, those of several in a field.
  std::size_t variable = 0, variables = 1;
  double start = 0.0, value = 0.0;
  // 95 % confidence interval of what the data alone say, from the residuals that are left; infinite where they
  // determine nothing. The guess, if it has a weight, may hold the value outside.
  double lower = 0.0, upper = 0.0;
  bool at_bound = false;
  bool is_outside = false;  // of its interval: the guess, smoothness or a bound holds it there
  // Share of the variable that the data determine, 1 to 0: what is missing lies in combinations that they do not; of
  // the combination of variables that the value of a field is.
  double determined = 1.0;
  bool has_influence = true;  // false: whatever the value is, what was observed would be the same
  // Share of the value that comes from the guess, 0 to 1: 1 less the diagonal of the resolution matrix. With more
  // variables than have intervals: at most so much.
  double from_guess = 0.0;
  // Estimate of what half the time step would add to the value: the share of the method's error in it.
  double by_time_step = 0.0;
  // Least and greatest of what those of several starts have found that are as good as the best one; nan: one start.
  double starts_lower = std::numeric_limits<double>::quiet_NaN();
  double starts_upper = std::numeric_limits<double>::quiet_NaN();
  // As of Learnable: the value was selected there; it is learned together with others as one variable.
  std::string body{};
  bool together = false;
};
// "spring.stiffness", "element.viscosity.damping", "velocity.x"
[[nodiscard]] SPRINGNET_API std::string name_of(const LearnedParameter& parameter);

// What a search from one of several starts has found.
struct LearnedStart {
  double start_cost = 0.0, cost = 0.0;  // nan: no motion near there succeeds
  int iterations = 0;                   // of all stages
  // Its cost is that of the best to 1 %, or to 1e-8 of the first start's.
  bool is_as_good = false;
  Eigen::VectorXd values;  // as of MotionDerivatives
  std::string reason;      // why it ended
};

struct LearnedNet {
  std::string method = "trajectory";  // or "online"
  std::vector<LearnedParameter> parameters;
  Eigen::VectorXd values;               // of all, as of MotionDerivatives
  double start_cost = 0.0, cost = 0.0;  // see LearnProgress
  double smooth_cost = 0.0;             // the part of smoothness in it
  double rms = 0.0;                     // of the weighted residuals of the observations
  std::size_t observed = 0;             // values
  std::size_t variables = 0;
  // Of the residuals by the variables, descending; with more variables than have intervals the greatest.
  std::vector<double> singular_values;
  std::size_t undetermined = 0;         // directions without influence
  double guess_weight = 0.0;            // given, or by the rule
  std::vector<GuessPoint> guess_curve;  // of the weights that the rule tried, the greatest first
  HeldOut held_out;
  FitQuality fit;
  std::vector<LearnProgress> history;  // of all stages of the best start, without values
  std::vector<LearnedStart> starts;    // none: there was one
  std::vector<LearnCourse> courses;    // of methods that were compared, see course_of(); none from learn() itself
  bool stopped = false;                // by on_iteration
  std::string reason;                  // why the search ended
  // An error that ended it early, after it had found better values than those at the start, or that left something
  // unknown: the values are the best until then. Empty: none.
  std::string failure;
  std::vector<std::string> notes;
};

// Throws Error(input) for observations, selections and nets that do not fit, and for a start whose motion fails;
// Error(simulation) if no step can be taken from there. Later errors are told in LearnedNet::failure.
[[nodiscard]] SPRINGNET_API LearnedNet learn(const std::vector<Experiment>& experiments,
                                             const std::shared_ptr<const PluginHost>& plugins,
                                             const std::vector<Learnable>& learnables,
                                             const LearnOptions& options = {});

struct OnlineOptions {
  // Above 0 to 1: share of the difference after a step that its gradient step would have taken away, at most.
  // Differences are those that earlier values left, too: learn slowly compared with what the motion forgets in a step,
  // or values swing.
  double rate = 0.05;
  std::size_t memory = std::size_t{1} << 30;  // bytes that sensitivities may take: 96 for each variable and node, about
};

// The paper's own method (section 3.5): the net learns while it moves, one gradient step after each time step, by
// real-time recurrent learning. Its error is that of a motion on which values have changed on the way; learn() is
// more accurate where a whole motion is at hand. The step is normalised (as in normalised LMS),
//     x <- x - rate S J^T r / (max |J|^2 + |r|^2),
// with the differences r after a step, their derivatives J by the variables x in units of their scale S, and the
// greatest |J| so far. So it is at most half of `rate` in these units: it cannot blow up where sensitivities are small
// beside noise, as at the beginning of a motion.
class SPRINGNET_API OnlineLearner {
 public:
  // Throws as learn(), and Error(input) if the sensitivities need more memory.
  OnlineLearner(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                const SimulationOptions& simulation, const std::vector<Learnable>& learnables,
                const OnlineOptions& options = {});
  ~OnlineLearner();
  OnlineLearner(OnlineLearner&&) noexcept;
  OnlineLearner& operator=(OnlineLearner&&) noexcept;
  OnlineLearner(const OnlineLearner&) = delete;
  OnlineLearner& operator=(const OnlineLearner&) = delete;

  // Makes a time step, and learns from what was observed in it: rows at times after its start, up to its end; may be
  // empty. Returns 1/2 sum of the weighted squares of the differences. Throws Error(input) for other times and as
  // check_observations(), Error(simulation) if the step fails or cannot be differentiated.
  double step(const Observations& seen);

  [[nodiscard]] double time() const noexcept;                    // s, of the last state
  [[nodiscard]] const Eigen::VectorXd& values() const noexcept;  // as of MotionDerivatives
  // What drives them, each by itself or by its logarithm.
  [[nodiscard]] const Eigen::VectorXd& variables() const noexcept;

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

// The same over the motion of one experiment, once. The result has no intervals; its cost is that of the values at the
// end, over the whole motion; `history` has the costs of the steps with observations.
[[nodiscard]] SPRINGNET_API LearnedNet learn_online(const Experiment& experiment,
                                                    const std::shared_ptr<const PluginHost>& plugins,
                                                    const std::vector<Learnable>& learnables,
                                                    const OnlineOptions& options = {},
                                                    const std::function<bool(const LearnProgress&)>& on_step = {});

// The course of learn() or learn_online() through what they have told, with values: of the first start. Simulates the
// whole motion for each.
[[nodiscard]] SPRINGNET_API LearnCourse course_of(const std::string& method, const std::vector<LearnProgress>& told,
                                                  const Experiment& experiment,
                                                  const std::shared_ptr<const PluginHost>& plugins,
                                                  const std::vector<Learnable>& learnables,
                                                  const LearnOptions& options = {});

// The values of the network that are learned, in the order of MotionDerivatives.
[[nodiscard]] SPRINGNET_API Eigen::VectorXd values_in(const std::shared_ptr<const Network>& network,
                                                      const std::shared_ptr<const PluginHost>& plugins,
                                                      const std::vector<Learnable>& learnables);
// The network with values that were learned.
[[nodiscard]] SPRINGNET_API Network with_values(const std::shared_ptr<const Network>& network,
                                                const std::shared_ptr<const PluginHost>& plugins,
                                                const std::vector<Learnable>& learnables,
                                                const Eigen::VectorXd& values);

[[nodiscard]] SPRINGNET_API std::string to_json(const LearnedNet& learned);

}  // namespace springnet
