// GetMesh: what a mesh is made of, a page at a time.
#include "server/service/get_mesh.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>

#include "server/errors.hpp"

namespace collided::server {
namespace {

using Call = UnaryCall<pb::GetMeshRequest, pb::GetMeshResponse>;
using Element = std::array<uint32_t, 3>;

constexpr uint32_t kPageElements = (1u << 20) / sizeof(Element);

void check_ready(const Scene& scene) {
  scene.record().check_open();
  if (!scene.record().is_ready())
    throw FailedPrecondition(
        "scene_id", fmt::format("scene_id: scene {} is not READY: triangles are still to be sent", scene.id()));
}

void check_page(const pb::GetMeshRequest& request, const Topology& topology) {
  const size_t meshes = topology.triangle_offset.size() - 1;
  if (request.mesh() >= meshes)
    throw InvalidInput("mesh", fmt::format("mesh is {}, but the scene has {} meshes", request.mesh(), meshes));
  const uint32_t count = topology.triangle_offset[request.mesh() + 1] - topology.triangle_offset[request.mesh()];
  if (request.first_element() > count)
    throw InvalidInput("first_element", fmt::format("first_element is {}, but mesh {} has {} elements",
                                                    request.first_element(), request.mesh(), count));
}

/// Elements `first` to `end`, numbered scene-wide, with vertices that count from `vertex`.
std::string pack(const Topology& topology, uint32_t first, uint32_t end, uint32_t vertex) {
  std::vector<Element> elements(topology.triangles.begin() + first, topology.triangles.begin() + end);
  for (Element& element : elements)
    for (uint32_t& corner : element) corner -= vertex;
  return {reinterpret_cast<const char*>(elements.data()), elements.size() * sizeof(Element)};
}

void fill(const Scene& scene, const pb::GetMeshRequest& request, pb::GetMeshResponse& response) {
  const Topology& topology = scene.engine().topology();
  check_page(request, topology);
  const uint32_t mesh = request.mesh(), begin = topology.triangle_offset[mesh],
                 end = topology.triangle_offset[mesh + 1], first = begin + request.first_element(),
                 vertex = topology.vertex_offset[mesh];
  response.set_elements(pack(topology, first, first + std::min(kPageElements, end - first), vertex));
  response.set_element_count(end - begin);
  response.set_vertex_count(topology.vertex_offset[mesh + 1] - vertex);
  response.set_edit_count(scene.record().edits());
}

}  // namespace

void get_mesh(Call& call, SceneHost& host, const std::shared_ptr<void>& held) {
  const SceneUse scene = host.scenes().find(call.caller().client, call.request().scene_id());
  scene->worker().post([&call, scene, held] {
    guard(call, [&] {
      check_ready(*scene);
      fill(*scene, call.request(), call.response());
      call.finish();
    });
  });
}

}  // namespace collided::server
