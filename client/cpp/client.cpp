// A connection to a daemon: scenes and streams.

#include "client/cpp/client.hpp"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <future>
#include <numeric>
#include <random>
#include <thread>
#include <utility>

#include "client/cpp/frame_stream_state.hpp"
#include "client/cpp/meshes/mesh_pages.hpp"
#include "client/cpp/transport/features.hpp"
#include "client/cpp/transport/grpc/address.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "client/cpp/transport/grpc/grpc_transport.hpp"
#include "client/cpp/transport/local/open_local.hpp"
#include "collided/v1/collision_service.grpc.pb.h"
#include "proto/constants.hpp"

namespace collided::client {

namespace {

using Service = v1::CollisionService::Stub;

constexpr size_t kTrianglesPerChunk = (1 << 19) / 12;  // 512 KiB, well below the limit of any daemon
constexpr size_t kMaxInlineBytes = 4 << 20;            // of triangles in the message that creates a scene
constexpr size_t kUploadsAtOnce = 8;
constexpr size_t kMostScenes = 1'000'000;  // that a daemon can have
constexpr int kCreateTries = 3;
constexpr std::chrono::milliseconds kRetryPause(200);

/// 128 random bits as hexadecimal digits.
std::string random_id() {
  std::random_device device;
  std::string id;
  for (int word = 0; word < 4; ++word) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(device()));
    id += digits;
  }
  return id;
}

void fill_mesh(const MeshInput& mesh, v1::MeshSpec& out) {
  if (mesh.is_static && mesh.is_rigid)
    throw Error(grpc::INVALID_ARGUMENT, "mesh " + mesh.name + " is static and rigid, and can only be one of them");
  out.set_name(mesh.name);
  out.set_vertex_count(mesh.vertex_count);
  out.set_motion(mesh.is_static  ? v1::MESH_MOTION_STATIC
                 : mesh.is_rigid ? v1::MESH_MOTION_RIGID
                                 : v1::MESH_MOTION_DEFORMABLE);
  out.set_groups(mesh.groups);
  out.set_collide_mask(mesh.collide_mask);
  out.set_no_self_contacts(mesh.no_self_contacts);
  out.set_exclude_rings(mesh.exclude_rings);
  out.set_exclude_rest_pairs(mesh.exclude_rest_pairs);
  out.set_half_thickness(mesh.half_thickness);
  out.set_solid(mesh.solid);
  out.set_triangle_count(static_cast<uint32_t>(mesh.triangles.size()));
  out.set_edges(mesh.edges.data(), mesh.edges.size_bytes());
  out.set_points(mesh.points.data(), mesh.points.size_bytes());
}

/// Puts triangles into a spec of these meshes, those of the smallest first, and returns the meshes whose triangles need
/// a call each: proto/README.md has the rule.
std::vector<uint32_t> put_inline(std::span<const MeshInput> meshes, uint64_t max_message_bytes, v1::SceneSpec& spec) {
  const size_t half = max_message_bytes / 2, used = spec.ByteSizeLong();
  size_t left = std::min(kMaxInlineBytes, half > used ? half - used : 0);
  std::vector<uint32_t> by_size(meshes.size()), uploads;
  std::iota(by_size.begin(), by_size.end(), 0);
  std::ranges::stable_sort(by_size, {}, [&](uint32_t mesh) { return meshes[mesh].triangles.size(); });
  for (const uint32_t mesh : by_size) {
    const auto triangles = std::as_bytes(meshes[mesh].triangles);
    if (triangles.size() > left) {
      uploads.push_back(mesh);
    } else {
      spec.mutable_meshes(static_cast<int>(mesh))->set_triangles(triangles.data(), triangles.size());
      left -= triangles.size();
    }
  }
  return uploads;
}

/// Makes a request for a scene, or a set of them, without triangles.
template <class Request>
Request request_of(v1::SceneSpec spec, std::span<const MeshInput> meshes, double lease_seconds) {
  for (const MeshInput& mesh : meshes) fill_mesh(mesh, *spec.add_meshes());
  Request request;
  request.set_request_id(random_id());
  request.set_lease_seconds(lease_seconds);
  *request.mutable_spec() = std::move(spec);
  return request;
}

const v1::Scene& checked(const v1::Scene& scene) {
  if (scene.scene_id().empty()) throw Error(grpc::DATA_LOSS, "the daemon's answer has no scene");
  return scene;
}

/// Over gRPC there is no device memory, so that a stream must not fall back to it.
void check_handles(const LocalOptions& local) {
  if (local.use == Local::kOn || (local.cuda_ipc_handle.empty() && local.output_cuda_ipc_handle.empty())) return;
  const char* field = local.cuda_ipc_handle.empty() ? "output_cuda_ipc_handle" : "cuda_ipc_handle";
  throw Error(grpc::INVALID_ARGUMENT, std::string("options.local.") + field + " is set, which needs Local::kOn",
              std::string("options.local.") + field);
}

/// Device memory of this process cannot be opened by its handle.
FrameStream stream_in_process(const InProcess& daemon, const v1::OpenStream& open, const StreamOptions& options,
                              std::shared_ptr<const Features> features) {
  const LocalOptions& local = options.local;
  if (!local.cuda_ipc_handle.empty() || !local.output_cuda_ipc_handle.empty())
    throw Error(
        grpc::FAILED_PRECONDITION, "options.local has a handle of device memory, which needs a daemon of its own",
        local.cuda_ipc_handle.empty() ? "options.local.output_cuda_ipc_handle" : "options.local.cuda_ipc_handle");
  return FrameStream::open(daemon.transport(), open,
                           {.is_local = true, .keeper = options.keeper, .features = std::move(features)});
}

}  // namespace

v1::MeshEdit edited_mesh(uint32_t mesh, const MeshInput& input) {
  v1::MeshEdit edit;
  edit.set_mesh(mesh);
  fill_mesh(input, *edit.mutable_spec());
  edit.mutable_spec()->set_triangles(input.triangles.data(), input.triangles.size_bytes());
  return edit;
}

v1::MeshEdit removed_mesh(uint32_t mesh) {
  v1::MeshEdit edit;
  edit.set_mesh(mesh);
  return edit;
}

struct Client::State {
  explicit State(const ChannelFactory& maker) : channels(maker) {
    stub = v1::CollisionService::NewStub(channels.connect());
    info = call(&Service::GetServerInfo, v1::GetServerInfoRequest());
    features = std::make_shared<Features>(info, channels.address());
  }

  template <class Request, class Response>
  Response call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                const Request& request, const std::string& scene_id = "") {
    return call(method, request, channels.call_context(scene_id));
  }

  template <class Request, class Response>
  Response call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                const Request& request, const std::unique_ptr<grpc::ClientContext>& context) {
    if (features) features->check_call(request);
    Response response;
    check(((*stub).*method)(context.get(), request, &response));
    return response;
  }

  /// Returns the context of one of several calls. Throws Error (DEADLINE_EXCEEDED) once it is later than `until`.
  std::unique_ptr<grpc::ClientContext> context_until(FrameTransport::Time until,
                                                     const std::string& scene_id = "") const;

  template <class Request, class Response>
  Response create(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                  const Request& request);
  v1::Scene upload_all(v1::Scene scene, std::span<const MeshInput> meshes, std::span<const uint32_t> uploads);
  v1::Scene upload(const std::string& scene_id, uint32_t index, const MeshInput& mesh);
  void try_delete(const std::string& scene_id);
  bool has_local(const v1::Scene& scene) const { return scene.endpoint().empty() && !info.local_socket().empty(); }
  FrameStream stream_locally(const v1::Scene& scene, const v1::OpenStream& open, const StreamOptions& stream);

  ChannelFactory channels;
  std::unique_ptr<Service> stub;
  v1::GetServerInfoResponse info;
  std::shared_ptr<const Features> features;  ///< null until `info` is known
};

template <class Request, class Response>
Response Client::State::create(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                               const Request& request) {
  for (int tries = 1;; ++tries) try {
      return call(method, request);
    } catch (const Error& e) {
      if (e.code() != grpc::UNAVAILABLE || tries == kCreateTries) throw;
      std::this_thread::sleep_for(kRetryPause * tries);
    }
}

v1::Scene Client::State::upload(const std::string& scene_id, uint32_t index, const MeshInput& mesh) {
  const size_t chunks = mesh.triangles.size() / kTrianglesPerChunk + 1;
  const auto context = channels.call_context(scene_id, std::chrono::seconds(chunks));
  v1::UploadMeshResponse response;
  const auto writer = stub->UploadMesh(context.get(), &response);
  for (size_t at = 0; at < mesh.triangles.size(); at += kTrianglesPerChunk) {
    const auto chunk = mesh.triangles.subspan(at, std::min(kTrianglesPerChunk, mesh.triangles.size() - at));
    v1::UploadMeshRequest request;
    request.set_scene_id(scene_id);
    request.set_mesh(index);
    request.set_triangles(chunk.data(), chunk.size_bytes());
    features->check_call(request);
    if (!writer->Write(request)) break;  // refused: Finish() says why
  }
  writer->WritesDone();
  check(writer->Finish());
  return std::move(*response.mutable_scene());
}

/// Uploads several at a time, as each takes a round trip. A scene that could not be completed is deleted.
v1::Scene Client::State::upload_all(v1::Scene scene, std::span<const MeshInput> meshes,
                                    std::span<const uint32_t> uploads) {
  const std::string id = scene.scene_id();
  std::deque<uint32_t> left(uploads.begin(), uploads.end());
  struct Upload {
    uint32_t mesh;
    bool is_alone;
    std::future<v1::Scene> scene;
  };
  std::deque<Upload> flying;
  size_t at_once = kUploadsAtOnce;
  try {
    while (!left.empty() || !flying.empty()) {
      for (; !left.empty() && flying.size() < at_once; left.pop_front()) {
        const uint32_t mesh = left.front();
        const auto send = [this, &id, mesh, &triangles = meshes[mesh]] { return upload(id, mesh, triangles); };
        flying.push_back({mesh, at_once == 1, std::async(std::launch::async, send)});
      }
      Upload first = std::move(flying.front());
      flying.pop_front();
      try {
        v1::Scene now = first.scene.get();
        if (now.state() == v1::SCENE_STATE_READY) scene = std::move(now);
      } catch (const Error& e) {
        if (first.is_alone || e.code() != grpc::RESOURCE_EXHAUSTED) throw;
        // A client may have few calls open, or little memory: this one goes again, once the others have ended.
        at_once = 1;
        left.push_front(first.mesh);
      }
    }
  } catch (const Error&) {
    try_delete(id);  // which ends the other uploads
    throw;
  }
  return scene;
}

std::unique_ptr<grpc::ClientContext> Client::State::context_until(FrameTransport::Time until,
                                                                  const std::string& scene_id) const {
  using std::chrono::milliseconds;
  const auto left = std::chrono::duration_cast<milliseconds>(until - std::chrono::steady_clock::now());
  if (left > milliseconds(0)) return channels.context_within(scene_id, left);
  throw Error(grpc::DEADLINE_EXCEEDED, "the daemon at " + channels.address() + " did not send all pages within " +
                                           std::to_string(channels.options().deadline.count()) + " ms (deadline)");
}

/// Ignores errors: it cleans up after a failed upload, whose error is the one to report.
void Client::State::try_delete(const std::string& scene_id) {
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  v1::DeleteSceneResponse ignored;
  stub->DeleteScene(channels.call_context(scene_id).get(), request, &ignored);
}

/// Fetches the scene's spec, which determines the memory needed and which the caller's copy may lack.
FrameStream Client::State::stream_locally(const v1::Scene& scene, const v1::OpenStream& open,
                                          const StreamOptions& stream) {
  const LocalOptions& options = stream.local;
  if (!has_local(scene))
    throw Error(grpc::FAILED_PRECONDITION, "options.local is on, but the daemon has no local socket (--local-socket)");
  v1::GetSceneRequest request;
  request.set_scene_id(scene.scene_id());
  const v1::Scene known = call(&Service::GetScene, request, scene.scene_id()).scene();
  const uint32_t limit = info.limits().max_window(),
                 window = open.window() ? open.window() : std::min(v1::kDefaultWindow, limit);
  if (window == 0 || window > limit)
    throw Error(grpc::RESOURCE_EXHAUSTED,
                "window is " + std::to_string(window) + "; the daemon's limit is " + std::to_string(limit),
                "open.window");
  const ConnectOptions& connect = channels.options();
  v1::OpenStream granted = open;
  granted.set_window(window);
  return FrameStream::open(
      open_local({info.local_socket(), channels.address(), connect.token, connect.patience, connect.deadline},
                 local_layout(known, window, options), options),
      granted,
      {.is_local = true,
       .keeper = stream.keeper,
       .deadline = connect.deadline,
       .address = info.local_socket(),
       .features = features});
}

Client::Client(std::unique_ptr<State> state) : state_(std::move(state)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

Client Client::connect(const std::string& address, const ConnectOptions& options) {
  return connect(ChannelFactory(address, options));
}

Client Client::connect(const ChannelFactory& channels) { return Client(std::make_unique<State>(channels)); }

const ChannelFactory& Client::channels() const { return state_->channels; }

const v1::GetServerInfoResponse& Client::server_info() const { return state_->info; }

std::vector<v1::ContactField> Client::contact_fields() const {
  const auto& type = *v1::ContactField_descriptor();
  std::vector<v1::ContactField> fields;
  for_each_column([&](v1::ContactField field, auto) {
    if (!state_->features->lack(type.FindValueByNumber(field)->full_name())) fields.push_back(field);
  });
  return fields;
}

v1::Scene Client::create_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes, double lease_seconds) {
  auto request = request_of<v1::CreateSceneRequest>(std::move(spec), meshes, lease_seconds);
  const auto uploads = put_inline(meshes, state_->info.limits().max_message_bytes(), *request.mutable_spec());
  return state_->upload_all(checked(state_->create(&Service::CreateScene, request).scene()), meshes, uploads);
}

v1::Scene Client::create_scenes(v1::SceneSpec spec, std::span<const MeshInput> meshes, uint32_t count,
                                double lease_seconds) {
  auto request = request_of<v1::CreateScenesRequest>(std::move(spec), meshes, lease_seconds);
  request.set_count(count);
  const auto uploads = put_inline(meshes, state_->info.limits().max_message_bytes(), *request.mutable_spec());
  const v1::CreateScenesResponse made = state_->create(&Service::CreateScenes, request);
  if (made.scenes().worlds() != count)
    throw Error(grpc::DATA_LOSS, "scenes.worlds is " + std::to_string(made.scenes().worlds()) + "; " +
                                     std::to_string(count) + " were asked for");
  return state_->upload_all(checked(made.scenes()), meshes, uploads);
}

v1::EstimateSceneResponse Client::estimate_scene(v1::SceneSpec spec, std::span<const MeshInput> meshes) {
  for (const MeshInput& mesh : meshes) fill_mesh(mesh, *spec.add_meshes());
  v1::EstimateSceneRequest request;
  *request.mutable_spec() = std::move(spec);
  return state_->call(&Service::EstimateScene, request);
}

v1::Scene Client::get_scene(const std::string& scene_id) {
  v1::GetSceneRequest request;
  request.set_scene_id(scene_id);
  return std::move(*state_->call(&Service::GetScene, request, scene_id).mutable_scene());
}

std::vector<v1::Scene> Client::list_scenes() {
  const auto until = time_after(state_->channels.options().deadline);
  std::vector<v1::Scene> scenes;
  v1::ListScenesRequest request;
  do {
    v1::ListScenesResponse page = state_->call(&Service::ListScenes, request, state_->context_until(until));
    const bool is_last = page.next_page_token().empty(), is_too_many = scenes.size() >= kMostScenes;
    if (!is_last && (page.scenes().empty() || is_too_many))
      throw Error(grpc::DATA_LOSS, "next_page_token is set after a page of " + std::to_string(page.scenes_size()) +
                                       " scenes, " + std::to_string(scenes.size()) + " before it");
    for (v1::Scene& scene : *page.mutable_scenes()) {
      if (!scenes.empty() && scene.scene_id() <= scenes.back().scene_id())
        throw Error(grpc::DATA_LOSS, "scenes names '" + scene.scene_id() + "' after '" + scenes.back().scene_id() +
                                         "'; ids must ascend");
      scenes.push_back(std::move(scene));
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

MeshElements Client::mesh_elements(const std::string& scene_id, uint32_t mesh) {
  v1::GetMeshRequest request;
  request.set_scene_id(scene_id);
  request.set_mesh(mesh);
  const auto until = time_after(state_->channels.options().deadline);
  return read_elements(mesh, [&](uint32_t first) {
    request.set_first_element(first);
    const std::chrono::seconds more(first / kTrianglesPerChunk);  // as uploads have
    return state_->call(&Service::GetMesh, request, state_->context_until(until + more, scene_id));
  });
}

void Client::delete_scene(const std::string& scene_id) {
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  state_->call(&Service::DeleteScene, request, scene_id);
}

FrameStream Client::stream(const v1::Scene& scene, const StreamOptions& options) {
  v1::OpenStream open;
  open.set_scene_id(scene.scene_id());
  open.set_window(options.window);
  open.set_delivery(options.delivery);
  open.set_resume_token(options.resume_token);
  const ChannelFactory& own = state_->channels;
  std::string local_refusal;
  check_handles(options.local);
  if (own.in_process()) return stream_in_process(*own.in_process(), open, options, state_->features);
  if (options.local.use == Local::kOn) return state_->stream_locally(scene, open, options);
  if (options.local.use == Local::kAutomatic && has_local_transport() && is_local_address(own.address()) &&
      state_->has_local(scene))
    try {
      return state_->stream_locally(scene, open, options);
    } catch (const Error& e) {  // if gRPC fails as well, its error is thrown
      local_refusal = e.message();
    }
  const ChannelFactory channels = scene.endpoint().empty() ? own : ChannelFactory(scene.endpoint(), own.options());
  return FrameStream::open(
      std::make_unique<GrpcTransport>(channels.connect(), channels.context(scene.scene_id()),
                                      state_->info.limits().max_message_bytes(), own.options().deadline),
      open,
      {.local_refusal = std::move(local_refusal),
       .keeper = options.keeper,
       .deadline = own.options().deadline,
       .address = channels.address(),
       .features = state_->features});
}

FrameStream Client::resume(const v1::Scene& scene, StreamOptions options) {
  options.resume_token = scene.resume_token();
  return stream(scene, options);
}

Watcher Client::watch(const std::string& scene_id, const WatchOptions& options) {
  return Watcher::open(state_->channels, scene_id, options, state_->features);
}

}  // namespace collided::client
