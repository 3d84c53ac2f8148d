#pragma once
// The RPCs of CollisionService except StreamFrames (transport/grpc/frame_calls.hpp). None does engine work itself: the
// scene's worker does.

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/auth/authenticator.hpp"
#include "server/config/config.hpp"
#include "server/convert/scene.hpp"
#include "server/limits/decode_budget.hpp"
#include "server/limits/waiting_calls.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/timed_jobs.hpp"
#include "server/transport/grpc/caller.hpp"
#include "server/transport/grpc/raw_service.hpp"
#include "server/transport/grpc/rpc_router.hpp"
#include "server/transport/grpc/unary_call.hpp"

namespace collided::server {

class CollisionService final : public RawService {
 public:
  /// `host` and `authenticator` outlive the service.
  CollisionService(const Config& config, SceneHost& host, const Authenticator& authenticator);

  /// Adds all methods except StreamFrames. Before the server is built; the service must outlive it.
  void add_to(RpcRouter& router);
  /// Number of open calls.
  uint64_t in_work() const { return static_cast<uint64_t>(calls_.use_count() - 1) + work_.size(); }
  WaitingCalls& waiting() { return waiting_; }
  const CallParts& parts() const { return parts_; }

  grpc::ServerReadReactor<grpc::ByteBuffer>* UploadMesh(grpc::CallbackServerContext*, grpc::ByteBuffer*) override;

 private:
  template <class Request, class Response>
  using Body = void (CollisionService::*)(UnaryCall<Request, Response>&);

  template <class Request, class Response>
  void add(RpcRouter& router, const char* method, Body<Request, Response> body);
  void get_server_info(UnaryCall<pb::GetServerInfoRequest, pb::GetServerInfoResponse>& call);
  void create_scene(UnaryCall<pb::CreateSceneRequest, pb::CreateSceneResponse>& call);
  void create_scenes(UnaryCall<pb::CreateScenesRequest, pb::CreateScenesResponse>& call);
  void estimate_scene(UnaryCall<pb::EstimateSceneRequest, pb::EstimateSceneResponse>& call);
  void get_scene(UnaryCall<pb::GetSceneRequest, pb::GetSceneResponse>& call);
  void get_mesh(UnaryCall<pb::GetMeshRequest, pb::GetMeshResponse>& call);
  void list_scenes(UnaryCall<pb::ListScenesRequest, pb::ListScenesResponse>& call);
  void delete_scene(UnaryCall<pb::DeleteSceneRequest, pb::DeleteSceneResponse>& call);
  void detect_frame(UnaryCall<pb::DetectFrameRequest, pb::DetectFrameResponse>& call);
  void detect_batch(UnaryCall<pb::DetectBatchRequest, pb::DetectBatchResponse>& call);
  /// Answers with the scene in `out`, a part of the call's response.
  void make_scene(UnaryCallBase& call, SceneRequest request, pb::Scene* out);
  SceneDefaults defaults(const Client& client) const;
  void build(const SceneUse& scene, UnaryCallBase& call, pb::Scene* out);

  const Config config_;
  SceneHost& host_;
  const std::vector<Device> devices_;
  DecodeBudget budget_;
  WaitingCalls waiting_;
  ClientWork work_;
  const CallParts parts_;
  TimedJobs watch_jobs_;
  const std::shared_ptr<int> calls_ = std::make_shared<int>();  // each open call holds a copy
};

}  // namespace collided::server
