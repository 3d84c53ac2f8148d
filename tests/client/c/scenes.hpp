#pragma once
// A cloth that falls on a solid, for the C library and for the engine itself.

#include <cmath>
#include <cstring>
#include <ostream>
#include <vector>

#include "client/c/include/collided/collided.h"
#include "gpu/detector.hpp"

namespace collided::test {

/// A square grid of n x n vertices.
inline std::vector<uint32_t> grid_triangles(uint32_t n) {
  std::vector<uint32_t> out;
  for (uint32_t i = 0; i + 1 < n; ++i)
    for (uint32_t j = 0; j + 1 < n; ++j) {
      const uint32_t a = i * n + j;
      for (const uint32_t v : {a, a + 1, a + n, a + 1, a + n + 1, a + n}) out.push_back(v);
    }
  return out;
}

/// The grid at a height that waves, so that it folds into itself and into what is below it.
template <class Real>
std::vector<Real> wave(uint32_t n, double height, double phase) {
  std::vector<Real> out;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < n; ++j) {
      const double x = double(i) / n, y = double(j) / n;
      for (const double v :
           {x + 0.1 * std::sin(9 * y + phase), y, height + 0.2 * std::sin(7 * x + phase) * std::cos(5 * y)})
        out.push_back(static_cast<Real>(v));
    }
  return out;
}

/// Positions in the box [-1, 2]^3.
inline std::vector<uint16_t> quantized(const std::vector<double>& positions) {
  std::vector<uint16_t> out;
  for (const double v : positions) out.push_back(static_cast<uint16_t>(std::lround((v + 1) / 3 * 65535)));
  return out;
}

struct CaseOfFrames {
  int32_t mode = COLLIDED_CCD, accuracy = COLLIDED_CERTIFIED, format = COLLIDED_F32;
  double thickness = 0;
  uint32_t kinds = 0;
  bool is_rigid = false;

  /// The test's name must not show padding.
  friend void PrintTo(const CaseOfFrames& of, std::ostream* out) {
    *out << "mode " << of.mode << " accuracy " << of.accuracy << " format " << of.format << " kinds " << of.kinds
         << (of.is_rigid ? " rigid" : "");
  }
};

/// Both meshes, and the bytes of three frames: cloth, then the ground, which moves only if it is rigid.
class Scene {
 public:
  explicit Scene(const CaseOfFrames& of) : of_(of), triangles_(grid_triangles(kSide)) {
    for (int frame = 0; frame < kFrames; ++frame) {
      cloth_.push_back(encode(0.5 - 0.25 * frame, 0.4 * frame));
      poses_.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.1 * frame});
    }
    ground_ = encode(0, 2);
    for (collided_mesh& mesh : meshes_) {
      mesh = {};
      mesh.struct_size = sizeof(mesh);
      mesh.triangles = triangles_.data();
      mesh.triangle_count = triangles_.size() / 3;
      mesh.vertex_count = kSide * kSide;
    }
    meshes_[1].motion = of.is_rigid ? COLLIDED_RIGID : COLLIDED_STATIC;
    spec.struct_size = sizeof(spec);
    spec.meshes = meshes_;
    spec.mesh_count = 2;
    spec.device = "cpu";
    spec.mode = of.mode;
    spec.accuracy = of.accuracy;
    spec.position_format = of.format;
    spec.thickness = of.thickness;
    spec.kinds = of.kinds;
    spec.fields = 511;
    if (of.kinds == COLLIDED_KINDS_TRIANGLE_TRIANGLE) spec.fields = COLLIDED_FIELDS_ELEMENTS | COLLIDED_FIELDS_FLAGS;
    spec.quantized_in = of.format == COLLIDED_Q16 ? kBox : nullptr;
    for (size_t i = 0; i < kFrames; ++i) add_frame(i);
    for (size_t i = 0; i < kFrames; ++i) frames[i].updates = updates_[i].data();
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  static constexpr int kFrames = 3;
  collided_scene_spec spec{};
  std::vector<collided_frame> frames;

  /// The same for the engine, written independently of the library.
  SceneSpec engine() const {
    SceneSpec out;
    out.mode = of_.mode == COLLIDED_DCD ? Mode::kDcd : Mode::kCcd;
    constexpr Accuracy kAccuracies[] = {Accuracy::kCandidates, Accuracy::kFast, Accuracy::kGuarded,
                                        Accuracy::kCertified, Accuracy::kExact};
    out.accuracy = kAccuracies[of_.accuracy - 1];
    out.scalar = of_.format == COLLIDED_F64 ? Scalar::kF64 : Scalar::kF32;
    out.thickness = of_.thickness;
    const auto has = [&](uint32_t kind) { return (of_.kinds & kind) != 0; };
    if (of_.kinds != 0)
      out.kinds = {has(COLLIDED_KINDS_VERTEX_TRIANGLE), has(COLLIDED_KINDS_EDGE_EDGE),
                   has(COLLIDED_KINDS_TRIANGLE_TRIANGLE), has(COLLIDED_KINDS_EDGE_TRIANGLE),
                   has(COLLIDED_KINDS_VERTEX_SOLID)};
    if (of_.kinds != COLLIDED_KINDS_TRIANGLE_TRIANGLE)
      out.fields = {ContactField::kElements, ContactField::kToi,           ContactField::kDistance,
                    ContactField::kWeights,  ContactField::kNormals,       ContactField::kFlags,
                    ContactField::kFeatures, ContactField::kSignedDistance};
    if (of_.format == COLLIDED_Q16) out.quantized_in = PositionBox{{-1, -1, -1}, {2, 2, 2}};
    MeshSpec mesh;
    mesh.vertex_count = kSide * kSide;
    mesh.triangles.resize(triangles_.size() / 3);
    std::memcpy(mesh.triangles.data(), triangles_.data(), triangles_.size() * sizeof(uint32_t));
    out.meshes = {mesh, mesh};
    out.meshes[1].motion = of_.is_rigid ? MeshMotion::kRigid : MeshMotion::kStatic;
    return out;
  }

  FrameInput engine_frame(size_t i) const {
    FrameInput out;
    out.updates.push_back({.mesh = 0, .end = cloth_[i]});
    if (i == 0) out.updates.push_back({.mesh = 1, .end = ground_});
    if (i > 0 && of_.is_rigid) out.updates.push_back({.mesh = 1, .transform = std::as_bytes(std::span(poses_[i]))});
    return out;
  }

 private:
  static constexpr uint32_t kSide = 14;
  static constexpr double kBox[6] = {-1, -1, -1, 2, 2, 2};
  using Bytes = std::vector<std::byte>;

  Bytes encode(double height, double phase) const {
    const auto bytes = [](const auto& numbers) {
      const auto view = std::as_bytes(std::span(numbers));
      return Bytes(view.begin(), view.end());
    };
    if (of_.format == COLLIDED_Q16) return bytes(quantized(wave<double>(kSide, height, phase)));
    return of_.format == COLLIDED_F64 ? bytes(wave<double>(kSide, height, phase))
                                      : bytes(wave<float>(kSide, height, phase));
  }

  void add_frame(size_t i) {
    std::vector<collided_update> updates(1);
    updates[0] = {
        sizeof(collided_update), nullptr, cloth_[i].data(), 0, cloth_[i].size(), nullptr, 0, 0, 0, nullptr, nullptr};
    if (i == 0)
      updates.push_back(
          {sizeof(collided_update), nullptr, ground_.data(), 0, ground_.size(), nullptr, 0, 0, 1, nullptr, nullptr});
    if (i > 0 && of_.is_rigid)
      updates.push_back({sizeof(collided_update), nullptr, nullptr, 0, 0, nullptr, 0, 0, 1, poses_[i].data(), nullptr});
    updates_.push_back(std::move(updates));
    frames.push_back({});
    frames.back().struct_size = sizeof(collided_frame);
    frames.back().update_count = updates_.back().size();
  }

  const CaseOfFrames of_;
  const std::vector<uint32_t> triangles_;
  std::vector<Bytes> cloth_;
  Bytes ground_;
  std::vector<std::array<double, 12>> poses_;
  collided_mesh meshes_[2];
  std::vector<std::vector<collided_update>> updates_;
};

}  // namespace collided::test
