// Every mistake of an integrator is found by its own check first.
#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "check/check.hpp"
#include "check/heap.hpp"

using namespace springnet;
using check::Result;

namespace {

check::Report integrator_report(const std::string& name, double seconds = 60.0, const std::string& only = {}) {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  check::Options options;
  options.seed = 11;
  options.limits.seconds = seconds;
  options.only = only;
  options.host = host;
  return check::check_file(BROKEN "/" + name + ".springnet" LIBRARY_SUFFIX, options);
}

}  // namespace

TEST_CASE("an integrator without a mistake passes") {
  const check::Report report = integrator_report("right_integrator");
  CHECK(report.findings.size() == 13);
  for (const check::Finding& finding : report.findings) {
    CAPTURE(finding.check);
    CAPTURE(finding.outcome.why);
    CHECK(finding.outcome.result == Result::passed);
  }
}

TEST_CASE("each mistake of an integrator fails its own check first") {
  struct Case {
    const char *name, *check, *part;
  };
  for (const Case& each : {
           Case{"order", "order", "closed form"},
           Case{"momentum", "momentum", "momentum"},
           Case{"states", "states", "Maxwell"},
           Case{"events", "events", "at the end of a step"},
           Case{"contact", "contact", "plane"},
           Case{"rigid", "rigid", "rod"},
           Case{"refusals", "refusals", "takes more than 3 s"},
           Case{"silent", "refusals", "without saying why"},
           Case{"option", "options", "parts = 0"},
           Case{"repeats", "repeats", "two runs"},
           Case{"threads", "repeats", "threads"},
           Case{"forget", "memory", "`forget`"},
           Case{"save", "memory", "saved memory"},
           Case{"restore", "memory", "`restore` takes"},
           Case{"steps", "leaks", "each step keeps"},
           Case{"lives", "leaks", "each instance leaves"},
       }) {
    CAPTURE(std::string(each.name));
    if (std::string(each.check) == "leaks" && !check::heap_in_use()) continue;
    const bool hangs = std::string(each.name) == "refusals";
    const check::Report report =
        integrator_report(std::string("integrator_") + each.name, hangs ? 3.0 : 60.0, hangs ? each.check : "");
    const auto bad = std::find_if(report.findings.begin(), report.findings.end(),
                                  [](const check::Finding& finding) { return check::is_bad(finding.outcome.result); });
    REQUIRE(bad != report.findings.end());
    CAPTURE(bad->outcome.why);
    CHECK(bad->check == each.check);
    CHECK(bad->outcome.why.find(each.part) != std::string::npos);
  }
}
