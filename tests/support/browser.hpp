// Opens pages in a headless Chromium (SPRINGNET_CHROMIUM).
#pragma once

#include <cstdlib>
#include <sstream>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "csv.hpp"
#include "temporary_folder.hpp"

namespace springnet::testing {

struct Visit {
  int status;
  std::string dom, log;
};

// The self-test gets 25 s of the browser's virtual clock: on a busy machine it waits long for a picture.
// --no-sandbox: tests run as root in containers. swiftshader: there is no graphics card.
inline Visit visit(const TemporaryFolder& folder, const std::string& address, const std::string& action) {
  const int time_budget = address.find("selftest") == std::string::npos ? 4000 : 25000;  // ms
  const std::string line =
      fmt::format("cd '{}' && timeout 120 '" SPRINGNET_CHROMIUM
                  "' --headless --no-sandbox --enable-unsafe-swiftshader --disable-quic --no-first-run "
                  "--disable-background-networking --disable-component-update --disable-sync --disable-extensions "
                  "--hide-scrollbars --window-size=1280,800 --user-data-dir=profile --virtual-time-budget={} "
                  "--enable-logging=stderr --v=0 {} '{}' > dom.txt 2> log.txt",
                  folder.path().string(), time_budget, action, address);
  const int status = std::system(line.c_str());
  return {status, read_text(folder.path() / "dom.txt"), read_text(folder.path() / "log.txt")};
}

inline nlohmann::json element(const std::string& dom, const std::string& id) {
  const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t begin = dom.find(start);
  REQUIRE_MESSAGE(begin != std::string::npos, "no ", id, " in the page");
  const std::size_t text = begin + start.size();
  return nlohmann::json::parse(dom.substr(text, dom.find("</script>", text) - text));
}

// Messages on the browser's console (errors, warnings, refused requests), except that software rendering is slow.
inline std::string console(const std::string& log) {
  std::istringstream lines(log);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    if (line.find(":CONSOLE") == std::string::npos || line.find("GL Driver Message") != std::string::npos) continue;
    found += line + "\n";
  }
  return found;
}

}  // namespace springnet::testing
