// An upload of one mesh's triangles.
#include "server/scenes/upload.hpp"

#include <spdlog/fmt/fmt.h>

#include <utility>

#include "server/errors.hpp"
#include "server/scenes/scene.hpp"

namespace collided::server {

Upload::Upload(std::function<void(const std::exception_ptr&)> fail, Clock::time_point now)
    : fail_(std::move(fail)), last_chunk_(now) {}

Upload::~Upload() = default;

void Upload::wait(const std::function<void()>& read) {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kOver) return;
  state_ = State::kWaiting;
  read();
}

bool Upload::receive(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kOver) return false;
  state_ = State::kWorking;
  last_chunk_ = now;
  return true;
}

bool Upload::end() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(state_, State::kOver) == State::kOver) return false;
  release();
  return true;
}

void Upload::end_if_stale(Clock::time_point now, std::chrono::duration<double> limit) {
  std::exception_ptr why;
  {
    const std::lock_guard lock(mutex_);
    if (state_ == State::kWaiting) why = stale_reason(now, limit);
    if (!why) return;
    state_ = State::kOver;
    release();
  }
  fail_(why);
}

std::exception_ptr Upload::stale_reason(Clock::time_point now, std::chrono::duration<double> limit) const {
  try {
    if (scene_) (*scene_)->record().check_open();
    if (now - last_chunk_ > limit)
      throw TimedOut("triangles", fmt::format("triangles: no chunk of the upload arrived for {} s; the scene is "
                                              "unchanged",
                                              limit.count()));
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

// Frees the mesh and the memory before the client is told, so that it can retry at once.
void Upload::release() {
  triangles_.reset();
  if (scene_) (*scene_)->uploads().end(mesh_);
  scene_.reset();
  ticket_.reset();
}

void Upload::begin(const SceneUse& scene, uint32_t mesh, std::shared_ptr<void> ticket) {
  const size_t meshes = scene->plan()->meshes.size();
  if (mesh >= meshes) throw InvalidInput("mesh", fmt::format("mesh is {}, but the scene has {} meshes", mesh, meshes));
  // What may fail comes first: a mesh that is reserved is released with scene_.
  auto triangles = std::make_unique<ReceivedTriangles>(scene->quota());
  auto use = std::make_unique<SceneUse>(scene);
  scene->uploads().begin(mesh);
  mesh_ = mesh;
  triangles_ = std::move(triangles);
  scene_ = std::move(use);
  ticket_ = std::move(ticket);
}

Scene* Upload::scene() const { return scene_ ? &**scene_ : nullptr; }

std::string Upload::mesh_name() const { return (*scene_)->record().mesh_name(mesh_); }

void Upload::reserve(uint64_t count) {
  const uint64_t awaited = (*scene_)->uploads().awaited(mesh_), come = triangles_->size() + count;
  if (come > awaited)
    throw InvalidInput("triangles", fmt::format("triangles has {} or more, but the mesh awaits {}", come, awaited));
  triangles_->reserve(count);
}

void OpenUploads::add(const std::shared_ptr<Upload>& upload) {
  const std::lock_guard lock(mutex_);
  std::erase_if(uploads_, [](const auto& other) { return other.expired(); });
  uploads_.push_back(upload);
}

void OpenUploads::end_stale(Upload::Clock::time_point now, std::chrono::duration<double> limit) {
  std::vector<std::shared_ptr<Upload>> open;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(uploads_, [](const auto& other) { return other.expired(); });
    for (const auto& upload : uploads_)
      if (auto alive = upload.lock()) open.push_back(std::move(alive));
  }
  for (const auto& upload : open) upload->end_if_stale(now, limit);
}

}  // namespace collided::server
