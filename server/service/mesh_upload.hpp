#pragma once
// One UploadMesh call: gathers the chunks of one mesh and hands them to the scene's worker at the end.

#include <grpcpp/grpcpp.h>

#include <memory>

#include "server/convert/convert.hpp"
#include "server/scenes/scene_host.hpp"
#include "server/service/caller.hpp"

namespace collided::server {

class MeshUpload final : public grpc::ServerReadReactor<pb::UploadMeshRequest> {
 public:
  /// `held` lives as long as the call.
  MeshUpload(const grpc::CallbackServerContext& context, SceneHost& host, const Authenticator& authenticator,
             pb::UploadMeshResponse* response, std::shared_ptr<void> held);

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void read();
  void begin();
  void finish(const grpc::Status& status);
  void take();
  void check_cancelled() const;
  void delete_if_unusable();
  void commit();
  void add_to_scene();

  const grpc::CallbackServerContext& context_;
  SceneHost& host_;
  pb::UploadMeshResponse* response_;
  const std::shared_ptr<void> held_;
  const std::shared_ptr<Upload> upload_;
  Caller caller_;
  pb::UploadMeshRequest request_;
};

}  // namespace collided::server
