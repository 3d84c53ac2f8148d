// The RPCs of CollisionService.
#include "server/service/service.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "server/errors.hpp"
#include "server/service/status.hpp"

namespace collided::server {
namespace {

constexpr uint32_t kMaxPage = 1000, kDefaultPage = 100;
constexpr size_t kFullPageBytes = size_t{1} << 20;  // a page may pass it by one scene

// Runs a body and finishes with what it throws.
template <class Body>
void guard(grpc::ServerUnaryReactor* reactor, const Body& body) {
  try {
    body();
  } catch (...) {
    const Failure failure = describe_current();
    spdlog::info("refused: {}", failure.message);
    reactor->Finish(to_status(failure));
  }
}

// Answers at once; `body` fills the response.
template <class Body>
grpc::ServerUnaryReactor* answer(grpc::CallbackServerContext* context, const Body& body) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    body();
    reactor->Finish(grpc::Status::OK);
  });
  return reactor;
}

// The default backend's devices come first.
std::vector<DeviceInfo> order_devices(std::vector<DeviceInfo> devices, const SceneDefaults& defaults) {
  const bool cuda = defaults.backend != "cpu" && defaults.cuda;
  const auto first = cuda ? Backend::kCuda : Backend::kCpu;
  std::stable_partition(devices.begin(), devices.end(), [&](const auto& device) { return device.backend == first; });
  return devices;
}

class Unserved final : public grpc::ServerWriteReactor<pb::WatchSceneResponse> {
 public:
  Unserved() { Finish(to_status(describe(std::make_exception_ptr(Unimplemented("", "WatchScene is not served"))))); }
  void OnDone() override { delete this; }
};

}  // namespace

CollisionService::CollisionService(const Config& config)
    : defaults_{config.backend, config.threads, config.limits, cuda_available()},
      devices_(order_devices(list_devices(), defaults_)),
      scenes_(config.limits.max_scenes, config.limits.max_window) {}

void CollisionService::announce_stop(double seconds) {
  stopping_ = true;
  std::lock_guard lock(mutex_);
  for (const auto& weak : streams_)
    if (const auto stream = weak.lock()) stream->announce_stop(seconds);
}

bool CollisionService::wait_idle(std::chrono::steady_clock::time_point deadline) const {
  constexpr auto kPoll = std::chrono::milliseconds(5);
  for (; calls_.use_count() > 1; std::this_thread::sleep_for(kPoll))
    if (std::chrono::steady_clock::now() >= deadline) return false;
  return true;
}

grpc::ServerUnaryReactor* CollisionService::GetServerInfo(Context* context, const pb::GetServerInfoRequest*,
                                                          pb::GetServerInfoResponse* response) {
  return answer(context, [&] {
    response->set_version(COLLIDED_VERSION);
    for (const auto& device : devices_) fill_device(device, response->add_devices());
    fill_limits(defaults_.limits, response->mutable_limits());
  });
}

grpc::ServerUnaryReactor* CollisionService::CreateScene(Context* context, const pb::CreateSceneRequest* request,
                                                        pb::CreateSceneResponse* response) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    if (stopping_) throw Stopping();
    auto scene = scenes_.add(parse_scene(*request, defaults_));
    scene->worker().post([=, this, held = calls_] { build(scene, response, reactor); });
  });
  return reactor;
}

void CollisionService::build(const std::shared_ptr<Scene>& scene, pb::CreateSceneResponse* response, Reactor* reactor) {
  guard(reactor, [&] {
    try {
      scene->build_if_complete();
    } catch (const NotFound&) {
      throw;
    } catch (...) {
      scenes_.remove(scene->id());
      throw;
    }
    fill_scene(*scene, response->mutable_scene());
    const auto& made = response->scene();
    spdlog::info("scene {} \"{}\": created {}, {} vertices, {} triangles", scene->id(), made.spec().display_name(),
                 made.device().empty() ? "without all its triangles" : "on " + made.device(), made.vertex_count(),
                 made.triangle_count());
    reactor->Finish(grpc::Status::OK);
  });
}

grpc::ServerReadReactor<pb::UploadMeshRequest>* CollisionService::UploadMesh(Context* context,
                                                                             pb::UploadMeshResponse* response) {
  return new MeshUpload(*context, scenes_, response, calls_);
}

grpc::ServerUnaryReactor* CollisionService::GetScene(Context* context, const pb::GetSceneRequest* request,
                                                     pb::GetSceneResponse* response) {
  return answer(context, [&] { fill_scene(*scenes_.find(request->scene_id()), response->mutable_scene()); });
}

grpc::ServerUnaryReactor* CollisionService::ListScenes(Context* context, const pb::ListScenesRequest* request,
                                                       pb::ListScenesResponse* response) {
  return answer(context, [&] {
    const uint32_t size = request->page_size() ? request->page_size() : kDefaultPage;
    if (size > kMaxPage) throw InvalidInput("page_size", fmt::format("page_size is {}, more than {}", size, kMaxPage));
    auto page = scenes_.page(request->page_token(), size + 1);  // one more tells whether a page follows
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
    auto scene = scenes_.remove(request->scene_id());
    scene->worker().post([scene, reactor, held = calls_] {
      scene->release();
      spdlog::info("scene {}: deleted", scene->id());
      reactor->Finish(grpc::Status::OK);
    });
  });
  return reactor;
}

grpc::ServerUnaryReactor* CollisionService::DetectFrame(Context* context, const pb::DetectFrameRequest* request,
                                                        pb::DetectFrameResponse* response) {
  auto* reactor = context->DefaultReactor();
  guard(reactor, [&] {
    auto scene = scenes_.find(request->scene_id());
    auto job = [=, held = calls_, arrival = std::chrono::steady_clock::now()] {
      guard(reactor, [&] {
        auto done = run_frame(*scene, {request->frame(), arrival, [=] { return context->IsCancelled(); }});
        check_answer(done, request->frame().frame_id());
        for (auto& chunk : done.contacts) *response->add_contacts() = std::move(chunk);
        *response->mutable_done() = std::move(done.done);
        reactor->Finish(grpc::Status::OK);
      });
    };
    if (!scene->worker().try_post(std::move(job)))
      throw LimitExceeded(
          "frame", fmt::format("more than {} frames wait for scene {}", defaults_.limits.max_window, scene->id()));
  });
  return reactor;
}

grpc::ServerBidiReactor<pb::StreamFramesRequest, pb::StreamFramesResponse>* CollisionService::StreamFrames(Context*) {
  auto stream = std::make_shared<FrameStream>(scenes_, defaults_.limits.max_window, calls_);
  if (stopping_) {
    stream->refuse(to_status(describe(std::make_exception_ptr(Stopping()))));
    return stream.get();
  }
  {
    std::lock_guard lock(mutex_);
    std::erase_if(streams_, [](const auto& weak) { return weak.expired(); });
    streams_.push_back(stream);
  }
  stream->start();
  return stream.get();
}

grpc::ServerWriteReactor<pb::WatchSceneResponse>* CollisionService::WatchScene(Context*, const pb::WatchSceneRequest*) {
  return new Unserved;
}

}  // namespace collided::server
