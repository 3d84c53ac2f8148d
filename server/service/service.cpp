// The RPCs of CollisionService but for StreamFrames.
#include "server/service/service.hpp"

#include <algorithm>
#include <utility>

#include "server/errors.hpp"
#include "server/service/detect_frame.hpp"
#include "server/service/guard.hpp"
#include "server/service/mesh_upload.hpp"

namespace collided::server {
namespace {

constexpr uint32_t kMaxPage = 1000, kDefaultPage = 100;
constexpr size_t kFullPageBytes = size_t{1} << 20;  // a page may pass it by one scene

// The default backend's devices come first.
std::vector<DeviceInfo> order_devices(std::vector<DeviceInfo> devices, bool cuda_first) {
  const auto first = cuda_first ? Backend::kCuda : Backend::kCpu;
  std::stable_partition(devices.begin(), devices.end(), [&](const auto& device) { return device.backend == first; });
  return devices;
}

class Unserved final : public grpc::ServerWriteReactor<pb::WatchSceneResponse> {
 public:
  Unserved() { Finish(to_status(describe(std::make_exception_ptr(Unimplemented("", "WatchScene is not served"))))); }
  void OnDone() override { delete this; }
};

}  // namespace

CollisionService::CollisionService(const Config& config, SceneHost& host, const Authenticator& authenticator)
    : config_(config),
      has_cuda_(cuda_available()),
      devices_(order_devices(list_devices(), config.backend != "cpu" && has_cuda_)),
      host_(host),
      authenticator_(authenticator) {}

// Answers at once; `body` fills the response.
template <class Body>
grpc::ServerUnaryReactor* CollisionService::answer(Context* context, const Body& body) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    body(identify(*context, authenticator_).client);
    reactor->Finish(grpc::Status::OK);
  });
  return reactor;
}

SceneDefaults CollisionService::defaults(const Client& client) const {
  Limits limits = host_.limits();
  limits.client = client->limits;
  return {config_.backend, config_.threads, limits, has_cuda_, !config_.local_socket.empty()};
}

grpc::ServerUnaryReactor* CollisionService::GetServerInfo(Context* context, const pb::GetServerInfoRequest*,
                                                          pb::GetServerInfoResponse* response) {
  return answer(context, [&](const Client& client) {
    response->set_version(COLLIDED_VERSION);
    for (const auto& device : devices_) fill_device(device, response->add_devices());
    fill_limits(host_.limits(), client->limits, response->mutable_limits());
    response->set_local_socket(config_.local_socket);
  });
}

grpc::ServerUnaryReactor* CollisionService::CreateScene(Context* context, const pb::CreateSceneRequest* request,
                                                        pb::CreateSceneResponse* response) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    const Caller caller = identify(*context, authenticator_);
    auto [scene, is_new] = host_.add_scene(caller.client, parse_scene(*request, defaults(caller.client)));
    Scene& target = *scene;
    if (is_new)
      return target.worker().post(
          [=, this, scene = std::move(scene), held = calls_] { build(scene, caller, response, reactor); });
    target.worker().post([=, this, scene = std::move(scene), held = calls_] {  // once the first request has made it
      guard(reactor, [&] {
        scene->check_open();
        fill_scene(*scene, response->mutable_scene());
        reactor->Finish(grpc::Status::OK);
      });
    });
  });
  return reactor;
}

void CollisionService::build(const SceneUse& scene, const Caller& caller, pb::CreateSceneResponse* response,
                             Reactor* reactor) {
  guard(reactor, [&] {
    try {
      scene->build_if_complete();
    } catch (const NotFound&) {
      throw;
    } catch (...) {
      host_.scenes().remove(caller.client, scene->id())->release();
      throw;
    }
    fill_scene(*scene, response->mutable_scene());
    const auto& made = response->scene();
    log_event(spdlog::level::info, "scene created",
              {{"scene", scene->id()},
               {"name", made.spec().display_name()},
               {"device", made.device().empty() ? "awaits triangles" : made.device()},
               {"vertices", made.vertex_count()},
               {"triangles", made.triangle_count()},
               {"client", caller.client->name},
               {"request", caller.ids.request_id},
               {"trace", caller.ids.trace_id}});
    reactor->Finish(grpc::Status::OK);
  });
}

grpc::ServerReadReactor<pb::UploadMeshRequest>* CollisionService::UploadMesh(Context* context,
                                                                             pb::UploadMeshResponse* response) {
  return new MeshUpload(*context, host_, authenticator_, response, calls_);
}

grpc::ServerUnaryReactor* CollisionService::GetScene(Context* context, const pb::GetSceneRequest* request,
                                                     pb::GetSceneResponse* response) {
  return answer(context, [&](const Client& client) {
    fill_scene(*host_.scenes().find(client, request->scene_id()), response->mutable_scene());
  });
}

grpc::ServerUnaryReactor* CollisionService::ListScenes(Context* context, const pb::ListScenesRequest* request,
                                                       pb::ListScenesResponse* response) {
  return answer(context, [&](const Client& client) {
    const uint32_t size = request->page_size() ? request->page_size() : kDefaultPage;
    if (size > kMaxPage) throw InvalidInput("page_size", fmt::format("page_size is {}, more than {}", size, kMaxPage));
    auto page = host_.scenes().page(client, request->page_token(), size + 1);  // one more tells whether a page follows
    size_t shown = 0;
    for (size_t bytes = 0; shown < std::min<size_t>(page.size(), size) && bytes < kFullPageBytes; ++shown) {
      fill_scene(*page[shown], response->add_scenes());
      bytes += response->scenes().rbegin()->ByteSizeLong();
    }
    if (shown < page.size()) response->set_next_page_token(page[shown - 1]->id());
  });
}

grpc::ServerUnaryReactor* CollisionService::DeleteScene(Context* context, const pb::DeleteSceneRequest* request,
                                                        pb::DeleteSceneResponse*) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    const Caller caller = identify(*context, authenticator_);
    auto scene = host_.scenes().remove(caller.client, request->scene_id());
    host_.end_stale_uploads();
    scene->worker().post([scene, caller, reactor, held = calls_] {
      scene->release();
      log_event(spdlog::level::info, "scene deleted",
                {{"scene", scene->id()},
                 {"client", caller.client->name},
                 {"request", caller.ids.request_id},
                 {"trace", caller.ids.trace_id}});
      reactor->Finish(grpc::Status::OK);
    });
  });
  return reactor;
}

grpc::ServerUnaryReactor* CollisionService::DetectFrame(Context* context, const pb::DetectFrameRequest* request,
                                                        pb::DetectFrameResponse* response) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    IncomingFrame incoming;
    const SceneUse scene = host_.scenes().find(identify(*context, authenticator_).client, request->scene_id());
    incoming.message = request->frame();
    auto frame = std::make_shared<PendingFrame>(admit_frame(host_, *scene, std::move(incoming)));
    const auto job = [=, held = calls_] { detect_frame(reactor, context, *scene, std::move(*frame), response); };
    if (!scene->worker().try_post(job))
      throw LimitExceeded::quota("scene:" + scene->id(),
                                 fmt::format("max_window is {}, and as many frames wait for scene {}",
                                             host_.limits().max_window, scene->id()));
  });
  return reactor;
}

grpc::ServerWriteReactor<pb::WatchSceneResponse>* CollisionService::WatchScene(Context*, const pb::WatchSceneRequest*) {
  return new Unserved;
}

}  // namespace collided::server
