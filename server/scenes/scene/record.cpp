// The record of a scene: its identity, its visible state, its stream and watchers, and how it ended.
#include "server/scenes/scene/record.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "server/auth/secrets.hpp"
#include "server/errors.hpp"

namespace collided::server {
namespace {

uint64_t count_triangles(const ScenePlan& plan) {
  uint64_t triangles = 0;
  for (const MeshPlan& mesh : plan.meshes) triangles += mesh.triangles;
  return triangles;
}

}  // namespace

std::string SceneEnd::text(std::chrono::steady_clock::time_point now) const {
  if (!is_expired) return "was deleted";
  const double ago = std::max(0.0, std::chrono::duration<double>(now - when).count());
  return fmt::format(
      "was deleted, as its lease of {:g} s ran out {:g} s ago: create it again, or ask for a longer lease_seconds",
      lease_seconds, std::floor(ago));
}

SceneRecord::SceneRecord(SceneIdentity identity, ScenePlan plan)
    : identity_(std::move(identity)),
      excludes_rest_pairs_(std::ranges::any_of(plan.engine.meshes, &MeshSpec::excludes_rest_pairs)) {
  shown_.vertices = count_vertices(plan.engine);
  shown_.triangles = count_triangles(plan);
  shown_.plan = std::make_shared<const ScenePlan>(std::move(plan));
}

std::shared_ptr<const ScenePlan> SceneRecord::plan() const {
  const std::lock_guard lock(mutex_);
  return shown_.plan;
}

SceneSnapshot SceneRecord::snapshot() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}

bool SceneRecord::is_ready() const {
  const std::lock_guard lock(mutex_);
  return shown_.ready;
}

uint64_t SceneRecord::last_frame_id() const {
  const std::lock_guard lock(mutex_);
  return shown_.last_frame_id;
}

uint64_t SceneRecord::edits() const {
  const std::lock_guard lock(mutex_);
  return shown_.edits;
}

uint64_t SceneRecord::device_bytes() const {
  const std::lock_guard lock(mutex_);
  uint64_t bytes = 0;
  for (const auto& part : shown_.memory) bytes += part.bytes;
  return bytes;
}

std::string SceneRecord::mesh_name(uint32_t mesh) const {
  return fmt::format("mesh {} (\"{}\")", mesh, plan()->meshes[mesh].name);
}

void SceneRecord::check_is_one(const std::string& field) const {
  if (const uint32_t worlds = plan()->engine.worlds; worlds > 0)
    throw FailedPrecondition(field,
                             fmt::format("{}: scene {} is a set of {} scenes, whose frames come by DetectBatch or "
                                         "StreamFrames",
                                         field, id(), worlds));
}

// The caller holds the lock.
void SceneRecord::check_token(const std::string& token) const {
  if (token.empty() && stream_)
    throw FailedPrecondition("open.resume_token",
                             fmt::format("open.resume_token is empty, but another stream of scene {} is open", id()));
  if (!token.empty() && !is_equal_secret(token, identity_.resume_token))
    throw PermissionDenied("open.resume_token", fmt::format("open.resume_token is not the token of scene {}", id()));
}

std::shared_ptr<SceneStream> SceneRecord::begin_stream(const std::shared_ptr<SceneStream>& stream,
                                                       const std::string& token) {
  const std::lock_guard lock(mutex_);  // so that close() finds it
  check_open();
  check_token(token);
  return std::exchange(stream_, stream);
}

bool SceneRecord::would_take_over(const std::string& token) const {
  const std::lock_guard lock(mutex_);
  return stream_ && is_equal_secret(token, identity_.resume_token);
}

void SceneRecord::end_stream(const SceneStream& stream) {
  std::shared_ptr<SceneStream> ended;  // may be the last reference, which is dropped without the lock
  const std::lock_guard lock(mutex_);
  if (stream_.get() == &stream) ended.swap(stream_);
}

std::shared_ptr<SceneStream> SceneRecord::stream() const {
  const std::lock_guard lock(mutex_);
  return stream_;
}

void SceneRecord::begin_watch(std::shared_ptr<SceneWatcher> watcher) {
  check_is_one("scene_id");
  const std::lock_guard lock(mutex_);  // so that close() finds it
  check_open();
  watchers_.add(std::move(watcher));
}

void SceneRecord::close(const SceneEnd& end) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    end_ = end;
    closed_ = true;
  }
  const auto why = std::make_exception_ptr(NotFound("scene_id", fmt::format("scene {} {}", id(), end.text(end.when))));
  if (const auto open = stream()) open->end(why);
  for (const auto& watcher : watchers_.all()) watcher->end(why);
}

void SceneRecord::check_open() const {
  if (!closed_) return;
  throw NotFound("scene_id", fmt::format("scene {} {}", id(), end_.text(std::chrono::steady_clock::now())));
}

void SceneRecord::show(const Detector& detector, uint64_t host_bytes) {
  auto memory = detector.memory();
  memory.push_back({"host", host_bytes});
  const uint64_t edges = detector.topology().edges.size();
  auto device = detector.device().name;
  const std::lock_guard lock(mutex_);
  shown_.ready = true;
  shown_.device = std::move(device);
  shown_.edges = edges;
  shown_.memory = std::move(memory);
}

void SceneRecord::show_frame(uint64_t frame_id) {
  const std::lock_guard lock(mutex_);
  shown_.last_frame_id = frame_id;
}

void SceneRecord::show_edit(std::shared_ptr<const ScenePlan> plan, uint64_t vertices) {
  const std::lock_guard lock(mutex_);
  shown_.vertices = vertices;
  shown_.triangles = count_triangles(*plan);
  shown_.plan = std::move(plan);
  ++shown_.edits;
}

}  // namespace collided::server
