#include "gpu/frame_check.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace collided {
namespace {

template <class T>
std::string text(const T& value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

template <class Real>
void check_coordinates(const std::string& field, std::span<const std::byte> bytes, double limit) {
  const size_t count = bytes.size() / sizeof(Real);
  for (size_t i = 0; i < count; ++i) {
    Real value;
    std::memcpy(&value, bytes.data() + i * sizeof(Real), sizeof(Real));
    if (std::abs(value) <= static_cast<Real>(limit)) continue;  // false for NaN
    throw InvalidInput(field, field + ": vertex " + text(i / 3) + ", coordinate " + "xyz"[i % 3] + " is " +
                                  text(value) + "; it must be finite and at most " + text(limit) + " in magnitude");
  }
}

void check_positions(const SceneSpec& spec, const std::string& field, std::span<const std::byte> bytes,
                     uint32_t vertex_count) {
  const uint64_t want = uint64_t{vertex_count} * bytes_per_vertex(spec.scalar);
  if (bytes.size() != want)
    throw InvalidInput(
        field, field + " has " + text(bytes.size()) + " bytes, " + text(vertex_count) + " vertices take " + text(want));
  if (spec.scalar == Scalar::kF64)
    check_coordinates<double>(field, bytes, coordinate_limit(spec.scalar));
  else
    check_coordinates<float>(field, bytes, coordinate_limit(spec.scalar));
}

void check_update(const SceneSpec& spec, const MeshPositions& update, const std::string& field, bool first) {
  if (update.mesh >= spec.meshes.size())
    throw InvalidInput(field + ".mesh", field + ".mesh is " + text(update.mesh) + ", the scene has " +
                                            text(spec.meshes.size()) + " meshes");
  const MeshSpec& mesh = spec.meshes[update.mesh];
  if (mesh.is_static && !first)
    throw InvalidInput(field + ".mesh", field + ".mesh " + text(update.mesh) + " is static: its positions come once");
  check_positions(spec, field + ".end", update.end, mesh.vertex_count);
  if (update.start.empty()) return;
  if (spec.mode == Mode::kDcd) throw InvalidInput(field + ".start", field + ".start is given, but the scene is DCD");
  if (mesh.is_static) throw InvalidInput(field + ".start", field + ".start is given, but the mesh is static");
  check_positions(spec, field + ".start", update.start, mesh.vertex_count);
}

void check_length(const std::string& field, double value, double limit) {
  if (!(value >= 0 && value <= limit))
    throw InvalidInput(field, field + " is " + text(value) + "; it must be from 0 to " + text(limit));
}

void check_settings(const SceneSpec& spec, const FrameSettings& settings) {
  if (spec.triangle_triangle && spec.mode == Mode::kCcd && settings.accuracy != Accuracy::kCandidates)
    throw InvalidInput(
        "triangle_triangle",
        "triangle_triangle is on, but only DCD tests triangle pairs; CCD lists them at CANDIDATES alone");
  check_length("delta", settings.delta, coordinate_limit(spec.scalar));
  const bool finds_features = spec.vertex_triangle || spec.edge_edge;
  if (spec.mode == Mode::kDcd && settings.accuracy == Accuracy::kFast && spec.thickness == 0 && finds_features)
    throw InvalidInput("thickness", "thickness is 0; discrete detection at FAST needs a distance > 0");
  if (settings.report == Report::kEarliestOnly && (spec.mode != Mode::kCcd || settings.accuracy < Accuracy::kGuarded))
    throw InvalidInput("report", "report is EARLIEST_ONLY, which needs CCD at GUARDED or above");
  if (settings.report == Report::kAnyHit && settings.accuracy < Accuracy::kFast)
    throw InvalidInput("report", "report is ANY_HIT, which needs FAST or above");
}

}  // namespace

double coordinate_limit(Scalar scalar) {
  return scalar == Scalar::kF64 ? std::numeric_limits<double>::max() / 8
                                : static_cast<double>(std::numeric_limits<float>::max() / 8);
}

void check_spec(const SceneSpec& spec) {
  check_length("thickness", spec.thickness, coordinate_limit(spec.scalar));
  if (!spec.vertex_triangle && !spec.edge_edge && !spec.triangle_triangle)
    throw InvalidInput("vertex_triangle",
                       "vertex_triangle, edge_edge and triangle_triangle are all off, nothing would be detected");
  if (spec.threads < 0)
    throw InvalidInput("threads", "threads is " + text(spec.threads) + ", the least is 0 (all cores)");
  check_settings(spec, settings_of(spec, {}));
}

void check_frame(const SceneSpec& spec, const FrameInput& frame, bool first) {
  check_settings(spec, settings_of(spec, frame));
  std::vector<bool> named(spec.meshes.size(), false);
  for (size_t i = 0; i < frame.updates.size(); ++i) {
    const std::string field = "updates[" + text(i) + "]";
    check_update(spec, frame.updates[i], field, first);
    if (named[frame.updates[i].mesh])
      throw InvalidInput(field + ".mesh", field + ".mesh " + text(frame.updates[i].mesh) + " comes twice in the frame");
    named[frame.updates[i].mesh] = true;
  }
  for (size_t mesh = 0; first && mesh < named.size(); ++mesh)
    if (!named[mesh])
      throw InvalidInput("updates",
                         "updates: the first frame must name every mesh, mesh " + text(mesh) + " is missing");
}

}  // namespace collided
