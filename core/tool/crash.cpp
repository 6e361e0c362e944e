#include "crash.hpp"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include <springnet/calling_threads.hpp>
#include <springnet/current_call.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/printable.hpp>
#include <springnet/whole_records.hpp>

#include "check/signal_name.hpp"

namespace springnet::tool {

namespace {

struct CrashSignal {
  int number;
  std::string_view meaning;
};
constexpr CrashSignal crash_signals[] = {{SIGSEGV, "access to memory that is not its own"},
                                         {SIGBUS, "access to memory that is not there"},
                                         {SIGFPE, "a division of integers by 0 or the like"},
                                         {SIGILL, "an invalid instruction"},
                                         {SIGABRT, "it called abort()"}};

// Fixed memory: a handler must not allocate.
constexpr std::size_t longest_folder = 1024;
char crash_folder[longest_folder];
bool on_terminal = false;  // then the line of progress is not ended
std::atomic<bool> crashing{false};

// One line, cut off where it is too long.
class CrashLine {
 public:
  void add(std::string_view text) noexcept {
    const std::size_t size = std::min(text.size(), sizeof text_ - 1 - size_);
    std::memcpy(text_ + size_, text.data(), size);
    size_ += size;
  }
  // Of a plugin's author or a file's name.
  void add_foreign(const char* text) noexcept {
    for (std::size_t k = 0; text[k] != '\0' && k < 400; ++k) {
      const auto byte = static_cast<unsigned char>(text[k]);
      add(byte < 0x20 || byte == 0x7f ? std::string_view("?") : std::string_view(text + k, 1));
    }
  }
  void add_number(std::uint32_t number) noexcept {
    char digits[10];
    std::size_t first = sizeof digits;
    do digits[--first] = static_cast<char>('0' + number % 10);
    while ((number /= 10) > 0);
    add({digits + first, sizeof digits - first});
  }
  void print() noexcept {
    text_[size_++] = '\n';
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text_, size_);
  }

 private:
  char text_[4096];
  std::size_t size_ = 0;
};

// "springs 3, 4, 5 and 125 more"
void add_members(CrashLine& line, const CalledMembers& members) noexcept {
  constexpr std::uint32_t most = 8, none = 0xffffffffu;
  if (members.numbers == nullptr) return;
  switch (members.are) {
    case CalledMembers::Are::springs:
      line.add(", called for springs ");
      break;
    case CalledMembers::Are::elements:
      line.add(", called for elements ");
      break;
    case CalledMembers::Are::springs_of_nodes:
      line.add(", called for springs of nodes ");
      break;
    case CalledMembers::Are::nodes_from:
      line.add(", called for nodes from number ");
      break;
    default:
      return;
  }
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < members.count; ++i) {
    const std::uint32_t number = members.number(i);
    if (number == none || ++count > most) continue;
    if (count > 1) line.add(", ");
    line.add_number(number);
  }
  if (count <= most) return;
  line.add(" and ");
  line.add_number(count - most);
  line.add(" more");
}

// "spring function 'linear' of plugin org.springnet.laws (/usr/lib/…)"
void add_component(CrashLine& line, const Component& component) noexcept {
  line.add(name_of(component.kind()));
  line.add(" '");
  line.add_foreign(component.description->id);
  line.add("' of plugin ");
  line.add_foreign(component.plugin->id);
  if (component.file.empty()) return;
  line.add(" (");
  line.add_foreign(component.file.c_str());
  line.add(")");
}

// "SIGABRT, it called abort()"
void add_signal(CrashLine& line, int signal) noexcept {
  line.add(check::signal_name(signal));
  for (const CrashSignal& each : crash_signals) {
    if (each.number != signal) continue;
    line.add(", ");
    line.add(each.meaning);
  }
}

void end_by(int signal) noexcept {
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  sigaction(signal, &action, nullptr);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  raise(signal);
}

// Async-signal-safe functions only.
void report_crash(int signal) {
  static volatile pthread_t crashed;
  if (crashing.exchange(true)) {
    // Another thread crashes, too: the first one reports and ends the process. Or the report itself crashes.
    while (pthread_equal(crashed, pthread_self()) == 0) pause();
    end_by(signal);
  }
  crashed = pthread_self();
  const CurrentCall call = current_call();
  CrashLine line;
  if (on_terminal) line.add("\n");
  line.add("springnet: error: ");
  if (call.component == nullptr) {
    line.add("springnet crashed (");
    add_signal(line, signal);
    line.add("), outside of all calls of plugins");
  } else {
    add_component(line, *call.component);
    line.add(" crashed (");
    add_signal(line, signal);
    line.add(")");
    add_members(line, call.members);
    write_whole_records();
  }
  if (crash_folder[0] != '\0') {
    line.add(call.component != nullptr ? "; the tables up to the last record are kept in " : "; tables are kept in ");
    line.add(crash_folder);
  }
  if (call.component != nullptr && !call.component->file.empty())
    line.add("; 'springnet plugin check' looks for mistakes in a plugin");
  line.print();
  end_by(signal);
}

// Where the handler runs: the thread's own stack may be what ran out. Of this thread until it ends, unless it has one
// already, as with sanitizers. Without memory for it the handler runs on the thread's own.
class CrashStack {
 public:
  CrashStack() noexcept {
    stack_t now{};
    if (sigaltstack(nullptr, &now) != 0 || (now.ss_flags & SS_DISABLE) == 0) return;
    void* const memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) return;
    stack_t stack{};
    stack.ss_sp = memory;
    stack.ss_size = size;
    if (sigaltstack(&stack, nullptr) == 0)
      memory_ = memory;
    else
      munmap(memory, size);
  }
  ~CrashStack() {
    if (memory_ == nullptr) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    if (sigaltstack(&none, nullptr) == 0) munmap(memory_, size);
  }
  CrashStack(const CrashStack&) = delete;
  CrashStack& operator=(const CrashStack&) = delete;

 private:
  static constexpr std::size_t size = std::size_t{1} << 16;
  void* memory_ = nullptr;
};

void have_crash_stack() noexcept { static thread_local const CrashStack stack; }

}  // namespace

void report_crashes() noexcept {
  on_terminal = isatty(STDERR_FILENO) == 1;
  have_crash_stack();
  prepare_calling_threads(have_crash_stack);
  for (const CrashSignal& each : crash_signals) {
    struct sigaction action {};
    if (sigaction(each.number, nullptr, &action) != 0 || (action.sa_flags & SA_SIGINFO) != 0 ||
        action.sa_handler != SIG_DFL)
      continue;
    action = {};
    action.sa_handler = report_crash;
    action.sa_flags = SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    sigaction(each.number, &action, nullptr);
  }
}

void set_crash_folder(const std::filesystem::path& folder) {
  const std::string text = printable_message(folder.string());
  const std::size_t size = std::min(text.size(), longest_folder - 1);
  std::memcpy(crash_folder, text.data(), size);
  crash_folder[size] = '\0';
}

}  // namespace springnet::tool
