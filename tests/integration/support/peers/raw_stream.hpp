#pragma once
// Any call of any method with messages of arbitrary bytes, valid or not.

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/integration/support/calls.hpp"

namespace collided::test {

inline std::string method_path(const std::string& method) { return "/collided.v1.CollisionService/" + method; }

/// A call with a deadline, one operation at a time.
class RawStream {
 public:
  using Metadata = std::vector<std::pair<std::string, std::string>>;

  RawStream(const std::shared_ptr<grpc::Channel>& channel, const std::string& path, const Metadata& metadata = {},
            grpc_compression_algorithm compression = GRPC_COMPRESS_NONE)
      : stub_(channel) {
    set_deadline(context_);
    for (const auto& [key, value] : metadata) context_.AddMetadata(key, value);
    context_.set_compression_algorithm(compression);
    call_ = stub_.PrepareCall(&context_, path, &queue_);
    call_->StartCall(this);
    wait();
  }
  ~RawStream() {
    if (!is_over_) {
      context_.TryCancel();
      finish();
    }
    queue_.Shutdown();
    wait();
  }

  /// False if the call is over.
  bool write(const std::string& bytes) {
    const grpc::Slice slice(bytes);
    call_->Write(grpc::ByteBuffer(&slice, 1), this);
    return wait();
  }
  bool writes_done() {
    call_->WritesDone(this);
    return wait();
  }
  bool read(std::string* bytes) {
    grpc::ByteBuffer buffer;
    call_->Read(&buffer, this);
    if (!wait()) return false;
    grpc::Slice slice;
    EXPECT_TRUE(buffer.DumpToSingleSlice(&slice).ok());
    bytes->assign(reinterpret_cast<const char*>(slice.begin()), slice.size());
    return true;
  }
  /// How the daemon ends the call.
  grpc::Status finish() {
    grpc::Status status;
    call_->Finish(&status, this);
    wait();
    is_over_ = true;
    return status;
  }

 private:
  bool wait() {
    void* tag = nullptr;
    bool ok = false;
    return queue_.Next(&tag, &ok) && ok;
  }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call_;
  bool is_over_ = false;
};

/// One message each way.
inline grpc::Status raw_call(const std::shared_ptr<grpc::Channel>& channel, const std::string& path,
                             const std::string& request, const RawStream::Metadata& metadata = {},
                             grpc_compression_algorithm compression = GRPC_COMPRESS_NONE) {
  RawStream call(channel, path, metadata, compression);
  if (call.write(request)) call.writes_done();
  for (std::string unread; call.read(&unread);) continue;
  return call.finish();
}

}  // namespace collided::test
