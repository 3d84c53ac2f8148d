#pragma once
// Cloth that waves through the ground beside a ball that turns, and frames of every sort that a session can repeat.

#include <cmath>
#include <string>
#include <vector>

#include "client/cpp/session.hpp"
#include "tests/integration/client_library/client_layers.hpp"

namespace collided::test {

using client::FrameOptions;
using client::MeshInput;
using client::RigidMatrix;
using client::Session;
using client::SessionOptions;
using Triangles = std::vector<std::array<uint32_t, 3>>;

inline constexpr uint32_t kCloth = 0, kBall = 1, kGround = 2, kCells = 8;

/// A frame with its own memory.
struct SessionFrame {
  std::string cloth = "", start = "", vertices = "", ball = "", ground = "";
  std::optional<RigidMatrix> pose = {};
  FrameOptions options = {};

  std::vector<FrameUpdate> updates() const {
    std::vector<FrameUpdate> out;
    if (!cloth.empty()) out.push_back({kCloth, bytes_of(cloth), bytes_of(start), bytes_of(vertices)});
    if (!ball.empty() || pose)
      out.push_back({.mesh = kBall, .positions = bytes_of(ball), .transform = pose ? &*pose : nullptr});
    if (!ground.empty()) out.push_back({.mesh = kGround, .positions = bytes_of(ground)});
    return out;
  }
};

/// Its cells are smaller than what counts as near at rest, so that a cloth without its first frame meets itself.
inline pb::SceneSpec session_spec(pb::DetectionMode mode, pb::PositionFormat format = pb::POSITION_FORMAT_F32) {
  pb::SceneSpec spec;
  spec.set_mode(mode);
  spec.set_position_format(format);
  spec.set_thickness(0.15);
  spec.set_rest_distance(0.15);
  if (mode == pb::DETECTION_MODE_DCD_AND_CCD) spec.set_min_separation(0.001);
  return spec;
}

struct SessionMeshes {
  Triangles cloth;
  const Triangles ball{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}, ground{{0, 1, 2}, {0, 2, 3}};
  std::vector<MeshInput> inputs;

  SessionMeshes() {
    for (uint32_t y = 0; y + 1 < kCells; ++y)
      for (uint32_t x = 0; x + 1 < kCells; ++x) {
        const uint32_t i = y * kCells + x, up = i + kCells;
        cloth.insert(cloth.end(), {{i, i + 1, up}, {up + 1, up, i + 1}});
      }
    inputs = {{.name = "cloth", .vertex_count = kCells * kCells, .triangles = cloth, .exclude_rest_pairs = true},
              {.name = "ball", .vertex_count = 4, .triangles = ball, .is_rigid = true},
              {.name = "ground", .vertex_count = 4, .triangles = ground, .is_static = true}};
  }
};

inline Points cloth_points(double time, double height) {
  Points points;
  for (uint32_t y = 0; y < kCells; ++y)
    for (uint32_t x = 0; x < kCells; ++x)
      points.push_back({x / 8.0, y / 8.0, height + 0.1 * std::sin(0.7 * time + 0.5 * x + 0.3 * y)});
  return points;
}

inline RigidMatrix ball_pose(double time, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c, -s, 0, 0.1, s, c, 0, 0.2, 0, 0, 1, 0.2 * std::cos(time)};
}

/// Frame `id` of a motion, from 1: whole, sparse, the ball alone, a trial or one that says where it starts, in turn.
inline SessionFrame session_frame(uint64_t id, pb::DetectionMode mode) {
  const double time = static_cast<double>(id);
  SessionFrame frame;
  frame.cloth = pack_points(cloth_points(time, 0));
  if (id == 1) {
    frame.ball = pack_points({{0.5, 0.5, 0}, {0.7, 0.5, 0}, {0.5, 0.7, 0}, {0.5, 0.5, 0.2}});
    frame.ground = pack_points({{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}});
    return frame;
  }
  switch (id % 5) {
    case 0:
      frame.cloth = pack_points({{0.1, 0.2, 0.3}, {0.3, 0.2, -0.1 * std::sin(time)}});
      frame.vertices = pack<uint32_t>({3, static_cast<uint32_t>(10 + id)});
      break;
    case 1:
      frame.pose = ball_pose(time, 0.1 * time);
      if (mode == pb::DETECTION_MODE_DCD_AND_CCD) frame.options.mode = pb::DETECTION_MODE_DCD;
      break;
    case 2:
      frame.cloth.clear();
      frame.pose = ball_pose(time, 0.1 * time);
      break;
    case 3:
      frame.options.trial = true;
      break;
    default:
      if (mode != pb::DETECTION_MODE_DCD) frame.start = pack_points(cloth_points(time - 0.5, 0.05));
  }
  return frame;
}

template <class T>
void add_bytes(std::string& out, const std::vector<T>& values) {
  out += pack<uint64_t>({values.size()}) + pack(values);
}

/// All that an answer says of contacts, and of how far the frame went.
inline std::string digest(const FrameOutput& output) {
  std::string out = pack<double>({output.done.earliest_toi(), output.done.advanced()});
  add_bytes(out, output.advance.ids);
  add_bytes(out, output.advance.fractions);
  client::for_each_kind(
      [&](pb::ContactKind, const client::Contacts& contacts) {
        add_bytes(out, contacts.elements);
        add_bytes(out, contacts.stencils);
        add_bytes(out, contacts.toi);
        add_bytes(out, contacts.distance);
        add_bytes(out, contacts.flags);
      },
      output);
  return out;
}

}  // namespace collided::test
