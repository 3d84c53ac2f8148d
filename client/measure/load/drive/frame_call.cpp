// One frame stream as a gRPC call.

#include "client/measure/load/drive/frame_call.hpp"

#include <grpcpp/impl/codegen/proto_utils.h>

namespace collided::cli::load {

namespace {

constexpr auto kMethod = "/collided.v1.CollisionService/StreamFrames";

}  // namespace

FrameCall::FrameCall(std::shared_ptr<grpc::Channel> channel, std::unique_ptr<grpc::ClientContext> context,
                     grpc::CompletionQueue& queue, void* owner)
    : started_{Event::kStarted, owner},
      written_{Event::kWritten, owner},
      read_{Event::kRead, owner},
      half_closed_{Event::kHalfClosed, owner},
      finished_{Event::kFinished, owner},
      channel_(std::move(channel)),
      context_(std::move(context)),
      call_(grpc::GenericStub(channel_).PrepareCall(context_.get(), kMethod, &queue)) {}

void FrameCall::write(const v1::OpenStream& open) {
  v1::StreamFramesRequest request;
  *request.mutable_open() = open;
  const grpc::Slice slice(request.SerializeAsString());
  write(grpc::ByteBuffer(&slice, 1));
}

bool FrameCall::parse(v1::StreamFramesResponse& message) {
  return grpc::SerializationTraits<v1::StreamFramesResponse>::Deserialize(&incoming_, &message).ok();
}

}  // namespace collided::cli::load
