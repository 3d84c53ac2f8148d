// A daemon that collidectl starts for itself, on a Unix socket.

#include "client/cli/daemon/own_daemon.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

#include "client/cli/daemon/interrupt.hpp"

namespace collided::cli {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds kReadyTimeout = 60s, kCompileTimeout = 30min, kLogPoll = 1s;
constexpr std::chrono::milliseconds kStopTimeout = 10s, kInterruptedTimeout = 1s, kPoll = 5ms;

bool is_program(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

/// Whether a path means the same in an address, where ',' separates and '%', '?' and '#' have a meaning of their own.
bool is_plain(const std::string& path) {
  return std::all_of(path.begin(), path.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("/._-~+").find(c) != std::string_view::npos;
  });
}

fs::path make_directory() {
  constexpr size_t kMaxBytes = 90;  // the path of a socket has at most 107
  std::string name = (fs::temp_directory_path() / "collidectl-XXXXXX").string();
  if (name.size() > kMaxBytes || !is_plain(name)) name = "/tmp/collidectl-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create the temporary directory " + name);
  return name;
}

/// One client may have all of them. Its other calls take connections, too.
void add_stream_limits(std::vector<std::string>& words, uint32_t streams) {
  constexpr uint32_t kOtherConnections = 16;
  words.insert(words.end(), {"--max-scenes", std::to_string(streams), "--max-streams", std::to_string(streams),
                             "--max-connections", std::to_string(streams + kOtherConnections), "--max-window", "1024"});
}

/// Without the address of the Unix socket.
std::vector<std::string> command_line(const fs::path& program, const fs::path& directory,
                                      const DaemonOptions& options) {
  // So that a missing GPU is reported for the scene, in one clear message, and not by a daemon that fails to start.
  const std::string backend = options.backend == "cuda" ? "auto" : options.backend;
  std::vector<std::string> words{program.string(),
                                 "--backend",
                                 backend,
                                 "--threads",
                                 std::to_string(options.threads),
                                 "--ready-file",
                                 (directory / "ready").string(),
                                 "--log-level",
                                 options.metrics ? "info" : "warning",  // the address of the metrics is logged
                                 "--max-message-mb",
                                 "2047"};
  // Its only client may use everything.
  words.insert(words.end(), {"--max-scenes-per-client", "1000000", "--max-streams-per-client", "1000000",
                             "--max-device-mb-per-client", "16777216", "--max-frame-seconds", "1000000",
                             "--max-frames-per-second", "1000000000"});
  if (options.streams > 0) add_stream_limits(words, options.streams);
  if (options.metrics) words.insert(words.end(), {"--http-address", "127.0.0.1:0"});
  if (options.cuda_ipc) words.push_back("--cuda-ipc");
  if (!options.all_transports) return words;
  words.insert(words.end(), {"--address", "127.0.0.1:0", "--local-socket", (directory / "local").string()});
  return words;
}

/// Without the settings of a daemon that serves others, which this one is not.
std::vector<char*> own_environment() {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (!std::string_view(*variable).starts_with("COLLIDED_")) variables.push_back(*variable);
  variables.push_back(nullptr);
  return variables;
}

/// The last lines of a daemon's log in one, after ": "; empty if there are none. The advice to run it with --help is
/// left out: nobody typed its command line.
std::string last_log_lines(const fs::path& log) {
  constexpr size_t kMaxLines = 3;
  std::ifstream in(log);
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

/// The line of a daemon's log in which it says that the driver compiles its kernels; empty if there is none.
std::string compiling_line(const fs::path& log) {
  std::ifstream in(log);
  for (std::string line; std::getline(in, line);)
    if (const size_t at = line.find("compiling the kernels"); at != std::string::npos) return line.substr(at);
  return "";
}

/// Gives the child its own process group, so that only collidectl gets the terminal's interrupts, and logs its output.
void detach(const fs::path& log) {
  setpgid(0, 0);
  signal(SIGPIPE, SIG_DFL);
  const int out = open(log.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0600);
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
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
  directory_ = make_directory();
  try {
    start(program, options);
    wait_until_ready(program);
  } catch (...) {
    stop();
    throw;
  }
}

OwnDaemon::~OwnDaemon() {
  if (has_ended())
    std::fprintf(stderr, "collidectl: its daemon ended with %s%s\n", describe(status_).c_str(),
                 last_log_lines(directory_ / "log").c_str());
  stop();
}

std::string OwnDaemon::tcp_address() const {
  std::ifstream in(directory_ / "ready");
  for (std::string line; std::getline(in, line);)
    if (!line.starts_with("unix:")) return line;
  return "";
}

std::string OwnDaemon::metrics_address() const {
  constexpr std::string_view kBefore = "metrics and health on ";
  std::ifstream in(directory_ / "log");
  for (std::string line; std::getline(in, line);)
    if (const size_t at = line.find(kBefore); at != std::string::npos) {
      const std::string rest = line.substr(at + kBefore.size());
      return rest.substr(0, rest.find(' '));
    }
  return "";
}

void OwnDaemon::start(const fs::path& program, const DaemonOptions& options) {
  std::vector<std::string> words = command_line(program, directory_, options);
  words.insert(words.begin() + 1, {"--address", address()});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::vector<char*> environment = own_environment();
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot start a process");
  if (pid_ > 0) return clean_up_on_interrupt(pid_, directory_.string());
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // if collidectl is killed, so is its daemon
  if (getppid() != parent) _exit(126);
  detach(directory_ / "log");
  execve(argv[0], argv.data(), environment.data());
  _exit(127);
}

void OwnDaemon::wait_until_ready(const fs::path& program) {
  const auto start = std::chrono::steady_clock::now();
  auto timeout = kReadyTimeout;
  auto next_look = start + kLogPoll;
  std::error_code error;
  while (!(fs::exists(directory_ / "ready", error) && fs::file_size(directory_ / "ready", error) > 0)) {
    if (has_ended())
      throw std::runtime_error("daemon " + program.string() + " ended with " + describe(status_) +
                               " before it was ready" + last_log_lines(directory_ / "log"));
    const auto now = std::chrono::steady_clock::now();
    if (now > next_look && timeout == kReadyTimeout) {
      next_look = now + kLogPoll;
      if (const std::string line = compiling_line(directory_ / "log"); !line.empty()) {
        std::fprintf(stderr, "collidectl: waiting for its daemon: %s\n", line.c_str());
        timeout = kCompileTimeout;
      }
    }
    if (now > start + timeout)
      throw std::runtime_error("daemon " + program.string() + " was not ready after " +
                               std::to_string(std::chrono::duration_cast<std::chrono::seconds>(timeout).count()) +
                               " seconds");
    std::this_thread::sleep_for(kPoll);
  }
}

bool OwnDaemon::has_ended() {
  if (pid_ > 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
  return pid_ <= 0;
}

void OwnDaemon::stop() noexcept {
  const auto timeout = is_interrupted() ? kInterruptedTimeout : kStopTimeout;
  if (pid_ > 0) kill(pid_, SIGTERM);
  for (auto waited = 0ms; !has_ended() && waited < timeout; waited += kPoll) std::this_thread::sleep_for(kPoll);
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status_, 0);
    pid_ = -1;
  }
  no_clean_up_on_interrupt();
  std::error_code error;
  if (!directory_.empty()) fs::remove_all(directory_, error);
}

}  // namespace collided::cli
