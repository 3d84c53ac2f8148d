// Scenes and their frames in the engine: whatever positions, options and edits there are, answers or refusals, and the
// same bytes of contacts from three broad phases. An input is messages, each after its length in two bytes: a request
// for a scene, then frames. Not at EXACT, which takes seconds where exponents are far apart and thickness is above 0:
// that is for exact_decisions.

#include <google/protobuf/stubs/logging.h>

#include <optional>

#include "server/convert/edit.hpp"
#include "server/frames/decode.hpp"
#include "tests/fuzz/targets/refusal.hpp"
#include "tests/server/convert/scene_request.hpp"
#include "tests/support/digest.hpp"

namespace collided::fuzz {
namespace {

using namespace server;  // NOLINT: the code under test

constexpr Engine kEngines[] = {Engine::kAllPairs, Engine::kOctree, Engine::kLbvh};

// Small enough that a run takes milliseconds.
Limits small_limits() {
  Limits limits;
  limits.max_vertices = limits.max_triangles = 64;
  limits.max_scene_bytes = uint64_t{64} << 20;
  return limits;
}

struct Answer {
  std::string refusal;
  std::optional<FrameResult> result;
};

class Scene {
 public:
  Scene(ScenePlan plan, Engine engine) : plan_(std::move(plan)) {
    plan_.engine.engine = engine;
    plan_.engine.threads = 1;
    detector_ = Detector::create(plan_.engine);
  }

  Answer step(const pb::Frame& frame) {
    Answer answer;
    try {
      FrameInput input = parse_frame(frame, {}, plan_.engine);
      std::vector<EditedMesh> edited;
      if (frame.has_edit()) {
        ParsedEdit edit = parse_edit(frame.edit(), plan_, small_limits());
        input.edit = std::move(edit.engine);
        edited = std::move(edit.meshes);
      }
      answer.result = detector_->detect(input);
      if (input.edit && !input.trial) plan_ = edited_plan(plan_, edited, detector_->spec());
    } catch (...) {
      check_refusal();
      answer.refusal = describe_current().message;
    }
    return answer;
  }

 private:
  ScenePlan plan_;
  std::unique_ptr<Detector> detector_;
};

void check(const FrameResult& result) {
  for_each_kind(
      [](ContactKind, const ContactSet& set) {
        for (const double toi : set.toi) require(toi >= 0 && toi <= 1, "times of impact are in [0, 1]");
        for (const double distance : set.distance) require(distance >= 0, "distances are 0 or more");
      },
      static_cast<const PerKind<ContactSet>&>(result));
}

// Where all contacts are reported, they are the same, whichever way the pairs were found.
void check_same(const Answer& answer, const Answer& first, bool all) {
  require(answer.result.has_value() == first.result.has_value(),
          "all broad phases answer, or none: " + answer.refusal + first.refusal);
  if (answer.result && all)
    require(test::same_contacts(*answer.result, *first.result), "all broad phases find the same contacts");
}

void step(const pb::Frame& frame, std::vector<Scene>& scenes, bool all) {
  std::optional<Answer> first;
  for (Scene& scene : scenes) {
    const Answer answer = scene.step(frame);
    if (answer.result) check(*answer.result);
    if (!first)
      first = answer;
    else
      check_same(answer, *first, all);
  }
}

std::vector<Scene> make_scenes(const std::string& wire) {
  SceneDefaults defaults;
  defaults.limits = small_limits();
  pb::CreateSceneRequest request;
  if (!request.ParseFromString(wire) || request.spec().accuracy() == pb::ACCURACY_EXACT) return {};
  const ScenePlan plan = parse_scene(request, defaults).plan;
  for (const MeshPlan& mesh : plan.meshes)
    if (mesh.awaited > 0) return {};
  std::vector<Scene> scenes;
  for (const Engine engine : kEngines) scenes.emplace_back(plan, engine);
  return scenes;
}

}  // namespace

void run(Input input) try {
  static const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  std::vector<Scene> scenes = make_scenes(std::string(input.take(input.number<uint16_t>())));
  constexpr int kMostFrames = 8;
  for (int i = 0; i < kMostFrames && !scenes.empty(); ++i) {
    const std::string wire(input.take(input.number<uint16_t>()));
    pb::Frame frame;
    if (wire.empty() || !frame.ParseFromString(wire) || frame.accuracy() == pb::ACCURACY_EXACT) return;
    step(frame, scenes, frame.report() != pb::REPORT_ANY_HIT && !frame.has_edit());
  }
} catch (...) {
  check_refusal();
}

}  // namespace collided::fuzz
