// Requests for scenes and frames: each is parsed within its bounds and checked, as the daemon does before anything is
// made of it. The first byte says which message it is.

#include <google/protobuf/stubs/logging.h>

#include "collided/v1/batch.pb.h"
#include "server/convert/edit.hpp"
#include "server/convert/facts.hpp"
#include "server/convert/meshes.hpp"
#include "server/convert/wire_bounds.hpp"
#include "server/frames/decode.hpp"
#include "server/frames/messages.hpp"
#include "server/service/page_token.hpp"
#include "server/sets/set_frame.hpp"
#include "tests/fuzz/targets/refusal.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::fuzz {
namespace {

using namespace server;  // NOLINT: the code under test

template <class Message>
Message parse_bounded(const std::string& wire) {
  Message message;
  const std::string& name = Message::descriptor()->name();
  FieldCount(name, max_fields(kMaxMeshes)).add_message(wire, *Message::descriptor(), name);
  if (!message.ParseFromString(wire)) throw InvalidInput(name, name + " is malformed");
  return message;
}

void check_plan(const ScenePlan& plan) {
  require(plan.meshes.size() == plan.engine.meshes.size(), "the plan names the engine's meshes");
  require(plan.min_bytes <= plan.engine.memory_budget, "a scene fits its budget");
  uint64_t vertices = count_vertices(plan.engine);
  require(vertices <= Limits().max_vertices, "a scene is within the limits");
  for (const MeshSpec& mesh : plan.engine.meshes)
    for (const auto& triangle : mesh.triangles)
      for (const uint32_t v : triangle) require(v < mesh.vertex_count, "triangles have vertices that there are");
}

void estimate(const std::string& wire) {
  const ScenePlan plan = parse_spec(parse_bounded<pb::EstimateSceneRequest>(wire).spec(), {});
  check_plan(plan);
  constexpr uint64_t kFew = 10'000;
  if (count_vertices(plan.engine) > kFew) return;  // so that a run takes no seconds
  for (const MeshPlan& mesh : plan.meshes)
    if (mesh.triangles > kFew) return;
  pb::EstimateSceneResponse response;
  fill_estimate(plan, &response);
}

ScenePlan plan_with(const std::function<void(pb::SceneSpec&)>& change) {
  return parse_scene(request_with(change), {}).plan;
}

const std::vector<ScenePlan>& plans() {
  static const std::vector<ScenePlan> plans = {
      plan_with([](auto&) {}),
      plan_with([](auto& spec) {
        spec.set_mode(pb::DETECTION_MODE_DCD), spec.set_position_format(pb::POSITION_FORMAT_F64), spec.set_thickness(1);
      }),
      plan_with([](auto& spec) { spec.mutable_meshes(0)->set_motion(pb::MESH_MOTION_RIGID); }),
  };
  return plans;
}

void take_frame(const pb::Frame& frame, const ScenePlan& plan) try {
  const FrameInput input = parse_frame(frame, {}, plan.engine);
  require(input.updates.size() == static_cast<size_t>(frame.updates_size()), "each update reaches the engine");
  check_no_worlds(frame);
  if (!frame.has_edit()) return;
  const ParsedEdit edit = parse_edit(frame.edit(), plan, {});
  require(edit.meshes.size() == static_cast<size_t>(frame.edit().meshes_size()), "each edited mesh reaches the engine");
} catch (...) {
  check_refusal();
}

void take_frame(const std::string& wire) {
  const pb::Frame frame = parse_bounded_frame(wire, 1, 0, "frame");
  for (const ScenePlan& plan : plans()) take_frame(frame, plan);
}

template <class Frame>
void take_set_frame(const Frame& frame) {
  pb::CreateScenesRequest set;
  set.set_count(3);
  *set.mutable_spec() = request().spec();
  static const SceneSpec spec = parse_scenes(set, {}).plan.engine;
  SetFrameInput input;
  if constexpr (std::is_same_v<Frame, pb::Frame>)
    input = parse_set_frame(frame, {}, spec);
  else
    input = parse_set_frame(frame, spec);
  for (const uint32_t world : input.worlds) require(world < spec.worlds, "a frame has worlds that there are");
  for (const uint32_t mesh : input.meshes) require(mesh < spec.meshes.size(), "a frame has meshes that there are");
}

void take(uint8_t which, const std::string& wire) try {
  switch (which % 8) {
    case 0:
      return check_plan(parse_scene(parse_bounded<pb::CreateSceneRequest>(wire), {}).plan);
    case 1:
      return check_plan(parse_scenes(parse_bounded<pb::CreateScenesRequest>(wire), {}).plan);
    case 2:
      return estimate(wire);
    case 3:
      return take_frame(wire);
    case 4:
      return take_set_frame(parse_bounded_frame(wire, 1, 0, "frame"));
    case 5:
      return take_set_frame(parse_bounded<pb::SetFrame>(wire));
    case 6:
      return check_page_token(parse_bounded<pb::ListScenesRequest>(wire).page_token(), "gpu0");
    default:
      const StreamTerms terms = parse_open(parse_bounded<pb::OpenStream>(wire), {});
      require(terms.window >= 1 && terms.window <= Limits().max_window, "a stream has a window within the limit");
  }
} catch (...) {
  check_refusal();
}

}  // namespace

void run(Input input) {
  static const google::protobuf::LogSilencer no_words_on_strings_that_are_not_utf8;
  const auto which = input.number<uint8_t>();
  take(which, input.rest());
}

}  // namespace collided::fuzz
