// Packets to be sent over a non-blocking socket.
#include "server/transport/local/outbox.hpp"

#include <utility>

namespace collided::server {

void Outbox::send(int socket, std::string packet, std::shared_ptr<const void> held) {
  if (is_gone_) return;
  if (!kept_.empty()) return keep(std::move(packet), std::move(held));
  const Sent sent = send_packet(socket, packet);
  if (sent == Sent::kGone) return drop();
  if (sent == Sent::kYes) return;
  is_short_ = sent == Sent::kShort;
  stalled_since_ = Clock::now();
  keep(std::move(packet), std::move(held));
}

void Outbox::keep(std::string packet, std::shared_ptr<const void> held) {
  bytes_ += packet.size();
  kept_.push_back({std::move(packet), std::move(held)});
}

void Outbox::flush(int socket) {
  while (!kept_.empty()) {
    const Sent sent = send_packet(socket, kept_.front().packet);
    if (sent == Sent::kGone) return drop();
    is_short_ = sent == Sent::kShort;
    if (sent != Sent::kYes) return;
    stalled_since_ = Clock::now();
    bytes_ -= kept_.front().packet.size();
    kept_.pop_front();
  }
}

void Outbox::drop() {
  is_gone_ = true;
  kept_.clear();
  bytes_ = 0;
}

}  // namespace collided::server
