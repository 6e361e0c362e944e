// Plugins as files: what is accepted, what is refused and with which words, and where files are searched.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#if defined(__linux__)
#include <link.h>
#endif
#include <sys/stat.h>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>

#include "child.hpp"
#include "facts.hpp"
#include "temporary_folder.hpp"

namespace fs = std::filesystem;
using springnet::ComponentKind;
using springnet::PluginHost;
using springnet::testing::has;

namespace {

const fs::path fixtures = FIXTURES;

fs::path fixture(const std::string& name) { return fixtures / name / (name + ".springnet" LIBRARY_SUFFIX); }

// An environment variable for the time of a test.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) { setenv(name, value.c_str(), 1); }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

}  // namespace

TEST_CASE("a good plugin offers its components, with where they come from") {
  PluginHost host;
  REQUIRE(host.load(fixture("good")));
  CHECK(host.refusals().empty());
  REQUIRE(host.components().size() == 1);
  const auto component = host.find(ComponentKind::spring_function, "fixture");
  REQUIRE(component != nullptr);
  CHECK(component->kind() == ComponentKind::spring_function);
  CHECK(component->file == fixture("good"));
  CHECK(std::string(component->plugin->version) == "1.2.3");
  CHECK(component->law().invariant == SPRINGNET_LENGTH);

  const double length = 2.5;
  double force = 0;
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.q = &length;
  batch.force = &force;
  CHECK(component->law().evaluate(component->law().context, &batch) == SPRINGNET_OK);
  CHECK(force == 2.5);
}

TEST_CASE("pipes, devices and sockets are refused, not opened") {
  const springnet::testing::TemporaryFolder folder;
  const std::string ending = ".springnet" LIBRARY_SUFFIX;
  REQUIRE(mkfifo((folder.path() / ("pipe" + ending)).c_str(), 0600) == 0);
  fs::create_symlink("/dev/zero", folder.path() / ("zero" + ending));
  fs::create_symlink("pipe" + ending, folder.path() / ("link" + ending));
  fs::create_symlink("loop" + ending, folder.path() / ("loop" + ending));
  fs::create_symlink("nowhere" + ending, folder.path() / ("dangling" + ending));
  const std::string reasons = springnet::testing::in_child([&] {
    PluginHost host;
    host.search(folder.path());
    std::string text = host.components().empty() ? "" : "taken";
    for (const springnet::Refusal& refusal : host.refusals())
      text += refusal.file.filename().string() + ": " + refusal.reason + "\n";
    return text;
  });
  CAPTURE(reasons);
  CHECK(has(reasons, "dangling" + ending + ": cannot be opened"));
  CHECK(has(reasons, "link" + ending + ": cannot be loaded as a library (it is a named pipe)"));
  CHECK(has(reasons, "loop" + ending + ": cannot be opened"));
  CHECK(has(reasons, "zero" + ending + ": cannot be loaded as a library (it is a device)"));
  CHECK_FALSE(has(reasons, "pipe" + ending));  // looked at already, behind the link
}

TEST_CASE("a plugin that was copied in part is refused, wherever it ends") {
  const springnet::testing::TemporaryFolder folder;
  const std::string whole = springnet::testing::read_text(fixture("good"));
  const fs::path copy = folder.path() / ("copy.springnet" LIBRARY_SUFFIX);
  std::size_t refused = 0;
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{63}, std::size_t{100}, std::size_t{900},
                                  std::size_t{3000}, std::size_t{5000}, whole.size() / 2, whole.size() - 1}) {
    folder.write(copy.filename().string(), whole.substr(0, bytes));
    // It may be accepted if nothing that is mapped is missing.
    const std::string reason = springnet::testing::in_child([&] {
      PluginHost host;
      return host.load(copy) ? std::string() : host.refusals()[0].reason;
    });
    CAPTURE(bytes);
    CAPTURE(reason);
    CHECK((reason.empty() || has(reason, "cannot be loaded as a library (")));
    refused += reason.empty() ? 0 : 1;
  }
  CHECK(refused >= 4);
}

TEST_CASE("a plugin of a later minor version, whose structs have grown, is accepted") {
  PluginHost host;
  CHECK(host.load(fixture("newer")));
  CHECK(host.find(ComponentKind::spring_function, "fixture") != nullptr);
}

TEST_CASE("every file that is not a plugin is refused with the reason and the remedy") {
  struct Case {
    std::string name;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases{
      {"text", {"cannot be loaded as a library", "complete library"}},
      {"empty", {"cannot be loaded as a library (file too short)", "complete library"}},
      {"folder", {"cannot be loaded as a library (it is a folder)"}},
      {"missing_symbol", {"(undefined symbol: springnet_fixture_nowhere)", "linked with"}},
      {"no_entry", {"no symbol springnet_plugin_entry", "export it"}},
      {"other_magic", {"magic number", "SDK"}},
      {"other_major", {"plugin ABI 1.", "reads 2.x", "rebuild the plugin"}},
      {"smaller_struct", {"has 48 bytes", "needs 72", "rebuild the plugin"}},
      {"out_of_range", {"'stiffness'", "default must be at least 0 N/m, is -1", "correct default or bounds"}},
  };
  for (const Case& c : cases) {
    CAPTURE(c.name);
    PluginHost host;
    CHECK_FALSE(host.load(fixture(c.name)));
    CHECK(host.components().empty());
    REQUIRE(host.refusals().size() == 1);
    CHECK(host.refusals()[0].file == fixture(c.name));
    CAPTURE(host.refusals()[0].reason);
    for (const std::string& word : c.words) CHECK(has(host.refusals()[0].reason, word));
  }
}

TEST_CASE("a file without a note of this ABI is refused before it is opened: its constructors do not run") {
  struct Case {
    std::string name;
    std::vector<std::string> words;
  };
  const std::vector<Case> cases{
      {"no_note", {"it has no note", "was not opened", "rebuild the plugin"}},
      {"foreign_note", {"it has no note", "was not opened"}},
      {"damaged_note", {"it has no note", "was not opened"}},
      {"earlier_note", {"built for plugin ABI 1.", "reads 2.x", "or use a springnet of ABI 1"}},
      {"later_note", {"built for plugin ABI 3.", "reads 2.x", "or use a springnet of ABI 3"}},
      {"needy_note", {"it needs plugin ABI 2.7", "use a newer springnet, or rebuild the plugin with the SDK"}},
  };
  const char* const trace = "SPRINGNET_FIXTURE_CONSTRUCTED";
  unsetenv(trace);
  for (const Case& c : cases) {
    CAPTURE(c.name);
    PluginHost host;
    CHECK_FALSE(host.load(fixture(c.name)));
    CHECK(std::getenv(trace) == nullptr);
    REQUIRE(host.refusals().size() == 1);
    CAPTURE(host.refusals()[0].reason);
    for (const std::string& word : c.words) CHECK(has(host.refusals()[0].reason, word));
  }
  // Of a file with its note they do.
  PluginHost host;
  CHECK(host.load(fixture("constructed")));
  CHECK(std::getenv(trace) != nullptr);
  unsetenv(trace);
}

#if defined(__linux__)
TEST_CASE("a file whose segments are the same millions of notes is refused at once") {
  constexpr std::size_t segments = 60'000, notes = 1'200'000;
  ElfW(Ehdr) header{};
  std::copy_n(ELFMAG, SELFMAG, header.e_ident);
  header.e_ident[EI_CLASS] = ELFCLASS64;
  header.e_phoff = sizeof header;
  header.e_phentsize = sizeof(ElfW(Phdr));
  header.e_phnum = segments;
  ElfW(Phdr) segment{};
  segment.p_type = PT_NOTE;
  segment.p_offset = sizeof header + segments * sizeof segment;
  segment.p_filesz = notes;
  const springnet::testing::TemporaryFolder folder;
  const fs::path file = folder.path() / "notes.springnet.so";
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(&header), sizeof header);
  for (std::size_t k = 0; k < segments; ++k) out.write(reinterpret_cast<const char*>(&segment), sizeof segment);
  out << std::string(notes, '\0');
  out.close();
  PluginHost host;
  const auto start = std::chrono::steady_clock::now();
  CHECK_FALSE(host.load(file));
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(20));  // an hour if it read all of them
  REQUIRE(host.refusals().size() == 1);
  CHECK(has(host.refusals()[0].reason, "it has no note"));
}
#endif

TEST_CASE("a file that is not there is refused") {
  PluginHost host;
  CHECK_FALSE(host.load(fixtures / "nowhere.springnet.so"));
  REQUIRE(host.refusals().size() == 1);
  CHECK(has(host.refusals()[0].reason, "cannot be opened (No such file"));
}

TEST_CASE("of two files with a plugin of one id the first is kept") {
  PluginHost host;
  REQUIRE(host.load(fixture("good")));
  CHECK_FALSE(host.load(fixture("same_id")));
  CHECK(host.components().size() == 1);
  const std::string reason = host.refusals().back().reason;
  CAPTURE(reason);
  CHECK(has(reason,
            "spring function 'fixture' is already provided by a plugin of the same id, "
            "org.example.fixture 1.2.3"));
  CHECK(has(reason, fixture("good").string()));
  CHECK(has(reason, "remove one of the two"));

  // The other way round it is the other one that is kept.
  PluginHost reverse;
  REQUIRE(reverse.load(fixture("same_id")));
  CHECK_FALSE(reverse.load(fixture("good")));
  CHECK(std::string(reverse.components()[0]->plugin->version) == "2.0.0");
}

TEST_CASE("plugins of two ids may offer the same component; one that names it says whose") {
  PluginHost host;
  REQUIRE(host.load(fixture("good")));
  REQUIRE(host.load(fixture("same_component")));
  CHECK(host.refusals().empty());
  CHECK(host.components().size() == 2);
  CHECK_THROWS_WITH_AS(static_cast<void>(host.find(ComponentKind::spring_function, "fixture")),
                       doctest::Contains("'fixture@org.example.fixture' or 'fixture@org.example.rival'"),
                       springnet::Error);
  CHECK(host.require(ComponentKind::spring_function, "fixture@org.example.fixture")->file == fixture("good"));
  CHECK(host.require(ComponentKind::spring_function, "fixture@org.example.rival")->file == fixture("same_component"));
}

TEST_CASE("the same file twice is one plugin, and no refusal") {
  PluginHost host;
  CHECK(host.load(fixture("good")));
  CHECK(host.load(fixtures / "good" / ".." / "good" / fixture("good").filename()));
  CHECK(host.components().size() == 1);
  CHECK(host.refusals().empty());
}

TEST_CASE("components outlive the host that loaded them") {
  std::shared_ptr<const springnet::Component> component;
  {
    PluginHost host;
    host.load(fixture("good"));
    component = host.find(ComponentKind::spring_function, "fixture");
  }
  REQUIRE(component != nullptr);
  CHECK(component->id() == "fixture");
  springnet_law_batch nothing{};
  nothing.struct_size = sizeof nothing;
  CHECK(component->law().evaluate(component->law().context, &nothing) == SPRINGNET_OK);
}

TEST_CASE("a folder: files by name, other endings ignored, a missing folder recorded") {
  PluginHost host;
  host.search(fixtures / "other_ending");
  CHECK(host.refusals().empty());
  host.search(fixtures / "good");
  host.search(fixtures / "good" / ".");
  CHECK(host.components().size() == 1);
  CHECK(host.refusals().empty());
  host.search(fixtures / "text");
  host.search(fixtures / "text");  // not looked at twice
  CHECK(host.refusals().size() == 1);
  host.search(fixtures / "nowhere");
  REQUIRE(host.refusals().size() == 2);
  CHECK(host.refusals()[1].file == fixtures / "nowhere");
  CHECK(has(host.refusals()[1].reason, "folder cannot be read"));
}

TEST_CASE("default search: folders given, then SPRINGNET_PLUGIN_PATH, then the library's own") {
  const Environment path("SPRINGNET_PLUGIN_PATH", (fixtures / "good").string() + "::" + (fixtures / "text").string());
  const PluginHost host = PluginHost::with_default_search({fixtures / "same_id"});
  const auto fixture_law = host.find(ComponentKind::spring_function, "fixture");
  REQUIRE(fixture_law != nullptr);
  CHECK(std::string(fixture_law->plugin->version) == "2.0.0");  // the folder given came first
  const auto refused = [&](const fs::path& file) {
    return std::any_of(host.refusals().begin(), host.refusals().end(),
                       [&](const springnet::Refusal& refusal) { return refusal.file == file; });
  };
  CHECK(refused(fixture("good")));
  CHECK(refused(fixture("text")));

  const auto linear = host.find(ComponentKind::spring_function, "linear");
  REQUIRE(linear != nullptr);
  CHECK(linear->file.parent_path().filename() == "plugins");
  CHECK(linear->file.parent_path().parent_path().filename() == "springnet");
}

TEST_CASE("the plugins of springnet are loaded without a refusal") {
  const PluginHost host = PluginHost::with_default_search();
  for (const springnet::Refusal& refusal : host.refusals()) MESSAGE(refusal.file.string(), ": ", refusal.reason);
  CHECK(host.refusals().empty());
  for (const char* id : {"linear", "nonlinear", "exponential", "rupturing"}) {
    CHECK_MESSAGE(host.find(ComponentKind::spring_function, id) != nullptr, id);
  }
  for (const char* id : {"linear", "relative", "power"}) {
    CHECK_MESSAGE(host.find(ComponentKind::viscosity_function, id) != nullptr, id);
  }
  for (const char* id : {"point_mass", "dragged"}) {
    CHECK_MESSAGE(host.find(ComponentKind::neuron, id) != nullptr, id);
  }
  for (const char* id : {"recurrent", "cvode"}) {
    CHECK_MESSAGE(host.find(ComponentKind::integrator, id) != nullptr, id);
  }
}

TEST_CASE("the working directory is never searched") {
  const fs::path before = fs::current_path();
  fs::current_path(fixtures / "good");
  const Environment path("SPRINGNET_PLUGIN_PATH", ":.:");
  const PluginHost host = PluginHost::with_default_search();
  fs::current_path(before);
  CHECK(host.find(ComponentKind::spring_function, "fixture") == nullptr);
  REQUIRE(host.refusals().size() == 1);
  CHECK(host.refusals()[0].file == ".");
  CHECK(has(host.refusals()[0].reason, "absolute path"));
}

TEST_CASE("an unknown component: nearest names, all known ones, and refused files") {
  PluginHost host;
  host.load(fixture("good"));
  host.load(fixture("other_major"));
  CHECK(host.require(ComponentKind::spring_function, "fixture") != nullptr);
  std::string message;
  try {
    static_cast<void>(host.require(ComponentKind::spring_function, "fixtrue"));
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::plugin);
    message = error.what();
  }
  CAPTURE(message);
  CHECK(has(message, "there is no spring function 'fixtrue'; did you mean 'fixture'?"));
  CHECK(has(message, fixture("other_major").string() + ": built for plugin ABI 1."));

  try {
    static_cast<void>(host.require(ComponentKind::neuron, "fixture"));
    message.clear();
  } catch (const springnet::Error& error) {
    message = error.what();
  }
  CAPTURE(message);
  CHECK(has(message, "'fixture' is a spring function"));
  CHECK(has(message, "SPRINGNET_PLUGIN_PATH"));
}

TEST_CASE("an unknown component of a plugin that is named: the plugins that have it, and where was searched") {
  PluginHost host;
  host.search(fixtures / "good");
  host.search(fixtures / "good" / ".");
  CHECK_THROWS_WITH_AS(
      static_cast<void>(host.require(ComponentKind::spring_function, "fixture@org.example.wrong")),
      ("there is no spring function 'fixture@org.example.wrong'; did you mean 'fixture@org.example.fixture'? known: "
       "fixture\nSearched: " +
       (fixtures / "good").string() + " (1 plugin file)")
          .c_str(),
      springnet::Error);
}
