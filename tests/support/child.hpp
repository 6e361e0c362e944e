// Runs code that may crash or hang in a child process.
#pragma once

#include <csignal>
#include <cstdlib>
#include <exception>
#include <string>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

namespace springnet::testing {

// `body` returns an error text, or an empty one. Returns that, or how the child died. The caller must not have threads.
template <class Body>
std::string in_child(const Body& body, unsigned seconds = 20) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child < 0) return "no process";
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    alarm(seconds);
    std::string text;
    try {
      text = body();
    } catch (const std::exception& error) {
      text = fmt::format("an exception came through: {}", error.what());
    } catch (...) {
      text = "something that is no std::exception came through";
    }
    const bool written = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(written ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(got));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status))
    return WTERMSIG(status) == SIGALRM ? fmt::format("hangs: no end after {} s", seconds)
                                       : fmt::format("ended by signal {}", WTERMSIG(status));
  if (WEXITSTATUS(status) != 0) return fmt::format("ended the process with status {}", WEXITSTATUS(status));
  return text;
}

}  // namespace springnet::testing
