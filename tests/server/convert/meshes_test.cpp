// What a scene declares of its meshes and positions, from the protocol to the engine: what is left out, what moves as a
// whole, and what is sent in 16 bits.

#include <gtest/gtest.h>

#include <cmath>

#include "server/errors.hpp"
#include "tests/server/convert/scene_refusals.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::server {
namespace {

TEST(ConvertMeshes, TakesWhatIsLeftOutAndTellsIt) {
  const auto wanted = request_with([](pb::SceneSpec& s) {
    *s.add_meshes() = s.meshes(0);
    s.mutable_meshes(1)->set_name("bag");
    s.mutable_meshes(0)->set_exclude_rings(8);
    s.mutable_meshes(1)->set_exclude_rest_pairs(true);
    s.set_rest_distance(0.5);
    auto* pair = s.add_excluded_meshes();
    pair->set_first(1);
    pair->set_second(0);
    s.add_excluded_meshes();
  });
  const SceneSpec engine = parse_scene(wanted, {}).plan.engine;
  EXPECT_EQ(engine.meshes[0].excluded_rings, 8u);
  EXPECT_TRUE(!engine.meshes[0].excludes_rest_pairs && engine.meshes[1].excludes_rest_pairs);
  EXPECT_EQ(engine.rest_distance, 0.5);
  EXPECT_EQ(engine.excluded_meshes, (std::vector<std::array<uint32_t, 2>>{{1, 0}, {0, 0}}));
  const auto told = shown(wanted).spec();
  EXPECT_EQ(told.meshes(0).exclude_rings(), 8u);
  EXPECT_TRUE(told.meshes(1).exclude_rest_pairs());
  EXPECT_EQ(told.rest_distance(), 0.5);
  ASSERT_EQ(told.excluded_meshes_size(), 2);
  EXPECT_EQ(told.excluded_meshes(0).first(), 1u);
  EXPECT_EQ(shown(request_with([](pb::SceneSpec& s) {
              s.set_thickness(0.25);
              s.mutable_meshes(0)->set_exclude_rest_pairs(true);
            }))
                .spec()
                .rest_distance(),
            0)
      << "each mesh's own distance";
}

TEST(ConvertMeshes, TakesHowThickEachIsAndTellsIt) {
  const auto wanted = request_with([](pb::SceneSpec& s) {
    *s.add_meshes() = s.meshes(0);
    s.mutable_meshes(1)->set_name("bag");
    s.mutable_meshes(1)->set_half_thickness(0.1);
  });
  const SceneSpec engine = parse_scene(wanted, {}).plan.engine;
  EXPECT_EQ(engine.meshes[0].half_thickness, 0);
  EXPECT_EQ(engine.meshes[1].half_thickness, 0.1);
  EXPECT_EQ(shown(wanted).spec().meshes(0).half_thickness(), 0);
  EXPECT_EQ(shown(wanted).spec().meshes(1).half_thickness(), 0.1);
}

TEST(ConvertMeshes, RefusalsOfAHalfThicknessNameValueAndLimit) {
  const auto refusal = [](double half) {
    return refusal_of(request_with([&](pb::SceneSpec& s) { s.mutable_meshes(0)->set_half_thickness(half); }));
  };
  const std::string rule = "; it must be from 0 to 4.2535293329816107e+37";
  EXPECT_EQ(refusal(-1), "spec.meshes[0].half_thickness is -1" + rule);
  EXPECT_EQ(refusal(std::nan("")), "spec.meshes[0].half_thickness is nan" + rule);
  EXPECT_EQ(refusal(INFINITY), "spec.meshes[0].half_thickness is inf" + rule);
}

TEST(ConvertMeshes, RefusalsOfWhatIsLeftOutNameValueAndLimit) {
  const auto refusal = [](const std::function<void(pb::SceneSpec&)>& change) {
    return refusal_of(request_with(change));
  };
  EXPECT_EQ(refusal([](pb::SceneSpec& s) { s.mutable_meshes(0)->set_exclude_rings(9); }),
            "spec.meshes[0].exclude_rings is 9, the limit is 8");
  EXPECT_EQ(refusal([](pb::SceneSpec& s) { s.set_rest_distance(0.5); }),
            "spec.rest_distance is 0.5, but no mesh excludes rest pairs");
  EXPECT_EQ(refusal([](pb::SceneSpec& s) { s.add_excluded_meshes()->set_second(7); }),
            "spec.excluded_meshes[0] is meshes 0 and 7, but the last mesh is 0");
  EXPECT_EQ(refusal([](pb::SceneSpec& s) { s.add_excluded_meshes(), s.add_excluded_meshes(); }),
            "spec.excluded_meshes[1] is meshes 0 and 0, which an earlier pair already is");
  EXPECT_EQ(refusal([](pb::SceneSpec& s) {
              s.set_mode(pb::DETECTION_MODE_DCD);
              s.add_kinds(pb::CONTACT_KIND_TRIANGLE_TRIANGLE);
              s.mutable_meshes(0)->set_exclude_rest_pairs(true);
            }),
            "spec.meshes[0].exclude_rest_pairs is on, but the scene has triangle pairs alone: rest pairs are "
            "vertex-triangle and edge-edge contacts");
}

std::string refusal_with(const std::function<void(pb::MeshSpec&)>& change) {
  return refusal_of(request_with([&](pb::SceneSpec& s) { change(*s.mutable_meshes(0)); }));
}

TEST(ConvertMeshes, TakesLooseElementsAndTellsTheirNumbers) {
  const auto wanted = request_with([](pb::SceneSpec& s) {
    s.mutable_meshes(0)->set_edges(packed<4>({0, 3, 1, 3}));
    s.mutable_meshes(0)->set_edge_count(2);
    auto* drop = s.add_meshes();
    drop->set_name("drop");
    drop->set_vertex_count(1);
    drop->set_points(packed<1>({0}));
  });
  const ScenePlan plan = parse_scene(wanted, {}).plan;
  EXPECT_EQ(plan.engine.meshes[0].edges, (std::vector<std::array<uint32_t, 2>>{{0, 3}, {1, 3}}));
  EXPECT_EQ(plan.engine.meshes[1].points, std::vector<uint32_t>{0});
  EXPECT_EQ(plan.meshes[1].awaited, 0u);
  const pb::Scene told = shown(wanted);
  EXPECT_EQ(told.triangle_count(), 2u);
  const pb::MeshSpec &cloth = told.spec().meshes(0), &drop = told.spec().meshes(1);
  EXPECT_TRUE(cloth.triangle_count() == 2 && cloth.edge_count() == 2 && cloth.point_count() == 0);
  EXPECT_TRUE(drop.triangle_count() == 0 && drop.edge_count() == 0 && drop.point_count() == 1);
  EXPECT_TRUE(cloth.edges().empty() && drop.points().empty());
}

TEST(ConvertMeshes, RefusalsOfLooseElementsNameValueAndLimit) {
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) {
              m.set_edges(packed<4>({0, 1, 2, 4}));
            }),
            "spec.meshes[0].edges[1] has vertex 4, but the mesh has 4 vertices");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) {
              m.set_edges(packed<2>({3, 3}));
            }),
            "spec.meshes[0].edges[0] has a vertex twice: 3 3");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) {
              m.set_edges(packed<3>({0, 1, 2}));
            }),
            "spec.meshes[0].edges has 12 bytes, which is not a multiple of 8");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) {
              m.set_points(packed<2>({3, ~0u}));
            }),
            "spec.meshes[0].points[1] has vertex 4294967295, but the mesh has 4 vertices");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) { m.set_points("123"); }),
            "spec.meshes[0].points has 3 bytes, which is not a multiple of 4");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) { m.set_edge_count(5); }),
            "spec.meshes[0].edge_count is 5, but spec.meshes[0].edges has 0: UploadMesh sends triangles alone");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) {
              m.set_points(packed<2>({0, 1})), m.set_point_count(1);
            }),
            "spec.meshes[0].point_count is 1, but spec.meshes[0].points has 2: UploadMesh sends triangles alone");
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) { m.clear_triangles(); }),
            "spec.meshes[0].triangles is empty and triangle_count is 0, but a mesh without edges and points needs a "
            "triangle");
}

TEST(ConvertMeshes, AMeshHasTheVerticesThatItsElementsNeed) {
  EXPECT_EQ(refusal_with([](pb::MeshSpec& m) { m.set_vertex_count(2); }),
            "spec.meshes[0].vertex_count is 2, but must be at least 3");
  const auto loose = [](uint32_t vertices) {
    return refusal_with([&](pb::MeshSpec& m) {
      m.clear_triangles();
      m.set_vertex_count(vertices);
      m.set_points(packed<1>({0}));
    });
  };
  EXPECT_EQ(loose(0), "spec.meshes[0].vertex_count is 0, but must be at least 1");
  EXPECT_EQ(loose(1), "accepted");
}

TEST(ConvertMeshes, LooseElementsCountAsTriangles) {
  SceneDefaults defaults;
  defaults.limits.max_triangles = 4;
  const auto with_edges = [](uint32_t count) {
    return request_with([&](pb::SceneSpec& s) {
      for (uint32_t i = 0; i < count; ++i) *s.mutable_meshes(0)->mutable_edges() += packed<2>({0, 1});
      s.mutable_meshes(0)->set_points(packed<1>({3}));
    });
  };
  EXPECT_EQ(refusal_of(with_edges(1), defaults), "accepted");
  EXPECT_EQ(refusal_of(with_edges(2), defaults),
            "spec.meshes has 5 triangles, edges and points in all, more than max_triangles, 4");
  const uint64_t without = parse_scene(request(), {}).plan.min_bytes;
  EXPECT_GT(parse_scene(with_edges(1000), {}).plan.min_bytes, without + 1000 * 12);
}

TEST(ConvertMeshes, TakesRigidMeshesAndEncodedPositions) {
  const ScenePlan plan = parse_scene(request_with([](pb::SceneSpec& s) {
                                       s.set_position_format(pb::POSITION_FORMAT_Q16);
                                       for (const double x : {-1.0, -2.0, -3.0})
                                         s.mutable_quantization_box()->add_lower(x);
                                       for (const double x : {1.0, 2.0, 3.0})
                                         s.mutable_quantization_box()->add_upper(x);
                                       s.mutable_meshes(0)->set_motion(pb::MESH_MOTION_RIGID);
                                     }),
                                     {})
                             .plan;
  EXPECT_EQ(plan.engine.meshes[0].motion, MeshMotion::kRigid);
  EXPECT_EQ(plan.engine.scalar, Scalar::kF32);
  ASSERT_TRUE(plan.engine.quantized_in);
  EXPECT_EQ(plan.engine.quantized_in->lower[2], -3);
  EXPECT_EQ(position_bytes(plan.engine), 6u);
}

TEST(ConvertMeshes, RefusesABoxThatDoesNotFitTheFormat) {
  using Request = pb::CreateSceneRequest;
  const auto refuse = expect_refused<InvalidInput>;
  const auto with = [](const std::function<void(pb::SceneSpec&)>& set) {
    return [set](Request& r) {
      pb::SceneSpec& spec = *r.mutable_spec();
      spec.set_position_format(pb::POSITION_FORMAT_Q16);
      for (int k = 0; k < 3; ++k)
        spec.mutable_quantization_box()->add_lower(0), spec.mutable_quantization_box()->add_upper(1);
      set(spec);
    };
  };
  refuse("spec.quantization_box", with([](pb::SceneSpec& s) { s.set_position_format(pb::POSITION_FORMAT_F32); }));
  refuse("spec.quantization_box", with([](pb::SceneSpec& s) { s.clear_quantization_box(); }));
  refuse("spec.quantization_box.lower", with([](pb::SceneSpec& s) { s.mutable_quantization_box()->clear_lower(); }));
  refuse("spec.quantization_box.upper", with([](pb::SceneSpec& s) { s.mutable_quantization_box()->add_upper(4); }));
  refuse("spec.quantization_box", with([](pb::SceneSpec& s) { s.mutable_quantization_box()->set_upper(1, -1); }));
  refuse("spec.quantization_box", with([](pb::SceneSpec& s) { s.mutable_quantization_box()->set_lower(0, NAN); }));
  refuse("spec.quantization_box", with([](pb::SceneSpec& s) { s.set_accuracy(pb::ACCURACY_EXACT); }));
}

}  // namespace
}  // namespace collided::server
