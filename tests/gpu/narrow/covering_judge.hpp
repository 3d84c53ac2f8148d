#pragma once
// Judges which contacts of a frame are covered: from the mesh and the positions alone, in rational arithmetic.

#include <compare>
#include <map>
#include <set>

#include "tests/support/brute_force.hpp"
#include "tests/support/judge/exact_features.hpp"

namespace collided::test {

/// What answers were judged on, so that a test can tell that it saw something.
struct CoveringCounts {
  size_t contacts = 0, kept = 0, same = 0, nearer = 0, crossing = 0;
  size_t shallow = 0, steep = 0;  ///< surfaces whose slope decides that a bit is unset or set
  size_t unsure = 0;              ///< features that only rounding tells from the judged ones
  size_t descents = 0, left_out = 0;
  size_t faces = 0, supports = 0;  ///< normals at distance 0: of a triangle there, of two directions

  CoveringCounts& operator+=(const CoveringCounts& other);
};

class CoveringJudge {
 public:
  /// The case has to be rounded to the scene's scalar type already.
  CoveringJudge(const Case& c, const Topology& topology);

  /// Expects the features and flags of a frame of contacts with all columns. `told`: whether the scene's kinds have
  /// both kinds of features. `is_complete`: no contact of its distance is missing.
  CoveringCounts expect(const FrameResult& found, Accuracy accuracy, bool has_both, bool is_complete);
  /// Expects the normals of contacts at distance 0, where coordinates are small integers: what is not 0 is clear.
  CoveringCounts expect_normals(const FrameResult& found) const;

 private:
  /// A vertex, an edge (two vertices) or the face of an element; vertices ascend.
  struct Feature {
    std::vector<uint32_t> vertices;
    uint32_t element = ~0u;  ///< of a face

    auto operator<=>(const Feature&) const = default;
  };
  /// How the surface at a feature shortens a gap.
  struct Descent {
    mpq_class squared_slope = 0;     ///< the steepest
    std::vector<uint32_t> elements;  ///< in which it does
  };
  /// What holds for every contact with these two features, the lower feature first.
  struct Between {
    std::optional<ExactPoint> gap;  ///< from the second to the first
    mpq_class squared = 0;
    Descent descent[2];
    std::optional<uint8_t> bits;  ///< that a contact had: 1 of the first, 2 of the second
    size_t count = 0, kept = 0;
    bool meshes_cross = false;
  };
  using Key = std::array<Feature, 2>;
  struct Contact {
    QueryKind kind;
    std::array<uint32_t, 4> stencil;
    uint8_t features, flags;
  };

  std::array<uint32_t, 4> stencil_of(QueryKind kind, const std::array<uint32_t, 2>& elements) const;
  std::array<Feature, 2> named(const Contact& contact, uint32_t element) const;
  JudgedFeatures truth_of(const Contact& contact) const;
  Between& between(const Key& key);
  Descent descent_at(const Feature& feature, const ExactPoint& way) const;
  std::vector<uint32_t> elements_at(const Feature& feature) const;
  bool cross(uint32_t mesh, uint32_t other);
  bool crosses(uint32_t edge, uint32_t element) const;
  void expect_features(const Contact& contact, const Key& ordered, Accuracy accuracy, CoveringCounts& counts);
  void expect_slopes(const Between& pair, uint8_t bits, CoveringCounts& counts) const;
  void expect_nearer_contacts(CoveringCounts& counts) const;
  void expect_points(const Contact& contact, const Between& pair, bool is_swapped, const std::array<double, 2>& weights,
                     Accuracy accuracy) const;
  double extent_of(const Contact& contact) const;
  std::vector<ExactPoint> directions_into(const Feature& feature) const;
  void expect_normal(const std::array<Feature, 2>& touching, const Normal& normal, CoveringCounts& counts) const;
  bool has_nearer(const Key& key, const Between& pair, int side, bool& is_left_out) const;
  uint32_t mesh_of(const Feature& feature) const { return mesh_of_vertex_[feature.vertices[0]]; }

  Topology topology_;
  Positions positions_;
  std::vector<ExactPoint> points_;
  std::vector<uint32_t> mesh_of_vertex_;
  std::vector<std::vector<uint32_t>> elements_of_;  ///< of each vertex
  std::vector<std::vector<uint32_t>> vertices_of_;  ///< of each element, ascending, each once
  std::map<std::array<uint32_t, 2>, bool> cross_;   ///< of two meshes
  std::map<std::array<uint32_t, 4>, JudgedFeatures> truths_[2];
  std::map<Key, Between> pairs_;
};

}  // namespace collided::test
