// Every file of tests/support/mesh_files/table.py is read as the table says, or refused in its words.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "client/scenes/mesh_files/mesh_file.hpp"
#include "client/scenes/mesh_files/mesh_text.hpp"
#include "client/scenes/vec3.hpp"

namespace collided::scenes {
namespace {

using Json = nlohmann::json;

Json read_table() {
  std::ifstream in(std::filesystem::path(MESH_TABLE) / "table.json");
  return Json::parse(in);
}

/// What a reader says behind the file's name; empty if it reads the file.
std::string error_of(const std::string& file, MeshFile& mesh) {
  try {
    mesh = read_mesh(file);
  } catch (const std::runtime_error& e) {
    const std::string text = e.what();
    EXPECT_TRUE(text.starts_with(file)) << text;
    return text.substr(std::min(file.size(), text.size()));
  }
  return "";
}

/// Sums and products of the table's integers are exact.
void expect_area(const MeshFile& mesh, const Vec3d& expected) {
  Vec3d sum{};
  for (const auto& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t[0]];
    const Vec3d area = cross(minus(mesh.positions[t[1]], a), minus(mesh.positions[t[2]], a));
    EXPECT_GE(dot(area, expected), 0) << "triangle " << t[0] << " " << t[1] << " " << t[2];
    for (size_t k = 0; k < 3; ++k) sum[k] += area[k];
  }
  EXPECT_EQ(sum, expected);
}

void expect_read(const Json& row, const MeshFile& mesh) {
  const auto expect_count = [&](const char* key, size_t count) { EXPECT_EQ(count, row.value(key, count)) << key; };
  expect_count("vertex_count", mesh.positions.size());
  expect_count("triangles", mesh.triangles.size());
  expect_count("edges", mesh.edges.size());
  expect_count("points", mesh.points.size());
  EXPECT_EQ(mesh.positions, row.value("vertices", mesh.positions));
  EXPECT_EQ(mesh.notes, row.value("notes", mesh.notes));
  if (row.contains("twice_area")) expect_area(mesh, row["twice_area"].get<Vec3d>());
}

TEST(MeshTable, EveryFileIsReadOrRefusedAsTheTableSays) {
  const Json table = read_table();
  ASSERT_GT(table.size(), 300u);
  for (const Json& row : table) {
    const auto name = row["name"].get<std::string>();
    SCOPED_TRACE(name);
    MeshFile mesh;
    const std::string error = error_of((std::filesystem::path(MESH_TABLE) / name).string(), mesh);
    EXPECT_EQ(error, row.value("error", ""));
    if (error.empty() && !row.contains("error")) expect_read(row, mesh);
  }
}

/// Damaged in a few bytes, or cut off, each file is read or refused, and nothing else.
TEST(MeshTable, DamagedFilesAreReadOrRefused) {
  constexpr std::string_view kBytes("0149-.,\"<>{}[] \n#\0\xff", 20);
  std::mt19937 random(3);
  int refused = 0;
  for (const Json& row : read_table()) {
    const std::filesystem::path file = std::filesystem::path(MESH_TABLE) / row["name"].get<std::string>();
    const std::string whole = read_file(file);
    if (whole.size() > 2000 || file.extension() == ".fbx") continue;
    for (int i = 0; i < 30 && !whole.empty(); ++i) {
      std::string text = whole.substr(0, i % 3 == 0 ? random() % whole.size() : whole.size());
      for (int k = 0; k < 2 && !text.empty(); ++k) text[random() % text.size()] = kBytes[random() % kBytes.size()];
      try {
        parse_mesh(file.extension().string(), text, "input");
      } catch (const std::runtime_error& e) {
        EXPECT_TRUE(std::string_view(e.what()).starts_with("input")) << e.what();
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace collided::scenes
