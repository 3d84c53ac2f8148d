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

}  // namespace

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
