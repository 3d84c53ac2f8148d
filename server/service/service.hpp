#pragma once
// The RPCs of CollisionService but for StreamFrames (frame_calls.hpp). No body does engine work: that goes to the
// scene's worker.

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/auth/authenticator.hpp"
#include "server/config/config.hpp"
#include "server/convert/convert.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/caller.hpp"
#include "server/service/raw_service.hpp"

namespace collided::server {

class CollisionService final : public RawService {
 public:
  /// `host` and `authenticator` outlive the service.
  CollisionService(const Config& config, SceneHost& host, const Authenticator& authenticator);

  /// Calls in work.
  uint64_t in_work() const { return static_cast<uint64_t>(calls_.use_count() - 1); }

  using Context = grpc::CallbackServerContext;
  using Reactor = grpc::ServerUnaryReactor;
  Reactor* GetServerInfo(Context*, const pb::GetServerInfoRequest*, pb::GetServerInfoResponse*) override;
  Reactor* CreateScene(Context*, const pb::CreateSceneRequest*, pb::CreateSceneResponse*) override;
  grpc::ServerReadReactor<pb::UploadMeshRequest>* UploadMesh(Context*, pb::UploadMeshResponse*) override;
  Reactor* GetScene(Context*, const pb::GetSceneRequest*, pb::GetSceneResponse*) override;
  Reactor* ListScenes(Context*, const pb::ListScenesRequest*, pb::ListScenesResponse*) override;
  Reactor* DeleteScene(Context*, const pb::DeleteSceneRequest*, pb::DeleteSceneResponse*) override;
  Reactor* DetectFrame(Context*, const pb::DetectFrameRequest*, pb::DetectFrameResponse*) override;
  grpc::ServerWriteReactor<pb::WatchSceneResponse>* WatchScene(Context*, const pb::WatchSceneRequest*) override;

 private:
  template <class Body>
  Reactor* answer(Context* context, const Body& body);
  SceneDefaults defaults(const Client& client) const;
  void build(const SceneUse& scene, const Caller& caller, pb::CreateSceneResponse* response, Reactor* reactor);

  const Config config_;
  const bool has_cuda_;
  const std::vector<DeviceInfo> devices_;
  SceneHost& host_;
  const Authenticator& authenticator_;
  const std::shared_ptr<int> calls_ = std::make_shared<int>();  // each call in work holds a copy
};

}  // namespace collided::server
