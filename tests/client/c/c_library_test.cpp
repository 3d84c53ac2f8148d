// The C library finds what the engine finds, bit for bit, and refuses what cannot be used.
#include <gtest/gtest.h>

#include <thread>
#include <tuple>

#include "tests/client/c/run.h"
#include "tests/client/c/scenes.hpp"

namespace collided::test {
namespace {

/// Compares with the engine's answers, frame by frame.
struct Judge {
  std::vector<FrameResult> results;
  Topology topology;
  size_t contacts = 0, columns = 0;
};

template <class Number, class T>
void expect_same(const Number* numbers, const Column<T>& column, Judge& judge) {
  ASSERT_EQ(numbers == nullptr, column.empty());
  if (numbers == nullptr) return;
  ++judge.columns;
  EXPECT_EQ(std::memcmp(numbers, column.data(), column.size() * sizeof(T)), 0);
}

void compare(const PerKind<ContactSet>& expected, int32_t kind, const collided_contacts* contacts, Judge& judge) {
  const ContactSet& set = kind == COLLIDED_VERTEX_TRIANGLE ? expected.vertex_triangle
                          : kind == COLLIDED_EDGE_EDGE     ? expected.edge_edge
                          : kind == COLLIDED_EDGE_TRIANGLE ? expected.edge_triangle
                          : kind == COLLIDED_VERTEX_SOLID  ? expected.vertex_solid
                                                           : expected.triangle_triangle;
  ASSERT_EQ(contacts->count, set.size());
  judge.contacts += contacts->count;
  expect_same(contacts->elements, set.elements, judge);
  expect_same(contacts->toi, set.toi, judge);
  expect_same(contacts->distance, set.distance, judge);
  expect_same(contacts->weights, set.weights, judge);
  expect_same(contacts->normals, set.normals, judge);
  expect_same(contacts->flags, set.flags, judge);
  expect_same(contacts->features, set.features, judge);
  expect_same(contacts->signed_distance, set.signed_distance, judge);
  const bool has_vertex = kind == COLLIDED_VERTEX_TRIANGLE || kind == COLLIDED_VERTEX_SOLID;
  ASSERT_EQ(contacts->stencils == nullptr, contacts->count == 0 || (!has_vertex && kind != COLLIDED_EDGE_EDGE));
  for (uint64_t i = 0; contacts->stencils != nullptr && i < contacts->count; ++i) {
    const uint32_t *s = contacts->stencils + 4 * i, *e = contacts->elements + 2 * i;
    if (has_vertex) {
      EXPECT_EQ(s[0], e[0]);
      EXPECT_EQ((std::array{s[1], s[2], s[3]}), judge.topology.triangles[e[1]]);
    } else {
      EXPECT_EQ((std::array{s[0], s[1]}), judge.topology.edges[e[0]]);
      EXPECT_EQ((std::array{s[2], s[3]}), judge.topology.edges[e[1]]);
    }
  }
}

void compare_frame(void* context, size_t frame, int32_t kind, const collided_contacts* contacts) {
  Judge& judge = *static_cast<Judge*>(context);
  compare(judge.results.at(frame), kind, contacts, judge);
}

class SameAsEngine : public testing::TestWithParam<CaseOfFrames> {};

TEST_P(SameAsEngine, InEveryFrame) {
  const Scene scene(GetParam());
  Judge judge;
  const auto engine = Detector::create(scene.engine());
  judge.topology = engine->topology();
  for (size_t i = 0; i < Scene::kFrames; ++i) judge.results.push_back(engine->detect(scene.engine_frame(i)));
  ASSERT_EQ(run_frames(&scene.spec, scene.frames.data(), scene.frames.size(), compare_frame, &judge), COLLIDED_OK)
      << collided_error_message();
  EXPECT_GT(judge.contacts, 20u);
  EXPECT_GT(judge.columns, 2u);
}

INSTANTIATE_TEST_SUITE_P(CLibrary, SameAsEngine,
                         testing::Values(CaseOfFrames{}, CaseOfFrames{.accuracy = COLLIDED_CANDIDATES},
                                         CaseOfFrames{.accuracy = COLLIDED_FAST},
                                         CaseOfFrames{.accuracy = COLLIDED_GUARDED, .format = COLLIDED_Q16},
                                         CaseOfFrames{.accuracy = COLLIDED_EXACT, .format = COLLIDED_F64},
                                         CaseOfFrames{.format = COLLIDED_F64, .is_rigid = true},
                                         CaseOfFrames{.mode = COLLIDED_DCD, .thickness = 0.03},
                                         CaseOfFrames{.mode = COLLIDED_DCD, .kinds = COLLIDED_KINDS_TRIANGLE_TRIANGLE},
                                         CaseOfFrames{.mode = COLLIDED_DCD, .kinds = COLLIDED_KINDS_EDGE_TRIANGLE}));

class CLibrary : public testing::Test {
 protected:
  void create() { ASSERT_EQ(collided_scene_create(&scene.spec, &made), COLLIDED_OK) << collided_error_message(); }
  collided_status detect(size_t i, collided_result** result) { return collided_detect(made, &scene.frames[i], result); }
  void TearDown() override { collided_scene_free(made); }

  Scene scene{{}};
  collided_scene* made = nullptr;
};

TEST_F(CLibrary, HasTheVersionOfItsHeader) {
  EXPECT_EQ(collided_abi_version(), static_cast<uint32_t>(COLLIDED_ABI_VERSION));
  EXPECT_STREQ(collided_version(), COLLIDED_VERSION);
}

// Programs that are compiled already have these numbers.
TEST_F(CLibrary, StructuresKeepTheirLayout) {
  EXPECT_EQ(sizeof(collided_mesh), 104u);
  EXPECT_EQ(offsetof(collided_mesh, solid), 96u);
  EXPECT_EQ(offsetof(collided_mesh, half_thickness), 88u);
  EXPECT_EQ(offsetof(collided_mesh, vertex_count), 56u);
  EXPECT_EQ(sizeof(collided_scene_spec), 144u);
  EXPECT_EQ(offsetof(collided_scene_spec, mode), 48u);
  EXPECT_EQ(offsetof(collided_scene_spec, thickness), 80u);
  EXPECT_EQ(sizeof(collided_update), 80u);
  EXPECT_EQ(offsetof(collided_update, transform), 64u);
  EXPECT_EQ(sizeof(collided_frame), 112u);
  EXPECT_EQ(offsetof(collided_frame, delta), 48u);
  EXPECT_EQ(offsetof(collided_frame, room_bytes), 96u);
  EXPECT_EQ(offsetof(collided_frame, advance_mode), 104u);
  EXPECT_EQ(offsetof(collided_frame, limits), 108u);
  EXPECT_EQ(sizeof(collided_contacts), 88u);
  EXPECT_EQ(offsetof(collided_contacts, signed_distance), 80u);
  EXPECT_EQ(offsetof(collided_contacts, flags), 64u);
  EXPECT_EQ(offsetof(collided_contacts, features), 72u);
  EXPECT_EQ(sizeof(collided_facts), 264u);
  EXPECT_EQ(offsetof(collided_facts, vertex_solid_contacts), 240u);
  EXPECT_EQ(offsetof(collided_facts, mesh_pair_count), 248u);
  EXPECT_EQ(offsetof(collided_facts, inside_out), 256u);
  EXPECT_EQ(sizeof(collided_mesh_pair), 40u);
  EXPECT_EQ(offsetof(collided_mesh_pair, depth), 32u);
  EXPECT_EQ(offsetof(collided_facts, edge_triangle_contacts), 232u);
  EXPECT_EQ(offsetof(collided_facts, contacts), 176u);
  EXPECT_EQ(offsetof(collided_facts, way), 200u);
  EXPECT_EQ(sizeof(collided_topology), 72u);
  EXPECT_EQ(sizeof(collided_device_info), 160u);
}

TEST_F(CLibrary, FactsStagesTopologyAndPositionsAreThere) {
  create();
  collided_result* result = nullptr;
  ASSERT_EQ(detect(0, &result), COLLIDED_OK);
  collided_result_free(result);
  ASSERT_EQ(detect(1, &result), COLLIDED_OK);
  collided_facts facts = {};
  facts.struct_size = sizeof(facts);
  ASSERT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);
  EXPECT_EQ(facts.contact_count, facts.contacts[0] + facts.contacts[1] + facts.contacts[2]);
  EXPECT_TRUE(facts.any_contact);
  EXPECT_LT(facts.earliest_toi, 1);
  EXPECT_GE(facts.broad_phase_engine, COLLIDED_OCTREE);
  ASSERT_GT(facts.stage_count, 0u);
  const char* name = nullptr;
  double milliseconds = -1;
  EXPECT_EQ(collided_result_stage(result, facts.stage_count - 1, &name, &milliseconds), COLLIDED_OK);
  EXPECT_GE(milliseconds, 0);
  EXPECT_EQ(collided_result_stage(result, facts.stage_count, &name, &milliseconds), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_field(), "index");
  collided_result_free(result);

  collided_topology topology = {};
  topology.struct_size = sizeof(topology);
  ASSERT_EQ(collided_scene_topology(made, &topology), COLLIDED_OK);
  EXPECT_EQ(topology.mesh_count, 2u);
  EXPECT_EQ(topology.vertex_offsets[2], topology.vertex_count);
  std::vector<float> positions(3 * topology.vertex_offsets[1]);
  ASSERT_EQ(collided_scene_positions(made, 0, positions.data(), positions.size() * sizeof(float)), COLLIDED_OK);
  EXPECT_EQ(std::memcmp(positions.data(), scene.frames[1].updates[0].end, positions.size() * sizeof(float)), 0);
  uint64_t bytes = 0;
  EXPECT_EQ(collided_scene_memory(made, &bytes), COLLIDED_OK);
  EXPECT_GT(bytes, 0u);
  collided_device_info info = {};
  info.struct_size = sizeof(info);
  EXPECT_EQ(collided_scene_device(made, &info), COLLIDED_OK);
  EXPECT_STREQ(info.id, "cpu:0");
}

TEST_F(CLibrary, AnAdvanceTellsHowFarTheEngineWent) {
  constexpr AdvanceMode kModes[] = {AdvanceMode::kAllOrOne, AdvanceMode::kAllOrOne, AdvanceMode::kPerMesh,
                                    AdvanceMode::kPerVertex};
  for (int32_t mode = 0; mode <= COLLIDED_ADVANCE_PER_VERTEX; ++mode) {
    create();
    collided_result *first = nullptr, *result = nullptr;
    ASSERT_EQ(detect(0, &first), COLLIDED_OK);
    collided_result_free(first);
    collided_frame frame = scene.frames[1];
    frame.advance = 1, frame.advance_mode = mode;
    ASSERT_EQ(collided_detect(made, &frame, &result), COLLIDED_OK) << collided_error_message();
    collided_facts facts = {};
    facts.struct_size = sizeof(facts);
    ASSERT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);

    const auto engine = Detector::create(scene.engine());
    engine->detect(scene.engine_frame(0));
    FrameInput input = scene.engine_frame(1);
    input.advance = true, input.advance_mode = kModes[mode];
    const FrameResult expected = engine->detect(input);
    EXPECT_LT(facts.advanced, 1);
    EXPECT_EQ(facts.advanced, expected.advanced);
    EXPECT_EQ(facts.way, expected.way);
    EXPECT_LT(facts.way, 1);
    EXPECT_EQ(facts.shortened_count > 0, mode > COLLIDED_ADVANCE_ALL_OR_ONE);
    ASSERT_EQ(facts.shortened_count, expected.shortened.ids.size());
    EXPECT_EQ(facts.shortened_ids == nullptr, facts.shortened_count == 0);
    for (uint64_t i = 0; i < facts.shortened_count; ++i) {
      EXPECT_EQ(facts.shortened_ids[i], expected.shortened.ids[i]);
      EXPECT_EQ(facts.shortened_fractions[i], expected.shortened.fractions[i]);
    }
    collided_result_free(result);
    collided_scene_free(made);
    made = nullptr;
  }
}

TEST_F(CLibrary, LimitsAreTheEnginesWithAllColumns) {
  scene.spec.fields = COLLIDED_FIELDS_ELEMENTS;
  create();
  collided_result *first = nullptr, *result = nullptr;
  ASSERT_EQ(detect(0, &first), COLLIDED_OK);
  collided_frame frame = scene.frames[1];
  frame.advance = 1, frame.limits = 1;
  ASSERT_EQ(collided_detect(made, &frame, &result), COLLIDED_OK) << collided_error_message();

  Judge judge;
  const auto engine = Detector::create(scene.engine());
  judge.topology = engine->topology();
  engine->detect(scene.engine_frame(0));
  FrameInput input = scene.engine_frame(1);
  input.advance = input.limits = true;
  const FrameResult expected = engine->detect(input);
  for (int32_t kind = COLLIDED_VERTEX_TRIANGLE; kind <= COLLIDED_VERTEX_SOLID; ++kind) {
    collided_contacts limits = {};
    limits.struct_size = sizeof(limits);
    ASSERT_EQ(collided_result_limits(result, kind, &limits), COLLIDED_OK) << collided_error_message();
    compare(expected.limits, kind, &limits, judge);
    ASSERT_EQ(collided_result_limits(first, kind, &limits), COLLIDED_OK) << "a frame that does not ask for them";
    EXPECT_EQ(limits.count, 0u);
  }
  EXPECT_GT(judge.contacts, 20u);
  EXPECT_EQ(judge.columns, 12u) << "six of vertex-triangle and six of edge-edge pairs";
  collided_contacts limits = {};
  limits.struct_size = sizeof(limits);
  EXPECT_EQ(collided_result_limits(result, 6, &limits), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_field(), "kind");
  collided_result_free(first);
  collided_result_free(result);
}

TEST(CLibraryCrossings, AreCountedBesideTheOtherKinds) {
  const Scene scene({.mode = COLLIDED_DCD, .kinds = COLLIDED_KINDS_VERTEX_TRIANGLE | COLLIDED_KINDS_EDGE_TRIANGLE});
  const auto engine = Detector::create(scene.engine());
  collided_scene* made = nullptr;
  ASSERT_EQ(collided_scene_create(&scene.spec, &made), COLLIDED_OK) << collided_error_message();
  uint64_t crossings = 0;
  for (size_t i = 0; i < Scene::kFrames; ++i) {
    const FrameResult expected = engine->detect(scene.engine_frame(i));
    collided_result* result = nullptr;
    ASSERT_EQ(collided_detect(made, &scene.frames[i], &result), COLLIDED_OK) << collided_error_message();
    collided_facts facts = {};
    facts.struct_size = sizeof(facts);
    ASSERT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);
    EXPECT_EQ(facts.edge_triangle_contacts, expected.edge_triangle.size());
    EXPECT_EQ(facts.candidates[0], expected.counts.candidates.vertex_triangle);
    EXPECT_EQ(facts.survivors[0], expected.counts.survivors.vertex_triangle);
    EXPECT_EQ(facts.contacts[0], expected.vertex_triangle.size());
    EXPECT_EQ(facts.contact_count, facts.contacts[0] + facts.edge_triangle_contacts);
    crossings += facts.edge_triangle_contacts;
    collided_result_free(result);
  }
  EXPECT_GT(crossings, 0u);
  collided_scene_free(made);
}

// A cube of side 1 in one of side 10.
TEST(CLibrarySolids, TellWhatIsInsideThem) {
  static const uint32_t kCube[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  collided_mesh meshes[2] = {};
  std::vector<double> positions[2];
  collided_update updates[2] = {};
  for (uint32_t m = 0; m < 2; ++m) {
    meshes[m].struct_size = sizeof(collided_mesh);
    meshes[m].triangles = kCube, meshes[m].triangle_count = 12, meshes[m].vertex_count = 8;
    meshes[m].solid = 1;
    for (uint32_t i = 0; i < 24; ++i) {
      const bool is_far = (i / 3 >> i % 3 & 1) != 0;
      positions[m].push_back(m == 0 ? 10.0 * is_far : 4.0 + is_far);
    }
    updates[m].struct_size = sizeof(collided_update);
    updates[m].mesh = m, updates[m].end = positions[m].data(), updates[m].end_bytes = 24 * sizeof(double);
  }
  collided_scene_spec spec = {};
  spec.struct_size = sizeof(spec);
  spec.meshes = meshes, spec.mesh_count = 2, spec.device = "cpu";
  spec.mode = COLLIDED_DCD, spec.position_format = COLLIDED_F64;
  spec.kinds = COLLIDED_KINDS_VERTEX_SOLID;
  spec.fields = COLLIDED_FIELDS_ELEMENTS | COLLIDED_FIELDS_DISTANCE | COLLIDED_FIELDS_PAIR_STATES;
  collided_frame frame = {};
  frame.struct_size = sizeof(frame);
  frame.updates = updates, frame.update_count = 2;
  collided_scene* made = nullptr;
  collided_result* result = nullptr;
  ASSERT_EQ(collided_scene_create(&spec, &made), COLLIDED_OK) << collided_error_message();
  ASSERT_EQ(collided_detect(made, &frame, &result), COLLIDED_OK) << collided_error_message();
  collided_contacts contacts = {};
  contacts.struct_size = sizeof(contacts);
  ASSERT_EQ(collided_result_contacts(result, COLLIDED_VERTEX_SOLID, &contacts), COLLIDED_OK);
  ASSERT_EQ(contacts.count, 8u);
  for (uint64_t i = 0; i < 8; ++i) EXPECT_DOUBLE_EQ(contacts.distance[i], i < 7 ? -4 : -5);
  collided_facts facts = {};
  facts.struct_size = sizeof(facts);
  ASSERT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);
  EXPECT_EQ(facts.vertex_solid_contacts, 8u);
  EXPECT_EQ(facts.inside_out, 0u);
  ASSERT_EQ(facts.mesh_pair_count, 1u);
  collided_mesh_pair pair = {};
  pair.struct_size = sizeof(pair);
  ASSERT_EQ(collided_result_mesh_pair(result, 0, &pair), COLLIDED_OK);
  EXPECT_EQ(std::tuple(pair.first, pair.second, pair.state), std::tuple(0u, 1u, int32_t{COLLIDED_PAIR_SECOND_INSIDE}));
  EXPECT_EQ(std::tuple(pair.first_inside, pair.second_inside, pair.deepest), std::tuple(0u, 8u, 15u));
  EXPECT_DOUBLE_EQ(pair.depth, 5);
  EXPECT_EQ(collided_result_mesh_pair(result, 1, &pair), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_field(), "index");
  collided_result_free(result);
  collided_scene_free(made);
}

// A program that was compiled before there were modes.
TEST_F(CLibrary, StructuresOfTheFirstVersionAreUsedAsTheyWere) {
  create();
  collided_frame frame = scene.frames[0];
  frame.struct_size = offsetof(collided_frame, advance_mode);
  frame.advance_mode = 77, frame.limits = 77;  // beyond its end
  collided_result* result = nullptr;
  ASSERT_EQ(collided_detect(made, &frame, &result), COLLIDED_OK) << collided_error_message();
  collided_facts facts = {};
  facts.struct_size = offsetof(collided_facts, way);
  facts.way = -7;
  ASSERT_EQ(collided_result_facts(result, &facts), COLLIDED_OK);
  EXPECT_EQ(facts.advanced, 1);
  EXPECT_EQ(facts.way, -7);
  collided_result_free(result);
}

TEST_F(CLibrary, AResultOutlivesItsScene) {
  create();
  collided_result *first = nullptr, *result = nullptr;
  ASSERT_EQ(detect(0, &first), COLLIDED_OK);
  ASSERT_EQ(detect(1, &result), COLLIDED_OK);
  collided_result_free(first);
  collided_scene_free(made);
  made = nullptr;
  collided_contacts contacts = {};
  contacts.struct_size = sizeof(contacts);
  ASSERT_EQ(collided_result_contacts(result, COLLIDED_EDGE_EDGE, &contacts), COLLIDED_OK);
  EXPECT_GT(contacts.count, 0u);
  EXPECT_LT(contacts.stencils[4 * contacts.count - 1], 2u * 14 * 14);
  collided_result_free(result);
}

TEST_F(CLibrary, FieldsThatAreNotAskedForAreNull) {
  scene.spec.fields = COLLIDED_FIELDS_TOI;
  create();
  collided_result *first = nullptr, *result = nullptr;
  ASSERT_EQ(detect(0, &first), COLLIDED_OK);
  ASSERT_EQ(detect(1, &result), COLLIDED_OK);
  collided_contacts contacts = {};
  contacts.struct_size = sizeof(contacts);
  ASSERT_EQ(collided_result_contacts(result, COLLIDED_VERTEX_TRIANGLE, &contacts), COLLIDED_OK);
  EXPECT_GT(contacts.count, 0u);
  EXPECT_NE(contacts.toi, nullptr);
  for (const void* column : {static_cast<const void*>(contacts.elements), static_cast<const void*>(contacts.stencils),
                             static_cast<const void*>(contacts.distance), static_cast<const void*>(contacts.flags),
                             static_cast<const void*>(contacts.normals), static_cast<const void*>(contacts.features),
                             static_cast<const void*>(contacts.signed_distance)})
    EXPECT_EQ(column, nullptr);
  collided_result_free(first);
  collided_result_free(result);
}

using Contacts = collided_status (*)(const collided_result*, int32_t, collided_contacts*);

collided_contacts contacts_by(Contacts call, const collided_result* result, int32_t kind) {
  collided_contacts contacts = {};
  contacts.struct_size = sizeof(contacts);
  EXPECT_EQ(call(result, kind, &contacts), COLLIDED_OK) << collided_error_message();
  return contacts;
}

/// Checks that `some` are the contacts of `all` from `first` on.
void expect_part(const collided_contacts& some, const collided_contacts& all, uint64_t first) {
  ASSERT_LE(first + some.count, all.count);
  const auto same = [&](const auto* part, const auto* whole, size_t width) {
    ASSERT_EQ(part == nullptr, some.count == 0 || whole == nullptr);
    if (part == nullptr) return;
    EXPECT_EQ(std::memcmp(part, whole + width * first, width * some.count * sizeof(*part)), 0);
  };
  same(some.elements, all.elements, 2);
  same(some.stencils, all.stencils, 4);
  same(some.toi, all.toi, 1);
  same(some.distance, all.distance, 1);
  same(some.weights, all.weights, 2);
  same(some.normals, all.normals, 3);
  same(some.flags, all.flags, 1);
  same(some.features, all.features, 1);
  same(some.signed_distance, all.signed_distance, 1);
}

TEST_F(CLibrary, ContactsStayInTheRoomAndThoseThatDoNotFitComeToTheHost) {
  for (const uint64_t room_bytes : {64, 1200, 1 << 20}) {
    alignas(64) static std::byte room[1 << 20];
    collided_result *all = nullptr, *parted = nullptr;
    for (collided_result** result : {&all, &parted}) {
      create();
      collided_result* first = nullptr;
      ASSERT_EQ(detect(0, &first), COLLIDED_OK);
      collided_result_free(first);
      collided_frame frame = scene.frames[1];
      if (result == &parted) frame.room = room, frame.room_bytes = room_bytes;
      ASSERT_EQ(collided_detect(made, &frame, result), COLLIDED_OK) << collided_error_message();
      collided_scene_free(made);
      made = nullptr;
    }
    uint64_t in_room = 0, count = 0;
    for (const int32_t kind : {COLLIDED_VERTEX_TRIANGLE, COLLIDED_EDGE_EDGE}) {
      const collided_contacts whole = contacts_by(collided_result_contacts, all, kind);
      const collided_contacts here = contacts_by(collided_result_contacts_in_room, parted, kind);
      const collided_contacts rest = contacts_by(collided_result_contacts, parted, kind);
      ASSERT_EQ(here.count + rest.count, whole.count);
      expect_part(here, whole, 0);
      expect_part(rest, whole, here.count);
      EXPECT_EQ(contacts_by(collided_result_contacts_in_room, all, kind).count, 0u);
      in_room += here.count;
      count += whole.count;
      EXPECT_TRUE(here.count == 0 || reinterpret_cast<const std::byte*>(here.toi) >= room);
    }
    EXPECT_GT(count, 20u);
    EXPECT_EQ(in_room == 0, room_bytes == 64);
    EXPECT_EQ(in_room == count, room_bytes == 1 << 20);
    collided_result_free(all);
    collided_result_free(parted);
  }
}

TEST_F(CLibrary, AFrameIsCancelledAndTheSceneStaysBusyMeanwhile) {
  create();
  struct Asked {
    collided_scene* scene;
    int times = 0;
    collided_status meanwhile = COLLIDED_OK;
  } asked{made};
  scene.frames[0].cancelled_context = &asked;
  scene.frames[0].cancelled = [](void* context) -> int32_t {
    Asked& self = *static_cast<Asked*>(context);
    ++self.times;
    uint64_t bytes = 0;
    self.meanwhile = collided_scene_memory(self.scene, &bytes);
    return 1;
  };
  collided_result* result = nullptr;
  EXPECT_EQ(detect(0, &result), COLLIDED_CANCELLED);
  EXPECT_EQ(result, nullptr);
  EXPECT_GT(asked.times, 0);
  EXPECT_EQ(asked.meanwhile, COLLIDED_FAILED_PRECONDITION);
  scene.frames[0].cancelled = nullptr;
  EXPECT_EQ(detect(0, &result), COLLIDED_OK) << "the scene is usable again";
  collided_result_free(result);
}

TEST_F(CLibrary, ErrorsAreEachThreadsOwn) {
  EXPECT_EQ(collided_scene_create(nullptr, nullptr), COLLIDED_INVALID_ARGUMENT);
  EXPECT_STREQ(collided_error_message(), "scene is null");
  std::thread([] {
    EXPECT_STREQ(collided_error_message(), "");
    EXPECT_EQ(collided_result_facts(nullptr, nullptr), COLLIDED_INVALID_ARGUMENT);
    EXPECT_STREQ(collided_error_field(), "result");
  }).join();
  EXPECT_STREQ(collided_error_field(), "scene");
}

}  // namespace
}  // namespace collided::test
