// Mesh files: bit-exact round trips, every PLY encoding, and hostile files.

#include "client/scenes/mesh_files/mesh_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace collided::scenes {
namespace {

class MeshFiles : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    dir_ = std::filesystem::temp_directory_path() / (std::string(test->name()) + std::to_string(getpid()));
    std::filesystem::create_directory(dir_);
  }
  void TearDown() override { std::filesystem::remove_all(dir_); }

  std::filesystem::path put(const std::string& name, const std::string& text) {
    std::ofstream(dir_ / name, std::ios::binary) << text;
    return dir_ / name;
  }
  std::string error_of(const std::string& name, const std::string& text) {
    try {
      read_mesh(put(name, text));
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }
  std::filesystem::path dir_;
};

MeshFile sample() {
  MeshFile mesh;
  mesh.positions = {{0.1, -0.0, 1e-310}, {1.0 / 3, 1e300, -2}, {0.3, 5e-324, 7}, {1, 2, 3}};
  mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
  return mesh;
}

bool same_bits(const MeshFile& a, const MeshFile& b) {
  return a.triangles == b.triangles && a.positions.size() == b.positions.size() &&
         std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof(Vec3d)) == 0;
}

TEST_F(MeshFiles, RoundTripsKeepEveryBit) {
  for (const char* name : {"m.obj", "m.ply", "m.PLY"}) {
    write_mesh(dir_ / name, sample());
    const MeshFile back = read_mesh(dir_ / name);
    EXPECT_TRUE(same_bits(back, sample())) << name;
    EXPECT_TRUE(back.is_double) << name;
  }
}

TEST_F(MeshFiles, FloatsAreToldFromDoubles) {
  MeshFile mesh = sample();
  for (Vec3d& p : mesh.positions) p = {0.5, 0.25, double(0.1f)};
  write_mesh(dir_ / "m.ply", mesh);
  EXPECT_FALSE(read_mesh(dir_ / "m.ply").is_double);
}

TEST_F(MeshFiles, ObjFormsAreRead) {
  const MeshFile mesh = read_mesh(put("m.obj",
                                      "# c\r\nv 0 0 0 1\r\nv +1 0 0\nv 1 1 0\nvn 0 0 1\nv 0 1 0\n\n"
                                      "usemtl a\nf 1/1/1 2//1 3 4\nf -4 -3 -1"));
  EXPECT_EQ(mesh.positions[1][0], 1);
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}));
}

TEST_F(MeshFiles, ObjLinesAndPointsAreLooseElements) {
  const MeshFile mesh = read_mesh(put("m.obj", "l 1 2/5 3\nv 0 0 0\nv 1 0 0\np 1 -1\nv 0 1 0\nl -1 1\n"));
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_EQ(mesh.edges, (std::vector<std::array<uint32_t, 2>>{{0, 1}, {1, 2}, {2, 0}}));
  EXPECT_EQ(mesh.points, (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(read_mesh(put("p.obj", "v 0 0 0\np 1\n")).points, std::vector<uint32_t>{0});
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nl 1\n").find("m.obj:2: the line has 1 vertex; it needs 2"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\np 2\n").find("m.obj:2: vertex index 2 is out of range"), std::string::npos);
}

TEST_F(MeshFiles, ObjCommentsAndLinesThatGoOnAreRead) {
  const MeshFile mesh = read_mesh(put("m.obj",
                                      "# C:\\meshes\\\nv 0 0 0 # 1\nv 1 \\\n0 0\r\nv 0 \\\r\n1 \\\r\n0\n"
                                      "f 1 2 3 # of 1 2 3\nf 3 2\\\n1#\n"));
  EXPECT_EQ(mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {2, 1, 0}}));
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nv 1 \\\nzero 0\n").find("m.obj:2: 'zero' is not a number"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nv 1 0 \\\n\nv 0 zero 0").find("m.obj:2: a number is missing"),
            std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 \\").find("m.obj:1: a number is missing"), std::string::npos);
}

TEST_F(MeshFiles, NumbersThatAreTooSmallAreZero) {
  const MeshFile mesh = read_mesh(put("m.obj", "v 1e-400 -1e-400 0.1e-99999\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  EXPECT_EQ(mesh.positions[0], (Vec3d{0, 0, 0}));
  for (const char* number : {"1e400", "-1e400"})
    EXPECT_NE(error_of("m.obj", "v 0 0 " + std::string(number) + "\n").find("is out of range"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 1e-400x\n").find("'1e-400x' is not a number"), std::string::npos);
}

TEST_F(MeshFiles, AByteOrderMarkIsNoPartOfTheFirstLine) {
  const MeshFile f = read_mesh(put("m.obj", "\xEF\xBB\xBFv 7 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_EQ(f.positions.size(), 3u);
  EXPECT_EQ(f.positions[0], (Vec3d{7, 0, 0}));
}

TEST_F(MeshFiles, VerticesOfFacesAreIntegers) {
  for (const std::string type : {"float", "double"}) {
    const std::string error =
        error_of("m.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 1\nproperty list uchar " +
                     type +
                     " vertex_indices\nend_header\n"
                     "0 0 0\n1 0 0\n0 1 0\n3 0 1.7 2\n");
    EXPECT_NE(error.find("m.ply:8: vertex_indices must be of an integer type"), std::string::npos) << error;
  }
}

template <class T>
std::string bytes(T value, bool big) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  std::string out(raw, sizeof(T));
  return big == (std::endian::native == std::endian::big) ? out : std::string(out.rbegin(), out.rend());
}

template <class T>
std::string binary_ply(bool big, const std::string& type) {
  std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\ncomment x\nelement vertex 3\nproperty " + type + " x\nproperty uchar red\nproperty " +
                    type + " y\nproperty " + type + " z\nelement face 1\nproperty uchar flag\n" +
                    "property list uchar int vertex_index\nelement edge 1\nproperty short a\nend_header\n";
  for (int v = 0; v < 3; ++v) {
    out += bytes(T(v + 0.5), big) + '\x7f' + bytes(T(-0.1), big) + bytes(T(3), big);
  }
  out += std::string("\1\3");
  for (const int32_t v : {2, 1, 0}) out += bytes(v, big);
  return out + bytes(int16_t{4}, big);
}

TEST_F(MeshFiles, EveryPlyEncodingIsRead) {
  for (const bool big : {false, true}) {
    const MeshFile f = read_mesh(put("f.ply", binary_ply<float>(big, "float")));
    EXPECT_EQ(f.positions[2], (Vec3d{2.5, double(-0.1f), 3}));
    EXPECT_EQ(f.triangles[0], (std::array<uint32_t, 3>{2, 1, 0}));
    EXPECT_FALSE(f.is_double);
    const MeshFile d = read_mesh(put("d.ply", binary_ply<double>(big, "float64")));
    EXPECT_EQ(d.positions[2], (Vec3d{2.5, -0.1, 3}));
    EXPECT_TRUE(d.is_double);
  }
  const MeshFile a = read_mesh(put("a.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
                                   "property double z\nelement face 1\nproperty list uchar uint vertex_indices\n"
                                   "end_header\n0.1 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  EXPECT_EQ(a.positions[0][0], 0.1);
  EXPECT_EQ(a.triangles.size(), 1u);
}

TEST_F(MeshFiles, EveryCutIsRefused) {
  const std::string whole = binary_ply<double>(true, "double");
  for (size_t n = 0; n < whole.size(); ++n) EXPECT_NE(error_of("m.ply", whole.substr(0, n)), "") << n;
}

std::string hostile_header(const std::string& vertices, const std::string& faces) {
  return "ply\nformat binary_little_endian 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uint int vertex_indices\nend_header\n";
}

TEST_F(MeshFiles, HostilePlyIsRefusedBeforeAllocation) {
  const std::string three(36, '\0');
  EXPECT_NE(error_of("m.ply", hostile_header("18446744073709551615", "1") + three).find("cut off"), std::string::npos);
  EXPECT_NE(error_of("m.ply", hostile_header("99999999999999999999", "1")).find("out of range"), std::string::npos);
  EXPECT_NE(error_of("m.ply", hostile_header("-1", "1")).find("not a number"), std::string::npos);
  EXPECT_NE(error_of("m.ply", hostile_header("3", "1") + three + "\xff\xff\xff\xff").find("cut off within element face"),
            std::string::npos);
  EXPECT_NE(error_of("m.ply", hostile_header("3", "1") + three + std::string("\3\0\0\0\0\0\0\0\1\0\0\0\3\0\0\0", 16))
                .find("vertex index 3 is out of range; there are 3 vertices"),
            std::string::npos);
  EXPECT_NE(error_of("m.ply", "ply\nformat ascii 1.0\nelement face 9999999\nend_header\n"), "");
  EXPECT_NE(error_of("m.ply", "ply\nelement vertex 1\nproperty float x\nend_header\n"), "");
  EXPECT_NE(error_of("m.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n"), "");
  EXPECT_NE(error_of("m.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"), "");
}

TEST_F(MeshFiles, LargeNumbersInPlyAreToldAsTheyAre) {
  const std::string error = error_of("m.ply",
                                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                     "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                                     "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9223372036854775807\n");
  EXPECT_NE(error.find("vertex index 9223372036854775808 is out of range"), std::string::npos) << error;
}

TEST_F(MeshFiles, AFrameIsSplitLikeTheFirst) {
  const auto quad = [](const std::string& corner) {
    return "v 0 0 0\nv " + corner + " 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n";
  };
  const MeshFile first = read_mesh(put("0.obj", quad("4 0"))), alone = read_mesh(put("1.obj", quad("1 2")));
  EXPECT_NE(alone.triangles, first.triangles) << "a quad that is concave there has another diagonal";
  const MeshFile second = read_mesh(dir_ / "1.obj", &first);
  EXPECT_EQ(second.triangles, first.triangles);
  const MeshFile other = read_mesh(put("2.obj", quad("1 2") + "f 1 2 3\n"), &first);
  EXPECT_EQ(other.triangles.size(), 3u) << "other faces are split by themselves";
}

TEST_F(MeshFiles, FilesWithoutAMeshAreRefused) {
  EXPECT_NE(error_of("m.obj", "").find("m.obj: has 0 vertices; a mesh needs 3"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "no mesh at all\n").find("m.obj: has 0 vertices"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nv 1 0 0\nf 1 2 1\n").find("m.obj: has 2 vertices"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n").find("m.obj: has no faces"), std::string::npos);
  EXPECT_NE(error_of("m.ply", "ply\nformat ascii 1.0\nend_header\n").find("m.ply: has 0 vertices"), std::string::npos);
}

TEST_F(MeshFiles, ErrorsNameFileAndPlace) {
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nv 1 zero 0\n").find("m.obj:2: 'zero' is not a number"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0\n").find("m.obj:1: a number is missing"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nf 1 1 2\n").find("m.obj:2: vertex index 2 is out of range; there is 1 vertex"),
            std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nf 1 0 1\n").find("vertex index 0"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nf 1 1\n").find("2 corners"), std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 1 0 0\nv 0 nan 0\n").find("m.obj:2: position nan is not finite"), std::string::npos);
  EXPECT_NE(error_of("m.ply",
                     "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
                     "property double z\nend_header\n0 0 0\n0 zero 0\n")
                .find("m.ply:9: 'zero' is not a number"),
            std::string::npos);
  EXPECT_NE(error_of("m.obj", "v 0 0 0\nf 1 3 4\nf 2 3 1\nv 1 0 0\nv 0 1 0\n")
                .find("m.obj:2: vertex index 4 is out of range; there are 3 vertices"),
            std::string::npos);
  EXPECT_NE(error_of("m.fbx", "solid").find("the extension must be .obj, .ply"), std::string::npos);
  EXPECT_THROW(read_mesh(dir_ / "none.ply"), std::runtime_error);
  std::filesystem::create_symlink("loop.obj", dir_ / "loop.obj");
  try {
    read_mesh(dir_ / "loop.obj");
    ADD_FAILURE() << "read";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("loop.obj: cannot be read: Too many levels"), std::string::npos) << e.what();
  }
  EXPECT_THROW(read_mesh(dir_), std::runtime_error);
}

}  // namespace
}  // namespace collided::scenes
