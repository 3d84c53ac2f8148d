// Scenes with meshes that are thick by themselves: in which frames that counts, edits that change it, rest pairs, what
// is refused, and what a thick mesh costs those near it.

#include <cmath>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/gpu/scene/sheets.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"
#include "tests/support/exclusions.hpp"

namespace collided::test {
namespace {

using ThickMeshes = OnBackend<>;

/// Two meshes that move, and a wall that does not.
Case moving_case() {
  Case c = soup(400, 90, 1, 0.2, 0.1);
  const Case other = soup(401, 60, 1, 0.2, 0.1), wall = soup(402, 40, 1, 0.3, 0);
  add_mesh(c, other.meshes[0].triangles, other.start[0], other.end[0]);
  add_mesh(c, wall.meshes[0].triangles, wall.start[0], {}, true);
  return c;
}

Case with_halves(Case c, const std::vector<double>& halves) {
  for (size_t mesh = 0; mesh < halves.size(); ++mesh) c.meshes[mesh].half_thickness = halves[mesh];
  return c;
}

const std::vector<double> kHalves = {0.02, 0.001, 0.01};

/// A frame that goes a part of the case's way from where the last one ended.
class Steps {
 public:
  explicit Steps(const Case& c, Scalar scalar) : case_(c), scalar_(scalar) {}

  const Frame& to(double t, bool is_first) {
    Case c = case_;
    for (size_t mesh = 0; mesh < c.end.size(); ++mesh)
      for (size_t i = 0; i < c.end[mesh].size(); ++i)
        for (size_t k = 0; k < 3; ++k)
          c.end[mesh][i][k] = (1 - t) * case_.start[mesh][i][k] + t * case_.end[mesh][i][k];
    frames_.push_back(std::make_unique<Frame>(c, Mode::kDcd, scalar_, is_first));
    return *frames_.back();
  }

 private:
  Case case_;
  Scalar scalar_;
  std::vector<std::unique_ptr<Frame>> frames_;
};

FrameInput asking(FrameInput input, Mode mode) {
  input.mode = mode;
  return input;
}

// With min_separation = thickness both kinds of frames ask for the same distance, but for the half thicknesses.
TEST_F(ThickMeshes, CountInTheDiscreteFramesOfBothModes) {
  const Case thin = moving_case(), thick = with_halves(thin, kHalves);
  for (const double separation : {0x1p-6, 0x1p-8})
    for (const Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kCertified, Accuracy::kExact})
      for (const Scalar scalar : {Scalar::kF32, Scalar::kF64}) {
        SCOPED_TRACE(testing::Message() << separation << " level " << int(accuracy) << " scalar " << int(scalar));
        SceneSpec spec = settings(Mode::kBoth, accuracy, scalar, 0x1p-6);
        spec.min_separation = separation;
        const auto with = Detector::create(spec_for(thick, spec)), without = Detector::create(spec_for(thin, spec));
        spec.mode = Mode::kDcd;
        spec.min_separation = 0;
        const auto discrete = Detector::create(spec_for(thick, spec));
        Steps steps(thin, scalar);
        for (int step = 0; step < 3; ++step) {
          const FrameInput input = steps.to(step / 2.0, step == 0).input();
          const FrameResult way = with->detect(input);
          EXPECT_TRUE(same_contacts(without->detect(input), way));
          EXPECT_GT(count_contacts(way), step == 0 ? 0u : 50u);
          const FrameResult near = discrete->detect(input), asked = with->detect(asking({}, Mode::kDcd));
          EXPECT_TRUE(same_contacts(near, asked));
          EXPECT_GT(count_contacts(near), count_contacts(without->detect(asking({}, Mode::kDcd))));
        }
      }
}

TEST_F(ThickMeshes, KeepNoFloorsOfAnAdvance) {
  const Case thin = moving_case(), thick = with_halves(thin, kHalves);
  for (const AdvanceMode mode : {AdvanceMode::kAllOrOne, AdvanceMode::kPerMesh, AdvanceMode::kPerVertex})
    for (const Mode scene : {Mode::kCcd, Mode::kBoth}) {
      SceneSpec spec = settings(scene, Accuracy::kCertified, Scalar::kF64, 0);
      spec.min_separation = 0x1p-10;
      const auto with = Detector::create(spec_for(thick, spec)), without = Detector::create(spec_for(thin, spec));
      Steps steps(thin, spec.scalar);
      const FrameInput first = steps.to(0, true).input();
      with->detect(first), without->detect(first);
      FrameInput input = steps.to(0.25, false).input();
      input.advance = true;
      input.advance_mode = mode;
      const FrameResult near = with->detect(input), other = without->detect(input);
      EXPECT_EQ(other.advanced, near.advanced);
      EXPECT_EQ(other.shortened.ids, near.shortened.ids);
      EXPECT_EQ(other.shortened.fractions, near.shortened.fractions);
      EXPECT_EQ(same_contacts(other, near), scene == Mode::kBoth) << "contacts of a scene of CCD alone are wider";
      // Contacts are those of the whole way, as in a frame that does not advance.
      const auto plain = Detector::create(spec_for(thick, spec));
      plain->detect(first);
      input.advance = false;
      input.advance_mode = AdvanceMode::kAllOrOne;
      EXPECT_TRUE(same_contacts(plain->detect(input), near));
    }
}

/// The edit that gives a mesh a half thickness, and leaves it as it is otherwise.
std::shared_ptr<const SceneEdit> thickening(const Case& c, uint32_t mesh, double half) {
  MeshSpec spec = c.meshes[mesh];
  spec.triangles = {};
  spec.half_thickness = half;
  return std::make_shared<const SceneEdit>(SceneEdit{.meshes = {{mesh, spec}}});
}

TEST_F(ThickMeshes, MayBecomeThickerAndThinner) {
  const Case c = with_halves(moving_case(), kHalves);
  for (const Reuse reuse : {Reuse::kOff, Reuse::kOn})
    for (const Accuracy accuracy : {Accuracy::kCandidates, Accuracy::kCertified, Accuracy::kExact}) {
      SceneSpec spec = settings(Mode::kDcd, accuracy, Scalar::kF64, 0x1p-6);
      spec.reuse = reuse;
      const auto edited = Detector::create(spec_for(c, spec));
      Steps steps(c, spec.scalar);
      edited->detect(steps.to(0.5, true).input());
      Case now = c;
      size_t last = 0;
      for (const auto& [mesh, half] :
           std::vector<std::pair<uint32_t, double>>{{1, 0.03}, {0, 0}, {2, 0.05}, {1, 0}, {2, 0}, {2, 0.02}}) {
        FrameInput refused;
        refused.edit = thickening(now, mesh, half);
        refused.updates = {{.mesh = 9}};
        EXPECT_NE(refused_field([&] { edited->detect(refused); }), "");
        const FrameResult before = edited->detect({});
        now.meshes[mesh].half_thickness = half;
        FrameInput input;
        input.edit = thickening(now, mesh, half);
        const FrameResult after = edited->detect(input);
        const FrameResult fresh = Detector::create(spec_for(now, spec))->detect(steps.to(0.5, true).input());
        EXPECT_TRUE(same_contacts(fresh, after)) << mesh << " " << half;
        EXPECT_TRUE(last == 0 || count_contacts(before) == last) << "the refused edit has left a trace";
        EXPECT_TRUE(same_contacts(fresh, edited->detect({})));
        last = count_contacts(after);
      }
    }
}

// Cells of 2^-7, and a contact distance that is just that, or a hair less.
TEST_F(ThickMeshes, RestWithinTheirOwnDistance) {
  constexpr double kCell = 0x1p-7;
  for (const Mode mode : {Mode::kDcd, Mode::kCcd, Mode::kBoth})
    for (const double half : {kCell / 4, std::nextafter(kCell / 4, 0)}) {
      Case rest, later;
      for (Case* c : {&rest, &later})
        add_mesh(*c, grid_triangles(8), flat_grid(8, kCell), c == &later ? flat_grid(8, 0.5 * kCell) : Positions{});
      SceneSpec spec = settings(mode, Accuracy::kExact, Scalar::kF64, kCell / 2);
      spec = spec_for(rest, spec);
      spec.meshes[0].half_thickness = half;
      const auto all = Detector::create(spec);
      spec.meshes[0].excludes_rest_pairs = true;
      const auto left = Detector::create(spec);
      const Exclusions excluded(rest, spec);
      for (const Case* c : {&rest, &later}) {
        const Frame frame(*c, Mode::kDcd, spec.scalar);
        const std::optional<Mode> asked = mode == Mode::kBoth ? std::optional(Mode::kDcd) : std::nullopt;
        FrameInput input = frame.input();
        input.mode = asked;
        const FrameResult found = left->detect(input), every = all->detect(input);
        EXPECT_TRUE(
            same_bytes(found.vertex_triangle, excluded.left_of(ContactKind::kVertexTriangle, every.vertex_triangle)));
        EXPECT_TRUE(same_bytes(found.edge_edge, excluded.left_of(ContactKind::kEdgeEdge, every.edge_edge)));
        if (c == &rest) {
          EXPECT_EQ(count_contacts(found), 0u) << "what is in contact at rest is left out";
          EXPECT_EQ(count_contacts(every) > 1000, half == kCell / 4);
        } else {
          EXPECT_GT(count_contacts(found), 10u);
          EXPECT_LT(count_contacts(found), count_contacts(every));
        }
      }
    }
}

// With a rest_distance of 0, a mesh's own distance decides which pairs are rest pairs. An edit of that distance finds
// them anew.
TEST_F(ThickMeshes, RestAnewWhereAnEditChangesTheirDistance) {
  constexpr double kCell = 0x1p-7;
  for (const double rest_distance : {0.0, kCell / 2}) {
    Case c;
    add_mesh(c, grid_triangles(8), flat_grid(8, kCell));
    c.meshes[0].excludes_rest_pairs = true;
    SceneSpec spec = settings(Mode::kDcd, Accuracy::kExact, Scalar::kF64, kCell / 2);
    spec.rest_distance = rest_distance;
    const auto detector = Detector::create(spec_for(c, spec));
    const Frame first(c, spec.mode, spec.scalar);
    EXPECT_EQ(count_contacts(detector->detect(first.input())), 0u);
    FrameInput input;
    input.edit = thickening(c, 0, kCell / 4);
    EXPECT_EQ(count_contacts(detector->detect(input)) == 0, rest_distance == 0);
  }
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InvalidInput& e) {
    return e.what();
  }
  return "";
}

TEST_F(ThickMeshes, AreRefusedWhereTheirThicknessIsNone) {
  const Case c = moving_case();
  const auto create = [&](double half, Scalar scalar) {
    Case bad = c;
    bad.meshes[1].half_thickness = half;
    return message_of([&] { Detector::create(spec_for(bad, settings(Mode::kDcd, Accuracy::kExact, scalar))); });
  };
  EXPECT_EQ(create(-0.5, Scalar::kF64).find("meshes[1].half_thickness is -0.5; it must be from 0 to "), 0u);
  EXPECT_EQ(create(std::nan(""), Scalar::kF64).find("meshes[1].half_thickness is nan; "), 0u);
  EXPECT_EQ(create(HUGE_VAL, Scalar::kF64).find("meshes[1].half_thickness is inf; "), 0u);
  EXPECT_EQ(create(0x1p127, Scalar::kF32).find("meshes[1].half_thickness is 1.7014118346046923e+38; "), 0u);
  EXPECT_EQ(create(1e37, Scalar::kF32), "");
  const auto detector = Detector::create(spec_for(c, settings(Mode::kDcd, Accuracy::kExact)));
  Steps steps(c, Scalar::kF64);
  detector->detect(steps.to(0, true).input());
  FrameInput input;
  input.edit = thickening(c, 1, -1);
  EXPECT_EQ(message_of([&] { detector->detect(input); }).find("edit.meshes[0].spec.half_thickness is -1; "), 0u);
}

// FAST in DCD needs a distance: the thickness, or the half thickness of one of two meshes that may touch.
TEST_F(ThickMeshes, GiveFastADistance) {
  const std::string needed = "; discrete detection at FAST needs a distance > 0";
  const auto refusal = [&](const std::vector<double>& halves, const std::function<void(SceneSpec&)>& change) {
    const Case c = with_halves(moving_case(), halves);
    SceneSpec spec = spec_for(c, settings(Mode::kDcd, Accuracy::kFast));
    change(spec);
    return message_of([&] { Detector::create(spec); });
  };
  const auto none = [](SceneSpec&) {};
  const auto between = [&](int i, int j) {
    return "thickness is 0, and so is the half_thickness of meshes " + std::to_string(i) + " and " + std::to_string(j) +
           needed;
  };
  EXPECT_EQ(refusal({0, 0, 0}, none), "thickness is 0" + needed);
  EXPECT_EQ(refusal({0.1, 0, 0}, none), between(1, 1));
  EXPECT_EQ(refusal({0.1, 0.1, 0}, none), "") << "the wall does not touch itself";
  EXPECT_EQ(refusal({0.1, 0, 0}, [](SceneSpec& spec) { spec.meshes[1].self_contacts = false; }), between(1, 2));
  EXPECT_EQ(refusal({0.1, 0, 0},
                    [](SceneSpec& spec) {
                      spec.meshes[1].self_contacts = false;
                      spec.excluded_meshes = {{2, 1}};
                    }),
            "");
  EXPECT_EQ(refusal({0.1, 0, 0}, [](SceneSpec& spec) { spec.thickness = 0.1; }), "");
  EXPECT_EQ(refusal({0, 0, 0}, [](SceneSpec& spec) { spec.accuracy = Accuracy::kGuarded; }), "");

  // Frames and edits may ask for it, too.
  const Case c = with_halves(moving_case(), {0.1, 0, 0});
  const auto detector = Detector::create(spec_for(c, settings(Mode::kDcd, Accuracy::kCertified)));
  Steps steps(c, Scalar::kF64);
  detector->detect(steps.to(0, true).input());
  FrameInput fast;
  fast.accuracy = Accuracy::kFast;
  EXPECT_EQ(message_of([&] { detector->detect(fast); }), between(1, 1));
  FrameInput edit = fast;
  edit.edit = thickening(c, 1, 0.01);
  EXPECT_EQ(message_of([&] { detector->detect(edit); }), "");
  EXPECT_EQ(message_of([&] { detector->detect(fast); }), "");
  edit.edit = thickening(c, 0, 0);
  EXPECT_EQ(message_of([&] { detector->detect(edit); }), between(0, 0));
  EXPECT_EQ(message_of([&] { detector->detect(fast); }), "") << "the refused edit has left no trace";
}

/// Hairs side by side, 0.03 apart, and a ball of six corners at z.
Case ball_and_hairs(double z, double half_of_ball) {
  Case c;
  Positions ball = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, hairs;
  for (Vec3d& p : ball) p = {0.2 * p[0], 0.2 * p[1], 0.2 * p[2] + z};
  std::vector<std::array<uint32_t, 3>> faces;
  for (uint32_t i = 0; i < 4; ++i)
    for (const uint32_t pole : {4u, 5u}) faces.push_back({i, (i + 1) % 4, pole});
  add_mesh(c, faces, ball);
  for (int i = 0; i < 400; ++i)
    for (const double x : {-1.0, 1.0}) hairs.push_back({x, 0.03 * (i - 200), 0});
  add_mesh(c, {}, hairs);
  c.meshes[0].self_contacts = false;
  for (uint32_t i = 0; i < 400; ++i) c.meshes[1].edges.push_back({2 * i, 2 * i + 1});
  return with_halves(c, {half_of_ball, 0.01});
}

// A thick ball next to hair of 0.02: hairs 0.03 apart are no candidates, however thick the ball is.
TEST_F(ThickMeshes, DoNotWidenThoseNearThem) {
  for (const Mode mode : {Mode::kDcd, Mode::kCcd}) {
    const auto detect = [&](double z, double half) {
      return run_case(ball_and_hairs(z, half), settings(mode, Accuracy::kCertified));
    };
    const FrameResult far = detect(9, 0.3), thin = detect(0.505, 0), near = detect(0.505, 0.3);
    EXPECT_EQ(far.counts.candidates.edge_edge, 0u);
    EXPECT_EQ(count_contacts(thin), 0u);
    // The three hairs that pass below the lowest corner within 0.31, and its four edges; candidates are those of the
    // hairs below its edges' boxes.
    EXPECT_EQ(near.edge_edge.size(), 12u);
    EXPECT_EQ(near.vertex_triangle.size(), 0u);
    for (const auto& [edge, other] : near.edge_edge.elements) EXPECT_TRUE(edge < 12 && other >= 12);
    EXPECT_LT(near.counts.candidates.edge_edge, 4 * (0.82 / 0.03 + 2));
  }
}

}  // namespace
}  // namespace collided::test
