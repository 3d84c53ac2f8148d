#pragma once
// Frames in, contacts out: one stream to one scene.

#include <memory>
#include <optional>

#include "client/cpp/contacts.hpp"
#include "client/cpp/positions.hpp"
#include "collided/v1/frame.pb.h"
#include "collided/v1/scene.pb.h"

namespace collided::client {

/// All that the daemon answered to one frame.
struct FrameOutput {
  uint64_t frame_id = 0;
  Contacts vertex_triangle;
  Contacts edge_edge;
  Contacts triangle_triangle;           ///< elements and flags alone
  v1::FrameDone done;                   ///< metrics and totals
  std::optional<v1::FrameError> error;  ///< the frame was refused; the stream goes on
  bool skipped = false;

  /// Throws the refusal as an Error.
  void check() const;
};

/// One thread may send while another receives. Outputs come in the order of the frames.
class FrameStream {
 public:
  FrameStream(FrameStream&&) noexcept;
  FrameStream& operator=(FrameStream&&) noexcept;
  /// Cancels what is in flight unless finish() was called.
  ~FrameStream();

  const v1::Scene& scene() const;
  /// Frames that may be in flight.
  uint32_t window() const;
  /// Waits until fewer frames than the window are in flight, then sends. Throws Error once the stream has ended.
  /// Outputs are kept until receive() takes them.
  void send(const v1::Frame& frame);
  /// Waits for the next output. Throws Error if the stream broke or nothing is in flight.
  FrameOutput receive();
  /// Tells the daemon that no more frames come, waits for its end and throws Error if it is a bad one.
  void finish();

 private:
  friend class Client;
  struct State;
  explicit FrameStream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collided::client
