#pragma once
// A real daemon as a child process on a Unix socket of its own.

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace collided::test {

class DaemonProcess {
 public:
  explicit DaemonProcess(std::vector<std::string> more = {}) {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::vector<std::string> arguments = {COLLIDED_DAEMON, "--address", address(),   "--ready-file", ready_file(),
                                          "--log-level",   "warning",   "--backend", "cpu"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    start(arguments);
  }
  ~DaemonProcess() {
    if (pid_ > 0) stop();
    std::filesystem::remove_all(folder_);
  }

  std::string address() const { return "unix:" + folder_ + "/socket"; }
  std::shared_ptr<grpc::Channel> channel() const {
    return grpc::CreateChannel(address(), grpc::InsecureChannelCredentials());
  }

  void signal(int number) const { kill(pid_, number); }

  /// The exit code; -1 if a signal killed it.
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  int stop() {
    signal(SIGTERM);
    return wait();
  }

 private:
  std::string ready_file() const { return folder_ + "/ready"; }

  void start(std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      execv(argv[0], argv.data());
      _exit(127);
    }
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!std::filesystem::exists(ready_file())) {
      if (waitpid(pid_, nullptr, WNOHANG) != 0 || std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("the daemon did not become ready");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  std::string folder_;
  pid_t pid_ = -1;
};

}  // namespace collided::test
