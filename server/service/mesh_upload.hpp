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
             pb::UploadMeshResponse* response, std::shared_ptr<void> held)
      : context_(context), host_(host), authenticator_(authenticator), response_(response), held_(std::move(held)) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void begin();
  void finish(const grpc::Status& status);
  void take();
  void check_cancelled() const;
  void delete_if_unusable();
  void commit();

  const grpc::CallbackServerContext& context_;
  SceneHost& host_;
  const Authenticator& authenticator_;
  pb::UploadMeshResponse* response_;
  const std::shared_ptr<void> held_;
  Caller caller_;
  pb::UploadMeshRequest request_;
  SceneUse scene_;
  uint32_t mesh_ = 0;
  Scene::Triangles triangles_;
};

}  // namespace collided::server
