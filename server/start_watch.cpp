// Lets SIGTERM and SIGINT end the daemon while it starts.
#include "server/start_watch.hpp"

#include <pthread.h>
#include <unistd.h>

#include <ctime>

namespace collided::server {
namespace {

constexpr int kSignals[] = {SIGTERM, SIGINT};
constexpr long kPollNanoseconds = 10'000'000;

extern "C" void end_at_once(int) { _exit(0); }

sigset_t the_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : kSignals) sigaddset(&signals, signal);
  return signals;
}

}  // namespace

void exit_on_signals() {
  for (const int signal : kSignals) {
    struct sigaction action {};
    action.sa_handler = end_at_once;
    sigaction(signal, &action, nullptr);
  }
}

StartWatch::StartWatch() {
  const sigset_t signals = the_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  thread_ = std::thread([this] { run(); });
}

// What has come by then is still to be taken by this thread or by whoever waits next: it is lost for neither.
StartWatch::~StartWatch() {
  is_over_ = true;
  thread_.join();
}

void StartWatch::run() const {
  const sigset_t signals = the_signals();
  const timespec poll{0, kPollNanoseconds};
  while (!is_over_)
    if (sigtimedwait(&signals, nullptr, &poll) > 0) _exit(0);
}

}  // namespace collided::server
