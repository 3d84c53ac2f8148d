// What a scene is made of, asked by who did not create it.
#include <gtest/gtest.h>

#include "client/cpp/meshes/mesh_pages.hpp"
#include "tests/integration/client_library/client_layers.hpp"
#include "tests/integration/support/daemon_process.hpp"

namespace collided::test {
namespace {

using client::MeshElements;
using client::MeshInput;
using Elements = std::vector<std::array<uint32_t, 3>>;

constexpr std::array<std::array<uint32_t, 3>, 1> kOne{{{0, 1, 2}}};
constexpr std::array<std::array<uint32_t, 2>, 1> kEdge{{{4, 3}}};
constexpr std::array<uint32_t, 1> kPoint{5};
constexpr uint32_t kLarge = 260;  // 268,324 triangles, 3.2 MB

class ElementsOfMeshes : public ::testing::Test {
 protected:
  pb::Scene make_scene() {
    pb::SceneSpec spec;
    spec.set_mode(pb::DETECTION_MODE_CCD);
    const MeshInput meshes[] = {
        {.name = "floor", .vertex_count = 3, .triangles = kOne, .is_static = true},
        {.name = "all", .vertex_count = 6, .triangles = kOne, .edges = kEdge, .points = kPoint}};
    return maker_.create_scene(spec, meshes);
  }
  pb::GetMeshResponse page(const std::string& scene, uint32_t mesh, uint32_t first) {
    grpc::ClientContext context;
    set_deadline(context);
    pb::GetMeshRequest request;
    request.set_scene_id(scene);
    request.set_mesh(mesh);
    request.set_first_element(first);
    pb::GetMeshResponse response;
    client::check(pb::CollisionService::NewStub(daemon_.channel())->GetMesh(&context, request, &response));
    return response;
  }
  void expect_refused(const std::string& scene, uint32_t mesh, uint32_t first, int code, const std::string& field) {
    try {
      page(scene, mesh, first);
      FAIL();
    } catch (const client::Error& e) {
      EXPECT_EQ(e.code(), code) << e.message();
      EXPECT_EQ(e.field(), field);
    }
  }

  DaemonProcess daemon_;
  Client maker_ = Client::connect(daemon_.address());
  Client other_ = Client::connect(daemon_.address());
};

TEST_F(ElementsOfMeshes, AreTrianglesThenEdgesThenPointsNumberedWithinTheMesh) {
  const std::string id = make_scene().scene_id();
  EXPECT_EQ(other_.mesh_elements(id, 0).elements, (Elements{{0, 1, 2}}));
  const MeshElements all = other_.mesh_elements(id, 1);
  EXPECT_EQ(all.elements, (Elements{{0, 1, 2}, {4, 3, 3}, {5, 5, 5}}));
  EXPECT_EQ(all.vertex_count, 6u);
  EXPECT_EQ(all.edit_count, 0u);
}

// A message of the daemon has room for 1 MiB of triangles, so that the large mesh must go up in chunks.
TEST(ElementsOfNewMeshes, GoWithTheSceneIfTheyAreFewAndInChunksElse) {
  const DaemonProcess daemon({"--max-message-mb", "2"});
  Client client = Client::connect(daemon.address());
  const std::vector<std::array<uint32_t, 3>> large(200'000, {0, 1, 2}), medium(80'000, {2, 0, 1});  // 2.4 and 0.96 MB
  std::vector<std::string> names;
  for (int i = 0; i < 300; ++i) names.push_back("small " + std::to_string(i));
  std::vector<MeshInput> meshes{{.name = "large", .vertex_count = 3, .triangles = large}};
  for (const auto& name : names) meshes.push_back({.name = name, .vertex_count = 3, .triangles = kOne});
  meshes.push_back({.name = "medium", .vertex_count = 3, .triangles = medium});
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_CCD);
  const pb::Scene scene = client.create_scene(spec, meshes), set = client.create_scenes(spec, meshes, 2);
  for (const std::string& id : {scene.scene_id(), set.scene_id()}) {
    EXPECT_EQ(client.get_scene(id).state(), pb::SCENE_STATE_READY);
    EXPECT_TRUE(client.mesh_elements(id, 0).elements == large);
    EXPECT_EQ(client.mesh_elements(id, 300).elements, (Elements{{0, 1, 2}}));
    EXPECT_TRUE(client.mesh_elements(id, 301).elements == medium);
  }
}

TEST_F(ElementsOfMeshes, ComeInPagesWhereTheyAreMany) {
  const MeshElements mesh = other_.mesh_elements(make_layers(maker_, kLarge).scene_id(), 0);
  Elements expected;
  const auto corners = layer_triangles(kLarge);
  for (size_t i = 0; i < corners.size(); i += 3) expected.push_back({corners[i], corners[i + 1], corners[i + 2]});
  EXPECT_TRUE(mesh.elements == expected);
}

TEST_F(ElementsOfMeshes, AreReadAnewIfAnEditShrinksTheMeshBetweenTwoPages) {
  const std::string id = make_layers(maker_, kLarge).scene_id();
  FrameStream stream = maker_.stream(maker_.get_scene(id));
  const std::string whole = layers_at(1, kLarge);
  ask(stream, 1, {.positions = bytes_of(whole)});
  const auto shrink = [&] {
    const std::string positions = pack<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const client::FrameUpdate update{.positions = bytes_of(positions)};
    pb::SceneEdit edit;
    *edit.add_meshes() = client::edited_mesh(0, {.vertex_count = 3, .triangles = kOne});
    stream.send(2, {&update, 1}, {.edit = edit});
    stream.receive().check();
  };
  std::vector<uint32_t> asked;
  const auto page_from = [&](uint32_t first) {
    if (asked.size() == 1) shrink();
    asked.push_back(first);
    return page(id, 0, first);
  };
  const MeshElements mesh = client::read_elements(0, page_from);
  EXPECT_EQ(mesh.elements, (Elements{{0, 1, 2}}));
  EXPECT_EQ(mesh.edit_count, 1u);
  ASSERT_EQ(asked.size(), 3u);
  EXPECT_GT(asked[1], 1u) << "past what the mesh has now";
  EXPECT_EQ(asked[2], 0u);
}

TEST_F(ElementsOfMeshes, ThatKeepRefusingAreGivenUp) {
  const std::string id = make_layers(maker_, kLarge).scene_id();
  int tries = 0;
  const auto page_from = [&](uint32_t first) {
    if (first == 0) ++tries;
    return page(id, 0, first == 0 ? 0 : ~0u);
  };
  try {
    client::read_elements(0, page_from);
    FAIL();
  } catch (const client::Error& e) {
    EXPECT_EQ(e.code(), grpc::ABORTED) << e.message();
    EXPECT_EQ(tries, 8);
  }
}

TEST_F(ElementsOfMeshes, FollowEdits) {
  const std::string id = make_layers(maker_).scene_id();
  FrameStream stream = maker_.stream(maker_.get_scene(id));
  ask_whole(stream, 1);
  pb::Frame frame;
  frame.set_frame_id(2);
  *frame.mutable_edit()->add_meshes() = client::removed_mesh(0);
  *frame.mutable_edit()->add_meshes() = client::edited_mesh(1, {.name = "new", .vertex_count = 3, .triangles = kOne});
  auto& update = *frame.add_updates();
  update.set_mesh(1);
  update.set_positions(pack<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}));
  auto watcher = other_.watch(id);
  stream.send(frame);
  stream.receive().check();
  client::WatchedFrame seen = watcher.receive();
  if (seen.frame_id == 1) {  // answered before the watch, but perhaps shown after that
    EXPECT_EQ(seen.edit_count, 0u);
    seen = watcher.receive();
  }
  EXPECT_EQ(seen.edit_count, 1u);
  EXPECT_TRUE(other_.mesh_elements(id, 0).elements.empty());
  EXPECT_EQ(other_.mesh_elements(id, 0).vertex_count, 0u);
  EXPECT_EQ(other_.mesh_elements(id, 1).elements, (Elements{{0, 1, 2}}));
  EXPECT_EQ(other_.mesh_elements(id, 1).edit_count, 1u);
}

TEST_F(ElementsOfMeshes, ThatAreNotThereAreNamed) {
  const std::string id = make_scene().scene_id();
  expect_refused(id, 2, 0, grpc::INVALID_ARGUMENT, "mesh");
  expect_refused(id, ~0u, 0, grpc::INVALID_ARGUMENT, "mesh");
  expect_refused(id, 1, 4, grpc::INVALID_ARGUMENT, "first_element");
  expect_refused("none", 0, 0, grpc::NOT_FOUND, "scene_id");
  auto awaiting = layers_request(4);
  awaiting.mutable_spec()->mutable_meshes(0)->set_triangle_count(1000);
  const auto stub = pb::CollisionService::NewStub(daemon_.channel());
  expect_refused(test::make_scene(*stub, awaiting), 0, 0, grpc::FAILED_PRECONDITION, "scene_id");
}

TEST_F(ElementsOfMeshes, BelongToScenesThatAreListed) {
  std::vector<std::string> made{make_scene().scene_id(), make_scene().scene_id()}, listed;
  std::sort(made.begin(), made.end());
  for (const pb::Scene& scene : other_.list_scenes()) listed.push_back(scene.scene_id());
  EXPECT_EQ(listed, made);
}

}  // namespace
}  // namespace collided::test
