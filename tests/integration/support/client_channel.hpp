#pragma once
// Named clients: channels whose calls all carry a bearer token.

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/client_interceptor.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace collided::test {

/// The token of the client with that name in a TokensFile.
inline std::string token_of(const std::string& name) { return "token-of-client-" + name; }

/// A file of tokens, each with limits such as "max-scenes = 5\n", that is deleted with the test.
class TokensFile {
 public:
  struct Entry {
    std::string name, limits = {};
  };
  explicit TokensFile(const std::vector<Entry>& entries) {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-tokens-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::ofstream file(path());
    for (const auto& [name, limits] : entries)
      file << "[[tokens]]\nname = \"" << name << "\"\ntoken = \"" << token_of(name) << "\"\n" << limits;
  }
  TokensFile(const TokensFile&) = delete;
  TokensFile& operator=(const TokensFile&) = delete;
  ~TokensFile() { std::filesystem::remove_all(folder_); }

  std::string path() const { return folder_ + "/tokens.toml"; }

 private:
  std::string folder_;
};

class TokenSender final : public grpc::experimental::Interceptor {
 public:
  explicit TokenSender(std::string header) : header_(std::move(header)) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    using grpc::experimental::InterceptionHookPoints;
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA))
      methods->GetSendInitialMetadata()->insert({"authorization", header_});
    methods->Proceed();
  }

 private:
  const std::string header_;
};

class TokenSenders final : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit TokenSenders(const std::string& name) : header_("Bearer " + token_of(name)) {}
  grpc::experimental::Interceptor* CreateClientInterceptor(grpc::experimental::ClientRpcInfo*) override {
    return new TokenSender(header_);
  }

 private:
  const std::string header_;
};

/// A separate connection for each `number`.
inline std::shared_ptr<grpc::Channel> channel_as(const std::string& name, const std::string& address, int number = 0) {
  grpc::ChannelArguments arguments;
  arguments.SetString("collided.test.client", name);
  arguments.SetInt("collided.test.connection", number);
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> senders;
  senders.push_back(std::make_unique<TokenSenders>(name));
  return grpc::experimental::CreateCustomChannelWithInterceptors(address, grpc::InsecureChannelCredentials(), arguments,
                                                                 std::move(senders));
}

}  // namespace collided::test
