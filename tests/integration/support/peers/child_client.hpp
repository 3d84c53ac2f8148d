#pragma once
// A client in its own process (stream_client.cpp, local_client.cpp), to be stopped or killed.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "tests/integration/support/program.hpp"

namespace collided::test {

class ChildClient {
 public:
  /// Streams frames of `layers.hpp` to a scene over gRPC, one after the other, endlessly.
  ChildClient(const std::string& address, const std::string& scene_id, unsigned side)
      : ChildClient(
            {setting("COLLIDED_STREAM_CLIENT", COLLIDED_STREAM_CLIENT), address, scene_id, std::to_string(side)}) {}
  /// A program that writes a byte to its output once its first frame was answered.
  explicit ChildClient(std::vector<std::string> command) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    std::vector<char*> argv;
    for (auto& word : command) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDOUT_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    output_ = ends[0];
  }
  ChildClient(const ChildClient&) = delete;
  ChildClient& operator=(const ChildClient&) = delete;
  ~ChildClient() {
    signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
    close(output_);
  }

  void signal(int number) const { kill(pid_, number); }
  /// Waits until its first frame was answered.
  bool is_answered() const {
    pollfd wait{output_, POLLIN, 0};
    char byte = 0;
    const bool answered = poll(&wait, 1, 60'000) == 1 && read(output_, &byte, 1) == 1;
    EXPECT_TRUE(answered) << "the child's first frame was not answered";
    return answered;
  }

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

}  // namespace collided::test
