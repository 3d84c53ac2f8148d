#pragma once
// Which contacts a subcommand leaves out.

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/app/options/finite.hpp"
#include "client/app/options/mesh_names.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

struct ExclusionOptions {
  uint32_t rings = 0;
  bool rest_pairs = false;
  double rest_distance = 0;                                 ///< 0: each mesh's own contact distance
  std::vector<std::pair<std::string, std::string>> meshes;  ///< pairs of names

  /// Rings and rest pairs: the same for all meshes.
  void apply_to(std::vector<client::MeshInput>& inputs) const {
    for (client::MeshInput& mesh : inputs) mesh.exclude_rings = rings, mesh.exclude_rest_pairs = rest_pairs;
  }
  /// Throws UsageError for a mesh that the scene does not have.
  void exclude_meshes(v1::SceneSpec& spec, const std::vector<client::MeshInput>& inputs) const {
    for (const auto& [first, second] : meshes) {
      v1::MeshPair& pair = *spec.add_excluded_meshes();
      pair.set_first(mesh_of(inputs, kMeshesOption, first));
      pair.set_second(mesh_of(inputs, kMeshesOption, second));
    }
  }

  static constexpr const char* kMeshesOption = "--exclude-meshes";
};

inline void add_ring_option(CLI::App& command, uint32_t& rings) {
  command
      .add_option("--exclude-rings", rings, "Leave out self contacts of features that so many edges or fewer connect")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
}

/// For subcommands whose scenes can have several meshes.
inline void add_mesh_pairs_option(CLI::App& command, ExclusionOptions& options) {
  command
      .add_option(ExclusionOptions::kMeshesOption, options.meshes,
                  "Leave out contacts between two meshes; the same name twice: of a mesh with itself")
      ->type_name("NAME NAME")
      ->allow_extra_args(false)
      ->check(CLI::Validator(
          [](const std::string& word) {  // CLI11 takes the next option for the second name
            return word.starts_with("--") ? "needs 2 values, NAME NAME; '" + word + "' is an option" : std::string();
          },
          ""));
}

/// For subcommands whose first frame is the shape at rest.
inline void add_rest_options(CLI::App& command, ExclusionOptions& options) {
  auto* rest = command.add_flag("--exclude-rest-pairs", options.rest_pairs,
                                "Leave out self contacts of features that are close in the first frame");
  command.add_option("--rest-distance", options.rest_distance, "How close that is; 0: as close as a contact of the mesh with itself")
      ->needs(rest)
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
}

}  // namespace collided::cli
