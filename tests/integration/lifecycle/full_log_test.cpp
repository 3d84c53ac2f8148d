// A log that nobody reads blocks neither frames nor the daemon's exit.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/integration/support/probe.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {
namespace {

/// Daemons started meanwhile write their log, every line of it down to debug, to a pipe of one page, which is read by
/// nobody else.
class LogPipe {
 public:
  LogPipe() {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-pipe-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    const std::string pipe = folder_ + "/pipe", script = folder_ + "/daemon";
    mkfifo(pipe.c_str(), 0600);
    fd_ = open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    fcntl(fd_, F_SETPIPE_SZ, 4096);
    before_ = setting("COLLIDED_DAEMON", COLLIDED_DAEMON);
    std::ofstream(script) << "#!/bin/sh\n"
                             "for word; do shift; [ \"$word\" = info ] && word=debug; set -- \"$@\" \"$word\"; done\n"
                             "exec '"
                          << before_ << "' \"$@\" 2> '" << pipe << "'\n";
    chmod(script.c_str(), 0700);
    setenv("COLLIDED_DAEMON", script.c_str(), 1);
  }
  LogPipe(const LogPipe&) = delete;
  LogPipe& operator=(const LogPipe&) = delete;
  ~LogPipe() {
    setenv("COLLIDED_DAEMON", before_.c_str(), 1);
    close(fd_);
    std::filesystem::remove_all(folder_);
  }

  /// Reads until the text appears; returns the rest of its line.
  std::string read_until(const std::string& text) {
    eventually("the log says " + text, [&] {
      char buffer[4096];
      for (ssize_t n = 0; (n = read(fd_, buffer, sizeof(buffer))) > 0;) log_.append(buffer, static_cast<size_t>(n));
      const auto found = log_.find(text);
      return found != std::string::npos && log_.find('\n', found) != std::string::npos;
    });
    const auto found = std::min(log_.size(), log_.find(text) + text.size());
    return log_.substr(found, log_.find('\n', found) - found);
  }
  const std::string& log() const { return log_; }

 private:
  std::string folder_, before_, log_;
  int fd_ = -1;
};

/// Enough frames that their lines exceed the pipe and the daemon's own queue.
void stream_frames(Stub& stub) {
  constexpr uint64_t kFrames = 10'000, kWindow = 16;
  const std::string scene = make_scene(stub, tip_request());
  {
    Stream stream(stub, scene, kWindow);
    ASSERT_TRUE(stream.opened());
    for (uint64_t id = 1; id <= kFrames; ++id) {
      stream.send(id == 1 ? first_frame(2) : tip_frame(id, 2));
      if (id < kWindow) continue;
      ASSERT_TRUE(stream.receive(id + 1 - kWindow).done);
    }
  }
  EXPECT_TRUE(delete_scene(stub, scene).ok());
}

double dropped_lines(const std::string& http_address) {
  const std::string text = http_get(http_address, "/metrics"), name = "\ncollided_dropped_log_lines_total ";
  const auto found = text.find(name);
  return found == std::string::npos ? -1 : std::stod(text.substr(found + name.size()));
}

TEST(FullLog, StopsNeitherFramesNorTheEnd) {
  LogPipe pipe;
  DaemonProcess daemon;
  const std::string http_address = pipe.read_until("metrics and health on ");
  const auto stub = pb::CollisionService::NewStub(daemon.channel());
  stream_frames(*stub);
  EXPECT_GT(dropped_lines(http_address), 0);
  pipe.read_until(" log lines were dropped");
  stream_frames(*stub);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0);
}

}  // namespace
}  // namespace collided::test
