// Edits of a scene from the protocol to the engine, and refusals.
#include "server/convert/edit.hpp"

#include <gtest/gtest.h>

#include "server/errors.hpp"
#include "tests/server/convert/scene_request.hpp"

namespace collided::server {
namespace {

/// Of the scene of one mesh, `cloth`, with four vertices and two triangles.
class ConvertEdit : public ::testing::Test {
 protected:
  ParsedEdit parse() const { return parse_edit(edit_, plan_, limits_); }
  /// The field of the refusal, which its text begins with; empty if it is taken.
  std::string refused() const {
    try {
      parse();
    } catch (const InvalidInput& e) {
      return e.field();
    } catch (const LimitExceeded& e) {
      return e.field();
    }
    return "";
  }
  pb::MeshSpec& add(uint32_t mesh, const std::string& name, uint32_t vertices) {
    pb::MeshEdit& edit = *edit_.add_meshes();
    edit.set_mesh(mesh);
    edit.mutable_spec()->set_name(name);
    edit.mutable_spec()->set_vertex_count(vertices);
    return *edit.mutable_spec();
  }

  ScenePlan plan_ = parse_scene(request(), {}).plan;
  Limits limits_;
  pb::SceneEdit edit_;
};

TEST_F(ConvertEdit, ReachesTheEngine) {
  add(1, "ball", 3).set_triangles(triangle({0, 1, 2}));
  edit_.add_meshes()->set_mesh(0);  // goes
  edit_.add_exclude_meshes()->set_first(1);
  edit_.add_include_meshes()->set_second(1);
  const ParsedEdit parsed = parse();
  const SceneEdit& engine = *parsed.engine;
  ASSERT_EQ(engine.meshes.size(), 2u);
  EXPECT_EQ(engine.meshes[0].mesh, 1u);
  EXPECT_EQ(engine.meshes[0].spec.vertex_count, 3u);
  EXPECT_EQ(engine.meshes[0].spec.triangles, (std::vector<TriangleCorners>{{0, 1, 2}}));
  EXPECT_EQ(engine.meshes[1].mesh, 0u);
  EXPECT_EQ(engine.meshes[1].spec.vertex_count, 0u);
  EXPECT_EQ(engine.excluded, (std::vector<std::array<uint32_t, 2>>{{1, 0}}));
  EXPECT_EQ(engine.included, (std::vector<std::array<uint32_t, 2>>{{0, 1}}));
  ASSERT_EQ(parsed.meshes.size(), 2u);
  EXPECT_EQ(parsed.meshes[0].name, "ball");
  EXPECT_EQ(parsed.meshes[0].triangles, 1u);
  EXPECT_FALSE(parsed.meshes[0].keeps_elements || parsed.meshes[1].keeps_elements);
}

TEST_F(ConvertEdit, ElementsThatAreNotThereAreThoseOfBefore) {
  add(0, "", 4);
  const ParsedEdit parsed = parse();
  EXPECT_TRUE(parsed.meshes[0].keeps_elements);
  EXPECT_EQ(parsed.meshes[0].name, "");
}

TEST_F(ConvertEdit, NamesAreThoseOfTheSceneThatItMakes) {
  add(1, "", 3).set_triangles(triangle({0, 1, 2}));
  EXPECT_EQ(refused(), "frame.edit.meshes[0].spec.name");
  edit_.mutable_meshes(0)->mutable_spec()->set_name("cloth");
  EXPECT_EQ(refused(), "frame.edit.meshes[0].spec.name");
  edit_.add_meshes()->set_mesh(0);  // whose name is free then
  EXPECT_EQ(refused(), "");
  edit_.mutable_meshes(0)->set_mesh(3);
  EXPECT_EQ(refused(), "frame.edit.meshes[0].mesh");
}

TEST_F(ConvertEdit, LimitsAreThoseOfTheSceneThatItMakes) {
  limits_.max_vertices = 6, limits_.max_triangles = 3;
  pb::MeshSpec& ball = add(1, "ball", 3);
  ball.set_triangles(triangle({0, 1, 2}));
  EXPECT_EQ(refused(), "frame.edit.meshes");  // 7 vertices
  limits_.max_vertices = 7;
  EXPECT_EQ(refused(), "");
  limits_.max_triangles = 2;
  EXPECT_EQ(refused(), "frame.edit.meshes");
  add(0, "", 3).set_triangles(triangle({0, 1, 2}));  // one triangle less, one vertex less
  limits_.max_vertices = 6;
  EXPECT_EQ(refused(), "");
}

TEST_F(ConvertEdit, BringsAllItsElements) {
  pb::MeshSpec& ball = add(1, "ball", 3);
  ball.set_triangles(triangle({0, 1, 2}));
  ball.set_triangle_count(2);
  EXPECT_EQ(refused(), "frame.edit.meshes[0].spec.triangle_count");
  ball.set_triangle_count(1);
  EXPECT_EQ(refused(), "");
  EXPECT_EQ(element_bytes(edit_), 12u);
  ball.set_edges(packed<2>({0, 1}));
  ball.set_points(packed<1>({2}));
  EXPECT_EQ(element_bytes(edit_), 12u + 8 + 4);
  EXPECT_EQ(parse().meshes[0].edges, 1u);
  EXPECT_EQ(parse().meshes[0].points, 1u);
}

TEST_F(ConvertEdit, IsOfSoManyMeshes) {
  for (uint32_t k = 1; k <= 256; ++k) add(k, "mesh " + std::to_string(k), 3).set_triangles(triangle({0, 1, 2}));
  EXPECT_EQ(refused(), "");
  add(257, "one more", 3).set_triangles(triangle({0, 1, 2}));
  EXPECT_EQ(refused(), "frame.edit.meshes");
}

TEST_F(ConvertEdit, TakesHowThickAMeshIs) {
  pb::MeshSpec& cloth = add(0, "", 4);
  EXPECT_EQ(parse().engine->meshes[0].spec.half_thickness, 0);
  cloth.set_half_thickness(0.25);
  EXPECT_EQ(parse().engine->meshes[0].spec.half_thickness, 0.25);
}

TEST_F(ConvertEdit, TakesWhetherAMeshIsASolid) {
  pb::MeshSpec& cloth = add(0, "", 4);
  EXPECT_FALSE(parse().engine->meshes[0].spec.solid);
  cloth.set_solid(true);
  EXPECT_TRUE(parse().engine->meshes[0].spec.solid);
}

}  // namespace
}  // namespace collided::server
