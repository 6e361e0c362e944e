#include "check/child.hpp"

#include <fcntl.h>
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
#include <cstring>
#include <exception>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "check/memory.hpp"

namespace springnet::check {
namespace {

// Written by the child, read by its parent once the child has ended: foreign data, like all of the child.
struct Shared {
  char doing[128];
  Fault fault;
  std::uint32_t done;  // `finished` once the outcome is complete
  std::uint32_t result;
  char why[2000];
};
constexpr std::uint32_t finished = 0x5eed;

Shared* shared = nullptr;  // in a child

constexpr std::size_t handler_stack_size = 1 << 16;

// Notes which array a fault is next to; the return repeats the access, which then ends the process.
void on_fault(int number, siginfo_t* info, void*) {
  if (shared != nullptr) shared->fault = fault_at(info->si_addr);
  signal(number, SIG_DFL);
}

void set_handlers() {
  // Those of the program, or of a sanitizer, would hide by which signal the child ends.
  for (const int number : {SIGILL, SIGFPE, SIGABRT, SIGTERM, SIGINT, SIGXCPU, SIGPIPE, SIGHUP}) signal(number, SIG_DFL);
  static char stack[handler_stack_size];
  stack_t alternate{};
  alternate.ss_sp = stack;
  alternate.ss_size = sizeof stack;
  sigaltstack(&alternate, nullptr);
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  sigaction(SIGSEGV, &action, nullptr);
  sigaction(SIGBUS, &action, nullptr);
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
void limit(Resource what, std::size_t value) {
  const rlimit bound{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
  setrlimit(what, &bound);
}

void set_limits(const Limits& limits) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, static_cast<std::size_t>(std::ceil(limits.seconds)) + 1);
  // Sanitizers reserve terabytes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr bool can_limit_memory = false;
#else
  constexpr bool can_limit_memory = true;
#endif
  if (const std::size_t used = can_limit_memory ? address_space() : 0; used > 0) limit(RLIMIT_AS, used + limits.memory);
}

void copy_text(char* to, std::size_t size, const std::string& text) {
  const std::size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  to[length] = '\0';
}

[[noreturn]] void be_child(const std::function<Outcome()>& body, const Limits& limits) {
  setpgid(0, 0);  // so that what it starts ends with it
#if defined(__linux__)
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  set_handlers();
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

double now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Waits for the child; false: it took too long and was killed.
bool wait_for(pid_t child, double seconds, int& status) {
  const double end = now() + seconds;
  long pause = 100'000;  // ns
  while (true) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) {
      kill(-child, SIGKILL);  // what it may have started
      return true;
    }
    if (ended < 0 && errno != EINTR) return true;
    if (now() > end) {
      kill(-child, SIGKILL);
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return false;
    }
    const timespec some{0, pause};
    nanosleep(&some, nullptr);
    pause = std::min(2 * pause, 5'000'000L);
  }
}

std::string text_of(const char* text, std::size_t size) { return {text, strnlen(text, size)}; }

std::string name_of_signal(int number) {
  switch (number) {
    case SIGSEGV:
      return "SIGSEGV";
    case SIGBUS:
      return "SIGBUS";
    case SIGFPE:
      return "SIGFPE";
    case SIGILL:
      return "SIGILL";
    case SIGABRT:
      return "SIGABRT";
    case SIGKILL:
      return "SIGKILL";
    default:
      return fmt::format("signal {}", number);
  }
}

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

Outcome outcome_of(const Shared& from, int status, bool in_time, const Limits& limits, const char* subject) {
  const std::string doing = text_of(from.doing, sizeof from.doing);
  const std::string where = doing.empty() ? "" : " while " + doing;
  if (!in_time || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU))
    return {Result::timed_out, fmt::format("{} takes more than {:g} s{}: end each call in a bounded time", subject,
                                           limits.seconds, where)};
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    return {Result::crashed, fmt::format("{} ends the process by {} ({}){}{}", subject, name_of_signal(number),
                                         strsignal(number), where, describe(from.fault))};
  }
  if (from.done != finished)
    return {Result::crashed,
            fmt::format("{} ends the process with status {}{}: return a status instead of calling exit", subject,
                        WEXITSTATUS(status), where)};
  if (from.result > static_cast<std::uint32_t>(Result::skipped)) return {Result::failed, "the report was overwritten"};
  return {static_cast<Result>(from.result), text_of(from.why, sizeof from.why)};
}

}  // namespace

void now_doing(const char* what) noexcept {
  if (shared != nullptr) copy_text(shared->doing, sizeof shared->doing, what);
}

Outcome run_in_child(const std::function<Outcome()>& body, const Limits& limits, const char* subject) {
  void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return {Result::skipped, "there is no memory for a child process"};
  auto* const page = static_cast<Shared*>(memory);  // all zeros
  std::fflush(nullptr);                             // else a child that calls exit prints it again
  const pid_t child = fork();
  if (child == 0) {
    shared = page;
    be_child(body, limits);
  }
  Outcome outcome{Result::skipped, "the system allows no further process"};
  if (child > 0) {
    setpgid(child, child);
    int status = 0;
    const bool in_time = wait_for(child, limits.seconds, status);
    outcome = outcome_of(*page, status, in_time, limits, subject);
  }
  munmap(memory, sizeof(Shared));
  return outcome;
}

}  // namespace springnet::check
