// Calls over credentials that tell whose connections they get.
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/auth/credentials.hpp"

namespace collided::server {
namespace {

/// Ends each call at once, and answers with its party as the status message.
class PartyService final : public grpc::CallbackGenericService {
  class Ended final : public grpc::ServerGenericBidiReactor {
   public:
    explicit Ended(const std::string& party) { Finish({grpc::StatusCode::ABORTED, party}); }
    void OnDone() override { delete this; }
  };
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* context) override {
    return new Ended(party_of(*context->auth_context()));
  }
};

class PartyServer {
 public:
  explicit PartyServer(const Party& party)
      : credentials_(make_plain_credentials([](const void*) { return true; }, party)) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", credentials_, &port_);
    builder.RegisterCallbackGenericService(&service_);
    server_ = builder.BuildAndStart();
  }
  ~PartyServer() { server_->Shutdown(std::chrono::system_clock::now()); }

  std::shared_ptr<grpc::Channel> channel() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port_), grpc::InsecureChannelCredentials(),
                                     arguments);
  }

 private:
  const std::shared_ptr<grpc::ServerCredentials> credentials_;
  PartyService service_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

std::string party_of_call(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, "/any/Method", grpc::ByteBuffer(), &queue);
  call->StartCall();
  grpc::ByteBuffer bytes;
  grpc::Status status;
  call->Finish(&bytes, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  return status.error_message();
}

TEST(PartyOfACall, IsThatOfItsConnection) {
  std::atomic<int> asked = 0;
  const PartyServer server([&] { return "uid:" + std::to_string(++asked); });
  const auto first = server.channel(), second = server.channel();
  const std::string of_first = party_of_call(first), of_second = party_of_call(second);
  EXPECT_EQ((std::set{of_first, of_second}), (std::set<std::string>{"uid:1", "uid:2"}));
  EXPECT_EQ(party_of_call(first), of_first);
  EXPECT_EQ(party_of_call(second), of_second);
}

TEST(PartyOfACall, IsTheSameForCallsAtOnce) {
  std::atomic<int> asked = 0;
  const PartyServer server([&] { return "uid:" + std::to_string(++asked); });
  const auto channel = server.channel();
  std::vector<std::jthread> threads;
  std::atomic<int> same = 0;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 50; ++k) same += party_of_call(channel) == "uid:1";
    });
  threads.clear();
  EXPECT_EQ(same, 400);
  EXPECT_EQ(asked, 1);
}

TEST(PartyOfACall, IsEmptyWhereNoneIsTold) {
  const PartyServer server(Party{});
  EXPECT_EQ(party_of_call(server.channel()), "");
}

}  // namespace
}  // namespace collided::server
