// The rules of a frame, and the paths that messages name.
#include "server/scenes/frame_check.hpp"

#include <gtest/gtest.h>

#include "server/errors.hpp"
#include "server/scenes/field_path.hpp"

namespace collided::server {
namespace {

// Mesh 0 is static, mesh 1 moves.
ScenePlan two_meshes(Mode mode = Mode::kCcd, Scalar scalar = Scalar::kF32) {
  ScenePlan plan;
  plan.meshes = {{"floor", 0}, {"tip", 0}};
  plan.engine.mode = mode;
  plan.engine.scalar = scalar;
  plan.engine.meshes.resize(2);
  for (auto& mesh : plan.engine.meshes) mesh.vertex_count = 3;
  plan.engine.meshes[0].is_static = true;
  return plan;
}

struct Frame {
  std::vector<float> values = std::vector<float>(9, 0.5f);
  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(values)); }
};

template <class Error>
std::string field_of(const ScenePlan& plan, const FrameInput& input, bool first) {
  try {
    check_updates(plan, input, first);
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(e.field()), std::string::npos) << e.what();
    return e.field();
  }
  return "accepted";
}

TEST(FrameCheck, IdsRiseFromOne) {
  EXPECT_THROW(check_frame_id(0, 0), InvalidInput);
  EXPECT_THROW(check_frame_id(4, 4), FailedPrecondition);
  EXPECT_THROW(check_frame_id(3, 4), FailedPrecondition);
  EXPECT_NO_THROW(check_frame_id(9, 4));
}

TEST(FrameCheck, FirstFrameNamesAllMeshes) {
  Frame f;
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{0, {}, f.bytes()}}, {}}, true), "frame.updates");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{0, {}, f.bytes()}, {1, {}, f.bytes()}}, {}}, true), "accepted");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{}, {}}, false), "accepted");
}

TEST(FrameCheck, UnknownDuplicateAndStaticMeshes) {
  Frame f;
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{2, {}, f.bytes()}}, {}}, false), "frame.updates[0].mesh");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{1, {}, f.bytes()}, {1, {}, f.bytes()}}, {}}, false),
            "frame.updates[1].mesh");
  EXPECT_EQ(field_of<FailedPrecondition>(two_meshes(), {{{0, {}, f.bytes()}}, {}}, false), "frame.updates[0].mesh");
}

TEST(FrameCheck, Lengths) {
  Frame f;
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{1, {}, {}}}, {}}, false), "frame.updates[0].positions");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(), {{{1, f.bytes().first(35), f.bytes()}}, {}}, false),
            "frame.updates[0].start_positions");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(Mode::kCcd, Scalar::kF64), {{{1, {}, f.bytes()}}, {}}, false),
            "frame.updates[0].positions");
  EXPECT_EQ(field_of<InvalidInput>(two_meshes(Mode::kDcd), {{{1, f.bytes(), f.bytes()}}, {}}, false),
            "frame.updates[0].start_positions");
}

TEST(FieldPath, EngineNamesBecomeProtocolNames) {
  EXPECT_EQ(frame_path("updates[1].end"), "frame.updates[1].positions");
  EXPECT_EQ(frame_path("updates[0].start"), "frame.updates[0].start_positions");
  EXPECT_EQ(frame_path("updates[0].mesh"), "frame.updates[0].mesh");
  EXPECT_EQ(frame_path(""), "frame");
  EXPECT_EQ(spec_path("meshes[0].triangles[5]"), "spec.meshes[0].triangles[5]");
  EXPECT_EQ(spec_path("memory_budget"), "spec.memory_budget_bytes");
}

TEST(FieldPath, MessagesNameTheProtocolsPath) {
  const InvalidInput engine("updates[1].end", "updates[1].end: vertex 2, coordinate y is nan");
  const InvalidInput ours = with_path(engine, frame_path);
  EXPECT_EQ(ours.field(), "frame.updates[1].positions");
  EXPECT_STREQ(ours.what(), "frame.updates[1].positions: vertex 2, coordinate y is nan");
  EXPECT_STREQ(with_path({"thickness", "must be >= 0"}, spec_path).what(), "spec.thickness: must be >= 0");
}

}  // namespace
}  // namespace collided::server
