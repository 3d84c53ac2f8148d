#pragma once
// How thick each mesh is beyond the thickness of the scene.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "client/app/input/mesh_input.hpp"
#include "client/app/options/mesh_names.hpp"
#include "client/app/options/values.hpp"

namespace collided::cli {

inline constexpr const char* kHalfThicknessOption = "--half-thickness";

/// "ball=0.01"; the name may have a '=' of its own. Throws CLI::ValidationError.
inline std::pair<std::string, double> parse_half_thickness(const std::string& word) {
  const size_t sign = word.rfind('=');
  double half = 0;
  using CLI::detail::lexical_cast;
  const bool is_read = sign != std::string::npos && sign > 0 && lexical_cast(word.substr(sign + 1), half);
  if (is_read && std::isfinite(half) && half >= 0) return {word.substr(0, sign), half};
  throw CLI::ValidationError(kHalfThicknessOption,
                             "'" + word + "' is not NAME=LENGTH with a finite length of at least 0");
}

/// For subcommands whose scenes can have several meshes.
inline void add_half_thickness_option(CLI::App& command, DetectionOptions& options) {
  const auto take = [&options](const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      auto [name, half] = parse_half_thickness(word);
      const auto is_same = [&](const auto& other) { return other.first == name; };
      if (std::ranges::any_of(options.half_thicknesses, is_same))
        throw CLI::ValidationError(kHalfThicknessOption, "mesh '" + name + "' is named twice");
      options.half_thicknesses.emplace_back(std::move(name), half);
    }
  };
  command
      .add_option_function<std::vector<std::string>>(
          kHalfThicknessOption, take,
          "Half of what a mesh is thick beyond --thickness; meshes touch within --thickness and both halves")
      ->type_name("NAME=LENGTH")
      ->allow_extra_args(false);
}

/// The inputs borrow the meshes' triangles. Throws UsageError for a half thickness of a mesh that there is not.
inline std::vector<client::MeshInput> thick_inputs(const std::vector<scenes::Mesh>& meshes,
                                                   const DetectionOptions& options) {
  std::vector<client::MeshInput> inputs = mesh_inputs(meshes);
  for (const auto& [name, half] : options.half_thicknesses)
    inputs[mesh_of(inputs, kHalfThicknessOption, name)].half_thickness = half;
  return inputs;
}

}  // namespace collided::cli
