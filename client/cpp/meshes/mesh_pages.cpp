// A mesh of a living scene, read in pages.

#include "client/cpp/meshes/mesh_pages.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <cstring>
#include <optional>
#include <string>

namespace collided::client {

namespace {

constexpr int kTries = 8;

void append_page(MeshElements& mesh, const v1::GetMeshResponse& page) {
  using Element = std::array<uint32_t, 3>;
  const size_t before = mesh.elements.size(), count = page.elements().size() / sizeof(Element);
  const bool is_short = count == 0 && before < page.element_count();
  if (page.elements().size() % sizeof(Element) != 0 || before + count > page.element_count() || is_short)
    throw Error(grpc::DATA_LOSS, "elements: a page of " + std::to_string(page.elements().size()) + " bytes after " +
                                     std::to_string(before) + " of " + std::to_string(page.element_count()) +
                                     " elements");
  mesh.elements.resize(before + count);
  if (count > 0) std::memcpy(mesh.elements[before].data(), page.elements().data(), page.elements().size());
  for (size_t i = before; i < mesh.elements.size(); ++i)
    for (const uint32_t vertex : mesh.elements[i])
      if (vertex >= page.vertex_count())
        throw Error(grpc::DATA_LOSS, "elements[" + std::to_string(i) + "] names vertex " + std::to_string(vertex) +
                                         " of " + std::to_string(page.vertex_count()));
}

/// None if the mesh has fewer elements now.
std::optional<v1::GetMeshResponse> later_page(const PageFrom& page_from, uint32_t first_element) try {
  return page_from(first_element);
} catch (const Error& e) {
  if (e.code() != grpc::INVALID_ARGUMENT || e.field() != "first_element") throw;
  return std::nullopt;
}

/// None if the scene was edited between two pages.
std::optional<MeshElements> read_once(const PageFrom& page_from) {
  const v1::GetMeshResponse first = page_from(0);
  MeshElements out{.vertex_count = first.vertex_count(), .elements = {}, .edit_count = first.edit_count()};
  append_page(out, first);
  while (out.elements.size() < first.element_count()) {
    const auto page = later_page(page_from, static_cast<uint32_t>(out.elements.size()));
    if (!page || page->edit_count() != out.edit_count) return std::nullopt;
    append_page(out, *page);
  }
  return out;
}

}  // namespace

MeshElements read_elements(uint32_t mesh, const PageFrom& page_from) {
  for (int tries = 0; tries < kTries; ++tries)
    if (auto elements = read_once(page_from)) return *std::move(elements);
  throw Error(grpc::ABORTED,
              "mesh " + std::to_string(mesh) + " was edited as it was read, " + std::to_string(kTries) + " times");
}

}  // namespace collided::client
