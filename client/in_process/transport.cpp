// A frame stream in this process: frames and answers are handed over, not encoded.

#include <grpcpp/support/status_code_enum.h>

#include <utility>

#include "client/cpp/frame_options.hpp"
#include "client/in_process/daemon.hpp"
#include "client/in_process/failure.hpp"

namespace collided::client {

namespace {

using server::InProcessStream;

class InProcessTransport final : public FrameTransport {
 public:
  explicit InProcessTransport(std::shared_ptr<const DaemonHere> daemon) : daemon_(std::move(daemon)) {}
  ~InProcessTransport() override {
    if (stream_) stream_->cancel();
  }

  bool open(const v1::OpenStream& open) override try {
    stream_ = daemon_->server().open(open);
    return true;
  } catch (...) {
    refusal_ = server::describe_current();
    return true;
  }

  std::span<std::byte> input(uint64_t bytes) override {
    return as_errors([&] { return stream_->input(bytes); });
  }

  bool send(const v1::Frame& frame, std::span<const FrameUpdate> updates) override {
    server::LentFrame lent;
    lent.arrays.resize(static_cast<size_t>(frame.updates_size()));  // those are in the message
    if (frame.updates_size() > 0)
      lent.message = frame;
    else
      copy_head(frame, lent.message);
    for (const FrameUpdate& update : updates) {
      add(update, *lent.message.add_updates());
      lent.arrays.push_back({update.start_positions, update.positions, update.indices});
    }
    return as_errors([&] { return stream_->submit(std::move(lent)); });
  }

  Arrival read(v1::StreamFramesResponse& response, Time deadline) override {
    if (!stream_) return Arrival::kEnd;
    switch (stream_->read(answer_, deadline)) {
      case InProcessStream::Arrival::kNothing:
        return Arrival::kNothing;
      case InProcessStream::Arrival::kEnd:
        return Arrival::kEnd;
      case InProcessStream::Arrival::kMessage:
        break;
    }
    response = std::move(answer_.message);
    return Arrival::kMessage;
  }

  /// Of the answer that was read last.
  std::span<const std::byte> shared(const v1::SharedRange& range) const override {
    return {reinterpret_cast<const std::byte*>(range.offset()), range.size()};
  }

  void half_close() override { stream_->half_close(); }
  void cancel() override {
    if (stream_) stream_->cancel();
  }
  std::optional<Error> finish() override { return error_of(server::to_status(stream_ ? stream_->end() : refusal_)); }

 private:
  static void add(const FrameUpdate& update, v1::MeshUpdate& out) {
    out.set_mesh(update.mesh);
    if (!update.indices.empty()) out.mutable_sparse();
    if (update.transform) out.mutable_rigid()->set_matrix(update.transform->data(), sizeof(RigidMatrix));
    if (update.start_transform)
      out.mutable_rigid()->set_start_matrix(update.start_transform->data(), sizeof(RigidMatrix));
  }

  const std::shared_ptr<const DaemonHere> daemon_;
  std::shared_ptr<InProcessStream> stream_;  // null if it was refused
  server::Failure refusal_;
  server::InProcessAnswer answer_;  // the reader's
};

}  // namespace

std::unique_ptr<FrameTransport> DaemonHere::transport() const {
  return std::make_unique<InProcessTransport>(shared_from_this());
}

}  // namespace collided::client
