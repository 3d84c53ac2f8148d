#pragma once
// The RPCs of CollisionService. No body does engine work: that goes to the scene's worker.

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <vector>

#include "collided/v1/collision_service.grpc.pb.h"
#include "server/config/config.hpp"
#include "server/convert/convert.hpp"
#include "server/scenes/scene_store.hpp"
#include "server/service/service_stream.hpp"
#include "server/service/service_upload.hpp"

namespace collided::server {

class CollisionService final : public pb::CollisionService::CallbackService {
 public:
  explicit CollisionService(const Config& config);

  /// Refuses new scenes and streams, and tells every open stream that the daemon stops.
  void announce_stop(double seconds);
  /// Waits until no call is in work; false if `deadline` came first.
  bool wait_idle(std::chrono::steady_clock::time_point deadline) const;
  /// Ends all scenes. After the gRPC server is down.
  void clear() { scenes_.clear(); }

  using Context = grpc::CallbackServerContext;
  using Reactor = grpc::ServerUnaryReactor;
  Reactor* GetServerInfo(Context*, const pb::GetServerInfoRequest*, pb::GetServerInfoResponse*) override;
  Reactor* CreateScene(Context*, const pb::CreateSceneRequest*, pb::CreateSceneResponse*) override;
  grpc::ServerReadReactor<pb::UploadMeshRequest>* UploadMesh(Context*, pb::UploadMeshResponse*) override;
  Reactor* GetScene(Context*, const pb::GetSceneRequest*, pb::GetSceneResponse*) override;
  Reactor* ListScenes(Context*, const pb::ListScenesRequest*, pb::ListScenesResponse*) override;
  Reactor* DeleteScene(Context*, const pb::DeleteSceneRequest*, pb::DeleteSceneResponse*) override;
  Reactor* DetectFrame(Context*, const pb::DetectFrameRequest*, pb::DetectFrameResponse*) override;
  grpc::ServerBidiReactor<pb::StreamFramesRequest, pb::StreamFramesResponse>* StreamFrames(Context*) override;
  grpc::ServerWriteReactor<pb::WatchSceneResponse>* WatchScene(Context*, const pb::WatchSceneRequest*) override;

 private:
  void build(const std::shared_ptr<Scene>& scene, pb::CreateSceneResponse* response, Reactor* reactor);

  SceneDefaults defaults_;
  std::vector<DeviceInfo> devices_;
  SceneStore scenes_;
  const std::shared_ptr<int> calls_ = std::make_shared<int>();  // each call in work holds a copy
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::vector<std::weak_ptr<FrameStream>> streams_;  // guarded by mutex_
};

}  // namespace collided::server
