// A scene and its stream that survive the loss of the connection, and of the daemon.

#include "client/cpp/session.hpp"

#include <grpcpp/support/status_code_enum.h>

#include <utility>

#include "client/cpp/positions.hpp"
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
  if (options.advance && is_quantized(format))
    refuse("options.advance", "is set, and where it ends cannot be encoded as Q16; use a stream, or F32");
}

}  // namespace

Session::Session(std::shared_ptr<State> state) : state_(std::move(state)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&& other) noexcept {
  const Session before(std::move(*this));
  state_ = std::move(other.state_);
  return *this;
}
Session::~Session() {
  if (state_) state_->end();
}

Session Session::open(const std::string& address, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options) {
  return Session(State::begin(ChannelFactory(address, options.connect), spec, meshes, options));
}

Session Session::open(const Client& client, const v1::SceneSpec& spec, std::span<const MeshInput> meshes,
                      const SessionOptions& options) {
  return Session(State::begin(client.channels(), spec, meshes, options));
}

FrameOutput Session::detect(std::span<const FrameUpdate> updates, const FrameOptions& options) {
  if (state_->is_own_thread())
    throw Error(grpc::FAILED_PRECONDITION, "detect() would wait for the function that calls it; use submit()");
  return submit(updates, options).get();
}

std::future<FrameOutput> Session::submit(std::span<const FrameUpdate> updates, const FrameOptions& options) {
  const auto answer = std::make_shared<std::promise<FrameOutput>>();  // a function can be copied
  submit(
      updates,
      [answer](FrameResult result) {
        if (result.ok())
          answer->set_value(std::move(result.output()));
        else
          answer->set_exception(std::make_exception_ptr(*result.error()));
      },
      options);
  return answer->get_future();
}

void Session::submit(std::span<const FrameUpdate> updates, std::function<void(FrameResult)> done,
                     const FrameOptions& options) {
  if (!done) refuse("done", "is null; it is called with the frame's result");
  check_repeatable(options, state_->connector.input().spec().position_format());
  state_->submit(OwnedFrame(updates, options), std::move(done));
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
