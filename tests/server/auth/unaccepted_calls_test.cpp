// A gRPC server that is late to accept its calls, as on a machine that is starved of CPU.
#include "server/limits/unaccepted_calls.hpp"

#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <thread>

#include "server/auth/credentials.hpp"

namespace collided::server {
namespace {

constexpr size_t kMax = 8;

class LateServer {
 public:
  LateServer() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", credentials_, &port_);
    builder.RegisterAsyncGenericService(&service_);
    queue_ = builder.AddCompletionQueue();
    server_ = builder.BuildAndStart();
    thread_ = std::thread([this] { run(); });
  }
  ~LateServer() {
    server_->Shutdown(std::chrono::system_clock::now());
    queue_->Shutdown();
    thread_.join();
  }

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  size_t waiting() const { return unaccepted_.waiting(); }
  /// Accepts as many calls, which have arrived or will, and ends them.
  void accept(size_t count) {
    for (size_t i = 0; i < count; ++i) {
      Call& call = calls_.emplace_back();
      service_.RequestCall(&call.context, &call.stream, queue_.get(), queue_.get(), &call);
    }
  }

 private:
  struct Call {
    grpc::GenericServerContext context;
    grpc::GenericServerAsyncReaderWriter stream{&context};
    bool is_accepted = false;
  };

  void run() {
    void* tag = nullptr;
    for (bool ok = false; queue_->Next(&tag, &ok);) {
      Call& call = *static_cast<Call*>(tag);
      if (!ok || std::exchange(call.is_accepted, true)) continue;
      unaccepted_.accept(connection_of(*call.context.auth_context()));
      call.stream.Finish(grpc::Status::OK, &call);
    }
  }

  UnacceptedCalls unaccepted_{kMax, 1024};
  const std::shared_ptr<grpc::ServerCredentials> credentials_ =
      make_plain_credentials([this](const void* connection) { return unaccepted_.arrive(connection); });
  grpc::AsyncGenericService service_;
  std::deque<Call> calls_;
  int port_ = 0;
  std::unique_ptr<grpc::ServerCompletionQueue> queue_;
  std::unique_ptr<grpc::Server> server_;
  std::thread thread_;
};

/// Calls over one connection.
class Calls {
 public:
  explicit Calls(const std::string& address) : stub_(channel_to(address)) {}
  ~Calls() {
    queue_.Shutdown();
    void* tag = nullptr;
    for (bool ok = false; queue_.Next(&tag, &ok);) continue;
  }

  void begin(size_t count) {
    for (size_t i = 0; i < count; ++i) {
      Call& call = calls_.emplace_back();
      call.answer = stub_.PrepareUnaryCall(&call.context, "/any/Method", grpc::ByteBuffer(), &queue_);
      call.answer->StartCall();
      call.answer->Finish(&call.bytes, &call.status, &call);
    }
  }
  void cancel() {
    for (Call& call : calls_) call.context.TryCancel();
  }
  /// The status of the next call that ends.
  grpc::StatusCode next() {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue_.Next(&tag, &ok));
    return static_cast<Call*>(tag)->status.error_code();
  }

 private:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncResponseReader> answer;
    grpc::ByteBuffer bytes;
    grpc::Status status;
  };

  static std::shared_ptr<grpc::Channel> channel_to(const std::string& address) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  }

  grpc::GenericStub stub_;
  std::deque<Call> calls_;
  grpc::CompletionQueue queue_;
};

TEST(UnacceptedCallsOfAServer, AreRefusedBeyondTheLimitAndOthersAreServed) {
  constexpr size_t kFlood = 1000;
  LateServer server;
  Calls flood(server.address()), honest(server.address());
  flood.begin(kFlood);
  for (size_t i = kMax; i < kFlood; ++i) ASSERT_EQ(flood.next(), grpc::StatusCode::RESOURCE_EXHAUSTED) << i;
  EXPECT_EQ(server.waiting(), kMax);
  honest.begin(1);
  server.accept(kMax + 1);
  EXPECT_EQ(honest.next(), grpc::StatusCode::OK);
  for (size_t i = 0; i < kMax; ++i) EXPECT_EQ(flood.next(), grpc::StatusCode::OK);
  EXPECT_EQ(server.waiting(), 0u);
}

// gRPC keeps them until they are accepted.
TEST(UnacceptedCallsOfAServer, CountWhenTheirClientHasResetThem) {
  LateServer server;
  Calls calls(server.address());
  calls.begin(kMax + 1);
  EXPECT_EQ(calls.next(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  calls.cancel();
  for (size_t i = 0; i < kMax; ++i) EXPECT_EQ(calls.next(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(server.waiting(), kMax);
  calls.begin(1);
  EXPECT_EQ(calls.next(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  server.accept(kMax + 1);
  calls.begin(1);
  grpc::StatusCode last = calls.next();
  for (int i = 0; last != grpc::StatusCode::OK && i < 1000; ++i) {  // until the server has accepted one
    calls.begin(1);
    last = calls.next();
  }
  EXPECT_EQ(last, grpc::StatusCode::OK);
}

}  // namespace
}  // namespace collided::server
