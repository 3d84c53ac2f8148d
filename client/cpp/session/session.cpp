// A scene and its stream that survive the loss of the connection, and of the daemon.

#include "client/cpp/session.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <utility>

#include "client/cpp/session/session_state.hpp"

namespace collided::client {

namespace {

[[noreturn]] void refuse(const std::string& field, const std::string& why) {
  throw Error(grpc::INVALID_ARGUMENT, field + " " + why, field);
}

/// Such frames depend on more than positions that a session can name.
void check_repeatable(const FrameOptions& options, v1::PositionFormat format) {
  if (options.edit) refuse("options.edit", "is set, which a session cannot restore; use a stream");
  if (options.from_last_fraction)
    refuse("options.from_last_fraction", "is set, which a session cannot restore; use a stream");
  if (options.advance && format == v1::POSITION_FORMAT_Q16)
    refuse("options.advance", "is set, and where it ends cannot be encoded as Q16; use a stream, or F32");
}

}  // namespace

Session::Session(std::unique_ptr<State> state) : state_(std::move(state)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Session Session::open(const std::string& address, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options) {
  return Session(std::make_unique<State>(ChannelFactory(address, options.connect), spec, meshes, options));
}

Session Session::open(const Client& client, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options) {
  return Session(std::make_unique<State>(client.channels(), spec, meshes, options));
}

FrameOutput Session::detect(std::span<const FrameUpdate> updates, const FrameOptions& options) {
  return submit(updates, options).get();
}

std::future<FrameOutput> Session::submit(std::span<const FrameUpdate> updates, const FrameOptions& options) {
  check_repeatable(options, state_->connector.input().spec().position_format());
  return state_->submit(OwnedFrame(updates, options));
}

void Session::close() {
  if (state_->stop()) state_->connector.remove(state_->scene);
}

v1::Scene Session::scene() const {
  const std::lock_guard lock(state_->mutex);
  return state_->scene;
}
uint32_t Session::window() const { return state_->window; }
uint64_t Session::reconnects() const {
  const std::lock_guard lock(state_->mutex);
  return state_->reconnects;
}
uint64_t Session::recreations() const {
  const std::lock_guard lock(state_->mutex);
  return state_->recreations;
}

}  // namespace collided::client
