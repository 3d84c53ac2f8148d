// A daemon that is killed in the middle of a stream, and started again: the session goes on where it was, and its
// caller does not notice. usage: resume_after_kill DAEMON, the program to start
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <collided/client.hpp>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "client/cpp/examples/grid.hpp"

using namespace collided::client;
namespace v1 = collided::v1;

namespace {

/// Something to kill.
class Daemon {
 public:
  explicit Daemon(std::string program) : program_(std::move(program)) {
    char folder[] = "/tmp/resume_after_kill-XXXXXX";
    if (!mkdtemp(folder)) throw std::runtime_error("cannot make a folder in /tmp");
    folder_ = folder;
    start();
  }
  ~Daemon() {
    kill();
    std::filesystem::remove_all(folder_);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  std::string address() const { return "unix:" + folder_ + "/socket"; }
  void start() {
    std::string where = address();
    char* const words[] = {program_.data(), const_cast<char*>("--address"), where.data(), nullptr};
    if (posix_spawn(&pid_, words[0], nullptr, nullptr, words, environ) != 0)
      throw std::runtime_error("cannot start " + program_);
  }
  void kill() {
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

 private:
  std::string program_, folder_;
  pid_t pid_ = -1;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: resume_after_kill DAEMON\n", stderr), 2;
  Daemon daemon(argv[1]);
  const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}};
  const MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = one},
                              {.name = "falling", .vertex_count = 3, .triangles = one}};
  v1::SceneSpec spec;
  spec.set_mode(v1::DETECTION_MODE_CCD);
  spec.set_position_format(v1::POSITION_FORMAT_F64);
  Session session = Session::open(daemon.address(), spec, meshes, {.connect = {.patience = std::chrono::seconds(30)}});

  const Points floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  for (int frame = 0; frame <= 6; ++frame) {
    const double z = 1 - 0.4 * frame;
    const Points falling{{1, 1, z}, {1.25, 1, z + 8}, {1, 1.25, z + 8}};
    const FrameUpdate updates[] = {{.mesh = 0, .positions = bytes_of(floor)},
                                   {.mesh = 1, .positions = bytes_of(falling)}};
    const FrameOutput output = session.detect(updates);
    std::printf("frame %d: %d contacts, %d recreations\n", frame, static_cast<int>(output.done.contact_count()),
                static_cast<int>(session.recreations()));
    if (frame != 2) continue;
    daemon.kill();
    daemon.start();
  }
  session.close();
} catch (const std::exception& error) {
  return std::fprintf(stderr, "resume_after_kill: %s\n", error.what()), 1;
}
