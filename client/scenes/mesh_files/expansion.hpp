#pragma once
// Limits what a mesh file can expand to.

#include <cstdint>
#include <string>
#include <utility>

#include "client/scenes/mesh_files/mesh_text.hpp"

namespace collided::scenes {

/// Meshes that nodes repeat, and arrays that several meshes share, take no bytes in the file. This counts what they
/// make, before it is made. The limit follows from the size of the file, so that no file is refused for what it holds
/// only once.
class Expansion {
 public:
  Expansion(std::string file, uint64_t bytes) : file_(std::move(file)), bytes_(bytes) {}

  /// Adds a file that the first one names.
  void add_bytes(uint64_t bytes) { bytes_ += bytes; }
  /// Counts vertices, corners of faces, ends of edges, and points.
  void count(uint64_t elements) {
    const uint64_t limit = kAllowance + kPerByte * bytes_;
    if (elements > limit - used_)
      fail(file_, "expands to more than " + std::to_string(limit) + " vertices and corners (a node counts as " +
                      std::to_string(kPerNode) + "), the limit for " + count_text(bytes_, "byte"));
    used_ += elements;
  }
  void count_node() { count(kPerNode); }

 private:
  static constexpr uint64_t kAllowance = uint64_t{1} << 23, kPerByte = 4, kPerNode = 64;

  std::string file_;
  uint64_t bytes_, used_ = 0;
};

}  // namespace collided::scenes
