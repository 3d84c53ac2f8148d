#pragma once
// Which contacts of a mesh with itself a subcommand leaves out.

#include <CLI/CLI.hpp>
#include <vector>

#include "client/cli/options/finite.hpp"
#include "client/cpp/client.hpp"

namespace collided::cli {

struct ExclusionOptions {
  uint32_t rings = 0;
  bool rest_pairs = false;
  double rest_distance = 0;  ///< 0: the thickness

  /// The same for all meshes.
  void apply_to(std::vector<client::MeshInput>& meshes) const {
    for (client::MeshInput& mesh : meshes) mesh.exclude_rings = rings, mesh.exclude_rest_pairs = rest_pairs;
  }
};

inline void add_ring_option(CLI::App& command, ExclusionOptions& options) {
  command
      .add_option("--exclude-rings", options.rings,
                  "Leave out self contacts of features that so many edges or fewer connect")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
}

/// For subcommands whose first frame is the shape at rest.
inline void add_rest_options(CLI::App& command, ExclusionOptions& options) {
  auto* rest = command.add_flag("--exclude-rest-pairs", options.rest_pairs,
                                "Leave out self contacts of features that are close in the first frame");
  command.add_option("--rest-distance", options.rest_distance, "How close that is; 0: the thickness")
      ->needs(rest)
      ->check(finite())
      ->check(at_least_zero())
      ->capture_default_str();
}

}  // namespace collided::cli
