// The frames that 'collidectl bench --end-to-end' sends, and how many bytes they are.

#include "client/measure/end_to_end/frames.hpp"

#include <algorithm>
#include <cmath>

#include "client/app/input/mesh_input.hpp"
#include "client/cpp/positions.hpp"

namespace collided::cli {

namespace {

double positions_megabytes(const scenes::Scene& scene, v1::PositionFormat format) {
  double vertices = 0;
  for (const scenes::Mesh& mesh : scene.meshes())
    if (!mesh.is_static) vertices += mesh.vertex_count;
  return vertices * static_cast<double>(client::position_bytes(format)) * 1e-6;
}

/// Time of a frame: back and forth around the middle of the motion, in steps as small as a simulator's, so that frames
/// are alike however many there are.
double time_of(int frame) {
  constexpr int kOneWay = 60;
  constexpr double kFrom = 0.5, kStep = 1.0 / 600;
  const int at = frame % (2 * kOneWay);
  return kFrom + kStep * std::min(at, 2 * kOneWay - at);
}

double bytes_of(const client::Contacts& contacts) {
  double bytes = 0;
  client::for_each_column(
      [&](v1::ContactField, auto column) { bytes += static_cast<double>(std::span(contacts.*column).size_bytes()); });
  return bytes;
}

}  // namespace

double scale_for(const std::string& scene, double megabytes, v1::PositionFormat format) {
  double best = 1, scale = 1, best_error = HUGE_VAL;
  for (int tries = 0; tries < 4; ++tries) {  // bytes grow by about the square of the scale
    const double bytes = positions_megabytes(*scenes::make_scene(scene, scale), format);
    if (const double error = std::abs(bytes - megabytes); error < best_error) {
      best = scale;
      best_error = error;
    }
    scale *= std::sqrt(megabytes / bytes);
  }
  return best;
}

v1::Frame frame_at(const scenes::Scene& scene, int frame, const v1::SceneSpec& spec) {
  std::vector<scenes::Vec3d> start;
  if (frame == 0 && spec.mode() == v1::DETECTION_MODE_CCD) start = scene.positions(time_of(0));
  return make_frame(scene.meshes(), static_cast<uint64_t>(frame) + 1, spec, scene.positions(time_of(frame + 1)), start);
}

std::vector<client::FrameUpdate> views_of(const v1::Frame& frame) {
  std::vector<client::FrameUpdate> out;
  for (const v1::MeshUpdate& update : frame.updates())
    out.push_back({.mesh = update.mesh(),
                   .positions = std::as_bytes(std::span(update.positions())),
                   .start_positions = std::as_bytes(std::span(update.start_positions()))});
  return out;
}

void move_to_input(client::FrameStream& stream, std::vector<client::FrameUpdate>& updates) {
  const auto move = [&](std::span<const std::byte>& bytes) {
    const std::span<std::byte> input = stream.input(bytes.size());
    std::copy(bytes.begin(), bytes.end(), input.begin());
    bytes = input;
  };
  for (client::FrameUpdate& update : updates) {
    move(update.positions);
    if (!update.start_positions.empty()) move(update.start_positions);
  }
}

double bytes_of(const std::vector<client::FrameUpdate>& updates) {
  size_t bytes = 0;
  for (const client::FrameUpdate& update : updates) bytes += update.positions.size() + update.start_positions.size();
  return static_cast<double>(bytes);
}

double bytes_of(const client::FrameOutput& output) {
  double bytes = 0;
  for_each_kind([&](v1::ContactKind, const client::Contacts& contacts) { bytes += bytes_of(contacts); }, output);
  return bytes;
}

}  // namespace collided::cli
