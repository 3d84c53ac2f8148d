#pragma once
// An honest client during an attack, and checks after it: every client is served, everything was released.

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/integration/support/baseline.hpp"
#include "tests/integration/support/stream.hpp"
#include "tests/integration/support/tip_scene.hpp"

namespace collided::test {

/// How an honest client connects to the daemon: a separate connection for each number.
using Connect = std::function<std::shared_ptr<grpc::Channel>(int number)>;

inline Connect connect_by(const std::string& address) {
  return [address](int number) { return channel_to(address, number); };
}

/// Streams frames from its construction on, one at a time over its own connection, and checks every contact.
class Bystander {
 public:
  explicit Bystander(const Connect& connect)
      : stub_(pb::CollisionService::NewStub(connect(kConnection))), thread_([this] { run(); }) {
    eventually("the bystander is served", [&] { return frames_ > 0; });
  }
  Bystander(const Bystander&) = delete;
  Bystander& operator=(const Bystander&) = delete;
  ~Bystander() { leave(); }

  uint64_t frames() const { return frames_; }
  /// The latency of each frame answered since the last call.
  std::vector<double> take_milliseconds() {
    const std::lock_guard lock(mutex_);
    return std::exchange(milliseconds_, {});
  }
  /// At least so many more frames are answered.
  void expect_served(uint64_t more = 3) const {
    const uint64_t now = frames_;
    eventually("the bystander is served further", [&] { return frames_ >= now + more; });
  }
  /// Ends its stream, which must be in order, and its scene.
  void leave() {
    is_leaving_ = true;
    if (thread_.joinable()) thread_.join();
    stub_.reset();  // its connection is one of the daemon's descriptors
  }

 private:
  static constexpr int kConnection = 4711;

  void run() {
    const std::string scene = make_scene(*stub_, tip_request());
    {
      Stream stream(*stub_, scene);
      ASSERT_TRUE(stream.opened()) << "the bystander's stream does not open";
      for (uint64_t id = 1; !is_leaving_; ++id, ++frames_) {
        const double depth = 1.5 + 0.125 * (id % 8);
        const pb::Frame frame = id == 1 ? first_frame(depth) : tip_frame(id, depth);
        const auto sent = std::chrono::steady_clock::now();
        const Answer answer = stream.ask(frame);
        note(std::chrono::steady_clock::now() - sent);
        ASSERT_TRUE(answer.done) << "the bystander's frame " << id << " was not answered";
        expect_tip_contact(answer, depth);
      }
      EXPECT_TRUE(stream.finish().ok());
    }
    EXPECT_TRUE(delete_scene(*stub_, scene).ok());
  }

  void note(std::chrono::duration<double, std::milli> took) {
    const std::lock_guard lock(mutex_);
    milliseconds_.push_back(took.count());
  }

  std::unique_ptr<Stub> stub_;
  std::atomic<bool> is_leaving_ = false;
  std::atomic<uint64_t> frames_ = 0;
  std::mutex mutex_;
  std::vector<double> milliseconds_;
  std::thread thread_;
};

/// A new client creates a scene, streams, and leaves.
inline void expect_new_client_served(const Connect& connect) {
  static std::atomic<int> connection = 100'000;
  auto stub = pb::CollisionService::NewStub(connect(++connection));
  const std::string scene = make_scene(*stub, tip_request());
  {
    Stream stream(*stub, scene);
    ASSERT_TRUE(stream.opened()) << "a new client's stream does not open";
    expect_tip_contact(stream.ask(first_frame(2)), 2);
    EXPECT_TRUE(stream.finish().ok());
  }
  EXPECT_TRUE(delete_scene(*stub, scene).ok());
}

inline void expect_new_client_served(const std::string& address) { expect_new_client_served(connect_by(address)); }

/// Constructed before an attack, and checked after it. The honest clients may use another transport than the attack.
class Aftermath {
 public:
  Aftermath(const Probe& probe, Connect connect)
      : connect_(std::move(connect)), baseline_(warmed_up(probe, connect_)), bystander_(connect_) {}
  Aftermath(const Probe& probe, const std::string& address) : Aftermath(probe, connect_by(address)) {}

  Bystander& bystander() { return bystander_; }
  /// New clients can connect, the bystander lost nothing, and memory, threads and descriptors are back.
  void expect_unharmed() {
    expect_new_client_served(connect_);
    bystander_.expect_served();
    bystander_.leave();
    baseline_.expect_back();
  }

 private:
  /// Whatever a first client leaves behind for good, such as gRPC's threads, is harmless.
  static const Probe& warmed_up(const Probe& probe, const Connect& connect) {
    expect_new_client_served(connect);
    return probe;
  }

  const Connect connect_;
  const Baseline baseline_;
  Bystander bystander_;
};

}  // namespace collided::test
