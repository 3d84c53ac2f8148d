// Many scenes of one spec, stepped together.

#include "client/cpp/batch/scene_set.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <cstring>
#include <string>
#include <utility>

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

[[noreturn]] void throw_lost(const std::string& what) { throw Error(grpc::DATA_LOSS, what); }

std::vector<uint64_t> begins_of(const v1::WorldContacts& from, size_t worlds) {
  std::vector<uint64_t> begin(worlds + 1);
  if (from.begin().size() != begin.size() * sizeof(uint64_t))
    throw_lost("contacts.begin has " + std::to_string(from.begin().size()) + " bytes for " + std::to_string(worlds) +
               " worlds");
  std::memcpy(begin.data(), from.begin().data(), from.begin().size());
  for (size_t i = 0; i < worlds; ++i)
    if (begin[i] > begin[i + 1]) throw_lost("contacts.begin descends at entry " + std::to_string(i + 1));
  if (begin[0] != 0 || begin[worlds] != from.contacts().count())
    throw_lost("contacts.begin does not go from 0 to the number of contacts");
  return begin;
}

SetOutput read_answer(v1::SetAnswer&& answer, size_t worlds) {
  SetOutput output;
  output.frame_id = answer.frame_id();
  if (answer.has_error()) output.error = std::move(*answer.mutable_error());
  output.done = std::move(*answer.mutable_done());
  output.refused = {answer.errors().begin(), answer.errors().end()};
  for_each_kind([&](v1::ContactKind, WorldContacts& contacts) { contacts.begin.assign(worlds + 1, 0); }, output);
  for (const v1::WorldContacts& from : answer.contacts())
    for_each_kind(
        [&](v1::ContactKind kind, WorldContacts& contacts) {
          if (kind != from.contacts().kind()) return;
          contacts.begin = begins_of(from, worlds);
          append(contacts, from.contacts());
        },
        output);
  return output;
}

}  // namespace

struct SceneSet::State {
  State(const ChannelFactory& channels, v1::Scene made, uint64_t max_answer_bytes)
      : channels(channels),
        scene(std::move(made)),
        max_answer_bytes(max_answer_bytes),
        stub(v1::CollisionService::NewStub(channels.connect(max_answer_bytes))) {}

  size_t worlds_in(const SetUpdate& update) const {
    return update.worlds.empty() ? scene.worlds() : update.worlds.size();
  }

  const ChannelFactory channels;
  const v1::Scene scene;
  const uint64_t max_answer_bytes;
  const std::unique_ptr<v1::CollisionService::Stub> stub;
  uint64_t last_frame = 0;
};

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
  return SceneSet(std::make_unique<State>(client.channels(), std::move(scene), bytes));
}

const v1::Scene& SceneSet::scene() const { return state_->scene; }

uint32_t SceneSet::worlds() const { return state_->scene.worlds(); }

SetOutput SceneSet::detect(const SetUpdate& update, const SetFrameOptions& options) {
  const SetStep step{this, update, options};
  SetOutput output = std::move(detect_batch({&step, 1})[0]);
  output.check();
  return output;
}

void SceneSet::close() {
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
  v1::DetectBatchResponse response;
  check(first.stub->DetectBatch(first.channels.call_context(first.scene.scene_id()).get(), request, &response));
  if (response.answers_size() != request.frames_size())
    throw_lost("answers has " + std::to_string(response.answers_size()) + " entries for " +
               std::to_string(request.frames_size()) + " frames");
  std::vector<SetOutput> outputs;
  for (size_t i = 0; i < steps.size(); ++i)
    outputs.push_back(read_answer(std::move(*response.mutable_answers(static_cast<int>(i))),
                                  steps[i].set->state_->worlds_in(steps[i].update)));
  return outputs;
}

}  // namespace collided::client
