#pragma once
// A daemon with a local socket, and set-up shared by its tests.

#include <sys/stat.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/local/local_stream.hpp"
#include "tests/integration/support/baseline.hpp"
#include "tests/integration/support/layers.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {

/// The local socket that the daemon advertises.
inline std::string local_socket_of(Stub& stub) {
  grpc::ClientContext context;
  set_deadline(context);
  pb::GetServerInfoResponse info;
  EXPECT_TRUE(stub.GetServerInfo(&context, {}, &info).ok());
  return info.local_socket();
}

/// A folder that every user may enter.
class OpenFolder {
 public:
  OpenFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-local-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
    chmod(path_.c_str(), 0755);
  }
  ~OpenFolder() { std::filesystem::remove_all(path_); }
  OpenFolder(const OpenFolder&) = delete;
  OpenFolder& operator=(const OpenFolder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

class LocalDaemon {
 public:
  explicit LocalDaemon(std::vector<std::string> more = {}) : daemon_(with_socket(std::move(more))) {}

  std::string path() const { return folder_.file("local"); }
  DaemonProcess& process() { return daemon_; }
  const Probe& probe() const { return probe_; }
  Stub& stub() { return *stub_; }
  std::string make_scene(const pb::CreateSceneRequest& request) { return test::make_scene(*stub_, request); }

  /// A good stream over each transport; the first call also allocates what the daemon keeps.
  void expect_good_streams() {
    const std::string near = make_scene(tip_request()), far = make_scene(tip_request());
    {
      LocalStream local(path(), near);
      Stream remote(*stub_, far);
      expect_tip_contact(local.ask_shared(first_frame(2)), 2);
      expect_tip_contact(remote.ask(first_frame(2)), 2);
    }
    EXPECT_TRUE(delete_scene(*stub_, near).ok());
    EXPECT_TRUE(delete_scene(*stub_, far).ok());
    EXPECT_TRUE(probe_.streams_become(0));
  }

 private:
  std::vector<std::string> with_socket(std::vector<std::string> more) const {
    more.insert(more.end(), {"--local-socket", path()});
    return more;
  }

  OpenFolder folder_;
  DaemonProcess daemon_;
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

}  // namespace collided::test
