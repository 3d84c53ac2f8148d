#pragma once
// Clients that keep the daemon busy: streams that send one frame repeatedly.

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "tests/integration/support/stream.hpp"

namespace collided::test {

/// What each stream of a load does.
struct FrameWork {
  pb::CreateSceneRequest scene = {};
  pb::Frame frame = {};  ///< ids are given when it is sent
  uint32_t window = 1;   ///< frames in flight at any time
};

/// Streams with a thread each, until this object is destroyed: then running frames are cancelled, and the scenes
/// deleted.
class FrameLoad {
 public:
  FrameLoad(std::vector<std::unique_ptr<Stub>> stubs, FrameWork work) : work_(std::move(work)) {
    for (auto& stub : stubs) clients_.emplace_back(std::move(stub), work_);
    for (Client& client : clients_) threads_.emplace_back([this, &client] { run(client); });
  }
  FrameLoad(const FrameLoad&) = delete;
  FrameLoad& operator=(const FrameLoad&) = delete;
  ~FrameLoad() {
    is_over_ = true;
    for (Client& client : clients_) client.stream.cancel();
    threads_.clear();
    for (Client& client : clients_) {
      client.stream.wait_end();
      EXPECT_TRUE(delete_scene(*client.stub, client.scene).ok());
    }
  }

  uint64_t frames() const { return frames_; }
  /// Every stream has had an answer.
  bool is_on() const { return running_ == static_cast<int>(clients_.size()); }
  /// Frames that the daemon did not compute.
  uint64_t refused() const { return refused_; }

 private:
  struct Client {
    Client(std::unique_ptr<Stub> to, const FrameWork& work)
        : stub(std::move(to)), scene(make_scene(*stub, work.scene)), stream(*stub, scene, work.window) {
      EXPECT_TRUE(stream.opened());
    }
    std::unique_ptr<Stub> stub;
    std::string scene;
    Stream stream;
  };

  void run(Client& client) {
    pb::Frame frame = work_.frame;
    const auto send = [&](uint64_t id) {
      frame.set_frame_id(id);
      client.stream.send(frame);
    };
    for (uint64_t id = 1; id <= work_.window; ++id) send(id);
    for (uint64_t id = 1; !is_over_; ++id) {
      const Answer answer = client.stream.receive(id);
      if (is_over_) return;
      ASSERT_FALSE(answer.ended) << "frame " << id << " of the load";
      if (answer.error) ++refused_;
      if (id == 1) ++running_;
      ++frames_;
      send(id + work_.window);
    }
  }

  const FrameWork work_;
  std::deque<Client> clients_;
  std::atomic<bool> is_over_ = false;
  std::atomic<int> running_ = 0;
  std::atomic<uint64_t> frames_ = 0, refused_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace collided::test
