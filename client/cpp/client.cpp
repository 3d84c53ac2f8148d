// A connection to a daemon: scenes and streams.

#include "client/cpp/client.hpp"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include "client/cpp/grpc_transport.hpp"
#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::client {

namespace {

constexpr int kMaxReceiveBytes = 4 << 20;              // the protocol's limit for every answer
constexpr size_t kTrianglesPerChunk = (1 << 20) / 12;  // 1 MiB, well below any daemon's limit

std::shared_ptr<grpc::Channel> open_channel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxReceiveBytes);
  // Two clients of one process shall not share a connection, nor one's failed attempts delay the other's.
  arguments.SetInt("grpc.use_local_subchannel_pool", 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

struct Client::State {
  std::string address;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::CollisionService::Stub> stub;
  v1::GetServerInfoResponse info;

  void upload(const std::string& scene_id, uint32_t index, const MeshInput& mesh, v1::Scene& scene);
};

void Client::State::upload(const std::string& scene_id, uint32_t index, const MeshInput& mesh, v1::Scene& scene) {
  grpc::ClientContext context;
  v1::UploadMeshResponse response;
  const auto writer = stub->UploadMesh(&context, &response);
  for (size_t at = 0; at < mesh.triangles.size(); at += kTrianglesPerChunk) {
    const auto chunk = mesh.triangles.subspan(at, std::min(kTrianglesPerChunk, mesh.triangles.size() - at));
    v1::UploadMeshRequest request;
    request.set_scene_id(scene_id);
    request.set_mesh(index);
    request.set_triangles(chunk.data(), chunk.size_bytes());
    if (!writer->Write(request)) break;  // the daemon refused: Finish() says why
  }
  writer->WritesDone();
  check(writer->Finish());
  scene = std::move(*response.mutable_scene());
}

Client::Client(std::unique_ptr<State> state) : state_(std::move(state)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

Client Client::connect(const std::string& address, std::chrono::milliseconds patience) {
  auto state = std::make_unique<State>();
  state->address = address;
  state->channel = open_channel(address);
  if (!state->channel->WaitForConnected(std::chrono::system_clock::now() + patience))
    throw Error(grpc::UNAVAILABLE, "no daemon answers at " + address);
  state->stub = v1::CollisionService::NewStub(state->channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + patience);
  check(state->stub->GetServerInfo(&context, {}, &state->info));
  return Client(std::move(state));
}

const v1::GetServerInfoResponse& Client::server_info() const { return state_->info; }

v1::Scene Client::create_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes) {
  for (const MeshInput& mesh : meshes) {
    v1::MeshSpec& out = *spec.add_meshes();
    out.set_name(mesh.name);
    out.set_vertex_count(mesh.vertex_count);
    out.set_motion(mesh.is_static ? v1::MESH_MOTION_STATIC : v1::MESH_MOTION_DEFORMABLE);
    out.set_triangle_count(static_cast<uint32_t>(mesh.triangles.size()));
  }
  grpc::ClientContext context;
  v1::CreateSceneRequest request;
  *request.mutable_spec() = std::move(spec);
  v1::CreateSceneResponse response;
  check(state_->stub->CreateScene(&context, request, &response));
  v1::Scene scene = std::move(*response.mutable_scene());
  const std::string id = scene.scene_id();
  try {
    for (uint32_t i = 0; i < meshes.size(); ++i) state_->upload(id, i, meshes[i], scene);
  } catch (const Error&) {
    grpc::ClientContext deletion;
    v1::DeleteSceneRequest gone;
    gone.set_scene_id(id);
    v1::DeleteSceneResponse ignored;
    state_->stub->DeleteScene(&deletion, gone, &ignored);  // best effort: the upload's error is the one to tell
    throw;
  }
  return scene;
}

v1::Scene Client::get_scene(const std::string& scene_id) {
  grpc::ClientContext context;
  v1::GetSceneRequest request;
  request.set_scene_id(scene_id);
  v1::GetSceneResponse response;
  check(state_->stub->GetScene(&context, request, &response));
  return std::move(*response.mutable_scene());
}

void Client::delete_scene(const std::string& scene_id) {
  grpc::ClientContext context;
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  v1::DeleteSceneResponse response;
  check(state_->stub->DeleteScene(&context, request, &response));
}

FrameStream Client::stream(const std::string& scene_id, uint32_t window) {
  auto transport =
      std::make_unique<GrpcTransport>(open_channel(state_->address), std::make_unique<grpc::ClientContext>(),
                                      state_->info.limits().max_message_bytes());
  v1::OpenStream open;
  open.set_scene_id(scene_id);
  open.set_window(window);
  return FrameStream::open(std::move(transport), open);
}

}  // namespace collided::client
