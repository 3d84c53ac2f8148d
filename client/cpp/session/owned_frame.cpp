// Copies of what a session may have to send again.

#include "client/cpp/session/owned_frame.hpp"

namespace collided::client {

namespace {

Bytes copy_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

std::optional<RigidMatrix> copy_of(const RigidMatrix* matrix) { return matrix ? std::optional(*matrix) : std::nullopt; }

const RigidMatrix* view_of(const std::optional<RigidMatrix>& matrix) { return matrix ? &*matrix : nullptr; }

/// Copies what `span` borrows, and points it there.
template <class T>
void own(std::span<const T>& span, std::vector<T>& memory) {
  memory.assign(span.begin(), span.end());
  span = memory;
}

}  // namespace

OwnedUpdate::OwnedUpdate(const FrameUpdate& update)
    : mesh(update.mesh),
      positions(copy_of(update.positions)),
      start_positions(copy_of(update.start_positions)),
      indices(copy_of(update.indices)),
      transform(copy_of(update.transform)),
      start_transform(copy_of(update.start_transform)) {}

FrameUpdate OwnedUpdate::view() const {
  return {mesh, positions, start_positions, indices, view_of(transform), view_of(start_transform)};
}

OwnedFrame::OwnedFrame(std::span<const FrameUpdate> frame, const FrameOptions& of_frame)
    : updates(frame.begin(), frame.end()), options(of_frame) {}

std::vector<FrameUpdate> OwnedFrame::views() const {
  std::vector<FrameUpdate> out;
  for (const OwnedUpdate& update : updates) out.push_back(update.view());
  return out;
}

OwnedScene::OwnedScene(const v1::SceneSpec& spec, std::span<const MeshInput> meshes)
    : spec_(spec), meshes_(meshes.begin(), meshes.end()), elements_(meshes.size()) {
  for (size_t i = 0; i < meshes_.size(); ++i) {
    own(meshes_[i].triangles, elements_[i].triangles);
    own(meshes_[i].edges, elements_[i].edges);
    own(meshes_[i].points, elements_[i].points);
  }
}

}  // namespace collided::client
