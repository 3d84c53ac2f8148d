// What is told of a scene before it is made, against the scene.

#include <map>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

using Parts = std::map<std::string, uint64_t>;

struct Setting {
  const char* name;
  void (*change)(SceneSpec& spec, Case& c);
};

void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

const Setting kSettings[] = {
    {"Defaults", [](SceneSpec&, Case&) {}},
    {"Candidates", [](SceneSpec& spec, Case&) { spec.accuracy = Accuracy::kCandidates; }},
    {"Fast", [](SceneSpec& spec, Case&) { spec.accuracy = Accuracy::kFast; }},
    {"Guarded", [](SceneSpec& spec, Case&) { spec.accuracy = Accuracy::kGuarded; }},
    {"Exact", [](SceneSpec& spec, Case&) { spec.accuracy = Accuracy::kExact; }},
    {"Discrete", [](SceneSpec& spec, Case&) { spec.mode = Mode::kDcd; }},
    {"TrianglePairs", [](SceneSpec& spec, Case&) { spec.mode = Mode::kDcd, spec.kinds = {.triangle_triangle = true}; }},
    {"VertexTriangle", [](SceneSpec& spec, Case&) { spec.kinds = {.vertex_triangle = true}; }},
    {"EdgeEdge", [](SceneSpec& spec, Case&) { spec.kinds = {.edge_edge = true}; }},
    {"EveryField", [](SceneSpec& spec, Case&) { spec.fields = kEveryField; }},
    {"Earliest", [](SceneSpec& spec, Case&) { spec.report = Report::kEarliestOnly; }},
    {"AnyHit", [](SceneSpec& spec, Case&) { spec.report = Report::kAnyHit; }},
    {"AnyHitExact", [](SceneSpec& spec, Case&) { spec.report = Report::kAnyHit, spec.accuracy = Accuracy::kExact; }},
    {"Doubles", [](SceneSpec& spec, Case&) { spec.scalar = Scalar::kF64; }},
    {"Octree", [](SceneSpec& spec, Case&) { spec.engine = Engine::kOctree; }},
    {"UniformGrid", [](SceneSpec& spec, Case&) { spec.engine = Engine::kUniformGrid; }},
    {"TwoLevelGrid", [](SceneSpec& spec, Case&) { spec.engine = Engine::kTwoLevelGrid; }},
    {"VirtualSubdivision", [](SceneSpec& spec, Case&) { spec.engine = Engine::kVss; }},
    {"AllPairs", [](SceneSpec& spec, Case&) { spec.engine = Engine::kAllPairs; }},
    {"Hierarchy", [](SceneSpec& spec, Case&) { spec.engine = Engine::kLbvh; }},
    {"StaticMesh", [](SceneSpec&, Case& c) { c.meshes[0].motion = MeshMotion::kStatic; }},
    {"RigidMesh", [](SceneSpec&, Case& c) { c.meshes[0].motion = MeshMotion::kRigid; }},
    {"DiscreteRigidMesh",
     [](SceneSpec& spec, Case& c) { spec.mode = Mode::kDcd, c.meshes[0].motion = MeshMotion::kRigid; }},
    {"BothModes", [](SceneSpec& spec, Case&) { spec.mode = Mode::kBoth; }},
    {"ExcludedMeshes",
     [](SceneSpec& spec, Case&) {
       spec.excluded_meshes = {{0, 1}};
     }},
    {"LooseElements",
     [](SceneSpec&, Case& c) {
       c = loosened(c);
       for (MeshSpec& mesh : c.meshes) mesh.points.resize(1);  // others are where it is, by float's spacing
     }},
    {"ThickMesh", [](SceneSpec&, Case& c) { c.meshes[0].half_thickness = 0.01; }},
    {"DiscreteThickMesh", [](SceneSpec& spec, Case& c) { spec.mode = Mode::kDcd, c.meshes[1].half_thickness = 0.01; }},
    {"NoSelfContacts", [](SceneSpec&, Case& c) { c.meshes[0].self_contacts = false; }}};

/// Two meshes of triangles so far apart that nothing is found.
Case sparse() {
  Case c = soup(90, 300, 1e6, 0.1, 0);
  const Case other = soup(91, 200, 1e6, 0.1, 0, {1e7, 0, 0});
  add_mesh(c, other.meshes[0].triangles, other.start[0], other.end[0]);
  return c;
}

struct Scene {
  explicit Scene(const Setting& setting) {
    Case c = sparse();
    SceneSpec wanted = settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32);
    setting.change(wanted, c);
    const SceneSpec spec = spec_for(c, wanted);
    detector = Detector::create(spec);
    const Frame positions(c, spec.mode, spec.scalar);
    FrameInput frame = positions.input();
    for (MeshPositions& update : frame.updates) update.start = {};
    result = detector->detect(frame);
    SceneSpec without_triangles = spec;
    for (MeshSpec& mesh : without_triangles.meshes) mesh.triangles = {}, mesh.edges = {}, mesh.points = {};
    const Topology& topology = detector->topology();
    estimate = estimate_scene(without_triangles, topology.vertex_count, topology.triangles.size());
    min_bytes = min_scene_bytes(without_triangles, topology.vertex_count, topology.triangles.size());
  }

  std::unique_ptr<Detector> detector;
  FrameResult result;
  SceneEstimate estimate;
  uint64_t min_bytes = 0;
};

Parts by_name(const std::vector<MemoryPart>& parts) {
  Parts out;
  for (const MemoryPart& part : parts) {
    EXPECT_GT(part.bytes, 0u) << part.part;
    EXPECT_TRUE(out.emplace(part.part, part.bytes).second) << part.part << " twice";
  }
  return out;
}

class Estimate : public OnBackend<::testing::TestWithParam<Setting>> {};

// On CPU cores all of it is known but the number of edges, and what positions take on their way.
TEST_P(Estimate, TellsTheMemoryOfTheFirstFrame) {
  const Scene scene(GetParam());
  ASSERT_EQ(scene.result.replays, 0u);
  const Parts told = by_name(scene.estimate.memory), held = by_name(scene.detector->memory());
  for (const auto& [part, bytes] : told) {
    ASSERT_TRUE(held.contains(part)) << part;
    EXPECT_LE(bytes, held.at(part)) << part;
  }
  if (kBackend != Backend::kCpu) return;
  for (const auto& [part, bytes] : held) {
    if (part == "staging") continue;
    ASSERT_TRUE(told.contains(part)) << part;
    const uint64_t edges = part == "edges" ? scene.detector->topology().edges.size() * 2 * sizeof(uint32_t) : 0;
    EXPECT_GE(told.at(part) + edges, bytes) << part;
  }
}

TEST_P(Estimate, TellsTheStagesOfAFrameThatFindsNothing) {
  const Scene scene(GetParam());
  std::vector<std::string> ran;
  for (const StageTime& stage : scene.result.stages) ran.push_back(stage.stage);
  EXPECT_EQ(scene.estimate.stages, ran);
}

TEST_P(Estimate, IsNoLessThanTheMinimum) {
  const Scene scene(GetParam());
  uint64_t bytes = scene.detector->topology().triangles.size() * 3 * sizeof(uint32_t);
  for (const MemoryPart& part : scene.estimate.memory) bytes += part.bytes;
  EXPECT_LE(scene.min_bytes, bytes);
}

INSTANTIATE_TEST_SUITE_P(Settings, Estimate, ::testing::ValuesIn(kSettings),
                         [](const auto& info) { return std::string(info.param.name); });

using Estimates = OnBackend<>;

TEST_F(Estimates, TellTheFieldsOfContacts) {
  for (const Accuracy level : {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kCertified}) {
    const Case c = soup(92, 300, 1, 0.3, 0.1);
    SceneSpec spec = settings(Mode::kCcd, level);
    spec.fields = kEveryField;
    const FrameResult result = run_case(c, spec);
    ASSERT_GT(result.vertex_triangle.size(), 0u);
    ASSERT_GT(result.edge_edge.size(), 0u);
    const SceneEstimate estimate = estimate_scene(spec, c.start[0].size(), c.meshes[0].triangles.size());
    for_each_kind(
        [&](ContactKind, const ContactSet& set, FieldSet fields) {
          for_each_field([&](ContactField field, const auto& column) { EXPECT_EQ(fields.has(field), !column.empty()); },
                         set);
        },
        result, estimate.fields);
  }
}

TEST_F(Estimates, RefuseWhatASceneRefuses) {
  SceneSpec spec = settings(Mode::kDcd, Accuracy::kFast);
  EXPECT_THROW(estimate_scene(spec, 3, 1), InvalidInput);
  spec.thickness = 0.1;
  EXPECT_NO_THROW(estimate_scene(spec, 3, 1));
}

// An estimate of the largest scene there can be takes no memory of its size.
TEST_F(Estimates, TakeNoMemory) {
  const uint64_t many = uint64_t{1} << 29;
  const SceneEstimate estimate = estimate_scene(settings(Mode::kCcd, Accuracy::kCertified), many, many);
  EXPECT_GT(by_name(estimate.memory).at("records"), many * 100);
}

}  // namespace
}  // namespace collided::test
