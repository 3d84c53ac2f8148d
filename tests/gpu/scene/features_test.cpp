// Tests which frames tell the features that closest points are on, and that these do not depend on threads, engines or
// other options. covering_test.cpp judges what they are, and which contacts are covered.

#include <algorithm>

#include "tests/gpu/backend.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/every_field.hpp"

namespace collided::test {
namespace {

using Features = OnBackend<>;

SceneSpec telling(Accuracy accuracy = Accuracy::kCertified, Scalar scalar = Scalar::kF64, double thickness = 0.02) {
  SceneSpec spec = settings(Mode::kDcd, accuracy, scalar, thickness);
  spec.fields = kEveryField;
  return spec;
}

size_t count_flagged(const ContactSet& set, uint8_t flag) {
  return static_cast<size_t>(std::count_if(set.flags.begin(), set.flags.end(), [&](uint8_t f) { return f & flag; }));
}
std::vector<size_t> kept(const ContactSet& set) {
  std::vector<size_t> places;
  for (size_t i = 0; i < set.size(); ++i)
    if ((set.flags[i] & kFlagCovered) == 0) places.push_back(i);
  return places;
}

/// A floor of two triangles that share a diagonal, and one more triangle with a corner over it.
Case over_diagonal(const Vec3d& corner) {
  Case c;
  add_mesh(c, {{0, 1, 2}, {0, 2, 3}}, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {}, true);
  Positions above = {corner, {0.25, 0.75, 2}, {0.75, 0.25, 2}};
  add_mesh(c, {{0, 1, 2}}, above, above);
  return c;
}

TEST_F(Features, OneContactOverTheSideOfTwoTriangles) {
  for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kGuarded, Accuracy::kCertified, Accuracy::kExact})
    for (const Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
      const FrameResult found = run_case(over_diagonal({0.5, 0.5, 0x1p-10}), telling(accuracy, scalar));
      const ContactSet& vt = found.vertex_triangle;
      ASSERT_EQ(2u, vt.size());
      ASSERT_EQ(2u, vt.features.size());
      EXPECT_EQ(std::vector<size_t>{0}, kept(vt));
      EXPECT_EQ(2, vt.features[0] & kOfTriangle);  // opposite corner 2 of 0 1 2: from 0 to 2
      EXPECT_EQ(3, vt.features[1] & kOfTriangle);
      EXPECT_EQ(0, vt.features[0] & kSameAsBefore);
      EXPECT_EQ(kSameAsBefore, vt.features[1] & kSameAsBefore);
      EXPECT_TRUE(kept(found.edge_edge).empty());
      EXPECT_EQ(1.0f, std::abs(vt.normals[0][2]));
    }
}

// Beside the diagonal one triangle is nearer, and its neighbour's side is covered.
TEST_F(Features, TheNearerTriangleCoversItsNeighboursSide) {
  const FrameResult found = run_case(over_diagonal({0.5078125, 0.4921875, 0x1p-10}), telling(Accuracy::kExact));
  const ContactSet& vt = found.vertex_triangle;
  ASSERT_EQ(2u, vt.size());
  EXPECT_EQ(std::vector<size_t>{0}, kept(vt));
  EXPECT_EQ(0, vt.features[0] & kOfTriangle);
  EXPECT_EQ(3, vt.features[1] & kOfTriangle);
  const uint8_t of_floor = vt.elements[0][0] < 4 ? kNearerAtFirst : kNearerAtSecond;
  EXPECT_NE(0, vt.features[1] & of_floor);
}

// A triangle that goes through the floor: its minimum is no contact of features, so that nothing nearer covers any.
TEST_F(Features, MeshesThatCrossAreNotCoveredByWhatIsNearer) {
  for (const bool crosses : {false, true}) {
    const FrameResult found =
        run_case(over_diagonal({0.5078125, 0.4921875, crosses ? -0x1p-10 : 0x1p-10}), telling(Accuracy::kExact));
    ASSERT_EQ(2u, found.vertex_triangle.size());
    EXPECT_EQ(crosses ? 2u : 1u, kept(found.vertex_triangle).size());
    EXPECT_TRUE(found.edge_triangle.elements.empty()) << "nobody asked for crossings";
    EXPECT_EQ(0u, found.counts.contacts.edge_triangle);
  }
}

// Where crossings are told, they are those of a scene that asks for nothing else.
TEST_F(Features, CrossingsAreToldOnlyIfTheKindsNameThem) {
  const Case c = soup(51, 200, 1, 0.25, 0);
  for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kExact}) {
    SceneSpec spec = telling(accuracy), alone = spec;
    spec.kinds.edge_triangle = true;
    alone.kinds = {.edge_triangle = true};
    const FrameResult both = run_case(c, spec), without = run_case(c, telling(accuracy));
    EXPECT_TRUE(same_bytes(run_case(c, alone).edge_triangle, both.edge_triangle));
    EXPECT_GT(both.edge_triangle.size(), 50u);
    EXPECT_TRUE(same_bytes(both.vertex_triangle, without.vertex_triangle));
    EXPECT_TRUE(same_bytes(both.edge_edge, without.edge_edge));
    EXPECT_EQ(0u, without.edge_triangle.size());
  }
  const Case far = over_diagonal({0.5, 0.5, -1});
  EXPECT_FALSE(run_case(far, telling()).any_contact) << "crossings that nobody asked for";
}

// All other columns are what they are without features, but for the flag, and for normals where surfaces touch.
TEST_F(Features, ScenesThatDoNotAskHaveNothingOfThem) {
  const Case c = soup(52, 300, 1, 0.2, 0);
  for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kCertified, Accuracy::kExact}) {
    SceneSpec spec = telling(accuracy);
    const auto asking = Detector::create(spec_for(c, spec));
    spec.fields = kEveryField.without(ContactField::kFeatures);
    const auto silent = Detector::create(spec_for(c, spec));
    const Frame frame(c, Mode::kDcd, Scalar::kF64);
    FrameResult with = asking->detect(frame.input()), without = silent->detect(frame.input());
    for_each_kind(
        [](ContactKind, ContactSet& set) {
          set.features = {};
          for (size_t i = 0; i < set.size(); ++i) set.flags[i] &= static_cast<uint8_t>(~kFlagCovered);
        },
        with);
    EXPECT_TRUE(same_contacts(with, without));
    const auto has_part = [](const Detector& detector) {
      const auto parts = detector.memory();
      return std::any_of(parts.begin(), parts.end(),
                         [](const MemoryPart& part) { return part.part == "fans" || part.part == "covering"; });
    };
    EXPECT_TRUE(has_part(*asking));
    EXPECT_FALSE(has_part(*silent));
    const auto has_stage = [](const FrameResult& result) {
      return std::any_of(result.stages.begin(), result.stages.end(),
                         [](const StageTime& time) { return time.stage == "cover"; });
    };
    EXPECT_TRUE(has_stage(with));
    EXPECT_FALSE(has_stage(without));
  }
}

// A byte for each contact, in frames of DCD that return them.
TEST_F(Features, OfDiscreteFramesThatReturnContacts) {
  const Case c = soup(53, 60, 1, 0.25, 0.1);
  SceneSpec spec = telling();
  spec.mode = Mode::kBoth;
  const auto both = Detector::create(spec_for(c, spec));
  const Frame frame(c, Mode::kCcd, Scalar::kF64);
  for (const Mode mode : {Mode::kCcd, Mode::kDcd, Mode::kCcd}) {
    FrameInput input = frame.input();
    input.mode = mode;
    if (mode == Mode::kDcd)
      for (MeshPositions& update : input.updates) update.start = {};
    const FrameResult found = both->detect(input);
    EXPECT_GT(found.edge_edge.size(), 0u);
    EXPECT_EQ(mode == Mode::kDcd ? found.edge_edge.size() : 0, found.edge_edge.features.size());
    EXPECT_EQ(0u, mode == Mode::kDcd ? 0 : count_flagged(found.edge_edge, kFlagCovered));
  }
  for (const Report report : {Report::kAll, Report::kAnyHit}) {
    spec = telling();
    spec.report = report;
    EXPECT_TRUE(run_case(c, spec).any_contact);
  }
  spec = telling(Accuracy::kCandidates);
  EXPECT_EQ(0u, run_case(c, spec).edge_edge.features.size());
}

// The same bytes, however many threads fill the table at once.
TEST_F(Features, DoNotDependOnThreadsOrEngines) {
  for (const Accuracy accuracy : {Accuracy::kFast, Accuracy::kExact})
    for (const Case& c : {soup(54, 400, 1, 0.15, 0), on_integers(soup(56, 300, 12, 3, 0))}) {
      SceneSpec spec = telling(accuracy);
      spec.threads = 1;
      const FrameResult expected = run_case(c, spec);
      EXPECT_GT(count_flagged(expected.edge_edge, kFlagCovered), 50u);
      for (const Engine engine : {Engine::kOctree, Engine::kLbvh, Engine::kAllPairs})
        for (const int threads : {1, 3}) {
          spec.engine = engine;
          spec.threads = threads;
          EXPECT_TRUE(same_contacts(expected, run_case(c, spec)));
        }
    }
}

// Several devices, each of which knows a part of the contacts, tell none.
TEST_F(Features, AreNotToldByParts) {
  const Case c = soup(57, 200, 1, 0.25, 0);
  SceneSpec spec = telling();
  spec.fields = kEveryField.without(ContactField::kFeatures);
  const FrameResult expected = run_case(c, spec);
  spec.fields = kEveryField;
  spec.part_devices = {spec.device, spec.device};
  EXPECT_TRUE(same_contacts(expected, run_case(c, spec)));
}

// One kind alone has the byte; covered is what a contact of either kind covers.
TEST_F(Features, FlagNothingWhereAKindIsMissing) {
  const Case c = soup(55, 200, 1, 0.25, 0);
  const FrameResult all = run_case(c, telling());
  for (const bool vertices : {true, false}) {
    SceneSpec spec = telling();
    spec.kinds = {.vertex_triangle = vertices, .edge_edge = !vertices};
    const FrameResult found = run_case(c, spec);
    const ContactSet& set = vertices ? found.vertex_triangle : found.edge_edge;
    const ContactSet& whole = vertices ? all.vertex_triangle : all.edge_edge;
    ASSERT_EQ(whole.features.size(), set.features.size());
    for (size_t i = 0; i < set.size(); ++i) {
      EXPECT_EQ(0, set.flags[i] & kFlagCovered);
      if (vertices) {
        EXPECT_EQ(whole.features[i], set.features[i]);
      }
    }
  }
}

}  // namespace
}  // namespace collided::test
