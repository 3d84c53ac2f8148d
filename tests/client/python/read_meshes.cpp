// Prints what the reader in C++ makes of the mesh files whose names it is given on standard input, a line each.

#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <string>

#include "client/scenes/mesh_files/mesh_file.hpp"

int main() {
  for (std::string file; std::getline(std::cin, file);) {
    try {
      const auto mesh = collided::scenes::read_mesh(file);
      std::printf("%zu vertices, %zu triangles, %zu edges, %zu points, %zu notes\n", mesh.positions.size(),
                  mesh.triangles.size(), mesh.edges.size(), mesh.points.size(), mesh.notes.size());
    } catch (const std::runtime_error&) {
      std::puts("refused");
    }
  }
}
