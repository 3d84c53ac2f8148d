#pragma once
// Meshes of a scene that options name.

#include <algorithm>
#include <string>
#include <vector>

#include "client/app/options/usage_error.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

/// The mesh's index. Throws UsageError that names the option, the word and the meshes that there are.
inline uint32_t mesh_of(const std::vector<client::MeshInput>& meshes, const char* option, const std::string& name) {
  const auto found = std::find_if(meshes.begin(), meshes.end(), [&](const auto& mesh) { return mesh.name == name; });
  if (found != meshes.end()) return static_cast<uint32_t>(found - meshes.begin());
  std::string names;
  for (const client::MeshInput& mesh : meshes) names += (names.empty() ? "" : ", ") + mesh.name;
  throw UsageError(std::string(option) + ": the scene has no mesh '" + name + "'; there are " + names);
}

}  // namespace collided::cli
