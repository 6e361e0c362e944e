#include "failure_text.hpp"

#include <sstream>

#include "sundials.hpp"

namespace springnet::cvode {

std::string failure_text(const FailureFacts& facts, const Settings& settings) {
  std::ostringstream text;
  text.precision(9);
  text << "cvode stopped at t = " << facts.time << " s: ";
  switch (facts.flag) {
    case CV_TOO_MUCH_WORK:
      text << settings.max_steps << " internal steps were not enough (the last one was " << facts.last_step
           << " s long). Raise max_steps or relative_tolerance, or look for a spring that is much stiffer or a node "
              "that is much lighter than the others";
      if (settings.method == Method::adams) text << "; for stiff networks choose method = \"bdf\"";
      break;
    case creeping:
      text << "its steps became too short to advance the time (the last one was " << facts.last_step
           << " s long). Look at what moves, holds or pulls the nodes at that time";
      break;
    case CV_TOO_MUCH_ACC:
      text << "the tolerances are finer than the rounding error of the numbers. Raise relative_tolerance, "
              "position_tolerance "
              "or velocity_tolerance, or move the network nearer to the origin";
      break;
    case CV_ERR_FAILURE:
      text << "no step is short enough for the tolerances (the last one was " << facts.last_step
           << " s long): the forces jump or grow without bound there. Look at the springs, loads and rigid connections "
              "at that time, or raise relative_tolerance";
      break;
    case CV_CONV_FAILURE:
      text << "the equations of a step could not be solved, even for the shortest (the last one was " << facts.last_step
           << " s long). Look for springs whose derivatives are wrong or jump, or try linear_solver = \"direct\"";
      break;
    case CV_FIRST_RHSFUNC_ERR:
      text << "the forces are not finite in the state that the step starts from";
      break;
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
      text << "the forces are not finite there, even for the shortest step";
      break;
    case CV_RHSFUNC_FAIL:
      text << "the forces could not be evaluated";
      break;
    case CV_RTFUNC_FAIL:
      text << "contacts and ruptures could not be evaluated";
      break;
    case CV_PROJ_MEM_NULL:
    case CV_PROJFUNC_FAIL:
    case CV_REPTD_PROJFUNC_ERR:
      text << "rigid connections, or surfaces that nodes slide on, could not be satisfied";
      break;
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
      text << "the linear system of a step could not be solved";
      break;
    default:
      text << (facts.cvode_message.empty() ? "no reason is known" : facts.cvode_message) << " (CVODE " << facts.flag
           << ")";
      return text.str();
  }
  if (!facts.reason.empty()) text << ". The last failure: " << facts.reason;
  return text.str();
}

}  // namespace springnet::cvode
