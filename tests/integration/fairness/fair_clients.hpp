#pragma once
// A daemon with named clients: one with many scenes, and honest ones.

#include <memory>
#include <string>
#include <vector>

#include "tests/integration/fairness/frame_load.hpp"
#include "tests/integration/support/bystander.hpp"
#include "tests/integration/support/client_channel.hpp"
#include "tests/integration/support/layers.hpp"

namespace collided::test {

class NamedClients {
 public:
  static constexpr char kBystander[] = "bystander";

  Connect connect_as(const std::string& client) const {
    return [this, client](int number) { return channel_as(client, daemon_.address(), number); };
  }
  std::unique_ptr<Stub> stub(const std::string& client, int number = 0) const {
    return pb::CollisionService::NewStub(connect_as(client)(number));
  }
  std::vector<std::unique_ptr<Stub>> stubs(const std::string& client, int count) const {
    std::vector<std::unique_ptr<Stub>> all;
    for (int i = 0; i < count; ++i) all.push_back(stub(client, i));
    return all;
  }

 protected:
  const TokensFile tokens_{
      {{"many", "max-scenes = 40\n"}, {"one"}, {"hasty", "max-frame-seconds = 0.001\n"}, {kBystander}}};
  DaemonProcess daemon_{{"--tokens-file", tokens_.path(), "--threads", "2"},
                        "cpu"};  // so that frames take equally long on any machine
  const Probe probe_{daemon_};
  Aftermath aftermath_{probe_, connect_as(kBystander)};
};

/// Frames of two layers without contacts; a larger side takes longer.
inline FrameWork layers_work(uint32_t side, uint32_t window) {
  return {layers_request(side), layers_frame(0, pack_points(layer_points(side, kLayersApart))), window};
}

}  // namespace collided::test
