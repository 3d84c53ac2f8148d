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
#include "gpu/boxes/boxes.hpp"
#include "gpu/positions/checks.hpp"
#include "gpu/positions/rigid_arc.hpp"
#include "gpu/positions/slot.hpp"
#include "gpu/state/buffers.hpp"

namespace collided {

/// Box of a position, to be joined with others'.
template <class Real>
struct PointBox {
  const Vec3<Real>* points;
  COLLIDED_HD Box<Real> operator()(uint64_t i) const { return {points[i], points[i]}; }
};

/// Where a rigid mesh's vertices are among the scene's, and among those at rest.
struct RigidPlace {
  uint32_t mesh, first_vertex, count;
  uint64_t first_rest;
};
struct RigidPoses {
  bool is_placed = false;  ///< a frame that counted has brought the positions at rest
  Box<double> rest = {};
  Pose start = {}, end = {};  ///< of the step in work, or of the last one
  Pose target = {};           ///< where the step in work would end
  Pose good = {};             ///< of the last good frame
};
struct RigidBody : RigidPlace, RigidPoses {};

template <Executor Exec, class Real>
class RigidMeshes {
 public:
  /// All that is known of them on the host.
  struct State {
    std::vector<RigidBody> bodies;
    uint64_t rest_count = 0;
    std::vector<double> deviations;  ///< those on the backend
    bool tells_turns = false;        ///< the backend knows of meshes that turn
  };

  /// Beyond this the shorter way round could be meant, or the longer.
  static constexpr double kMaxAngle = 3;

  RigidMeshes(Exec& exec, const SceneShape& shape, SceneBuffers<Exec, Real>& scene)
      : exec_(exec), shape_(shape), scene_(scene) {
    list_bodies();
  }

  const State& state() const { return state_; }
  void restore(State state) { state_ = std::move(state); }
  /// The scene's meshes and buffers are those of an edit, which leaves all but the `first` ones where they were.
  void edit(const State& before, const Buffer<Vec3<Real>, Exec>& rest_before, const FirstMeshes& first) {
    state_ = {};
    list_bodies();
    require();
    for (RigidBody& body : state_.bodies) {
      if (first[body.mesh]) continue;
      const RigidBody& old = *find(before.bodies, body.mesh);
      exec_.copy(rest_of(body), rest_before.data() + old.first_rest, uint64_t{body.count} * sizeof(Vec3<Real>));
      static_cast<RigidPoses&>(body) = old;
    }
  }

  /// Memory for a frame.
  void require() {
    if (bodies().empty()) return;
    scene_.rigid.rest.allocate(state_.rest_count);
    scene_.rigid.bounds.allocate(bodies().size());
    if (!has_paths()) return;
    const size_t meshes = shape_.spec.meshes.size();
    if (!state_.deviations.empty()) return;
    scene_.rigid.first_vertex.allocate(meshes);
    scene_.rigid.deviations.allocate(meshes + 1);
    exec_.upload(scene_.rigid.first_vertex.data(), shape_.vertex_offset.data(), meshes * sizeof(uint32_t));
  }

  /// Where the step begins: where the last good frame ended, or so far along the last frame's way, where the meshes'
  /// positions at the start go, too.
  void begin(const std::optional<double>& start_fraction) {
    for (RigidBody& body : bodies()) {
      body.start = start_fraction ? pose_along(body.start, body.end, *start_fraction) : body.good;
      body.end = body.target = body.start;
      if (!start_fraction) continue;
      transform(body, body.start, scene_.start.data());
      transform(body, body.start, scene_.end.data());
    }
  }
  /// Puts the frame's moves in `start` and `end`, where the slot has put positions.
  void place(const std::vector<RigidMove>& moves, bool is_ccd) {
    if (bodies().empty()) return;
    keep_rest();
    for (const RigidMove& move : moves) place(move, is_ccd);
    if (is_ccd) measure();
  }
  /// The same ends in other positions that the slot has put its own into.
  void place_ends(const std::vector<RigidMove>& moves, Vec3<Real>* positions) {
    for (const RigidMove& move : moves) transform(*find(bodies(), move.mesh), move.end, positions);
  }

  bool has_any() const { return !state_.bodies.empty(); }
  /// Goes a part of the step's way, with poses and positions. fraction_of(mesh): from 0 to 1.
  template <class FractionOf>
  void go(const FractionOf& fraction_of) {
    for (RigidBody& body : bodies()) {
      body.end = pose_along(body.start, body.target, fraction_of(body.mesh));
      transform(body, body.end, scene_.end.data());
    }
    tell_turns();
  }
  /// Tells the backend how meshes turn on the way from `start` to `end`. As long as none has turned, it is told
  /// nothing.
  void tell_turns() {
    const bool none_turns = !turning();
    if (none_turns && !state_.tells_turns) return;
    MemoryHold making(shape_.spec.memory_quota);
    making.resize(shape_.spec.meshes.size() * sizeof(MeshTurn));
    std::vector<MeshTurn> turns(shape_.spec.meshes.size());
    for (const RigidBody& body : bodies()) turns[body.mesh] = mesh_turn<Real>(body.start, body.end, body.rest);
    scene_.rigid.turns.allocate(turns.size());
    exec_.upload(scene_.rigid.turns.data(), turns.data(), turns.size() * sizeof(MeshTurn));
    exec_.wait();
    state_.tells_turns = !none_turns;
  }
  /// Returns a distance that vertices on the step's way are within of the straight lines between its ends' positions,
  /// besides what the last rounding to Real explains, if their mesh does not turn.
  double off_straight() const {
    double off = 0;
    for (const RigidBody& body : state_.bodies) {
      double largest = max(largest_component(body.rest.lo), largest_component(body.rest.hi));
      for (size_t i = 3; i < body.start.rows.size(); i += 4)
        largest = std::max({largest, std::abs(body.start.rows[i]), std::abs(body.target.rows[i])});
      // Each of both ends and the point between takes a few roundings of sums of four numbers up to this.
      if (body.start.rows != body.target.rows) off = std::max(off, 64 * Precision<double>::kUnit * largest);
    }
    return off;
  }
  void commit() {
    for (RigidBody& body : bodies()) body.good = body.end, body.is_placed = true;
  }

  /// A mesh that turns in the step in work, or turned in the last one.
  std::optional<uint32_t> turning() const {
    const auto found = std::find_if(state_.bodies.begin(), state_.bodies.end(),
                                    [](const RigidBody& body) { return !body.start.has_rotation_of(body.end); });
    return found == state_.bodies.end() ? std::nullopt : std::optional(found->mesh);
  }

 private:
  bool has_paths() const { return shape_.spec.mode != Mode::kDcd; }
  std::vector<RigidBody>& bodies() { return state_.bodies; }
  void list_bodies() {
    for (uint32_t mesh = 0; mesh < shape_.spec.meshes.size(); ++mesh) {
      if (shape_.spec.meshes[mesh].motion != MeshMotion::kRigid) continue;
      const uint32_t count = shape_.spec.meshes[mesh].vertex_count;
      bodies().push_back({{mesh, shape_.vertex_offset[mesh], count, state_.rest_count}, {}});
      state_.rest_count += count;
    }
  }
  template <class Bodies>
  static auto find(Bodies& bodies, uint32_t mesh) {
    return std::lower_bound(bodies.begin(), bodies.end(), mesh,
                            [](const RigidBody& body, uint32_t wanted) { return body.mesh < wanted; });
  }
  Vec3<Real>* rest_of(const RigidBody& body) const { return scene_.rigid.rest.data() + body.first_rest; }

  /// Of the meshes that have their first positions in this frame.
  void keep_rest() {
    const auto is_placed = [](const RigidBody& body) { return body.is_placed; };
    if (std::all_of(bodies().begin(), bodies().end(), is_placed)) return;
    Box<Real>* bounds = scene_.rigid.bounds.data();
    for (size_t i = 0; i < bodies().size(); ++i) {
      const RigidBody& body = bodies()[i];
      if (!body.is_placed)
        exec_.copy(rest_of(body), scene_.end.data() + body.first_vertex, uint64_t{body.count} * sizeof(Vec3<Real>));
      exec_.reduce_into("rigid_bounds", body.count, PointBox<Real>{rest_of(body)}, empty_box<Real>(), JoinBoxes{},
                        bounds + i);
    }
    std::vector<Box<Real>> boxes(bodies().size());
    exec_.download(boxes.data(), bounds, boxes.size() * sizeof(Box<Real>));
    for (size_t i = 0; i < bodies().size(); ++i) {
      if (bodies()[i].is_placed) continue;
      static_cast<RigidPoses&>(bodies()[i]) = {};
      bodies()[i].rest = {convert<double>(boxes[i].lo), convert<double>(boxes[i].hi)};
    }
  }

  void place(const RigidMove& move, bool is_ccd) {
    RigidBody& body = *find(bodies(), move.mesh);
    const std::string field = "updates[" + std::to_string(move.update) + "].";
    if (move.start || !body.is_placed) {
      body.start = move.start.value_or(move.end);
      if (move.start) check_reach(field + "start_transform", body, body.start);
      if (has_paths()) transform(body, body.start, scene_.start.data());
    }
    body.end = body.target = move.end;
    check_reach(field + "transform", body, body.end);
    if (is_ccd) check_angle(field + "transform", body);
    transform(body, body.end, scene_.end.data());
  }
  void transform(const RigidBody& body, const Pose& pose, Vec3<Real>* positions) {
    exec_.for_each("transform_positions", body.count,
                   TransformPositions<Real>(pose, rest_of(body), positions + body.first_vertex));
  }
  void check_reach(const std::string& field, const RigidBody& body, const Pose& pose) const {
    const double reach = largest_coordinate(pose, body.rest);
    if (!(reach <= reach_limit_))
      throw InvalidInput(field, field + " puts vertices of mesh " + std::to_string(body.mesh) +
                                    " at coordinates of up to " + text(reach) + "; they must be at most " +
                                    text(reach_limit_) + " in magnitude");
  }
  void check_angle(const std::string& field, const RigidBody& body) const {
    const double angle = angle_between(body.start, body.end);
    if (angle > kMaxAngle)
      throw InvalidInput(field, field + " turns mesh " + std::to_string(body.mesh) + " by " + text(angle) +
                                    " radians in one step, the limit is " + text(kMaxAngle) +
                                    ": divide the step, or give start_transform where the mesh jumps");
  }

  /// How far the bodies' arcs are from the step's paths, for the backend.
  void measure() {
    std::vector<double> deviations(shape_.spec.meshes.size() + 1, 0.0);
    for (const RigidBody& body : bodies()) {
      deviations[body.mesh] = arc_deviation<Real>(body.start, body.end, body.rest);
      deviations.back() = std::max(deviations.back(), deviations[body.mesh]);
    }
    if (deviations == state_.deviations) return;
    state_.deviations = std::move(deviations);
    exec_.upload(scene_.rigid.deviations.data(), state_.deviations.data(), state_.deviations.size() * sizeof(double));
  }

  Exec& exec_;
  const SceneShape& shape_;
  SceneBuffers<Exec, Real>& scene_;
  State state_;
  const double reach_limit_ = reach_limit(shape_.spec);
};

}  // namespace collided
