// Many scenes of one spec, stepped together.

#include "client/cpp/batch/scene_set.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <algorithm>
#include <deque>
#include <numeric>
#include <string>
#include <utility>

#include "client/cpp/batch/set_answer.hpp"
#include "client/cpp/transport/features.hpp"
#include "client/cpp/transport/grpc/channel.hpp"
#include "collided/v1/collision_service.grpc.pb.h"

namespace collided::client {

namespace {

constexpr uint64_t kLeastAnswerBytes = uint64_t{64} << 10;

uint64_t checked_answer_bytes(uint64_t asked, uint64_t limit) {
  if (asked == 0) return limit;
  if (asked < kLeastAnswerBytes || asked > limit)
    throw Error(grpc::INVALID_ARGUMENT,
                "max_answer_bytes is " + std::to_string(asked) + "; it must be from " +
                    std::to_string(kLeastAnswerBytes) + " to the daemon's max_message_bytes, " + std::to_string(limit),
                "max_answer_bytes");
  return asked;
}

void fill(const SetStep& step, v1::SetFrame& out) {
  const SetUpdate& update = step.update;
  out.mutable_worlds()->Assign(update.worlds.begin(), update.worlds.end());
  out.mutable_meshes()->Assign(update.meshes.begin(), update.meshes.end());
  out.set_positions(update.positions.data(), update.positions.size());
  out.set_start_positions(update.start_positions.data(), update.start_positions.size());
  out.set_mode(step.options.mode);
  out.set_accuracy(step.options.accuracy);
  if (step.options.delta) out.set_delta(*step.options.delta);
}

}  // namespace

struct SceneSet::State {
  State(const ChannelFactory& channels, const v1::GetServerInfoResponse& info, v1::Scene made,
        uint64_t max_answer_bytes, LocalOptions local)
      : channels(channels),
        features(info, channels.address()),
        scene(std::move(made)),
        max_answer_bytes(max_answer_bytes),
        local(std::move(local)),
        stub(v1::CollisionService::NewStub(channels.connect(max_answer_bytes))) {}

  size_t worlds_in(const SetUpdate& update) const {
    return update.worlds.empty() ? scene.worlds() : update.worlds.size();
  }
  /// Null where the daemon grants none. Throws Error if the set or the daemon is gone.
  FrameStream* open_stream();
  void send(FrameStream& over, const SetUpdate& update, const SetFrameOptions& options);
  SetOutput receive(FrameStream& over);

  const ChannelFactory channels;
  const Features features;
  const v1::Scene scene;
  const uint64_t max_answer_bytes;
  const LocalOptions local;
  const std::unique_ptr<v1::CollisionService::Stub> stub;
  std::optional<FrameStream> stream;
  bool has_no_stream = false;
  std::deque<std::vector<uint32_t>> sent;  ///< worlds of the frames in flight
  std::deque<SetOutput> called;            ///< answers of calls, where there is no stream
  uint64_t last_frame = 0;
};

/// One that has ended, such as for having been idle, is opened again if nothing was in flight.
FrameStream* SceneSet::State::open_stream() {
  if (has_no_stream || (stream && (!stream->has_ended() || !sent.empty()))) return stream ? &*stream : nullptr;
  stream.reset();
  try {
    stream = Client::connect(channels).resume(scene, {.local = local});
  } catch (const Error& e) {
    if (e.code() != grpc::RESOURCE_EXHAUSTED || local.use == Local::kOn) throw;
    has_no_stream = true;
    return nullptr;
  }
  last_frame = std::max(last_frame, stream->scene().last_frame_id());
  return &*stream;
}

void SceneSet::State::send(FrameStream& over, const SetUpdate& update, const SetFrameOptions& options) {
  FrameOptions all{.mode = options.mode, .accuracy = options.accuracy, .delta = options.delta};
  all.worlds = {update.worlds.begin(), update.worlds.end()};
  all.meshes = {update.meshes.begin(), update.meshes.end()};
  std::vector<uint32_t> worlds = all.worlds;
  if (worlds.empty()) {
    worlds.resize(scene.worlds());
    std::iota(worlds.begin(), worlds.end(), 0u);
  }
  const FrameUpdate one{.positions = update.positions, .start_positions = update.start_positions};
  over.send(++last_frame, {&one, 1}, all);
  sent.push_back(std::move(worlds));
}

SetOutput SceneSet::State::receive(FrameStream& over) {
  if (sent.empty()) throw Error(grpc::FAILED_PRECONDITION, "receive() was called with no frame in flight");
  const std::vector<uint32_t> worlds = std::move(sent.front());
  sent.pop_front();
  auto output = over.receive_within(channels.options().deadline);
  if (output) return read_output(*std::move(output), worlds);
  over.cancel();
  throw Error(grpc::DEADLINE_EXCEEDED, "the daemon did not answer the set's frame in time");
}

void SetOutput::check() const {
  if (error) throw Error(error->code(), error->message(), error->field());
}

SceneSet::SceneSet(std::unique_ptr<State> state) : state_(std::move(state)) {}
SceneSet::SceneSet(SceneSet&&) noexcept = default;
SceneSet& SceneSet::operator=(SceneSet&&) noexcept = default;
SceneSet::~SceneSet() = default;

SceneSet SceneSet::create(Client& client, v1::SceneSpec spec, std::span<const MeshInput> meshes, uint32_t count,
                          const SceneSetOptions& options) {
  const uint64_t bytes =
      checked_answer_bytes(options.max_answer_bytes, client.server_info().limits().max_message_bytes());
  v1::Scene scene = client.create_scenes(std::move(spec), meshes, count, options.lease_seconds);
  return SceneSet(
      std::make_unique<State>(client.channels(), client.server_info(), std::move(scene), bytes, options.local));
}

const v1::Scene& SceneSet::scene() const { return state_->scene; }

uint32_t SceneSet::worlds() const { return state_->scene.worlds(); }

SetOutput SceneSet::detect(const SetUpdate& update, const SetFrameOptions& options) {
  if (!state_->sent.empty() || !state_->called.empty())
    throw Error(grpc::FAILED_PRECONDITION, "detect() was called with frames in flight; receive() their answers first");
  send(update, options);
  return receive();
}

void SceneSet::send(const SetUpdate& update, const SetFrameOptions& options) {
  if (FrameStream* const stream = state_->open_stream()) return state_->send(*stream, update, options);
  const SetStep step{this, update, options};
  state_->called.push_back(std::move(detect_batch({&step, 1})[0]));
}

SetOutput SceneSet::receive() {
  SetOutput output;
  if (!state_->called.empty()) {
    output = std::move(state_->called.front());
    state_->called.pop_front();
  } else {
    if (!state_->stream) throw Error(grpc::FAILED_PRECONDITION, "receive() was called with no frame in flight");
    output = state_->receive(*state_->stream);
  }
  output.check();
  return output;
}

std::span<std::byte> SceneSet::input(uint64_t bytes) {
  FrameStream* const stream = state_->open_stream();
  return stream ? stream->input(bytes) : std::span<std::byte>();
}

bool SceneSet::is_local() {
  const FrameStream* const stream = state_->open_stream();
  return stream && stream->is_local();
}

void SceneSet::close() {
  state_->stream.reset();
  v1::DeleteSceneRequest request;
  request.set_scene_id(state_->scene.scene_id());
  v1::DeleteSceneResponse response;
  check(state_->stub->DeleteScene(state_->channels.call_context(request.scene_id()).get(), request, &response));
}

std::vector<SetOutput> detect_batch(std::span<const SetStep> steps) {
  if (steps.empty()) return {};
  SceneSet::State& first = *steps[0].set->state_;
  v1::DetectBatchRequest request;
  request.set_max_answer_bytes(first.max_answer_bytes);
  for (const SetStep& step : steps) {
    SceneSet::State& set = *step.set->state_;
    v1::SetFrame& frame = *request.add_frames();
    frame.set_scene_id(set.scene.scene_id());
    frame.set_frame_id(++set.last_frame);
    fill(step, frame);
  }
  first.features.check_call(request);
  v1::DetectBatchResponse response;
  check(first.stub->DetectBatch(first.channels.call_context(first.scene.scene_id()).get(), request, &response));
  if (response.answers_size() != request.frames_size())
    throw Error(grpc::DATA_LOSS, "answers has " + std::to_string(response.answers_size()) + " entries for " +
                                     std::to_string(request.frames_size()) + " frames");
  std::vector<SetOutput> outputs;
  for (size_t i = 0; i < steps.size(); ++i)
    outputs.push_back(read_answer(std::move(*response.mutable_answers(static_cast<int>(i))),
                                  steps[i].set->state_->worlds_in(steps[i].update)));
  return outputs;
}

}  // namespace collided::client
