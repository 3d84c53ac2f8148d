#pragma once
// One UploadMesh call: collects the chunks of one mesh and hands them to the scene's worker at the end.

#include <grpcpp/grpcpp.h>

#include <memory>

#include "collided/v1/collision_service.pb.h"
#include "server/limits/waiting_calls.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/transport/grpc/caller.hpp"
#include "server/transport/grpc/request_call.hpp"

namespace collided::server {

namespace pb = collided::v1;

class MeshUpload final : public grpc::ServerReadReactor<grpc::ByteBuffer> {
 public:
  /// `host` and `parts` must outlive the call, which keeps `held` alive.
  MeshUpload(const grpc::CallbackServerContext& context, SceneHost& host, const CallParts& parts,
             grpc::ByteBuffer* response, std::shared_ptr<void> held);

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void await_first();
  void read();
  void take_chunk();
  void parse();
  void begin();
  void finish(const grpc::Status& status);
  void take();
  void check_cancelled() const;
  void delete_if_unusable();
  void commit();
  void add_to_scene();

  const grpc::CallbackServerContext& context_;
  SceneHost& host_;
  const CallParts& parts_;
  grpc::ByteBuffer* response_;
  const std::shared_ptr<void> held_;
  const std::shared_ptr<Upload> upload_;
  Caller caller_;
  grpc::ByteBuffer bytes_;  // of the awaited chunk
  pb::UploadMeshRequest request_;
  std::shared_ptr<void> share_;  // of the decode budget, for the current chunk
  std::unique_ptr<WaitingCalls::Wait> first_chunk_;
};

}  // namespace collided::server
