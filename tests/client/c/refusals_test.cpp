// The C library refuses each value that cannot be used, names its field, and changes nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/client/c/scenes.hpp"

namespace collided::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct BadSpec {
  const char* field;
  std::function<void(collided_scene_spec& spec, collided_mesh* meshes)> spoil;
};

TEST(CLibraryRefusals, SpecsWithTheirField) {
  uint32_t bad_corner[] = {0, 1, 7}, twice[] = {0, 1, 1}, pair[] = {0, 2};
  double upside_down[] = {0, 0, 0, 1, -1, 1}, endless[] = {0, 0, 0, 1, kInfinity, 1};
  const BadSpec cases[] = {
      {"spec.struct_size", [](auto& s, auto*) { s.struct_size = 8; }},
      {"spec.struct_size", [](auto& s, auto*) { s.struct_size = 0; }},
      {"spec.struct_size", [](auto& s, auto*) { s.struct_size = ~size_t{0}; }},
      {"meshes", [](auto& s, auto*) { s.meshes = nullptr; }},
      {"meshes", [](auto& s, auto*) { s.mesh_count = 0; }},
      {"mesh_count", [](auto& s, auto*) { s.mesh_count = ~uint64_t{0}; }},
      {"meshes[1].struct_size", [](auto&, auto* m) { m[1].struct_size = 4000; }},
      {"meshes[0].struct_size", [](auto&, auto* m) { m[0].struct_size = 4; }},
      {"meshes[0].vertex_count", [](auto&, auto* m) { m[0].vertex_count = 0; }},
      {"meshes[1].triangles", [](auto&, auto* m) { m[1].triangles = nullptr; }},
      {"meshes[1].triangle_count", [](auto&, auto* m) { m[1].triangle_count = uint64_t{1} << 62; }},
      {"meshes[1].edges", [](auto&, auto* m) { m[1].edge_count = 1; }},
      {"meshes[1].points", [](auto&, auto* m) { m[1].point_count = 1; }},
      {"meshes[0].triangles[0]", [&](auto&, auto* m) { m[0].triangles = bad_corner; }},
      {"meshes[0].triangles[0]", [&](auto&, auto* m) { m[0].triangles = twice; }},
      {"meshes[0].motion", [](auto&, auto* m) { m[0].motion = 4; }},
      {"meshes[0].motion", [](auto&, auto* m) { m[0].motion = -1; }},
      {"meshes[1].excluded_rings", [](auto&, auto* m) { m[1].excluded_rings = 9; }},
      {"meshes[1].half_thickness", [](auto&, auto* m) { m[1].half_thickness = -1; }},
      {"meshes[0].half_thickness", [](auto&, auto* m) { m[0].half_thickness = kNan; }},
      {"meshes[0].half_thickness", [](auto&, auto* m) { m[0].half_thickness = kInfinity; }},
      {"meshes[0].half_thickness", [](auto&, auto* m) { m[0].half_thickness = 1e300; }},
      {"meshes[0].solid", [](auto&, auto* m) { m[0].solid = 1; }},
      {"vertex_solid", [](auto& s, auto*) { s.mode = COLLIDED_DCD, s.kinds = COLLIDED_KINDS_VERTEX_SOLID; }},
      {"pair_states", [](auto& s, auto*) { s.mode = COLLIDED_DCD, s.fields = COLLIDED_FIELDS_PAIR_STATES; }},
      {"excluded_meshes", [](auto& s, auto*) { s.excluded_mesh_count = 1; }},
      {"excluded_meshes[0]", [&](auto& s, auto*) { s.excluded_meshes = pair, s.excluded_mesh_count = 1; }},
      {"device", [](auto& s, auto*) { s.device = "tpu"; }},
      {"device", [](auto& s, auto*) { s.device = "cuda:x"; }},
      {"mode", [](auto& s, auto*) { s.mode = 4; }},
      {"accuracy", [](auto& s, auto*) { s.accuracy = 6; }},
      {"report", [](auto& s, auto*) { s.report = -7; }},
      {"report", [](auto& s, auto*) { s.mode = COLLIDED_DCD, s.report = COLLIDED_REPORT_EARLIEST_ONLY; }},
      {"position_format", [](auto& s, auto*) { s.position_format = 99; }},
      {"broad_phase_engine", [](auto& s, auto*) { s.broad_phase_engine = 9; }},
      {"reuse", [](auto& s, auto*) { s.reuse = 3; }},
      {"kinds", [](auto& s, auto*) { s.kinds = 32; }},
      {"fields", [](auto& s, auto*) { s.fields = 1024; }},
      {"thickness", [](auto& s, auto*) { s.thickness = kNan; }},
      {"thickness", [](auto& s, auto*) { s.thickness = -1; }},
      {"delta", [](auto& s, auto*) { s.delta = kInfinity; }},
      {"min_separation", [](auto& s, auto*) { s.min_separation = kNan; }},
      {"rest_distance", [](auto& s, auto*) { s.rest_distance = 1; }},
      {"quantized_in", [](auto& s, auto*) { s.position_format = COLLIDED_Q16; }},
      {"quantized_in", [&](auto& s, auto*) { s.quantized_in = endless; }},
      {"quantized_in", [&](auto& s, auto*) { s.position_format = COLLIDED_Q16, s.quantized_in = endless; }},
      {"quantized_in", [&](auto& s, auto*) { s.position_format = COLLIDED_Q16, s.quantized_in = upside_down; }},
      {"expected_contacts", [](auto& s, auto*) { s.expected_contacts = uint64_t{1} << 40; }},
      {"threads", [](auto& s, auto*) { s.threads = -1; }},
      {"threads", [](auto& s, auto*) { s.threads = std::numeric_limits<int32_t>::max(); }},
  };
  const uint32_t triangle[] = {0, 1, 2};
  for (const BadSpec& bad : cases) {
    collided_mesh meshes[2] = {};
    for (collided_mesh& mesh : meshes) {
      mesh.struct_size = sizeof(mesh);
      mesh.vertex_count = 3;
      mesh.triangles = triangle;
      mesh.triangle_count = 1;
    }
    collided_scene_spec spec = {};
    spec.struct_size = sizeof(spec);
    spec.meshes = meshes;
    spec.mesh_count = 2;
    spec.device = "cpu";
    bad.spoil(spec, meshes);
    collided_scene* scene = nullptr;
    ASSERT_EQ(collided_scene_create(&spec, &scene), COLLIDED_INVALID_ARGUMENT) << bad.field;
    EXPECT_EQ(scene, nullptr);
    EXPECT_STREQ(collided_error_field(), bad.field) << collided_error_message();
    EXPECT_EQ(std::string(collided_error_message()).rfind(bad.field, 0), 0u) << collided_error_message();
  }
}

struct BadFrame {
  const char* field;
  std::function<void(collided_frame& frame, collided_update* updates)> spoil;
};

TEST(CLibraryRefusals, FramesWithTheirFieldAndTheSceneStays) {
  const Scene scene({.is_rigid = true});
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&scene.spec, &made), COLLIDED_OK);
  collided_result* result = nullptr;
  ASSERT_EQ(collided_detect(made, &scene.frames[0], &result), COLLIDED_OK);
  collided_result_free(result);
  const double scaled[12] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, lost[12] = {kNan, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const double bad_fraction = 1.5, bad_delta = kNan;
  const uint32_t falling[] = {3, 2};
  alignas(64) char room[128];
  std::vector<float> positions(14 * 14 * 3);
  positions[5] = std::numeric_limits<float>::infinity();
  const BadFrame cases[] = {
      {"frame.struct_size", [](auto& f, auto*) { f.struct_size = 1; }},
      {"updates", [](auto& f, auto*) { f.updates = nullptr; }},
      {"update_count", [](auto& f, auto*) { f.update_count = ~uint64_t{0}; }},
      {"updates[0].mesh", [](auto&, auto* u) { u[0].mesh = 2; }},
      {"updates[1].mesh",
       [](auto&, auto* u) {
         u[1].mesh = 0, u[1].transform = nullptr, u[1].end = u[0].end, u[1].end_bytes = u[0].end_bytes;
       }},
      {"updates[0].end", [](auto&, auto* u) { u[0].end = nullptr; }},
      {"updates[0].end", [](auto&, auto* u) { u[0].end_bytes -= 12; }},
      {"updates[0].end_bytes", [](auto&, auto* u) { u[0].end_bytes = 0; }},
      {"updates[0].end", [&](auto&, auto* u) { u[0].end = positions.data(); }},
      {"updates[0].start", [](auto&, auto* u) { u[0].start_bytes = 12; }},
      {"updates[0].indices", [](auto&, auto* u) { u[0].is_sparse = 1, u[0].index_count = 2; }},
      {"updates[0].indices", [&](auto&, auto* u) { u[0].indices = falling, u[0].index_count = 2; }},
      {"updates[0].indices",
       [&](auto&, auto* u) { u[0].is_sparse = 1, u[0].indices = falling, u[0].index_count = 2, u[0].end_bytes = 24; }},
      {"updates[0].index_count",
       [&](auto&, auto* u) { u[0].is_sparse = 1, u[0].indices = falling, u[0].index_count = uint64_t{1} << 61; }},
      {"updates[0].transform", [&](auto&, auto* u) { u[0].transform = scaled; }},
      {"updates[1].transform", [&](auto&, auto* u) { u[1].transform = scaled; }},
      {"updates[1].transform", [&](auto&, auto* u) { u[1].transform = lost; }},
      {"mode", [](auto& f, auto*) { f.mode = COLLIDED_DCD_AND_CCD; }},
      {"mode", [](auto& f, auto*) { f.mode = 77; }},
      {"accuracy", [](auto& f, auto*) { f.accuracy = -1; }},
      {"report", [](auto& f, auto*) { f.report = 4; }},
      {"delta", [&](auto& f, auto*) { f.delta = &bad_delta; }},
      {"start_fraction", [&](auto& f, auto*) { f.start_fraction = &bad_fraction; }},
      {"advance", [](auto& f, auto*) { f.accuracy = COLLIDED_FAST, f.advance = 1; }},
      {"advance_mode", [](auto& f, auto*) { f.advance_mode = COLLIDED_ADVANCE_PER_MESH; }},
      {"advance_mode", [](auto& f, auto*) { f.advance = 1, f.advance_mode = 4; }},
      {"advance_mode", [](auto& f, auto*) { f.advance = 1, f.advance_mode = -1; }},
      {"limits", [](auto& f, auto*) { f.limits = 1; }},
      {"stream", [](auto& f, auto*) { f.stream = &f; }},  // of a scene on CPU cores
      {"room", [](auto& f, auto*) { f.room_bytes = 64; }},
      {"room_bytes", [&](auto& f, auto*) { f.room = positions.data(); }},
      {"room", [&](auto& f, auto*) { f.room = room + 1, f.room_bytes = 64; }},
  };
  for (const BadFrame& bad : cases) {
    collided_frame frame = scene.frames[1];
    collided_update updates[] = {frame.updates[0], frame.updates[1]};
    frame.updates = updates;
    bad.spoil(frame, updates);
    result = reinterpret_cast<collided_result*>(&frame);
    ASSERT_EQ(collided_detect(made, &frame, &result), COLLIDED_INVALID_ARGUMENT) << bad.field;
    EXPECT_EQ(result, nullptr);
    EXPECT_STREQ(collided_error_field(), bad.field) << collided_error_message();
  }
  ASSERT_EQ(collided_detect(made, &scene.frames[1], &result), COLLIDED_OK) << collided_error_message();
  collided_facts facts = {};
  facts.struct_size = sizeof(facts);
  EXPECT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);
  const auto engine = Detector::create(scene.engine());
  engine->detect(scene.engine_frame(0));
  EXPECT_EQ(facts.contact_count, count_contacts(engine->detect(scene.engine_frame(1)))) << "the scene was not changed";
  collided_result_free(result);
  collided_scene_free(made);
}

TEST(CLibraryRefusals, NullPointersEverywhere) {
  const Scene scene({});
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&scene.spec, &made), COLLIDED_OK);
  collided_result* result = nullptr;
  const collided_status refused[] = {collided_device_count(nullptr),
                                     collided_device(0, nullptr),
                                     collided_scene_create(nullptr, &made),
                                     collided_scene_topology(nullptr, nullptr),
                                     collided_scene_memory(nullptr, nullptr),
                                     collided_scene_positions(nullptr, 0, nullptr, 0),
                                     collided_detect(nullptr, &scene.frames[0], &result),
                                     collided_detect(made, nullptr, &result),
                                     collided_detect(made, &scene.frames[0], nullptr),
                                     collided_result_contacts(nullptr, 1, nullptr),
                                     collided_result_contacts_in_room(nullptr, 1, nullptr),
                                     collided_result_facts(nullptr, nullptr),
                                     collided_result_mesh_pair(nullptr, 0, nullptr),
                                     collided_result_stage(nullptr, 0, nullptr, nullptr),
                                     collided_result_unused_option(nullptr, 0, nullptr)};
  for (const collided_status status : refused) EXPECT_EQ(status, COLLIDED_INVALID_ARGUMENT);
  collided_scene_free(nullptr);
  collided_result_free(nullptr);
}

/// A later header adds a member like this.
struct LaterSpec {
  collided_scene_spec now;
  uint64_t later;
};

TEST(CLibraryRefusals, MembersOfALaterVersionUnlessTheyAreZero) {
  const Scene scene({});
  LaterSpec spec{scene.spec, 0};
  spec.now.struct_size = sizeof(spec);
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&spec.now, &made), COLLIDED_OK) << collided_error_message();
  collided_scene_free(made);
  spec.later = 1;
  EXPECT_EQ(collided_scene_create(&spec.now, &made), COLLIDED_UNIMPLEMENTED);
  EXPECT_EQ(made, nullptr);
  spec.now = scene.spec;
  spec.now.reserved = 1;
  EXPECT_EQ(collided_scene_create(&spec.now, &made), COLLIDED_UNIMPLEMENTED);
}

TEST(CLibraryRefusals, ElementsOfLaterMeshesAreStridesApart) {
  struct LaterMesh {
    collided_mesh now;
    uint64_t later = 0;
  } meshes[2];
  const Scene scene({});
  for (size_t i = 0; i < 2; ++i) {
    meshes[i].now = scene.spec.meshes[i];
    meshes[i].now.struct_size = sizeof(LaterMesh);
  }
  collided_scene_spec spec = scene.spec;
  spec.meshes = &meshes[0].now;
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&spec, &made), COLLIDED_OK) << collided_error_message();
  struct LaterTopology {
    collided_topology now;
    uint64_t later = 7;
  } topology{};
  topology.now.struct_size = sizeof(topology);
  EXPECT_EQ(collided_scene_topology(made, &topology.now), COLLIDED_OK);
  EXPECT_EQ(topology.now.mesh_count, 2u);
  EXPECT_EQ(topology.later, 0u) << "what this version does not know is 0";
  collided_scene_free(made);
}

TEST(CLibraryRefusals, PositionsBeforeAFrameAndOfAnotherSize) {
  const Scene scene({});
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&scene.spec, &made), COLLIDED_OK);
  std::vector<float> positions(14 * 14 * 3);
  EXPECT_EQ(collided_scene_positions(made, 0, positions.data(), 4 * positions.size()), COLLIDED_FAILED_PRECONDITION);
  EXPECT_EQ(collided_scene_positions(made, 0, positions.data(), 4), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_field(), "bytes");
  EXPECT_EQ(collided_scene_positions(made, 2, positions.data(), 4 * positions.size()), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_field(), "mesh");
  collided_scene_free(made);
}

}  // namespace
}  // namespace collided::test
