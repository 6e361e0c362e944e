#include "process.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <initializer_list>

namespace springnet::tool {

namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

constexpr unsigned patience = 1;  // s

// Only what a signal handler may call.
void note_interrupt(int) {
  interrupt_seen = 1;
  alarm(patience);
}

void explain_wait(int) {
  static constexpr char text[] =
      "springnet: ends after this time step and its outputs; another Ctrl-C or SIGTERM ends it at once\n";
  if (::write(STDERR_FILENO, text, sizeof text - 1) < 0) return;  // nobody reads it
}

bool is_ignored(int signal) noexcept {
  struct sigaction now;
  return sigaction(signal, nullptr, &now) == 0 && (now.sa_flags & SA_SIGINFO) == 0 && now.sa_handler == SIG_IGN;
}

void handle(int signal, void (*handler)(int), int flags) noexcept {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void prepare_process() noexcept {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) != -1) continue;
    // open() takes the lowest free descriptor, this one. Opened for the wrong direction, so that its users get an
    // error.
    if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) return;
  }
  handle(SIGXFSZ, SIG_IGN, 0);
}

void catch_interrupts() noexcept {
  for (const int signal : {SIGINT, SIGTERM}) {
    if (!is_ignored(signal)) handle(signal, note_interrupt, SA_RESTART | static_cast<int>(SA_RESETHAND));
  }
  handle(SIGALRM, explain_wait, SA_RESTART);
  // Not reset by the first one, because these repeat: SIGHUP from the shell and the kernel, SIGXCPU every second.
  for (const int signal : {SIGHUP, SIGXCPU}) {
    if (!is_ignored(signal)) handle(signal, note_interrupt, SA_RESTART);
  }
}

void outlive_readers() noexcept { handle(SIGPIPE, SIG_IGN, 0); }

bool interrupted() noexcept { return interrupt_seen != 0; }

}  // namespace springnet::tool
