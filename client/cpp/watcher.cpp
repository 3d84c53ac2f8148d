// The frames of a scene as an observer sees them.

#include "client/cpp/watcher.hpp"

#include <utility>

#include "client/cpp/transport/grpc/channel.hpp"
#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::client {

namespace {

constexpr int kDataLoss = 15;

v1::WatchSceneRequest request_of(const std::string& scene_id, const WatchOptions& options) {
  v1::WatchSceneRequest request;
  request.set_scene_id(scene_id);
  request.set_frame_interval(options.frame_interval);
  request.set_max_frames_per_second(options.max_frames_per_second);
  request.set_max_contacts_per_kind(options.max_contacts_per_kind);
  request.mutable_position_meshes()->Add(options.meshes.begin(), options.meshes.end());
  request.set_vertex_stride(options.vertex_stride);
  return request;
}

WatchedFrame frame_of(v1::WatchSceneResponse& response) {
  WatchedFrame frame;
  frame.frame_id = response.frame_id();
  frame.skipped_frames = response.skipped_frames();
  frame.omitted_contacts = response.omitted_contacts();
  frame.edit_count = response.edit_count();
  for_each_kind(
      [&](v1::ContactKind kind, Contacts& contacts) {
        for (const v1::ContactChunk& chunk : response.done().contacts())
          if (chunk.kind() == kind) append(contacts, chunk);
      },
      frame);
  frame.done = std::move(*response.mutable_done());
  frame.done.clear_contacts();
  frame.positions.assign(response.positions().begin(), response.positions().end());
  return frame;
}

}  // namespace

struct Watcher::State {
  State(const ChannelFactory& channels, const std::string& scene_id, const WatchOptions& options)
      : stub(v1::CollisionService::NewStub(channels.connect())),
        context(channels.context(scene_id)),
        reader(stub->WatchScene(context.get(), request_of(scene_id, options))) {
    if (!read().has_opened()) throw Error(kDataLoss, "the first message of a watch is not `opened`");
    opened = std::move(*response.mutable_opened());
  }
  ~State() {
    if (!reader) return;
    context->TryCancel();
    reader->Finish();
  }

  v1::WatchSceneResponse& read() {
    if (!reader) throw Error(grpc::FAILED_PRECONDITION, "the watch has ended");
    if (reader->Read(&response)) return response;
    check(std::exchange(reader, nullptr)->Finish());
    throw Error(kDataLoss, "the daemon ended the watch without a reason");
  }

  const std::unique_ptr<v1::CollisionService::Stub> stub;
  const std::unique_ptr<grpc::ClientContext> context;
  std::unique_ptr<grpc::ClientReader<v1::WatchSceneResponse>> reader;  // null once the watch has ended
  v1::WatchSceneResponse response;
  v1::WatchOpened opened;
};

Watcher::Watcher(std::unique_ptr<State> state) : state_(std::move(state)) {}
Watcher::Watcher(Watcher&&) noexcept = default;
Watcher& Watcher::operator=(Watcher&&) noexcept = default;
Watcher::~Watcher() = default;

Watcher Watcher::open(const ChannelFactory& channels, const std::string& scene_id, const WatchOptions& options) {
  return Watcher(std::make_unique<State>(channels, scene_id, options));
}

const v1::Scene& Watcher::scene() const { return state_->opened.scene(); }
uint32_t Watcher::vertex_stride() const { return state_->opened.vertex_stride(); }

WatchedFrame Watcher::receive() {
  v1::WatchSceneResponse& response = state_->read();
  if (!response.has_done()) throw Error(kDataLoss, "a message of the watch is neither `opened` nor a frame");
  return frame_of(response);
}

void Watcher::cancel() { state_->context->TryCancel(); }

}  // namespace collided::client
