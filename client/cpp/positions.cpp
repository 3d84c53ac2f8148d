// Positions as they go on the wire.

#include "client/cpp/positions.hpp"

#include <cstring>

#include "client/cpp/error.hpp"

namespace collided::client {

namespace {

constexpr int kInvalidArgument = 3;

[[noreturn]] void refuse(v1::PositionFormat format) {
  throw Error(kInvalidArgument, "position format " + std::to_string(format) + " is not F32 or F64");
}

std::string pack_f32(Positions positions) {
  std::string out(positions.size() * 3 * sizeof(float), '\0');
  char* to = out.data();
  for (const auto& p : positions) {
    const std::array<float, 3> f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
    std::memcpy(to, f.data(), sizeof f);
    to += sizeof f;
  }
  return out;
}

template <class Real>
void move(std::span<Real> positions, std::span<const Real> target, double fraction) {
  if (positions.size() != target.size())
    throw Error(kInvalidArgument, "target has " + std::to_string(target.size()) + " coordinates, positions have " +
                                      std::to_string(positions.size()));
  if (!(fraction >= 0 && fraction <= 1))
    throw Error(kInvalidArgument, "fraction is " + std::to_string(fraction) + "; it must be from 0 to 1");
  if (fraction == 0) return;
  for (size_t i = 0; i < positions.size(); ++i) {
    const double x = positions[i], way = target[i] - x, part = fraction * way;
    positions[i] = fraction == 1 ? target[i] : static_cast<Real>(x + part);
  }
}

}  // namespace

void move_along(std::span<float> positions, std::span<const float> target, double fraction) {
  move(positions, target, fraction);
}
void move_along(std::span<double> positions, std::span<const double> target, double fraction) {
  move(positions, target, fraction);
}

uint64_t position_bytes(v1::PositionFormat format) {
  switch (format) {
    case v1::POSITION_FORMAT_UNSPECIFIED:
    case v1::POSITION_FORMAT_F32:
      return 3 * sizeof(float);
    case v1::POSITION_FORMAT_F64:
      return 3 * sizeof(double);
    default:
      refuse(format);
  }
}

std::string pack_positions(Positions positions, v1::PositionFormat format) {
  switch (format) {
    case v1::POSITION_FORMAT_UNSPECIFIED:
    case v1::POSITION_FORMAT_F32:
      return pack_f32(positions);
    case v1::POSITION_FORMAT_F64:
      return {reinterpret_cast<const char*>(positions.data()), positions.size_bytes()};
    default:
      refuse(format);
  }
}

v1::MeshUpdate mesh_update(uint32_t mesh, v1::PositionFormat format, Positions positions, Positions start) {
  v1::MeshUpdate update;
  update.set_mesh(mesh);
  update.set_positions(pack_positions(positions, format));
  if (!start.empty()) update.set_start_positions(pack_positions(start, format));
  return update;
}

}  // namespace collided::client
