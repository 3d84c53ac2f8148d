// A daemon that collidectl starts for itself, on a Unix socket.

#include "client/app/daemon/own_daemon.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <deque>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "client/app/daemon/interrupt.hpp"

namespace collided::cli {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::seconds kReadyTimeout = 60s, kCompileTimeout = 30min;
constexpr std::chrono::seconds kStopTimeout = 10s, kInterruptedTimeout = 1s;

bool is_program(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

/// One client may have all of them. Its other calls take connections, too.
void add_stream_limits(std::vector<std::string>& words, uint32_t streams) {
  constexpr uint32_t kOtherConnections = 16;
  words.insert(words.end(), {"--max-scenes", std::to_string(streams), "--max-streams", std::to_string(streams),
                             "--max-connections", std::to_string(streams + kOtherConnections), "--max-window", "1024"});
}

std::vector<std::string> command_line(const fs::path& program, const DaemonOptions& options) {
  // So that a missing GPU is reported for the scene, in one clear message, and not by a daemon that fails to start.
  const std::string backend = options.backend == "cuda" ? "auto" : options.backend;
  std::vector<std::string> words{program.string(), "--private", "--backend",
                                 backend,          "--threads", std::to_string(options.threads)};
  if (options.streams > 0) add_stream_limits(words, options.streams);
  if (options.metrics)  // their address is logged
    words.insert(words.end(), {"--http-address", "127.0.0.1:0", "--log-level", "info"});
  if (options.cuda_ipc) words.push_back("--cuda-ipc");
  if (options.tcp) words.insert(words.end(), {"--address", "127.0.0.1:0"});
  return words;
}

/// Returns the text between `before` and the first of `ends`; empty if `before` is missing.
std::string text_after(const std::string& text, std::string_view before, const char* ends = "\n") {
  const size_t at = text.find(before);
  if (at == std::string::npos) return "";
  const size_t begin = at + before.size();
  return text.substr(begin, text.find_first_of(ends, begin) - begin);
}

/// Returns the last lines of a daemon's log in one, after ": "; empty if there are none. It leaves out the advice to
/// run the daemon with --help, since nobody typed its command line.
std::string last_lines(const std::string& log) {
  constexpr size_t kMaxLines = 3;
  std::istringstream in(log);
  std::deque<std::string> last;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.starts_with("Run with --help")) continue;
    last.push_back(line);
    if (last.size() > kMaxLines) last.pop_front();
  }
  std::string out;
  for (const std::string& line : last) out += (out.empty() ? ": " : "; ") + line;
  return out;
}

std::string describe(int status) {
  if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status));
  return "exit code " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

fs::path find_daemon() {
  if (const char* named = std::getenv("COLLIDED_DAEMON")) {
    if (is_program(named)) return named;
    throw std::runtime_error(std::string("COLLIDED_DAEMON is '") + named + "', which is not a program");
  }
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  std::vector<fs::path> places{here, here / "../bin", here / "../../server"};
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string place; std::getline(path, place, ':');) places.push_back(place);
  for (const fs::path& place : places)
    if (is_program(place / "collided")) return place / "collided";
  throw std::runtime_error("no daemon 'collided' was found; set COLLIDED_DAEMON or use --server");
}

OwnDaemon::OwnDaemon(const DaemonOptions& options) {
  const fs::path program = find_daemon();
  start(command_line(program, options));
  try {
    wait_until_ready(program);
  } catch (...) {
    stop();
    throw;
  }
}

OwnDaemon::~OwnDaemon() {
  const bool has_ended = waitpid(pid_, &status_, WNOHANG) == pid_;
  if (has_ended) pid_ = -1;
  stop();
  if (has_ended)
    std::fprintf(stderr, "collidectl: its daemon ended with %s%s\n", describe(status_).c_str(),
                 last_lines(said_).c_str());
}

std::string OwnDaemon::address() const { return text_after(said_, "\nready ", ",\n"); }

std::string OwnDaemon::tcp_address() const { return text_after(text_after(said_, "\nready "), ","); }

std::string OwnDaemon::metrics_address() const { return text_after(said_, "metrics and health on ", " \n"); }

void OwnDaemon::start(std::vector<std::string> words) {
  constexpr int kLogBytes = 1 << 20;  // nobody reads it before the end
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::array<int, 2> in{}, out{};
  if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0)
    throw std::runtime_error("cannot make a pipe");
  fcntl(out[0], F_SETPIPE_SZ, kLogBytes);
  input_ = in[1];
  output_ = out[0];
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);  // only collidectl gets the terminal's interrupts
    signal(SIGPIPE, SIG_DFL);
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    dup2(out[1], STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  if (pid_ < 0) throw std::runtime_error("cannot start a process");
  clean_up_on_interrupt(pid_, input_, output_);
}

void OwnDaemon::wait_until_ready(const fs::path& program) {
  constexpr std::string_view kCompiling = "compiling the kernels";
  const auto start = Clock::now();
  auto timeout = kReadyTimeout;
  while (address().empty()) {
    if (!read_some(100ms)) throw std::runtime_error(why_ended(program));
    const auto took = Clock::now() - start;
    if (took > 1s && timeout == kReadyTimeout && said_.find(kCompiling) != std::string::npos) {
      std::fprintf(stderr, "collidectl: waiting for its daemon: %s%s\n", kCompiling.data(),
                   text_after(said_, kCompiling).c_str());
      timeout = kCompileTimeout;
    }
    if (took > timeout)
      throw std::runtime_error("daemon " + program.string() + " was not ready after " +
                               std::to_string(timeout.count()) + " seconds");
  }
}

std::string OwnDaemon::why_ended(const fs::path& program) {
  waitpid(pid_, &status_, 0);
  pid_ = -1;
  const size_t refused = said_.find("not expected: ");
  if (refused != std::string::npos && said_.find("--private", refused) != std::string::npos)
    return "a private daemon must be of release 0.2.0 or later, and " + program.string() + " is older";
  return "daemon " + program.string() + " ended with " + describe(status_) + " before it was ready" + last_lines(said_);
}

bool OwnDaemon::read_some(std::chrono::milliseconds timeout) {
  pollfd output{output_, POLLIN, 0};
  if (poll(&output, 1, static_cast<int>(timeout.count())) <= 0) return true;
  std::array<char, 4096> some{};
  const ssize_t size = read(output_, some.data(), some.size());
  if (size > 0) said_.append(some.data(), static_cast<size_t>(size));
  return size > 0 || (size < 0 && errno == EINTR);
}

bool OwnDaemon::is_gone_within(std::chrono::milliseconds timeout) {
  for (const auto end = Clock::now() + timeout; Clock::now() < end;)
    if (!read_some(10ms)) return true;
  return false;
}

void OwnDaemon::stop() noexcept {
  close(input_);
  if (!is_gone_within(is_interrupted() ? kInterruptedTimeout : kStopTimeout)) {
    if (pid_ > 0) kill(pid_, SIGKILL);
    is_gone_within(kStopTimeout);
  }
  if (pid_ > 0) waitpid(pid_, &status_, 0);
  no_clean_up_on_interrupt();
  close(output_);
}

}  // namespace collided::cli
