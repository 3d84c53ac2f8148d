#pragma once
// A frame stream over the local socket, one message at a time, without the client library.

#include <optional>
#include <string>

#include "tests/integration/local/local_socket.hpp"
#include "tests/integration/support/stream.hpp"

namespace collided::test {

/// How a local stream is opened.
struct LocalSizes {
  static constexpr size_t kInput = 256 << 10;
  size_t input = kInput, output = 64 << 10;  ///< bytes
  uint32_t window = 0;
  std::string resume_token = "";
  std::string token = "";
};

class LocalStream {
 public:
  LocalStream(const std::string& path, const std::string& scene_id, const LocalSizes& sizes = {})
      : sizes_(sizes), memory_(sizes.input + sizes.output), raw_(path) {
    auto request = open_request(scene_id, sizes.input, sizes.output, sizes.window);
    request.mutable_open()->mutable_open()->set_resume_token(sizes.resume_token);
    request.mutable_open()->set_token(sizes.token);
    raw_.send(request, {memory_.file()});
    const auto response = raw_.receive();
    if (!response) return;
    if (response->frame().has_opened()) opened_ = response->frame().opened();
    if (response->has_closed()) closed_ = response->closed();
  }

  const std::optional<pb::StreamOpened>& opened() const { return opened_; }
  const Memory& memory() const { return memory_; }
  RawLocal& raw() { return raw_; }

  /// With its positions in this frame's part of the input region.
  bool send_shared(const pb::Frame& frame) {
    const uint32_t parts = opened_ ? opened_->window() : 1;
    const size_t part = sizes_.input / parts / 8 * 8;
    return raw_.send(shared_frame(frame, memory_, frame.frame_id() % parts * part));
  }
  /// With the arrays of its contacts in the chunks; notices of a stop in between are counted.
  Answer receive(uint64_t frame_id) {
    Answer answer;
    while (const auto packet = raw_.receive()) {
      if (packet->has_closed()) {
        closed_ = packet->closed();
        break;
      }
      const auto& response = packet->frame();
      if (response.has_draining()) {
        ++drainings_;
        continue;
      }
      EXPECT_EQ(response.frame_id(), frame_id);
      if (response.has_contacts()) take(response.contacts(), answer);
      for (const auto& chunk : response.done().contacts()) take(chunk, answer);
      if (response.has_done()) answer.done = response.done();
      if (response.has_error()) answer.error = response.error();
      if (answer.done || answer.error) return answer;
    }
    answer.ended = true;
    return answer;
  }
  Answer ask(const pb::Frame& frame) {
    raw_.send(frame);
    return receive(frame.frame_id());
  }
  Answer ask_shared(const pb::Frame& frame) {
    send_shared(frame);
    return receive(frame.frame_id());
  }

  /// Chunks whose arrays came in shared memory, and those that came in packets.
  size_t shared_chunks() const { return shared_chunks_; }
  size_t packet_chunks() const { return packet_chunks_; }
  int drainings() const { return drainings_; }
  /// Why the stream ended, once that was received.
  const std::optional<pb::LocalClosed>& closed() const { return closed_; }

 private:
  void take(const pb::ContactChunk& chunk, Answer& answer) {
    answer.chunks.push_back(own_arrays(chunk, memory_, sizes_.input));
    ++(chunk.has_shared() ? shared_chunks_ : packet_chunks_);
  }

  const LocalSizes sizes_;
  Memory memory_;
  RawLocal raw_;
  std::optional<pb::StreamOpened> opened_;
  std::optional<pb::LocalClosed> closed_;
  size_t shared_chunks_ = 0, packet_chunks_ = 0;
  int drainings_ = 0;
};

}  // namespace collided::test
