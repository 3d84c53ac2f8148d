#pragma once
// An honest client beside an attack, and what must be true after it: everybody is served, everything was given back.

#include <atomic>
#include <string>
#include <thread>

#include "tests/integration/baseline.hpp"
#include "tests/integration/stream.hpp"
#include "tests/integration/tip_scene.hpp"

namespace collided::test {

/// Streams frames from its making on, one at a time over a connection of its own, and checks every contact.
class Bystander {
 public:
  explicit Bystander(const std::string& address)
      : stub_(pb::CollisionService::NewStub(channel_to(address, kConnection))), thread_([this] { run(); }) {
    eventually("the bystander is served", [&] { return frames_ > 0; });
  }
  Bystander(const Bystander&) = delete;
  Bystander& operator=(const Bystander&) = delete;
  ~Bystander() { leave(); }

  uint64_t frames() const { return frames_; }
  /// At least so many more frames are answered.
  void expect_served(uint64_t more = 3) const {
    const uint64_t now = frames_;
    eventually("the bystander is served further", [&] { return frames_ >= now + more; });
  }
  /// Ends its stream, which must be in order, and its scene.
  void leave() {
    is_leaving_ = true;
    if (thread_.joinable()) thread_.join();
    stub_.reset();  // and its connection
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
        const Answer answer = stream.ask(id == 1 ? first_frame(depth) : tip_frame(id, depth));
        ASSERT_TRUE(answer.done) << "the bystander's frame " << id << " was not answered";
        expect_tip_contact(answer, depth);
      }
      EXPECT_TRUE(stream.finish().ok());
    }
    EXPECT_TRUE(delete_scene(*stub_, scene).ok());
  }

  std::unique_ptr<Stub> stub_;
  std::atomic<bool> is_leaving_ = false;
  std::atomic<uint64_t> frames_ = 0;
  std::thread thread_;
};

/// A client that was not there before makes a scene, streams, and leaves.
inline void expect_new_client_served(const std::string& address) {
  static std::atomic<int> connection = 100'000;
  auto stub = pb::CollisionService::NewStub(channel_to(address, ++connection));
  const std::string scene = make_scene(*stub, tip_request());
  {
    Stream stream(*stub, scene);
    ASSERT_TRUE(stream.opened()) << "a new client's stream does not open";
    expect_tip_contact(stream.ask(first_frame(2)), 2);
    EXPECT_TRUE(stream.finish().ok());
  }
  EXPECT_TRUE(delete_scene(*stub, scene).ok());
}

/// Made before an attack, and asked after it. The address may be another one than the attack's.
class Aftermath {
 public:
  Aftermath(const Probe& probe, std::string address)
      : address_(std::move(address)), baseline_(warmed_up(probe, address_)), bystander_(address_) {}

  const Bystander& bystander() const { return bystander_; }
  /// New clients get in, the bystander lost nothing, and memory, threads and descriptors are back.
  void expect_unharmed() {
    expect_new_client_served(address_);
    bystander_.expect_served();
    bystander_.leave();
    baseline_.expect_back();
  }

 private:
  /// What a first client leaves behind for good, such as gRPC's threads, is no harm.
  static const Probe& warmed_up(const Probe& probe, const std::string& address) {
    expect_new_client_served(address);
    return probe;
  }

  const std::string address_;
  const Baseline baseline_;
  Bystander bystander_;
};

}  // namespace collided::test
