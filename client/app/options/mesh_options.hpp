#pragma once
// What options say of meshes by their names: how thick they are, and which are solids.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "client/app/input/mesh_input.hpp"
#include "client/app/options/mesh_names.hpp"
#include "client/app/options/values.hpp"

namespace collided::cli {

inline constexpr const char* kHalfThicknessOption = "--half-thickness";
inline constexpr const char* kSolidOption = "--solid";

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

/// A flag, so that mesh files may follow it.
inline void add_solid_option(CLI::App& command, DetectionOptions& options) {
  command.add_flag(kSolidOption, options.solids,
                   "Meshes bound volumes: tell what is inside them (dcd); --solid=ball,box: these alone");
}

/// For subcommands whose scenes can have several meshes.
inline void add_mesh_options(CLI::App& command, DetectionOptions& options) {
  add_half_thickness_option(command, options);
  add_solid_option(command, options);
}

inline void set_solids(std::vector<client::MeshInput>& inputs, const std::string& solids) {
  if (solids == kAllSolids) {
    for (client::MeshInput& input : inputs) input.solid = true;
    return;
  }
  std::istringstream names(solids);
  for (std::string name; std::getline(names, name, ',');) inputs[mesh_of(inputs, kSolidOption, name)].solid = true;
}

/// The inputs borrow the meshes' triangles. Throws UsageError where options name a mesh that there is not.
inline std::vector<client::MeshInput> described_inputs(const std::vector<scenes::Mesh>& meshes,
                                                       const DetectionOptions& options) {
  std::vector<client::MeshInput> inputs = mesh_inputs(meshes);
  for (const auto& [name, half] : options.half_thicknesses)
    inputs[mesh_of(inputs, kHalfThicknessOption, name)].half_thickness = half;
  set_solids(inputs, options.solids);
  return inputs;
}

}  // namespace collided::cli
