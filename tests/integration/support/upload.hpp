#pragma once
// An UploadMesh call with a deadline.

#include <memory>
#include <string>
#include <vector>

#include "tests/integration/support/calls.hpp"
#include "tests/integration/support/positions.hpp"

namespace collided::test {

/// An UploadMesh call to mesh 0, with its first chunk.
class Upload {
 public:
  Upload(Stub& stub, const std::string& scene_id, const std::vector<uint32_t>& triangles) {
    set_deadline(context_);
    call_ = stub.UploadMesh(&context_, &response_);
    pb::UploadMeshRequest chunk;
    chunk.set_scene_id(scene_id);
    chunk.set_triangles(pack(triangles));
    call_->Write(chunk);
  }

  grpc::Status finish() {
    call_->WritesDone();
    return call_->Finish();
  }
  /// The status with which the daemon ends it.
  grpc::Status wait_end() { return call_->Finish(); }
  grpc::Status cancel() {
    context_.TryCancel();
    return call_->Finish();
  }

 private:
  grpc::ClientContext context_;
  pb::UploadMeshResponse response_;
  std::unique_ptr<grpc::ClientWriter<pb::UploadMeshRequest>> call_;
};

/// `count` triangles of the vertices 0, 1 and 2.
inline std::vector<uint32_t> many_triangles(size_t count) {
  std::vector<uint32_t> corners;
  for (size_t i = 0; i < 3 * count; ++i) corners.push_back(static_cast<uint32_t>(i % 3));
  return corners;
}

}  // namespace collided::test
