// The RPCs of CollisionService except StreamFrames.
#include "server/service/service.hpp"

#include <algorithm>
#include <utility>

#include "proto/additions.hpp"
#include "server/batch/detect_batch.hpp"
#include "server/convert/facts.hpp"
#include "server/errors.hpp"
#include "server/service/get_mesh.hpp"
#include "server/service/mesh_upload.hpp"
#include "server/service/page_token.hpp"
#include "server/service/watch_call.hpp"
#include "server/transport/grpc/detect_frame.hpp"

namespace collided::server {
namespace {

constexpr uint32_t kMaxPage = 1000, kDefaultPage = 100;
constexpr size_t kFullPageBytes = size_t{1} << 20;  // exceeded by one scene at most

// The default backend's devices come first.
std::vector<DeviceState> order_devices(std::vector<DeviceState> devices, const std::string& backend) {
  const auto first = backend == "cpu" ? Backend::kCpu : Backend::kCuda;
  std::ranges::stable_partition(devices, [&](const auto& each) { return each.info.device.backend == first; });
  return devices;
}

std::vector<Device> devices_of(const SceneHost& host) {
  std::vector<Device> devices;
  for (const DeviceInfo& info : host.devices().infos()) devices.push_back(info.device);
  return devices;
}

std::string path_of(const char* method) {
  return fmt::format("/{}/{}", pb::CollisionService::service_full_name(), method);
}

class RefusedUpload final : public grpc::ServerReadReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedUpload(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

}  // namespace

CollisionService::CollisionService(const Config& config, SceneHost& host, const Authenticator& authenticator)
    : config_(config),
      host_(host),
      devices_(devices_of(host)),
      budget_(decode_budget_bytes(config.limits)),
      work_(host.host_turns()),
      parts_{authenticator, host, budget_, waiting_, work_, config.limits.max_message_bytes} {}

template <class Request, class Response>
void CollisionService::add(RpcRouter& router, const char* method, Body<Request, Response> body) {
  router.add(path_of(method), [this, body](grpc::GenericCallbackServerContext& context) {
    const auto run = [this, body](UnaryCall<Request, Response>& call) { (this->*body)(call); };
    return serve_unary<Request, Response>(context, parts_, run);
  });
}

void CollisionService::add_to(RpcRouter& router) {
  add(router, "GetServerInfo", &CollisionService::get_server_info);
  add(router, "CreateScene", &CollisionService::create_scene);
  add(router, "CreateScenes", &CollisionService::create_scenes);
  add(router, "EstimateScene", &CollisionService::estimate_scene);
  add(router, "GetScene", &CollisionService::get_scene);
  add(router, "GetMesh", &CollisionService::get_mesh);
  add(router, "ListScenes", &CollisionService::list_scenes);
  add(router, "DeleteScene", &CollisionService::delete_scene);
  add(router, "DetectFrame", &CollisionService::detect_frame);
  add(router, "DetectBatch", &CollisionService::detect_batch);
  router.add(path_of("WatchScene"), [this](grpc::GenericCallbackServerContext& context) {
    return WatchCall::serve(context, host_, parts_, watch_jobs_);
  });
}

SceneDefaults CollisionService::defaults(const Client& client) const {
  Limits limits = host_.limits();
  limits.client = client->limits;
  return {config_.backend, config_.threads, limits, !config_.local_socket.empty(), devices_};
}

void CollisionService::get_server_info(UnaryCall<pb::GetServerInfoRequest, pb::GetServerInfoResponse>& call) {
  auto& response = call.response();
  response.set_version(COLLIDED_VERSION);
  for (const auto& device : order_devices(host_.devices().state(), config_.backend))
    fill_device(device, response.add_devices());
  for (const auto& device : host_.devices().unusable()) fill_unusable(device, response.add_unusable_devices());
  fill_limits(host_.limits(), call.caller().client->limits, response.mutable_limits());
  response.set_local_socket(config_.local_socket);
  static const auto kAdditions = pb::additions_of(*pb::GetServerInfoResponse::descriptor()->file());
  for (const auto& [feature, release] : kAdditions) response.add_features(feature);
  call.finish();
}

void CollisionService::create_scene(UnaryCall<pb::CreateSceneRequest, pb::CreateSceneResponse>& call) {
  make_scene(call, parse_scene(call.request(), defaults(call.caller().client)), call.response().mutable_scene());
}

void CollisionService::create_scenes(UnaryCall<pb::CreateScenesRequest, pb::CreateScenesResponse>& call) {
  make_scene(call, parse_scenes(call.request(), defaults(call.caller().client)), call.response().mutable_scenes());
}

void CollisionService::make_scene(UnaryCallBase& call, SceneRequest request, pb::Scene* out) {
  auto [scene, is_new] = host_.add_scene(call.caller().client, std::move(request));
  Scene& target = *scene;
  if (is_new)
    return target.worker().post(
        [this, &call, out, scene = std::move(scene), held = calls_] { build(scene, call, out); });
  target.worker().post([&call, out, scene = std::move(scene), held = calls_] {  // once the first request has created it
    guard(call, [&] {
      scene->engine().check_built();
      scene->record().check_open();
      fill_scene(*scene, out);
      call.finish();
    });
  });
}

void CollisionService::build(const SceneUse& scene, UnaryCallBase& call, pb::Scene* out) {
  const Caller& caller = call.caller();
  guard(call, [&] {
    try {
      scene->engine().build_if_complete();
    } catch (const NotFound&) {
      throw;
    } catch (...) {
      host_.scenes().remove(caller.client, scene->id())->release();
      throw;
    }
    fill_scene(*scene, out);
    const pb::Scene& made = *out;
    log_event(spdlog::level::info, "scene created",
              {{"scene", scene->id()},
               {"name", made.spec().display_name()},
               {"device", made.device_id()},
               {"on", made.device().empty() ? "awaits triangles" : made.device()},
               {"vertices", made.vertex_count()},
               {"triangles", made.triangle_count()},
               {"worlds", made.worlds()},
               {"client", caller.client->name},
               {"request", caller.ids.request_id},
               {"trace", caller.ids.trace_id}});
    call.finish();
  });
}

void CollisionService::estimate_scene(UnaryCall<pb::EstimateSceneRequest, pb::EstimateSceneResponse>& call) {
  const Client& client = call.caller().client;
  const ScenePlan plan = parse_spec(call.request().spec(), defaults(client));
  host_.check_could_add(client, plan);
  fill_estimate(plan, &call.response());
  const DeviceInfo& device = host_.devices().preferred(wish_of(plan));
  call.response().set_device(device.name);
  call.response().set_device_id(to_string(device.device));
  call.finish();
}

grpc::ServerReadReactor<grpc::ByteBuffer>* CollisionService::UploadMesh(grpc::CallbackServerContext* context,
                                                                        grpc::ByteBuffer* response) try {
  return new MeshUpload(*context, host_, parts_, response, calls_);
} catch (...) {  // gRPC itself would answer UNIMPLEMENTED
  return new RefusedUpload(to_status(describe_current()));
}

void CollisionService::get_scene(UnaryCall<pb::GetSceneRequest, pb::GetSceneResponse>& call) {
  fill_scene(*host_.scenes().find(call.caller().client, call.request().scene_id()), call.response().mutable_scene());
  call.finish();
}

void CollisionService::get_mesh(UnaryCall<pb::GetMeshRequest, pb::GetMeshResponse>& call) {
  server::get_mesh(call, host_, calls_);
}

void CollisionService::list_scenes(UnaryCall<pb::ListScenesRequest, pb::ListScenesResponse>& call) {
  const auto& request = call.request();
  auto& response = call.response();
  const uint32_t size = request.page_size() ? request.page_size() : kDefaultPage;
  if (size > kMaxPage) throw InvalidInput("page_size", fmt::format("page_size is {}, more than {}", size, kMaxPage));
  check_page_token(request.page_token(), config_.name);
  // One more, to see whether another page follows.
  auto page = host_.scenes().page(call.caller().client, request.page_token(), size + 1);
  size_t shown = 0;
  for (size_t bytes = 0; shown < std::min<size_t>(page.size(), size) && bytes < kFullPageBytes; ++shown) {
    fill_scene(*page[shown], response.add_scenes());
    bytes += response.scenes().rbegin()->ByteSizeLong();
  }
  if (shown < page.size()) response.set_next_page_token(page[shown - 1]->id());
  call.finish();
}

void CollisionService::delete_scene(UnaryCall<pb::DeleteSceneRequest, pb::DeleteSceneResponse>& call) {
  auto scene = host_.scenes().remove(call.caller().client, call.request().scene_id());
  host_.end_stale_uploads();
  scene->worker().post([scene, &call, held = calls_] {
    guard(call, [&] {
      scene->release();
      const Caller& caller = call.caller();
      log_event(spdlog::level::info, "scene deleted",
                {{"scene", scene->id()},
                 {"client", caller.client->name},
                 {"request", caller.ids.request_id},
                 {"trace", caller.ids.trace_id}});
      call.finish();
    });
  });
}

void CollisionService::detect_frame(UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>& call) {
  server::detect_frame(call, host_, calls_);
}

void CollisionService::detect_batch(UnaryCall<pb::DetectBatchRequest, pb::DetectBatchResponse>& call) {
  server::detect_batch(call, host_, calls_);
}

}  // namespace collided::server
