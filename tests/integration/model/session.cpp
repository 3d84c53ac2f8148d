#include <algorithm>

#include "tests/integration/model/set_session.hpp"

namespace collided::test {
namespace {

pb::Accuracy any_accuracy(Numbers& numbers, const ModelFrame& frame) {
  constexpr pb::Accuracy kLevels[] = {pb::ACCURACY_EXACT, pb::ACCURACY_EXACT, pb::ACCURACY_CERTIFIED,
                                      pb::ACCURACY_GUARDED};
  return kLevels[numbers.below(frame.advance ? 3 : 4)];
}

pb::Frame message_for(const LiveScene& scene, const ModelFrame& frame, pb::Accuracy accuracy) {
  pb::Frame message = message_of(frame);
  message.set_accuracy(accuracy);
  if (scene.mode == pb::DETECTION_MODE_DCD_AND_CCD)
    message.set_mode(frame.discrete ? pb::DETECTION_MODE_DCD : pb::DETECTION_MODE_CCD);
  return message;
}

int code_of(const Answer& answer) {
  if (answer.error) return answer.error->code();
  require(answer.done.has_value(), answer.ended ? "the stream ended instead of an answer" : "a frame was skipped");
  return grpc::OK;
}

/// A frame on its way to an answer.
struct Asked {
  ModelFrame frame;
  pb::Accuracy accuracy;
  SceneModel edited;
  Way way;
};
Asked asked(Numbers& numbers, const SceneModel& model, const ModelFrame& frame) {
  SceneModel edited = model.edited(frame);
  Way way = edited.way_of(frame);
  return {frame, any_accuracy(numbers, frame), std::move(edited), std::move(way)};
}

/// The answer is right, and the model goes where the scene went.
void accept(LiveScene& scene, Asked& asked, const Answer& answer) {
  check_answer(asked.edited, asked.frame, asked.accuracy, asked.way, answer.chunks, *answer.done);
  asked.edited.apply(asked.frame, asked.way, asked.frame.advance ? answer.done->advanced() : 1);
  scene.model = asked.edited;
}

}  // namespace

SessionRunner::~SessionRunner() {
  for (auto& scene : scenes_) {
    scene->stream.reset();
    delete_scene(*client_of(*scene).stub, scene->id);
  }
}

void SessionRunner::run(const Session& session) {
  for (const Command& command : session) run(command);
  for (const auto& scene : scenes_) look(*scene);
}

void SessionRunner::run(const Command& command) {
  Numbers numbers(command);
  const size_t owner = numbers.below(2);
  if (command.action == Action::kCreate) return void(create(numbers, owner));
  if (command.action == Action::kBadCreate) return refuse_create(numbers, owner);
  if (command.action == Action::kBatch) return run_set(numbers, clients_[owner]);
  LiveScene& scene = scene_for(numbers);
  switch (command.action) {
    case Action::kBurst:
      return burst(numbers, scene);
    case Action::kBadFrame:
      return refuse_frame(numbers, scene);
    case Action::kEdit:
      if (scene.model.had_a_frame()) return step(numbers, scene, any_edit(numbers, scene.model, scene.mode));
      break;
    case Action::kOpen:
      return open(numbers, scene);
    case Action::kTakeOver:
      return take_over(numbers, scene);
    case Action::kBreak:
      return break_off(numbers, scene);
    case Action::kClose:
      return close(scene);
    case Action::kDelete:
      return remove(scene);
    case Action::kLook:
      return look(scene);
    case Action::kStranger:
      return intrude(numbers, scene);
    default:
      break;
  }
  step(numbers, scene, any_frame(numbers, scene.model, scene.mode));
}

LiveScene& SessionRunner::scene_for(Numbers& numbers) {
  const uint32_t choice = numbers.below(4);
  if (scenes_.empty()) return create(numbers, choice % 2);
  return *scenes_[choice % scenes_.size()];
}

LiveScene& SessionRunner::create(Numbers& numbers, size_t owner) {
  constexpr pb::DetectionMode kModes[] = {pb::DETECTION_MODE_CCD, pb::DETECTION_MODE_CCD, pb::DETECTION_MODE_DCD,
                                          pb::DETECTION_MODE_DCD_AND_CCD};
  constexpr double kThicknesses[] = {0, 0.5, 1};
  const pb::DetectionMode mode = kModes[numbers.below(4)];
  const double thickness = kThicknesses[numbers.below(3)];
  const std::vector<ModelMesh> meshes = any_meshes(numbers);
  pb::CreateSceneRequest request;
  *request.mutable_spec() = spec_of(meshes, mode, thickness);
  pb::Scene scene;
  const auto status = create_scene(*clients_[owner].stub, request, &scene);
  require(status.ok(), "a scene was refused: " + status.error_message());
  scenes_.push_back(std::make_unique<LiveScene>(
      LiveScene{scene.scene_id(), scene.resume_token(), owner, mode, SceneModel(meshes, thickness)}));
  look(*scenes_.back());
  return *scenes_.back();
}

void SessionRunner::refuse_create(Numbers& numbers, size_t owner) {
  pb::CreateSceneRequest request;
  *request.mutable_spec() = spec_of(any_meshes(numbers), pb::DETECTION_MODE_CCD, 0);
  pb::SceneSpec& spec = *request.mutable_spec();
  switch (numbers.below(5)) {
    case 0:
      spec.mutable_meshes(0)->mutable_triangles()->replace(0, 4, pack<uint32_t>({9}));
      break;
    case 1:
      spec.clear_meshes();
      break;
    case 2:
      spec.clear_mode();
      break;
    case 3:
      spec.set_thickness(-1);
      break;
    default:
      spec.mutable_meshes(0)->mutable_triangles()->pop_back();
      break;
  }
  require_code(create_scene(*clients_[owner].stub, request).error_code(), grpc::INVALID_ARGUMENT, "a bad scene");
}

int SessionRunner::ask(Numbers& numbers, LiveScene& scene, const pb::Frame& frame, Answer& answer) {
  if (scene.stream) {
    require(scene.stream->send(frame, numbers.one_in(2)), "a frame could not be sent");
    answer = scene.stream->receive(frame.frame_id());
    return code_of(answer);
  }
  pb::DetectFrameResponse response;
  const auto status = detect(*client_of(scene).stub, scene.id, frame, &response);
  answer.chunks.assign(response.contacts().begin(), response.contacts().end());
  answer.done = response.done();
  return status.error_code();
}

void SessionRunner::step(Numbers& numbers, LiveScene& scene, const ModelFrame& frame) {
  Asked question = asked(numbers, scene.model, frame);
  const pb::Frame message = message_for(scene, frame, question.accuracy);
  if (scene.stream && numbers.one_in(6))
    require_code(detect(*client_of(scene).stub, scene.id, message).error_code(), grpc::FAILED_PRECONDITION,
                 "a frame beside a stream");
  Answer answer;
  const int code = ask(numbers, scene, message, answer);
  require(code == grpc::OK, "a good frame got code " + std::to_string(code) + ": " +
                                (answer.error ? answer.error->message() : "") + "\n" + message.ShortDebugString());
  try {
    accept(scene, question, answer);
  } catch (const Mismatch& mismatch) {
    throw Mismatch(mismatch.what() + ("\nin " + message.ShortDebugString()));
  }
}

void SessionRunner::burst(Numbers& numbers, LiveScene& scene) {
  if (!scene.stream) open(numbers, scene);
  std::vector<Asked> questions;
  SceneModel model = scene.model;
  while (questions.size() < scene.stream->opened()->window()) {
    ModelFrame frame = any_frame(numbers, model, scene.mode);
    frame.advance = false;  // the frame after it begins where only the answer tells
    frame.id = (questions.empty() ? model.last_frame_id() : questions.back().frame.id) + 1;
    questions.push_back(asked(numbers, model, frame));
    model = questions.back().edited;
    model.apply(frame, questions.back().way);
  }
  for (const Asked& question : questions)
    require(scene.stream->send(message_for(scene, question.frame, question.accuracy), numbers.one_in(2)),
            "a frame of a burst could not be sent");
  for (Asked& question : questions) {
    const Answer answer = scene.stream->receive(question.frame.id);
    require_code(code_of(answer), grpc::OK, "a frame of a burst");
    accept(scene, question, answer);
  }
}

void SessionRunner::refuse_frame(Numbers& numbers, LiveScene& scene) {
  const ModelFrame frame = any_frame(numbers, scene.model, scene.mode);
  pb::Frame message = message_for(scene, frame, pb::ACCURACY_EXACT);
  const grpc::StatusCode expected = spoil(numbers, scene.model, message);
  if (expected == grpc::OK) return;
  Answer answer;
  const int code = ask(numbers, scene, message, answer);
  require_code(code, expected, "a bad frame " + message.ShortDebugString());
  scene.model.refuse();
}

void SessionRunner::open(Numbers& numbers, LiveScene& scene) {
  const bool local = numbers.one_in(2);
  if (scene.stream) {
    const bool guesses = numbers.one_in(2);
    FrameChannel second(client_of(scene), local, scene.id, guesses ? "wrong" : "");
    require(!second.opened(), "a second stream was opened");
    return require_code(second.end(), guesses ? grpc::PERMISSION_DENIED : grpc::FAILED_PRECONDITION, "a second stream");
  }
  scene.stream = std::make_unique<FrameChannel>(client_of(scene), local, scene.id);
  require(scene.stream->opened().has_value(), "a stream was not opened");
  require(scene.stream->opened()->scene().last_frame_id() == scene.model.last_frame_id(),
          "last_frame_id at an opening");
}

void SessionRunner::take_over(Numbers& numbers, LiveScene& scene) {
  auto second = std::make_unique<FrameChannel>(client_of(scene), numbers.one_in(2), scene.id, scene.resume_token);
  require(second->opened().has_value(), "a stream was not taken over");
  require(second->opened()->scene().last_frame_id() == scene.model.last_frame_id(), "last_frame_id at a takeover");
  if (scene.stream) require_code(scene.stream->end(), grpc::ABORTED, "a stream that was taken over");
  scene.stream = std::move(second);
}

// A frame is under way when the connection breaks: it was applied, or it was not, and the resumed stream says which.
void SessionRunner::break_off(Numbers& numbers, LiveScene& scene) {
  if (!scene.stream) open(numbers, scene);
  ModelFrame frame = any_frame(numbers, scene.model, scene.mode);
  frame.trial = frame.advance = false;
  Asked question = asked(numbers, scene.model, frame);
  const bool sends = numbers.one_in(2);
  if (sends) scene.stream->send(message_for(scene, frame, question.accuracy), numbers.one_in(2));
  scene.stream.reset();
  scene.stream = std::make_unique<FrameChannel>(client_of(scene), numbers.one_in(2), scene.id, scene.resume_token);
  require(scene.stream->opened().has_value(), "a broken stream was not resumed");
  const uint64_t last = scene.stream->opened()->scene().last_frame_id();
  if (last == frame.id) {
    question.edited.apply(frame, question.way);
    scene.model = question.edited;
  } else if (sends) {
    scene.model.refuse();  // it may have begun, so that nothing is left of the way before it
  }
  require(last == scene.model.last_frame_id(), "last_frame_id after a break");
}

void SessionRunner::close(LiveScene& scene) {
  if (!scene.stream) return;
  require_code(scene.stream->close(), grpc::OK, "a stream that its client closed");
  scene.stream.reset();
}

void SessionRunner::remove(LiveScene& scene) {
  Stub& stub = *client_of(scene).stub;
  require(delete_scene(stub, scene.id).ok(), "a scene could not be deleted");
  if (scene.stream) require_code(scene.stream->end(), grpc::NOT_FOUND, "the stream of a deleted scene");
  require_code(get_scene(stub, scene.id).error_code(), grpc::NOT_FOUND, "a deleted scene");
  require_code(delete_scene(stub, scene.id).error_code(), grpc::NOT_FOUND, "deleting a deleted scene");
  std::erase_if(scenes_, [&](const auto& other) { return other.get() == &scene; });
}

void SessionRunner::look(const LiveScene& scene) {
  Stub& stub = *client_of(scene).stub;
  pb::Scene seen;
  require(get_scene(stub, scene.id, &seen).ok(), "a scene is gone");
  require(seen.last_frame_id() == scene.model.last_frame_id(), "last_frame_id");
  require(seen.edit_count() == scene.model.edit_count(), "edit_count");
  require(seen.vertex_count() == scene.model.vertex_count(), "vertex_count");
  require(seen.triangle_count() == scene.model.triangle_count(), "triangle_count");
  require(seen.edge_count() == scene.model.edge_count(), "edge_count");

  std::vector<std::string> ids, listed;
  for (const auto& other : scenes_)
    if (other->owner == scene.owner) ids.push_back(other->id);
  for (const auto& other : list_scenes(stub)) listed.push_back(other.scene_id());
  std::ranges::sort(ids);
  require(ids == listed, "ListScenes has other scenes");
}

// To another client the scene does not exist, whatever it tries.
void SessionRunner::intrude(Numbers& numbers, const LiveScene& scene) {
  Client& stranger = clients_[1 - scene.owner];
  const auto expect = [](int code) { require_code(code, grpc::NOT_FOUND, "another client's scene"); };
  expect(get_scene(*stranger.stub, scene.id).error_code());
  expect(delete_scene(*stranger.stub, scene.id).error_code());
  expect(detect(*stranger.stub, scene.id, message_of(any_frame(numbers, scene.model, scene.mode))).error_code());
  FrameChannel stream(stranger, numbers.one_in(2), scene.id, scene.resume_token);
  require(!stream.opened(), "another client opened a stream");
  expect(stream.end());
}

}  // namespace collided::test
