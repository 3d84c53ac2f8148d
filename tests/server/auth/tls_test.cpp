// TLS over real sockets, with certificates that openssl makes.
#include <grpcpp/generic/async_generic_service.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "server/auth/credentials.hpp"
#include "server/auth/tls_files.hpp"
#include "server/transport/grpc/caller.hpp"
#include "tests/server/auth/certificates.hpp"

namespace collided::server {
namespace {

using test::Certificates;

// Answers every call with the name of its client as the error message.
class TellName final : public grpc::CallbackGenericService {
 public:
  explicit TellName(const Config& config) : authenticator_(config) {}
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* context) override {
    return new Reactor(identify(*context, authenticator_).client->name);
  }

 private:
  const Authenticator authenticator_;
  struct Reactor final : grpc::ServerGenericBidiReactor {
    explicit Reactor(const std::string& name) { Finish({grpc::StatusCode::NOT_FOUND, name}); }
    void OnDone() override { delete this; }
  };
};

class TlsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { certificates_ = new Certificates; }
  static void TearDownTestSuite() { delete certificates_; }

  static std::string path(const std::string& name) { return certificates_->path(name); }
  static Tls tls(const std::string& name, const std::string& client_ca = "") {
    return {path(name + ".pem"), path(name + ".key"), client_ca.empty() ? "" : path(client_ca)};
  }

  // `tell`: called for changed files.
  void start(
      const Tls& tls, std::function<void(bool)> tell = [](bool) {}) {
    watch_ = std::make_unique<CertificateWatch>(tls, std::move(tell));
    credentials_ = make_credentials(*watch_, [](const void*) { return true; });
    Config config;
    config.tls = tls;
    service_ = std::make_unique<TellName>(config);
    grpc::ServerBuilder builder;
    builder.RegisterCallbackGenericService(service_.get());
    builder.AddListeningPort("localhost:0", credentials_, &port_);
    server_ = builder.BuildAndStart();
    ASSERT_NE(server_, nullptr);
  }
  void TearDown() override {
    if (server_) server_->Shutdown(std::chrono::system_clock::now());
    server_.reset();
  }

  grpc::Status call(const std::shared_ptr<grpc::ChannelCredentials>& credentials) const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a handshake each time
    const auto channel = grpc::CreateCustomChannel("localhost:" + std::to_string(port_), credentials, arguments);
    grpc::GenericStub stub(channel);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    grpc::ByteBuffer request, response;
    grpc::CompletionQueue queue;
    const auto rpc = stub.PrepareUnaryCall(&context, "/a/b", request, &queue);
    grpc::Status status;
    rpc->StartCall();
    rpc->Finish(&response, &status, nullptr);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    return status;
  }
  // `client`: whose certificate to present; empty: none.
  grpc::Status call(const std::string& ca, const std::string& client) const {
    grpc::SslCredentialsOptions options;
    options.pem_root_certs = certificates_->read(ca);
    if (!client.empty()) {
      options.pem_cert_chain = certificates_->read(client + ".pem");
      options.pem_private_key = certificates_->read(client + ".key");
    }
    return call(grpc::SslCredentials(options));
  }

  static Certificates* certificates_;
  std::unique_ptr<CertificateWatch> watch_;
  std::shared_ptr<grpc::ServerCredentials> credentials_;
  std::unique_ptr<TellName> service_;
  std::unique_ptr<grpc::Server> server_;
  int port_ = 0;
};

Certificates* TlsTest::certificates_ = nullptr;

template <class Condition>
bool wait_until(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

TEST_F(TlsTest, ServesItsCertificate) {
  start(tls("server"));
  EXPECT_EQ(call("ca.pem", "").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(call("ca.pem", "").error_message(), "anonymous");
  EXPECT_EQ(call("other-ca.pem", "").error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(call(grpc::InsecureChannelCredentials()).error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(TlsTest, ClientsNeedACertificateOfTheCa) {
  start(tls("server", "ca.pem"));
  const auto good = call("ca.pem", "client");
  EXPECT_EQ(good.error_code(), grpc::StatusCode::NOT_FOUND) << good.error_message();
  EXPECT_EQ(good.error_message(), "sim-1");
  for (const auto* client : {"", "stranger", "expired", "self-signed"})
    EXPECT_EQ(call("ca.pem", client).error_code(), grpc::StatusCode::UNAVAILABLE) << client;
  EXPECT_EQ(call(grpc::InsecureChannelCredentials()).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(call("ca.pem", "client").error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(TlsTest, ACertificateWithoutACommonNameIsKnownByItsAlternativeName) {
  start(tls("server", "ca.pem"));
  EXPECT_EQ(call("ca.pem", "alternative").error_message(), "san:sim-4.example");
}

// Both are from a CA that the daemon trusts; omitting the name must not turn a client into another.
TEST_F(TlsTest, NamesOfDifferentKindsAreDifferentClients) {
  start(tls("server", "ca.pem"));
  certificates_->make_named("common", "/CN=alice", "other.example", "ca");
  certificates_->make_named("alternative-alice", "/O=robots", "alice", "ca");
  certificates_->make_named("prefixed", "/CN=san:alice", "other.example", "ca");
  EXPECT_EQ(call("ca.pem", "common").error_message(), "alice");
  EXPECT_EQ(call("ca.pem", "alternative-alice").error_message(), "san:alice");
  EXPECT_EQ(call("ca.pem", "prefixed").error_message(), "cn:san:alice");
}

TEST_F(TlsTest, TakesUpARenewedCertificate) {
  certificates_->copy("server", "renewed");
  start(tls("renewed", "ca.pem"));
  EXPECT_EQ(call("ca.pem", "client").error_code(), grpc::StatusCode::NOT_FOUND);
  certificates_->copy("other-server", "renewed");
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (call("other-ca.pem", "client").error_code() != grpc::StatusCode::NOT_FOUND) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(call("ca.pem", "client").error_code(), grpc::StatusCode::UNAVAILABLE);
}

// A full disk, a truncated copy, a pair of which only one half was renewed.
TEST_F(TlsTest, KeepsTheLastGoodFiles) {
  certificates_->copy("server", "kept");
  std::filesystem::copy_file(path("ca.pem"), path("kept-ca.pem"));
  std::atomic<int> taken = 0, refused = 0;
  start(tls("kept", "kept-ca.pem"), [&](bool is_taken) { ++(is_taken ? taken : refused); });
  const std::string good = certificates_->read("server.pem"), ca = certificates_->read("ca.pem");
  const auto put = [&](const std::string& name, const std::string& text) { std::ofstream(path(name)) << text; };
  const std::pair<const char*, std::string> bad[] = {{"kept.pem", ""},
                                                     {"kept.pem", good.substr(0, good.size() / 2)},
                                                     {"kept.pem", certificates_->read("client.pem")},
                                                     {"kept-ca.pem", ca + good.substr(0, good.size() / 2)}};
  int count = 0;
  for (const auto& [name, text] : bad) {
    const std::string before = certificates_->read(name);
    put(name, text);
    ++count;
    EXPECT_TRUE(wait_until([&] { return refused == count; })) << name << ": " << text;
    EXPECT_EQ(call("ca.pem", "client").error_code(), grpc::StatusCode::NOT_FOUND) << name << ": " << text;
    put(name, before);
  }
  certificates_->copy("other-server", "kept");
  EXPECT_TRUE(wait_until([&] { return taken == 1; }));
  EXPECT_EQ(call("other-ca.pem", "client").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(refused, count);
}

TEST_F(TlsTest, RefusesFilesThatCannotBeUsed) {
  EXPECT_NO_THROW(sound_tls_files(Tls()));
  EXPECT_NO_THROW(sound_tls_files(tls("server", "ca.pem")));
  auto wrong_key = tls("server"), no_file = tls("server"), no_pem = tls("server"), locked = tls("server");
  wrong_key.key = path("client.key");
  no_file.certificate = path("nowhere.pem");
  no_pem.client_ca = path("text.pem");
  locked.key = path("locked.key");
  for (const auto& [bad, named] : {std::pair{wrong_key, "--tls-key"},
                                   {no_file, "--tls-certificate"},
                                   {no_pem, "--tls-client-ca"},
                                   {locked, "--tls-key"},
                                   {tls("expired"), "has expired"}}) {
    try {
      sound_tls_files(bad);
      FAIL() << named;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace collided::server
