#pragma once
// The meshes of a recorded scene.

#include <vector>

#include "client/cpp/client.hpp"

namespace collided::cli {

/// Owns the elements that the inputs borrow.
class RecordedMeshes {
 public:
  /// Throws std::runtime_error naming the mesh and the field if an array has not a whole number of elements.
  explicit RecordedMeshes(const v1::SceneSpec& spec);
  RecordedMeshes(const RecordedMeshes&) = delete;
  RecordedMeshes& operator=(const RecordedMeshes&) = delete;
  const std::vector<client::MeshInput>& inputs() const { return inputs_; }

 private:
  struct Elements {
    std::vector<std::array<uint32_t, 3>> triangles;
    std::vector<std::array<uint32_t, 2>> edges;
    std::vector<uint32_t> points;
  };
  std::vector<Elements> elements_;
  std::vector<client::MeshInput> inputs_;
};

}  // namespace collided::cli
