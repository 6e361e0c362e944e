// Loads plugins and scenes in a supervised process, which checks them and tells what it finds by a pipe. It is started
// again without a plugin of the search path that ends it.
#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/plugin_search.hpp>
#include <springnet/printable.hpp>

#include "check/check.hpp"

namespace springnet::check {
namespace {

namespace fs = std::filesystem;

// ---- Messages: six texts each, "4:load3:abc…", the first of which says what it is.

using Message = std::array<std::string, 6>;
constexpr const char *loading = "loading", *loaded = "loaded", *found = "found", *unusable = "unusable",
                     *trouble = "trouble";

void send(const Message& message) {
  std::string bytes;
  for (const std::string& text : message) bytes += fmt::format("{}:{}", text.size(), text);
  tell(bytes);
}
void send(const char* what, const Finding& finding) {
  send({what, finding.component, finding.kind, finding.check,
        fmt::format("{}", static_cast<unsigned>(finding.outcome.result)), finding.outcome.why});
}

unsigned number_of(std::string_view text) {
  unsigned number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}
Finding finding_of(const Message& message) {
  const auto result = static_cast<Result>(std::min(number_of(message[4]), static_cast<unsigned>(Result::skipped)));
  return {message[1], message[2], message[3], {result, message[5]}};
}

// The complete ones.
std::vector<Message> messages_of(std::string_view bytes) {
  std::vector<Message> messages;
  while (true) {
    Message message;
    for (std::string& text : message) {
      const std::size_t colon = bytes.find(':');
      const std::size_t size = number_of(bytes.substr(0, colon));
      if (colon == std::string_view::npos || size > bytes.size() - colon - 1) return messages;
      text = bytes.substr(colon + 1, size);
      bytes.remove_prefix(colon + 1 + size);
    }
    messages.push_back(std::move(message));
  }
}

// ---- In the supervised process.

Finding finding_of(const fs::path& file, const Outcome& outcome) {
  return {printable(file.filename().string()), "plugin", "load", {outcome.result, printable_message(outcome.why)}};
}

// Of this process; 1 where the system does not say.
std::ptrdiff_t thread_count() {
  std::error_code unknown;
  const fs::directory_iterator threads("/proc/self/task", unknown);
  return unknown ? 1 : std::distance(begin(threads), end(threads));
}

// Loads a file into the host; false: it must not be used, which has been told. Checks run in forks of this process,
// which a thread of the plugin would not follow.
bool load(PluginHost& host, const fs::path& file, bool is_target) {
  send({loading, file.string()});
  now_doing(fmt::format("{} is loaded", printable(file.filename().string())).c_str());
  const std::ptrdiff_t before = thread_count();
  const bool is_usable = host.load(file);
  if (const std::ptrdiff_t more = thread_count() - before; more > 0) {
    const std::string why = fmt::format(
        "loading it starts {} thread{}: start them in a call, so that a program that only lists plugins "
        "has none",
        more, more == 1 ? "" : "s");
    send(unusable, finding_of(file, {Result::failed, why}));
    return false;
  }
  if (!is_usable && is_target) {
    send(unusable, finding_of(file, {Result::failed, host.refusals().back().reason}));
    return false;
  }
  send({loaded, file.string()});
  return true;
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code unknown;
  return a == b || fs::equivalent(a, b, unknown);
}

using Files = std::vector<fs::path>;
bool contains(const Files& files, const fs::path& file) {
  return std::any_of(files.begin(), files.end(), [&](const fs::path& each) { return is_same_file(each, file); });
}

// Null: a plugin must not be used.
std::shared_ptr<const PluginHost> search(const Options& options, const Files& left_out) {
  PluginHost one_by_one;
  for (const fs::path& file : plugin_files(options.folders))
    if (!contains(left_out, file) && !load(one_by_one, file, false)) return nullptr;
  // Its messages know what was searched.
  if (left_out.empty()) return std::make_shared<const PluginHost>(PluginHost::with_default_search(options.folders));
  return std::make_shared<const PluginHost>(std::move(one_by_one));
}

std::vector<std::shared_ptr<const Component>> components_named(const Target& target, const PluginHost& host) {
  std::vector<std::shared_ptr<const Component>> components;
  for (const auto& component : host.components()) {
    if (target.kind && component->kind() != *target.kind) continue;
    if (component->id() == target.name || fmt::format("{}@{}", component->id(), component->plugin->id) == target.name)
      components.push_back(component);
  }
  if (components.empty())
    throw Error(ErrorKind::plugin,
                fmt::format("there is no component '{}'{}{}, and no file of this name; 'springnet plugin list' lists "
                            "all components",
                            printable(target.name), target.kind ? " of the kind " : "",
                            target.kind ? name_of(*target.kind) : ""));
  return components;
}

void check_here(const Target& target, Options options, const Files& left_out) {
  if (options.host == nullptr) options.host = search(options, left_out);
  if (options.host == nullptr) return;
  const Listener listener = [](const Finding& finding) { send(found, finding); };
  switch (target.what) {
    case Target::What::file: {
      PluginHost host;
      if (load(host, target.name, true)) check_components(host.components(), options, listener);
      break;
    }
    case Target::What::scene: {
      now_doing("the scene is loaded");
      check_laws_of(target.read(target.name, *options.host), options, listener);
      break;
    }
    case Target::What::component:
      check_components(components_named(target, *options.host), options, listener);
  }
}

// ---- In the caller.

// What the supervised process has told.
struct Told {
  End end;
  std::vector<Finding> findings;
  std::optional<Finding> refused;  // the file that was loaded last must not be used
  std::optional<Error> error;
  Files files;         // that were loaded
  fs::path last_file;  // that it began to load
};
Told converse(const Target& target, const Options& options, const Files& left_out) {
  const auto body = [&] {
    try {
      check_here(target, options, left_out);
    } catch (const Error& error) {
      send({trouble, fmt::format("{}", static_cast<unsigned>(error.kind())), error.what()});
    } catch (const std::exception& error) {
      send({trouble, fmt::format("{}", static_cast<unsigned>(ErrorKind::simulation)), error.what()});
    }
  };
  Told told;
  told.end = supervise(body, options.limits.seconds, "the plugin");
  for (const Message& message : messages_of(told.end.told)) {
    if (message[0] == found) told.findings.push_back(finding_of(message));
    if (message[0] == unusable) told.refused = finding_of(message);
    if (message[0] == trouble) told.error = Error(static_cast<ErrorKind>(number_of(message[1])), message[2]);
    if (message[0] == loading) told.last_file = message[1];
    if (message[0] == loaded) told.files.push_back(message[1]);
  }
  const bool fails_to_load = is_bad(told.end.outcome.result) && !told.last_file.empty() &&
                             (told.files.empty() || told.files.back() != told.last_file);
  if (!told.refused && fails_to_load) told.refused = finding_of(told.last_file, told.end.outcome);
  return told;
}

// Who ends the process after all checks: each file alone, in a process of its own.
std::vector<Finding> with_wrong_destructors(const Files& files, const Outcome& together, const Options& options) {
  std::vector<Finding> findings;
  for (const fs::path& file : files) {
    const auto load_alone = [&file] { static_cast<void>(PluginHost().load(file)); };
    const End end = supervise(load_alone, options.limits.seconds, "the plugin");
    if (is_bad(end.outcome.result)) findings.push_back(finding_of(file, end.outcome));
  }
  if (findings.empty()) findings.push_back(finding_of(files.empty() ? fs::path("?") : files.back(), together));
  return findings;
}

// What went wrong outside of the checks.
std::vector<Finding> faults_of(const Target& target, const Told& told, const Options& options) {
  const End& end = told.end;
  if (!is_bad(end.outcome.result)) return {};
  if (end.was_leaving) return with_wrong_destructors(told.files, end.outcome, options);
  if (!end.component.empty())
    return {{printable(end.component),
             printable(end.kind),
             "load",
             {end.outcome.result, printable_message(end.outcome.why)}}};
  return {finding_of(target.name, end.outcome)};
}

}  // namespace

Report check_target(const Target& target, const Options& options) {
  Report report{options.seed, true, {}};
  const auto add = [&report](const std::vector<Finding>& findings) {
    report.findings.insert(report.findings.end(), findings.begin(), findings.end());
  };
  Files left_out;
  while (true) {
    const Told told = converse(target, options, left_out);
    if (told.refused) {
      report.loaded = false;
      add({*told.refused});
      if (target.what == Target::What::file && is_same_file(target.name, told.last_file)) return report;
      if (contains(left_out, told.last_file)) return report;
      left_out.push_back(told.last_file);
      continue;
    }
    add(told.findings);
    add(faults_of(target, told, options));
    if (!told.error) return report;
    if (report.findings.empty()) throw *told.error;
    report.loaded = false;
    add({{printable(target.name),
          target.what == Target::What::scene ? "scene" : "component",
          "load",
          {Result::failed, printable_message(told.error->what())}}});
    return report;
  }
}

}  // namespace springnet::check
