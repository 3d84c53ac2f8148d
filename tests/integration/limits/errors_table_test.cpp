// The table of proto/ERRORS.md, read and provoked: each code in the situations that its row names.
#include <absl/status/status.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/integration/local/local_daemon.hpp"
#include "tests/integration/support/peers/breaking_peer.hpp"
#include "tests/integration/support/peers/raw_stream.hpp"
#include "tests/integration/support/upload.hpp"

namespace collided::test {
namespace {

// What stands in the row of each code under "when".
std::map<std::string, std::string> read_table() {
  std::ifstream file(setting("COLLIDED_ERRORS_PAGE", COLLIDED_ERRORS_PAGE));
  std::map<std::string, std::string> rows;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("| ") || line.starts_with("| code |")) continue;
    const auto end = line.find(" | ", 2), next = line.find(" | ", end + 3);
    rows[line.substr(2, end - 2)] = line.substr(end + 3, next - end - 3);
  }
  return rows;
}

pb::Frame bad_tip(const std::function<void(pb::MeshUpdate&)>& change) {
  pb::Frame frame = first_frame(2);
  change(*frame.mutable_updates(0));
  return frame;
}

pb::CreateSceneRequest awaiting_request() {
  auto request = tip_request();
  request.mutable_spec()->mutable_meshes(0)->set_triangle_count(2);
  return request;
}

grpc::Status server_info(const std::string& address, const std::string& token = "",
                         std::chrono::milliseconds most = kNoCallTakesLonger) {
  auto stub = pb::CollisionService::NewStub(channel_to(address));
  grpc::ClientContext context;
  set_deadline(context, most);
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  pb::GetServerInfoResponse info;
  return stub->GetServerInfo(&context, {}, &info);
}

std::string code_of(const grpc::Status& status) {
  return absl::StatusCodeToString(static_cast<absl::StatusCode>(status.error_code()));
}

struct Situation {
  std::string code, words;  ///< that the row of the code has
  std::function<grpc::Status()> provoke;
};

class ErrorsTable : public testing::Test {
 protected:
  std::string tip() { return make_scene(*stub_, tip_request()); }
  grpc::Status detect_bad(const std::function<void(pb::MeshUpdate&)>& change) {
    return detect(*stub_, tip(), bad_tip(change));
  }
  grpc::Status second_frame(const pb::Frame& frame) {
    const std::string id = tip();
    EXPECT_TRUE(detect(*stub_, id, first_frame(2)).ok());
    return detect(*stub_, id, frame);
  }
  grpc::Status create(const std::function<void(pb::CreateSceneRequest&)>& change) {
    auto request = tip_request();
    change(request);
    return create_scene(*stub_, request);
  }
  // A second stream of a scene that has one; with `first`, how that one ends.
  grpc::Status second_stream(std::function<std::string(const pb::Scene&)> token, bool first = false) {
    const auto scene = made_scene(*stub_, tip_request());
    Stream open(*stub_, scene.scene_id());
    EXPECT_TRUE(open.opened());
    Stream second(*stub_, scene.scene_id(), 0, token(scene));
    return first ? open.wait_end() : second.finish();
  }

  std::vector<Situation> invalid_arguments() {
    const std::string code = "INVALID_ARGUMENT";
    const auto nan = [](pb::MeshUpdate& tip) {
      auto points = tip_points(0);
      points[0] = {0, 0, std::nan("")};
      tip.set_positions(pack_points(points, false));
    };
    return {{code, "NaN", [=, this] { return detect_bad(nan); }},
            {code, "a wrong length",
             [this] { return detect_bad([](pb::MeshUpdate& tip) { tip.set_positions("12 bytes 1 2"); }); }},
            {code, "an unknown mesh", [this] { return detect_bad([](pb::MeshUpdate& tip) { tip.set_mesh(7); }); }},
            {code, "or vertex",
             [this] {
               return create([](auto& request) {
                 request.mutable_spec()->mutable_meshes(0)->set_triangles(pack<uint32_t>({0, 1, 3}));
               });
             }},
            {code, "values that do not go together",
             [this] {
               return create([](auto& request) {
                 request.mutable_spec()->set_mode(pb::DETECTION_MODE_DCD);
                 request.mutable_spec()->set_report(pb::REPORT_EARLIEST_ONLY);
               });
             }},
            {code, "a static mesh moved", [this] {
               pb::Frame again = first_frame(2);
               again.set_frame_id(2);
               return second_frame(again);
             }}};
  }
  std::vector<Situation> failed_preconditions() {
    const std::string code = "FAILED_PRECONDITION";
    std::vector<Situation> all = {
        {code, "a stale frame id", [this] { return second_frame(tip_frame(1, 2)); }},
        {code, "a scene still awaiting triangles",
         [this] { return detect(*stub_, make_scene(*stub_, awaiting_request()), first_frame(2)); }},
        {code, "another stream open", [this] { return second_stream([](const pb::Scene&) { return ""; }); }}};
    if (test_backend() == "cpu")
      all.push_back({code, "CUDA where there is none", [this] {
                       return create([](auto& request) { request.mutable_spec()->set_backend(pb::BACKEND_CUDA); });
                     }});
    return all;
  }
  std::vector<Situation> missing_and_present() {
    const auto deleted = [this] {
      const std::string id = tip();
      EXPECT_TRUE(delete_scene(*stub_, id).ok());
      return get_scene(*stub_, id);
    };
    const auto expired = [this] {
      auto request = tip_request();
      request.set_lease_seconds(0.1);
      const auto id = make_scene(*stub_, request);
      probe_.scenes_become(0);
      return get_scene(*stub_, id);
    };
    const auto repeated = [this] {
      const auto with_name = [this](const char* name) {
        return create([name](auto& request) {
          request.set_request_id("same");
          request.mutable_spec()->set_display_name(name);
        });
      };
      EXPECT_TRUE(with_name("one").ok());
      return with_name("other");
    };
    return {{"NOT_FOUND", "its lease ended", expired},
            {"NOT_FOUND", "deleted", deleted},
            {"ALREADY_EXISTS", "made another scene", repeated}};
  }
  std::vector<Situation> exhausted() {
    const std::string code = "RESOURCE_EXHAUSTED";
    return {{code, "past a [limit]", [this] { return create([](auto& request) { request.set_lease_seconds(1e6); }); }},
            {code, "a memory budget",
             [this] { return create([](auto& request) { request.mutable_spec()->set_memory_budget_bytes(1); }); }},
            {code, "a stream that was idle for too long", [this] {
               Stream stream(*stub_, tip());
               return stream.wait_end();
             }}};
  }
  std::vector<Situation> secrets() {
    return {
        {"UNAUTHENTICATED", "no token", [this] { return server_info(guarded_.address()); }},
        {"UNAUTHENTICATED", "an unknown one", [this] { return server_info(guarded_.address(), "is-not-known-here"); }},
        {"PERMISSION_DENIED", "a wrong resume token",
         [this] { return second_stream([](const pb::Scene&) { return "wrong"; }); }},
        {"ABORTED", "another stream took the scene over",
         [this] { return second_stream([](const pb::Scene& scene) { return scene.resume_token(); }, true); }}};
  }
  std::vector<Situation> times_and_connections() {
    const auto silent_upload = [this] { return Upload(*stub_, make_scene(*stub_, awaiting_request()), {}).wait_end(); };
    const auto cancelled = [this] { return Upload(*stub_, make_scene(*stub_, awaiting_request()), {}).cancel(); };
    const auto nobody = [this] { return server_info("unix:" + folder_.file("nobody")); };
    const auto broken = [] {
      const BreakingPeer peer;
      return server_info(peer.address());
    };
    const auto compressed = [this] {
      return raw_call(channel_to(daemon_.address()), method_path("GetScene"), "", {}, GRPC_COMPRESS_GZIP);
    };
    const auto unknown = [this] { return raw_call(channel_to(daemon_.address()), method_path("Frobnicate"), ""); };
    return {{"DEADLINE_EXCEEDED", "the call's own deadline",
             [this] { return server_info(daemon_.address(), "", std::chrono::milliseconds(-1)); }},
            {"DEADLINE_EXCEEDED", "an upload without a chunk for too long", silent_upload},
            {"CANCELLED", "the client cancelled", cancelled},
            {"UNAVAILABLE", "nobody answers", nobody},
            {"INTERNAL", "a connection that broke", broken},
            {"UNIMPLEMENTED", "a method that this version does not have", unknown},
            {"UNIMPLEMENTED", "a message that gRPC compressed", compressed}};
  }

  std::vector<std::string> with_tokens() {
    std::ofstream(folder_.file("tokens.toml")) << "[[tokens]]\nname = \"a\"\ntoken = \"token-of-client-a\"\n";
    chmod(folder_.file("tokens.toml").c_str(), 0600);
    return {"--tokens-file", folder_.file("tokens.toml")};
  }

  OpenFolder folder_;
  DaemonProcess daemon_{{"--max-idle-seconds", "0.5", "--max-scenes", "1000", "--max-scenes-per-client", "1000"}};
  DaemonProcess guarded_{with_tokens()};
  Probe probe_{daemon_};
  std::unique_ptr<Stub> stub_ = pb::CollisionService::NewStub(daemon_.channel());
};

TEST_F(ErrorsTable, EveryRowComesTrue) {
  std::vector<Situation> situations = missing_and_present();  // first, while there is no other scene
  for (auto&& more : {invalid_arguments(), failed_preconditions(), exhausted(), secrets(), times_and_connections()})
    situations.insert(situations.end(), more.begin(), more.end());
  const auto table = read_table();
  std::set<std::string> provoked;
  for (const auto& [code, words, provoke] : situations) {
    const auto row = table.find(code);
    ASSERT_NE(row, table.end()) << "README's table of errors has no row " << code;
    EXPECT_NE(row->second.find(words), std::string::npos)
        << code << " does not tell \"" << words << "\": " << row->second;
    const auto status = provoke();
    EXPECT_EQ(code_of(status), code) << words << ": " << status.error_message();
    provoked.insert(code);
  }
  for (const auto& [code, when] : table) EXPECT_TRUE(provoked.contains(code)) << code << " is not known here: " << when;
}

}  // namespace
}  // namespace collided::test
