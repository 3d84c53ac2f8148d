#pragma once
// A real daemon as a child process on its own Unix socket, with metrics over HTTP.

#include <fcntl.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/support/calls.hpp"
#include "tests/integration/support/program.hpp"

namespace collided::test {

class DaemonProcess {
 public:
  /// `descriptors`: hard and soft limit of its file descriptors; 0: as this process has them.
  explicit DaemonProcess(std::vector<std::string> more = {}, const std::string& backend = test_backend(),
                         rlim_t descriptors = 0)
      : descriptors_(descriptors) {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::vector<std::string> arguments = {setting("COLLIDED_DAEMON", COLLIDED_DAEMON),
                                          "--address",
                                          address(),
                                          "--http-address",
                                          "127.0.0.1:0",
                                          "--ready-file",
                                          ready_file(),
                                          "--log-level",
                                          "info",
                                          "--backend",
                                          backend};
    arguments.insert(arguments.end(), more.begin(), more.end());
    start(arguments);
  }
  DaemonProcess(const DaemonProcess&) = delete;
  DaemonProcess& operator=(const DaemonProcess&) = delete;
  ~DaemonProcess() {
    if (pid_ > 0) {
      EXPECT_EQ(stop(), 0) << "the daemon's exit code";
    }
    if (testing::Test::HasFailure()) std::fputs(("the daemon's log:\n" + log()).c_str(), stderr);
    std::filesystem::remove_all(folder_);
  }

  std::string address() const { return "unix:" + folder_ + "/socket"; }
  /// The bound address of `--address 127.0.0.1:0`.
  std::string tcp_address() const {
    std::ifstream file(ready_file());
    std::string line;
    while (std::getline(file, line) && line.starts_with("unix:")) continue;
    return line;
  }
  std::string http_address() const {
    const std::string text = log(), before = "metrics and health on ";
    const auto begin = text.find(before) + before.size();
    return text.substr(begin, text.find('\n', begin) - begin);
  }
  std::shared_ptr<grpc::Channel> channel() const { return channel_to(address()); }

  pid_t pid() const { return pid_; }
  void signal(int number) const { kill(pid_, number); }

  /// The exit code; -1 if a signal killed it, or if it did not end in time.
  int wait(std::chrono::seconds most = std::chrono::seconds(60)) {
    const auto deadline = std::chrono::steady_clock::now() + most;
    int status = 0;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "the daemon did not end within " << most.count() << " s";
        signal(SIGKILL);
        waitpid(pid_, &status, 0);
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  int stop() {
    signal(SIGTERM);
    return wait();
  }

  std::string log() const {
    std::ostringstream text;
    text << std::ifstream(log_file()).rdbuf();
    return text.str();
  }

 private:
  std::string ready_file() const { return folder_ + "/ready"; }
  std::string log_file() const { return folder_ + "/log"; }

  void start(std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const int log = open(log_file().c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0600);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(log, STDOUT_FILENO);
      dup2(log, STDERR_FILENO);
      const rlimit limit{descriptors_, descriptors_};
      if (descriptors_) setrlimit(RLIMIT_NOFILE, &limit);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(log);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!std::filesystem::exists(ready_file())) {
      if (waitpid(pid_, nullptr, WNOHANG) != 0 || std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("the daemon did not become ready");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  const rlim_t descriptors_;
  std::string folder_;
  pid_t pid_ = -1;
};

}  // namespace collided::test
