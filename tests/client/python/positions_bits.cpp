// Computes positions with the C++ client, for positions_test.py to compare. It reads doubles from standard input and
// writes doubles to standard output, x y z per vertex. For q16 it writes uint16.
//
// usage: positions_bits f32|f64 along FRACTION   < positions, targets
//        positions_bits f32|f64 rigid            < 12 numbers of the matrix, positions
//        positions_bits f64 pose FRACTION        < 12 numbers of each of two matrices; writes those of a third
//        positions_bits f64 q16                  < 3 of the box's lower corner, 3 of its upper one, positions

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "client/cpp/positions.hpp"

using namespace collided::client;

namespace {

std::vector<double> read_all() {
  std::vector<double> out;
  for (double x; std::fread(&x, sizeof x, 1, stdin) == 1;) out.push_back(x);
  return out;
}

template <class Real>
std::vector<Real> as(std::span<const double> values) {
  std::vector<Real> out;
  for (const double x : values) out.push_back(static_cast<Real>(x));
  return out;
}

RigidMatrix matrix_of(std::span<const double> in) {
  RigidMatrix matrix;
  std::copy_n(in.begin(), matrix.size(), matrix.begin());
  return matrix;
}

template <class Real>
std::vector<Real> moved(std::span<const double> in, const char* how, double fraction) {
  if (std::strcmp(how, "along") == 0) {
    auto x = as<Real>(in.first(in.size() / 2));
    const auto target = as<Real>(in.subspan(in.size() / 2));
    move_along(std::span(x), std::span<const Real>(target), fraction);
    return x;
  }
  const RigidMatrix matrix = matrix_of(in);
  auto x = as<Real>(in.subspan(matrix.size()));
  move_rigidly(std::span(x), matrix);
  return x;
}

template <class T>
void write_all(const T* values, size_t count) {
  std::fwrite(values, sizeof(T), count, stdout);
}

void write_quantized(std::span<const double> in) {
  collided::v1::QuantizationBox box;
  for (size_t axis = 0; axis < 3; ++axis) {
    box.add_lower(in[axis]);
    box.add_upper(in[3 + axis]);
  }
  std::vector<std::array<double, 3>> positions((in.size() - 6) / 3);
  std::memcpy(positions.data(), in.data() + 6, positions.size() * sizeof(positions[0]));
  const std::string packed = pack_quantized(positions, box);
  write_all(packed.data(), packed.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::vector<double> in = read_all();
  if (std::strcmp(argv[2], "q16") == 0) return write_quantized(in), 0;
  const double fraction = argc > 3 ? std::strtod(argv[3], nullptr) : 0;
  if (std::strcmp(argv[2], "pose") == 0) {
    const std::span<const double> all(in);
    const RigidMatrix pose = pose_along(matrix_of(all.first(12)), matrix_of(all.subspan(12)), fraction);
    return write_all(pose.data(), pose.size()), 0;
  }
  if (std::strcmp(argv[1], "f32") == 0) {
    const std::vector<float> x = moved<float>(in, argv[2], fraction);
    const std::vector<double> wide(x.begin(), x.end());
    write_all(wide.data(), wide.size());
  } else {
    const std::vector<double> x = moved<double>(in, argv[2], fraction);
    write_all(x.data(), x.size());
  }
}
