#pragma once
// Meshes that move as a whole: their positions at rest, their poses in the step in work and in the last good frame, and
// how far a step's straight paths are from the screws that they move along.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gpu/base/text.hpp"
#include "gpu/positions/blend.hpp"
#include "gpu/positions/rigid_arc.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/search/boxes.hpp"
#include "gpu/step/buffers.hpp"

namespace collided {

/// Box of a position, to be joined with others'.
template <class Real>
struct PointBox {
  const Vec3<Real>* points;
  COLLIDED_HD Box<Real> operator()(uint64_t i) const { return {points[i], points[i]}; }
};

template <Executor Exec, class Real>
class RigidMeshes {
 public:
  /// Beyond this the shorter way round could be meant, or the longer.
  static constexpr double kMaxAngle = 3;

  RigidMeshes(Exec& exec, const SceneShape& shape, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), shape_(shape), scene_(scene) {
    for (uint32_t mesh = 0; mesh < shape.spec.meshes.size(); ++mesh) {
      if (shape.spec.meshes[mesh].motion != MeshMotion::kRigid) continue;
      bodies_.push_back({mesh, shape.vertex_offset[mesh], shape.spec.meshes[mesh].vertex_count, rest_count_});
      rest_count_ += bodies_.back().count;
    }
  }

  /// Memory for a frame.
  void require() {
    if (bodies_.empty()) return;
    scene_.rigid.rest.allocate(rest_count_);
    if (!has_paths()) return;
    const size_t meshes = shape_.spec.meshes.size();
    if (!deviations_.empty()) return;
    scene_.rigid.first_vertex.allocate(meshes);
    scene_.rigid.deviations.allocate(meshes + 1);
    exec_.upload(scene_.rigid.first_vertex.data(), shape_.vertex_offset.data(), meshes * sizeof(uint32_t));
  }

  /// Where the step begins: where the last good frame ended, or so far along the last frame's way, where the meshes'
  /// positions at the start go, too.
  void begin(const std::optional<double>& start_fraction) {
    for (Body& body : bodies_) {
      body.start = start_fraction ? along(body.start, body.end, *start_fraction) : body.good;
      body.end = body.target = body.start;
      if (!start_fraction) continue;
      transform(body, body.start, scene_.start.data());
      transform(body, body.start, scene_.end.data());
    }
  }
  /// Puts the frame's moves in `start` and `end`, where the slot has put positions. `first`: those to be kept at rest.
  void place(const std::vector<RigidMove>& moves, bool first, bool is_ccd) {
    if (bodies_.empty()) return;
    if (first) keep_rest();
    for (const RigidMove& move : moves) place(move, first, is_ccd);
    if (is_ccd) measure();
  }
  /// The same ends in other positions that the slot has put its own into.
  void place_ends(const std::vector<RigidMove>& moves, Vec3<Real>* positions) {
    for (const RigidMove& move : moves) transform(body_of(move.mesh), move.end, positions);
  }

  /// So far along the step's way, on which no mesh turns: where the pose is, so are the positions.
  void go(double fraction) {
    for (Body& body : bodies_) {
      body.end = along(body.start, body.target, fraction);
      transform(body, body.end, scene_.end.data());
    }
  }
  void commit() {
    for (Body& body : bodies_) body.good = body.end;
  }

  /// A mesh that turns in the step in work, or turned in the last one.
  std::optional<uint32_t> turning() const {
    const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                    [](const Body& body) { return !body.start.has_rotation_of(body.end); });
    return found == bodies_.end() ? std::nullopt : std::optional(found->mesh);
  }

 private:
  struct Body {
    uint32_t mesh, first_vertex, count;
    uint64_t first_rest;
    Box<double> rest = {};
    Pose start = {}, end = {};  ///< of the step in work, or of the last one
    Pose target = {};           ///< where the step in work would end
    Pose good = {};             ///< of the last good frame
  };

  bool has_paths() const { return shape_.spec.mode != Mode::kDcd; }
  Body& body_of(uint32_t mesh) {
    return *std::lower_bound(bodies_.begin(), bodies_.end(), mesh,
                             [](const Body& body, uint32_t wanted) { return body.mesh < wanted; });
  }
  /// Of a mesh that does not turn.
  static Pose along(const Pose& start, const Pose& end, double fraction) {
    Pose pose = end;
    for (size_t i = 3; i < pose.rows.size(); i += 4) pose.rows[i] = blend(start.rows[i], end.rows[i], fraction);
    return pose;
  }

  void keep_rest() {
    RigidBuffers<Exec, Real>& rigid = scene_.rigid;
    rigid.bounds.allocate(bodies_.size());
    for (size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      Vec3<Real>* rest = rigid.rest.data() + body.first_rest;
      exec_.copy(rest, scene_.end.data() + body.first_vertex, uint64_t{body.count} * sizeof(Vec3<Real>));
      exec_.reduce_into("rigid_bounds", body.count, PointBox<Real>{rest}, empty_box<Real>(), JoinBoxes{},
                        rigid.bounds.data() + i);
    }
    std::vector<Box<Real>> boxes(bodies_.size());
    exec_.download(boxes.data(), rigid.bounds.data(), boxes.size() * sizeof(Box<Real>));
    for (size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i].rest = {convert<double>(boxes[i].lo), convert<double>(boxes[i].hi)};
      bodies_[i].start = bodies_[i].end = bodies_[i].target = {};
    }
  }

  void place(const RigidMove& move, bool first, bool is_ccd) {
    Body& body = body_of(move.mesh);
    const std::string field = "updates[" + std::to_string(move.update) + "].";
    if (move.start || first) {
      body.start = move.start.value_or(move.end);
      if (move.start) check_reach(field + "start_transform", body, body.start);
      if (has_paths()) transform(body, body.start, scene_.start.data());
    }
    body.end = body.target = move.end;
    check_reach(field + "transform", body, body.end);
    if (is_ccd) check_angle(field + "transform", body);
    transform(body, body.end, scene_.end.data());
  }
  void transform(const Body& body, const Pose& pose, Vec3<Real>* positions) {
    exec_.for_each(
        "transform_positions", body.count,
        TransformPositions<Real>(pose, scene_.rigid.rest.data() + body.first_rest, positions + body.first_vertex));
  }
  void check_reach(const std::string& field, const Body& body, const Pose& pose) const {
    const double reach = largest_coordinate(pose, body.rest);
    if (!(reach <= reach_limit_))
      throw InvalidInput(field, field + " puts vertices of mesh " + std::to_string(body.mesh) +
                                    " at coordinates of up to " + text(reach) + "; they must be at most " +
                                    text(reach_limit_) + " in magnitude");
  }
  void check_angle(const std::string& field, const Body& body) const {
    const double angle = angle_between(body.start, body.end);
    if (angle > kMaxAngle)
      throw InvalidInput(field, field + " turns mesh " + std::to_string(body.mesh) + " by " + text(angle) +
                                    " radians in one step, the limit is " + text(kMaxAngle) +
                                    ": divide the step, or give start_transform where the mesh jumps");
  }

  /// How far the bodies' arcs are from the step's paths, for the backend.
  void measure() {
    std::vector<double> deviations(shape_.spec.meshes.size() + 1, 0.0);
    for (const Body& body : bodies_) {
      deviations[body.mesh] = arc_deviation(body.start, body.end, body.rest, Precision<Real>::kUnit);
      deviations.back() = std::max(deviations.back(), deviations[body.mesh]);
    }
    if (deviations == deviations_) return;
    deviations_ = std::move(deviations);
    exec_.upload(scene_.rigid.deviations.data(), deviations_.data(), deviations_.size() * sizeof(double));
  }

  Exec& exec_;
  const SceneShape& shape_;
  SceneBuffers<Exec, Real>& scene_;
  std::vector<Body> bodies_;
  uint64_t rest_count_ = 0;
  const double reach_limit_ = reach_limit(shape_.spec);
  std::vector<double> deviations_;  ///< those on the backend
};

}  // namespace collided
