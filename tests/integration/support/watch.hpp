#pragma once
// A WatchScene call with a deadline, one message at a time.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tests/integration/support/calls.hpp"

namespace collided::test {

/// Asks for a scene, and for what `more` adds.
inline pb::WatchSceneRequest watch_request(const std::string& scene_id,
                                           const std::function<void(pb::WatchSceneRequest&)>& more = {}) {
  pb::WatchSceneRequest request;
  request.set_scene_id(scene_id);
  if (more) more(request);
  return request;
}

class Watch {
 public:
  Watch(Stub& stub, const pb::WatchSceneRequest& request) {
    set_deadline(context_);
    call_ = stub.WatchScene(&context_, request);
    if (const auto first = next(); first && first->has_opened()) opened_ = first->opened();
  }
  ~Watch() {
    if (!call_) return;
    context_.TryCancel();
    wait_end();
  }

  const std::optional<pb::WatchOpened>& opened() const { return opened_; }
  /// Nothing once the watch is over.
  std::optional<pb::WatchSceneResponse> next() {
    pb::WatchSceneResponse response;
    if (!call_->Read(&response)) return std::nullopt;
    return response;
  }
  /// How the daemon ends it; drops what comes before.
  grpc::Status wait_end() {
    while (next()) continue;
    const auto status = call_->Finish();
    call_.reset();
    return status;
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<pb::WatchSceneResponse>> call_;
  std::optional<pb::WatchOpened> opened_;
};

}  // namespace collided::test
