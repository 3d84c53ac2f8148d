#pragma once
// An answer against the judge, and how much of what was judged.

#include "tests/gpu/backend.hpp"
#include "tests/gpu/solids/solid_scenes.hpp"

namespace collided::test {

/// Settings that tell all that there is of solids.
SceneSpec looking_into_solids(Accuracy accuracy, Scalar scalar);
/// The case's spec with pairs of meshes that are left out.
SceneSpec spec_of(const SolidsScene& scene, SceneSpec settings);
FrameResult run_solids(const SolidsScene& scene, const SceneSpec& settings);

/// Moves and scales all of a scene.
SolidsScene placed(SolidsScene scene, double scale, double by);

/// What was judged of answers.
struct Tally {
  std::array<uint64_t, 4> states = {};
  uint64_t apart = 0, open = 0, inside = 0, on = 0, deep = 0, inside_out = 0, rivals = 0;
  long double ulps = 0, place = 0, normal = 0;  ///< the farthest off: depths, their places and directions

  void print(const char* of) const;
  /// Every state, and vertices of every kind.
  void expect_all() const;
};

/// Where a frame of a scene is compared with what the judge says of the scene.
class JudgedScene {
 public:
  explicit JudgedScene(SolidsScene scene);

  const SolidsScene& scene() const { return scene_; }
  const SolidsJudge& judge() const { return *judge_; }
  const JudgedSolids& truth() const { return truth_; }
  /// All that is told of solids. Returns false where something is wrong, and says what.
  bool expect(const FrameResult& result, Accuracy accuracy, Tally& tally) const;
  bool expect_at(Accuracy accuracy, Scalar scalar, Tally& tally) const;
  /// The meshes as they are, to be put into a test.
  std::string text_of(std::initializer_list<uint32_t> meshes) const;

 private:
  bool expect_states(const FrameResult& result) const;
  bool expect_deepest(const FrameResult& result) const;
  bool expect_inside(const FrameResult& result, Accuracy accuracy, Tally& tally) const;
  bool expect_place(const ContactSet& set, size_t i, Tally& tally) const;
  uint32_t mesh_of_triangle(uint32_t triangle) const;
  uint32_t mesh_of_vertex(uint32_t vertex) const;

  SolidsScene scene_;
  std::unique_ptr<SolidsJudge> judge_;
  JudgedSolids truth_;
  std::vector<uint32_t> vertex_end_, triangle_end_;  ///< of each mesh
  Positions positions_;
  std::vector<std::array<uint32_t, 3>> triangles_;
};

}  // namespace collided::test
