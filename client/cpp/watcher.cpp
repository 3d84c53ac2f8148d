// The frames of a scene as an observer sees them.

#include "client/cpp/watcher.hpp"

#include <future>
#include <utility>

#include "client/cpp/frame_stream_state.hpp"
#include "client/cpp/positions.hpp"
#include "client/cpp/transport/features.hpp"
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

void check_positions(const v1::WatchSceneResponse& response, const v1::Scene& scene) {
  const size_t bytes = 3 * (is_double(scene.spec().position_format()) ? sizeof(double) : sizeof(float));
  for (const v1::VertexSample& sample : response.positions())
    if (sample.positions().size() % bytes != 0 || sample.mesh() >= static_cast<uint32_t>(scene.spec().meshes_size()))
      throw Error(kDataLoss, "positions of mesh " + std::to_string(sample.mesh()) + " has " +
                                 std::to_string(sample.positions().size()) + " bytes; the scene had " +
                                 std::to_string(scene.spec().meshes_size()) + " meshes, of " + std::to_string(bytes) +
                                 " bytes for a vertex");
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
  State(const ChannelFactory& maker, const std::string& scene_id, const v1::WatchSceneRequest& request)
      : channels(maker),
        stub(v1::CollisionService::NewStub(channels.connect())),
        context(channels.context(scene_id)),
        reader(stub->WatchScene(context.get(), request)) {
    if (!read_within(channels.options().deadline).has_opened())
      throw Error(kDataLoss, "the first message of a watch is not `opened`");
    opened = std::move(*response.mutable_opened());
  }
  ~State() {
    if (!reader) return;
    context->TryCancel();
    reader->Finish();
  }

  /// gRPC has no deadline for one message, so that another thread cancels the call.
  v1::WatchSceneResponse& read_within(std::chrono::milliseconds deadline) {
    auto message = std::async(std::launch::async, [this]() -> v1::WatchSceneResponse& { return read(); });
    if (message.wait_until(time_after(deadline)) == std::future_status::ready) return message.get();
    context->TryCancel();
    message.wait();
    throw Error(grpc::DEADLINE_EXCEEDED, "the daemon at " + channels.address() + " did not open the watch within " +
                                             std::to_string(deadline.count()) + " ms (deadline)");
  }

  v1::WatchSceneResponse& read() {
    if (!reader) throw Error(grpc::FAILED_PRECONDITION, "the watch has ended");
    if (reader->Read(&response)) return response;
    check(std::exchange(reader, nullptr)->Finish());
    throw Error(kDataLoss, "the daemon ended the watch without a reason");
  }

  const ChannelFactory channels;  // which keeps a daemon in this process
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

Watcher Watcher::open(const ChannelFactory& channels, const std::string& scene_id, const WatchOptions& options,
                      const std::shared_ptr<const Features>& features) {
  const v1::WatchSceneRequest request = request_of(scene_id, options);
  if (features) features->check_call(request);
  return Watcher(std::make_unique<State>(channels, scene_id, request));
}

const v1::Scene& Watcher::scene() const { return state_->opened.scene(); }
uint32_t Watcher::vertex_stride() const { return state_->opened.vertex_stride(); }

WatchedFrame Watcher::receive() {
  v1::WatchSceneResponse& response = state_->read();
  if (!response.has_done()) throw Error(kDataLoss, "a message of the watch is neither `opened` nor a frame");
  if (response.done().limits_size() > 0) throw Error(kDataLoss, "the daemon names limits in a watch, which shows none");
  const v1::Scene& scene = state_->opened.scene();
  const bool is_as_opened = response.edit_count() == scene.edit_count();
  if (is_as_opened) check_positions(response, scene);
  WatchedFrame frame = frame_of(response);
  const SceneSize size = size_of(scene.spec());
  if (is_as_opened && size.vertices > 0)
    for_each_kind([&](v1::ContactKind kind, const Contacts& contacts) { check_ids(kind, contacts, 0, size); }, frame);
  return frame;
}

void Watcher::cancel() { state_->context->TryCancel(); }

}  // namespace collided::client
