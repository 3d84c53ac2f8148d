// A unary call as raw messages.
#include "server/transport/grpc/unary_call.hpp"

#include <utility>

namespace collided::server {

// The client may take its answer late: until then only its bytes are kept.
void UnaryCallBase::finish() {
  auto answer_share = parts_.budget.take(caller().client, response_message().ByteSizeLong());
  bytes_ = to_bytes(response_message());
  forget_messages();
  share_ = std::move(answer_share);
  StartWriteAndFinish(&bytes_, grpc::WriteOptions(), grpc::Status::OK);
}

}  // namespace collided::server
