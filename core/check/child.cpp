#include "check/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include <springnet/current_call.hpp>
#include <springnet/plugin_host.hpp>

#include "check/memory.hpp"
#include "check/signal_name.hpp"

namespace springnet::check {
namespace {

// Written by the child, read by its parent once the child has ended: foreign data, like all of the child.
struct Shared {
  char doing[128];
  char component[128], kind[32];  // that the process was in when it ended
  Fault fault;
  double since;        // when `doing` began, of now()
  std::uint32_t done;  // `finished` once the outcome is complete, or the body of a supervised process has returned
  std::uint32_t result;
  char why[2000];
};
constexpr std::uint32_t finished = 0x5eed;

Shared* shared = nullptr;  // in a child
int to_parent = -1;        // in a supervised process

constexpr std::size_t handler_stack_size = 1 << 16;

double now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void copy_text(char* to, std::size_t size, std::string_view text) noexcept {
  const std::size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  to[length] = '\0';
}

// Async-signal-safe.
void note_component() noexcept {
  const Component* const component = current_call().component;
  if (shared == nullptr || component == nullptr) return;
  copy_text(shared->component, sizeof shared->component, component->description->id);
  copy_text(shared->kind, sizeof shared->kind, name_of(component->kind()));
}

// Notes which array a fault is next to; the return repeats the access, which then ends the process.
void on_fault(int number, siginfo_t* info, void*) {
  if (shared != nullptr && number != SIGABRT) shared->fault = fault_at(info->si_addr);
  note_component();
  signal(number, SIG_DFL);
}

void set_handlers() {
  // Those of the program, or of a sanitizer, would hide by which signal the child ends.
  for (const int number : {SIGTERM, SIGINT, SIGXCPU, SIGPIPE, SIGHUP}) signal(number, SIG_DFL);
  static char stack[handler_stack_size];
  stack_t alternate{};
  alternate.ss_sp = stack;
  alternate.ss_size = sizeof stack;
  sigaltstack(&alternate, nullptr);
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) sigaction(number, &action, nullptr);
}

// Bytes of address space in use; 0: not known.
std::size_t address_space() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0;
  file >> pages;
  return file ? pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) : 0;
}

// Resource: the type of RLIMIT_CORE and so on, which systems name differently.
template <class Resource>
void limit(Resource what, std::size_t value, std::size_t spare = 0) {
  const rlimit bound{static_cast<rlim_t>(value), static_cast<rlim_t>(value + spare)};
  setrlimit(what, &bound);
}

// s of all threads together.
std::size_t processor_time(const Limits& limits) {
  return static_cast<std::size_t>(std::ceil(limits.seconds * limits.threads)) + 1;
}

void set_limits(const Limits& limits) {
  limit(RLIMIT_CORE, 0);
  // At the first bound SIGXCPU tells why the process ends; SIGKILL of the second one would not.
  limit(RLIMIT_CPU, processor_time(limits), 1);
  // Sanitizers reserve terabytes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr bool can_limit_memory = false;
#else
  constexpr bool can_limit_memory = true;
#endif
  if (const std::size_t used = can_limit_memory ? address_space() : 0; used > 0) limit(RLIMIT_AS, used + limits.memory);
}

void become_child(Shared* page) {
  shared = page;
  setpgid(0, 0);  // so that what it starts ends with it
#if defined(__linux__)
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  set_handlers();
}

[[noreturn]] void be_child(const std::function<Outcome()>& body, const Limits& limits) {
  set_limits(limits);
  Outcome outcome;
  try {
    outcome = body();
  } catch (const std::exception& error) {
    outcome = {Result::failed, error.what()};
  } catch (...) {
    outcome = {Result::failed, "an exception that is no std::exception came through: catch it within the component"};
  }
  shared->result = static_cast<std::uint32_t>(outcome.result);
  copy_text(shared->why, sizeof shared->why, outcome.why);
  shared->done = finished;
  _exit(0);
}

// How a process ended.
struct Ending {
  int status = 0;
  bool in_time = true;          // else it was killed
  double processor_time = 0.0;  // s, of all its threads
};

// Waits for the child, until `seconds` after `since`, which the child may change. Meanwhile `each` reads what it sends.
template <class Each>
Ending wait_for(pid_t child, const volatile double& since, double seconds, const Each& each) {
  Ending ending;
  rusage used{};
  long pause = 100'000;  // ns
  while (true) {
    const pid_t ended = wait4(child, &ending.status, WNOHANG, &used);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) return ending;
    if (now() > since + seconds) {
      ending.in_time = false;
      kill(-child, SIGKILL);
      kill(child, SIGKILL);
      wait4(child, &ending.status, 0, &used);
      break;
    }
    each();
    const timespec some{0, pause};
    nanosleep(&some, nullptr);
    pause = std::min(2 * pause, 5'000'000L);
  }
  kill(-child, SIGKILL);  // what it may have started
  const auto seconds_of = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  ending.processor_time = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  return ending;
}

std::string text_of(const char* text, std::size_t size) { return {text, strnlen(text, size)}; }

std::string describe(const Fault& fault) {
  const std::string name = text_of(fault.name, sizeof fault.name);
  if (fault.kind == Fault::Kind::none || name.empty()) return {};
  switch (fault.kind) {
    case Fault::Kind::beyond:
      return fmt::format(": it reads or writes beyond the end of {}", name);
    case Fault::Kind::before:
      return fmt::format(": it reads or writes before the start of {}", name);
    case Fault::Kind::read_only:
      return fmt::format(": it writes to {}, which is an input", name);
    case Fault::Kind::null:
      return fmt::format(": it uses {}", name);
    default:
      return {};
  }
}

std::string place_of(const Shared& from) {
  const std::string doing = text_of(from.doing, sizeof from.doing);
  return doing.empty() ? "" : " while " + doing;
}

Outcome crash_of(const Shared& from, int status, const char* subject) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    const std::string_view name = signal_name(number);
    return {Result::crashed, fmt::format("{} ends the process by {} ({}){}{}", subject,
                                         name.empty() ? fmt::format("signal {}", number) : name, strsignal(number),
                                         place_of(from), describe(from.fault))};
  }
  return {Result::crashed, fmt::format("{} ends the process with status {}{}: return a status instead of calling exit",
                                       subject, WEXITSTATUS(status), place_of(from))};
}

Outcome late(const Shared& from, double seconds, const char* of, const char* subject) {
  return {Result::timed_out, fmt::format("{} takes more than {:g} s{}{}: end each call in a bounded time", subject,
                                         seconds, of, place_of(from))};
}

Outcome outcome_of(const Shared& from, const Ending& ending, const Limits& limits, const char* subject) {
  if (!ending.in_time) return late(from, limits.seconds, "", subject);
  const int number = WIFSIGNALED(ending.status) ? WTERMSIG(ending.status) : 0;
  const bool used_up = ending.processor_time >= static_cast<double>(processor_time(limits));
  if (number == SIGXCPU || (number == SIGKILL && used_up))
    return late(from, limits.seconds * limits.threads, " of processor time", subject);
  if (number != 0 || from.done != finished) return crash_of(from, ending.status, subject);
  if (from.result > static_cast<std::uint32_t>(Result::skipped)) return {Result::failed, "the report was overwritten"};
  return {static_cast<Result>(from.result), text_of(from.why, sizeof from.why)};
}

// Zeros that parent and child share; null: there is no memory.
Shared* share_page() {
  void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  auto* const page = static_cast<Shared*>(memory);
  page->since = now();
  return page;
}

constexpr const char* no_memory = "there is no memory for a child process";
constexpr const char* no_process = "the system allows no further process";

// Appends what can be read now.
void read_some(int from, std::string& text) {
  char part[4096];
  for (pollfd ready{from, POLLIN, 0}; poll(&ready, 1, 0) > 0 && (ready.revents & POLLIN) != 0;) {
    const ssize_t size = read(from, part, sizeof part);
    if (size <= 0) return;
    text.append(part, static_cast<std::size_t>(size));
  }
}

[[noreturn]] void be_supervised(const std::function<void()>& body) {
  limit(RLIMIT_CORE, 0);
  std::atexit(note_component);  // a component that calls exit
  try {
    body();
  } catch (...) {
    now_doing("reporting");
    std::abort();
  }
  now_doing("the process ends, in a destructor of the library");
  shared->done = finished;
  std::exit(0);
}

}  // namespace

void now_doing(const char* what) noexcept {
  if (shared == nullptr) return;
  copy_text(shared->doing, sizeof shared->doing, what);
  shared->since = now();
}

void tell(std::string_view bytes) noexcept {
  while (!bytes.empty()) {
    const ssize_t written = write(to_parent, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) return;
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

Outcome run_in_child(const std::function<Outcome()>& body, const Limits& limits, const char* subject) {
  Shared* const page = share_page();
  if (page == nullptr) return {Result::skipped, no_memory};
  std::fflush(nullptr);  // else a child that calls exit prints it again
  const double begin = page->since;
  if (shared != nullptr) shared->since = begin + limits.seconds;  // a supervised process waits for its check
  const pid_t child = fork();
  if (child == 0) {
    become_child(page);
    be_child(body, limits);
  }
  Outcome outcome{Result::skipped, no_process};
  if (child > 0) {
    setpgid(child, child);
    outcome = outcome_of(*page, wait_for(child, begin, limits.seconds, [] {}), limits, subject);
  }
  if (shared != nullptr) shared->since = now();
  munmap(page, sizeof(Shared));
  return outcome;
}

End supervise(const std::function<void()>& body, double seconds, const char* subject) {
  End end;
  Shared* const page = share_page();
  int ends[2];
  if (page == nullptr || pipe(ends) != 0) {
    if (page != nullptr) munmap(page, sizeof(Shared));
    end.outcome = {Result::failed, no_memory};
    return end;
  }
  for (const int each : ends) fcntl(each, F_SETFD, FD_CLOEXEC);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    to_parent = ends[1];
    become_child(page);
    be_supervised(body);
  }
  close(ends[1]);
  if (child < 0) {
    end.outcome = {Result::failed, no_process};
  } else {
    setpgid(child, child);
    const Ending ending = wait_for(child, page->since, seconds, [&] { read_some(ends[0], end.told); });
    read_some(ends[0], end.told);
    end.was_leaving = page->done == finished;
    end.component = text_of(page->component, sizeof page->component);
    end.kind = text_of(page->kind, sizeof page->kind);
    if (!ending.in_time)
      end.outcome = late(*page, seconds, "", subject);
    else if (!end.was_leaving || WIFSIGNALED(ending.status) || WEXITSTATUS(ending.status) != 0)
      end.outcome = crash_of(*page, ending.status, subject);
  }
  close(ends[0]);
  munmap(page, sizeof(Shared));
  return end;
}

}  // namespace springnet::check
