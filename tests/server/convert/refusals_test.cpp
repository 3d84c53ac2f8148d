// Words of refusals: the names that clients set, and what helps.

#include <gtest/gtest.h>

#include "server/refusals/advice.hpp"
#include "server/refusals/field_path.hpp"

namespace collided::server {
namespace {

std::string frame_refusal(const std::string& field, const std::string& text) {
  return with_path(InvalidInput(field, text), frame_path).what();
}

TEST(Refusals, NameWhatClientsSetWhereverTheyNameIt) {
  EXPECT_EQ(frame_refusal("updates[1].start_transform", "updates[1].start_transform is given, but the scene is DCD"),
            "frame.updates[1].rigid.start_matrix is given, but the scene is DCD");
  EXPECT_EQ(frame_refusal("updates[0].transform",
                          "updates[0].transform turns mesh 0 by 4 radians: divide the step, or give start_transform"),
            "frame.updates[0].rigid.matrix turns mesh 0 by 4 radians: divide the step, or give rigid.start_matrix");
  EXPECT_EQ(frame_refusal("updates[0].start", "updates[0].start is given, but the mesh is rigid: start_transform says"),
            "frame.updates[0].start_positions is given, but the mesh is rigid: rigid.start_matrix says");
  EXPECT_EQ(frame_refusal("edit", "edit is given with start_fraction"), "frame.edit is given with from_last_fraction");
  EXPECT_EQ(frame_refusal("start_fraction", "start_fraction is 2"), "frame.from_last_fraction is 2");
  EXPECT_EQ(with_protocol_names("restart_transform, start_transforms"), "restart_transform, start_transforms");
}

/// Deformable meshes that may all touch, at CERTIFIED, all of them reported.
SceneSpec spec_of(Mode mode, size_t meshes = 2) {
  SceneSpec spec;
  spec.mode = mode;
  spec.meshes.resize(meshes);
  return spec;
}
const FrameInput kFrame;
BusyScene busy(const SceneSpec& spec, const FrameInput& frame = kFrame) {
  return {spec, frame, [](uint32_t mesh) { return "mesh " + std::to_string(mesh); }};
}
/// Returns the advice that follows the refusal of a frame that took too long.
std::string advice_for(const SceneSpec& spec, const FrameInput& frame = kFrame) {
  const std::string refusal = "max_frame_seconds is 10, and frame 2 has run for 10.001 s";
  const std::string text = with_advice(LimitExceeded("f", refusal), FrameProgress{}, busy(spec, frame)).what();
  return text.substr(refusal.size());
}
bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Refusals, ATooLongFrameSaysWhatItFoundAndWhatHelps) {
  const SceneSpec spec = spec_of(Mode::kCcd);
  FrameProgress progress{.pairs = 5, .candidates = 60, .contacts = 7, .far_meshes = {}};
  progress.far_meshes = {{3, 0.5, 0.125}, {1, 0.25, 0.125}};
  const auto refusal =
      LimitExceeded::quota("client:one", "max_frame_seconds is 10, and frame 2 has run for 10.001 s", 0);
  const LimitExceeded advised = with_advice(refusal, progress, busy(spec));
  const std::string text = advised.what();
  EXPECT_EQ(advised.subject(), "client:one");
  EXPECT_EQ(text.find(refusal.what()), 0u);
  EXPECT_TRUE(has(text, "By then it had found 5 pairs of triangles, 60 candidates and 7 contacts")) << text;
  EXPECT_TRUE(has(text, ". In this step mesh 3 moves by 0.5 or more, 4 times its mean edge of 0.125, mesh 1 moves"))
      << text;
  EXPECT_TRUE(has(text, "several shorter ones")) << text;
  EXPECT_TRUE(has(text, "any_hit or earliest_only")) << text;
  EXPECT_TRUE(has(text, "--max-frame-seconds")) << text;
}

TEST(Refusals, EachLimitNamesTheOptionThatRaisesIt) {
  const SceneSpec spec = spec_of(Mode::kDcd);
  const FrameProgress progress{.pairs = 1, .far_meshes = {}};
  for (const auto& [limit, option] : {std::pair{"spec.memory_budget_bytes is 1 bytes", "--max-scene-mb"},
                                      {"max_device_bytes_per_client is 1 bytes", "--max-device-mb-per-client"},
                                      {"max_device_bytes is 1 bytes", "--max-device-mb"},
                                      {"max_device_bytes of cuda:0 is 1 bytes", "--max-device-mb"}}) {
    const std::string text = with_advice(LimitExceeded("f", limit), progress, busy(spec)).what();
    EXPECT_TRUE(text.ends_with(option) || has(text, std::string(option) + ",")) << text;
    EXPECT_FALSE(has(text, "earliest_only")) << text;
    EXPECT_FALSE(has(text, "moves by")) << text;
  }
}

constexpr const char* kRaised =
    "a higher limit: the daemon's option --max-frame-seconds, or max-frame-seconds of the client's token";

TEST(Refusals, NameNothingThatTheSceneOrTheFrameHasAlready) {
  SceneSpec spec = spec_of(Mode::kBoth);
  spec.thickness = 0.1;
  EXPECT_EQ(advice_for(spec),
            ". What takes less: report any_hit or earliest_only; fewer kinds; fewer fields; meshes that are left out "
            "(groups and collide_mask, excluded_meshes, no_self_contacts); a smaller thickness; or " +
                std::string(kRaised));
  spec.meshes[1].half_thickness = 0.1;
  EXPECT_TRUE(has(advice_for(spec), "; a smaller thickness; a smaller half_thickness; or "));
  FrameInput frame;
  frame.report = Report::kEarliestOnly;
  EXPECT_TRUE(has(advice_for(spec, frame), ": report any_hit; fewer kinds; fewer fields;"));
  frame.report = Report::kAnyHit;
  EXPECT_TRUE(has(advice_for(spec, frame), ": fewer kinds; meshes that"));
  frame = {};
  frame.mode = Mode::kDcd;  // has no times
  EXPECT_TRUE(has(advice_for(spec, frame), ": report any_hit; fewer"));
  frame.mode = Mode::kCcd, frame.accuracy = Accuracy::kCandidates;
  EXPECT_FALSE(has(advice_for(spec, frame), "report"));
}

TEST(Refusals, NameWhatIsLeftWhereLittleCouldBeLess) {
  SceneSpec spec = spec_of(Mode::kCcd, 1);
  spec.kinds = {.vertex_triangle = true};
  spec.fields = {ContactField::kElements, ContactField::kToi};
  spec.report = Report::kAnyHit;
  EXPECT_EQ(advice_for(spec),
            ". What takes less: meshes that are left out (no_self_contacts); or " + std::string(kRaised));
  spec.meshes[0].self_contacts = false;
  EXPECT_EQ(advice_for(spec), ". What helps is " + std::string(kRaised));
  spec.meshes[0].self_contacts = true, spec.meshes[0].motion = MeshMotion::kRigid;
  EXPECT_EQ(advice_for(spec), ". What helps is " + std::string(kRaised));
}

}  // namespace
}  // namespace collided::server
