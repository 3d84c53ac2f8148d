// A frame stream over the daemon's local socket.

#include "client/cpp/transport/local/local_transport.hpp"

#include <grpcpp/support/status_code_enum.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "client/cpp/frame_options.hpp"
#include "proto/constants.hpp"

namespace collided::client {

namespace {

constexpr uint64_t kAlignment = 64;
constexpr size_t kMaxInlineBytes = 64;  // up to this many go into the packet itself

LocalFd connect_to(const LocalPeer& peer) {
  LocalFd socket = connect_to_socket(peer.path, SOCK_SEQPACKET, peer.patience);
  check_trusted(socket, peer.path, peer.trusted);
  limit_sending(socket, peer.deadline);
  return socket;
}

// Hands `file` over with the packet; -1: none.
bool send_with_file(int socket, const std::string& packet, int file) {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  iovec bytes{const_cast<char*>(packet.data()), packet.size()};
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  if (file >= 0) {
    message.msg_control = control;
    message.msg_controllen = sizeof(control);
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(part), &file, sizeof(int));
  }
  ssize_t sent = -1;
  do sent = sendmsg(socket, &message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent >= 0;
}

// The packet's size; 0 or less at the end. A reset may be reported before the daemon's last packets.
ssize_t receive(int socket, std::string& packet) {
  constexpr int kTries = 2;
  packet.resize(v1::kMaxPacketBytes);
  for (int reset = 0;;) {
    const ssize_t size = recv(socket, packet.data(), packet.size(), 0);
    if (size >= 0 || (errno != EINTR && (errno != ECONNRESET || ++reset == kTries))) return size;
  }
}

// Whether there is something to receive, or the stream has ended.
bool has_arrived(int socket, FrameTransport::Time deadline) {
  using std::chrono::nanoseconds;
  pollfd state{socket, POLLIN, 0};
  for (;;) {
    const auto left = std::max(nanoseconds(0), nanoseconds(deadline - std::chrono::steady_clock::now()));
    const timespec timeout{left.count() / std::nano::den, left.count() % std::nano::den};
    const int ready = ppoll(&state, 1, &timeout, nullptr);
    if (ready >= 0 || errno != EINTR) return ready != 0;
  }
}

}  // namespace

LocalTransport::LocalTransport(const LocalPeer& peer, const LocalLayout& layout, const std::string& token,
                               const LocalOptions& options)
    : layout_(layout),
      socket_(connect_to(peer)),
      region_(layout.input_in_file() + layout.output_in_file()),
      deadline_(peer.deadline) {
  opening_.set_version(v1::kLocalVersion);
  opening_.set_token(token);
  opening_.set_input_bytes(layout.input_in_file());
  opening_.set_output_bytes(layout.output_bytes);
  opening_.set_cuda_ipc_handle(options.cuda_ipc_handle);
  opening_.set_output_cuda_ipc_handle(options.output_cuda_ipc_handle);
}

bool LocalTransport::open(const v1::OpenStream& open) {
  v1::LocalRequest request;
  *opening_.mutable_open() = open;
  opening_.mutable_open()->set_window(layout_.window);
  *request.mutable_open() = opening_;
  // A daemon that refuses the connection has closed it by now, and its answer can still be read: a failure to send
  // does not matter.
  send_with_file(socket_.get(), request.SerializeAsString(), region_.file());
  return true;
}

std::span<std::byte> LocalTransport::input(uint64_t bytes) {
  const auto room = take_room(bytes);
  if (room.size() == bytes) return room;
  throw Error(grpc::RESOURCE_EXHAUSTED, "input of " + std::to_string(bytes) + " bytes was requested, but only " +
                                            std::to_string(layout_.frame_bytes - used_) + " of the " +
                                            std::to_string(layout_.frame_bytes) + " for one frame are left");
}

/// From the next frame's part of the input; empty if there is not enough left.
std::span<std::byte> LocalTransport::take_room(uint64_t bytes) {
  if (bytes > layout_.frame_bytes - used_) return {};
  const uint64_t start = frames_ % layout_.window * layout_.frame_bytes + used_;
  used_ = std::min((used_ + bytes + kAlignment - 1) / kAlignment * kAlignment, layout_.frame_bytes);
  return region_.bytes().subspan(start, bytes);
}

/// The range of the bytes in the input region, to which they are copied unless they are there already. nullopt if they
/// are few enough for the packet, or if there is no room.
std::optional<v1::SharedRange> LocalTransport::place(Bytes bytes) {
  const auto region = region_.bytes();
  uint64_t offset = reinterpret_cast<uintptr_t>(bytes.data()) - reinterpret_cast<uintptr_t>(region.data());
  if (offset >= layout_.window * layout_.frame_bytes || offset % v1::kRangeAlignment != 0) {
    if (bytes.size() <= kMaxInlineBytes) return std::nullopt;
    const auto room = take_room(bytes.size());
    if (room.size() != bytes.size()) return std::nullopt;
    std::memcpy(room.data(), bytes.data(), bytes.size());
    offset = static_cast<uint64_t>(room.data() - region.data());
  }
  v1::SharedRange range;
  range.set_offset(offset);
  range.set_size(bytes.size());
  return range;
}

void LocalTransport::add(const FrameUpdate& update, v1::MeshUpdate& out) {
  out.set_mesh(update.mesh);
  const auto put = [this](Bytes bytes, const auto& share, const auto& keep) {
    if (bytes.empty()) return;
    if (const auto range = place(bytes))
      *share() = *range;
    else
      keep()->assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  put(
      update.positions, [&] { return out.mutable_shared_positions(); }, [&] { return out.mutable_positions(); });
  put(
      update.start_positions, [&] { return out.mutable_shared_start_positions(); },
      [&] { return out.mutable_start_positions(); });
  put(
      update.indices, [&] { return out.mutable_sparse()->mutable_shared_indices(); },
      [&] { return out.mutable_sparse()->mutable_indices(); });
  if (update.transform) out.mutable_rigid()->set_matrix(update.transform->data(), sizeof(RigidMatrix));
  if (update.start_transform)
    out.mutable_rigid()->set_start_matrix(update.start_transform->data(), sizeof(RigidMatrix));
}

/// Arrays in the message are placed; ranges that it names are kept.
void LocalTransport::add(const v1::MeshUpdate& update, v1::MeshUpdate& out) {
  if (update.has_sparse()) *out.mutable_sparse() = v1::SparseIndices();
  if (update.sparse().has_shared_indices())
    *out.mutable_sparse()->mutable_shared_indices() = update.sparse().shared_indices();
  if (update.has_shared_positions()) *out.mutable_shared_positions() = update.shared_positions();
  if (update.has_shared_start_positions()) *out.mutable_shared_start_positions() = update.shared_start_positions();
  if (update.has_rigid()) *out.mutable_rigid() = update.rigid();
  const auto bytes_of = [](const std::string& text) { return std::as_bytes(std::span(text)); };
  add(FrameUpdate{.mesh = update.mesh(),
                  .positions = bytes_of(update.positions()),
                  .start_positions = bytes_of(update.start_positions()),
                  .indices = bytes_of(update.sparse().indices())},
      out);
}

bool LocalTransport::send(const v1::Frame& frame, std::span<const FrameUpdate> updates) {
  v1::Frame& out = *outgoing_.mutable_frame();
  out.Clear();
  copy_head(frame, out);
  for (const auto& update : frame.updates()) add(update, *out.add_updates());
  for (const auto& update : updates) add(update, *out.add_updates());
  const v1::SharedRange whole = place_if_long(out);
  used_ = 0;
  ++frames_;
  if (whole.size() == 0) return send_packet(outgoing_);
  v1::LocalRequest request;
  *request.mutable_shared_frame() = whole;
  return send_packet(request);
}

/// The range of the message in the input region, if it is too long for a packet; else an empty one.
v1::SharedRange LocalTransport::place_if_long(const v1::Frame& frame) {
  constexpr size_t kEnvelopeBytes = 8;  // the packet's own field
  const size_t bytes = frame.ByteSizeLong();
  if (bytes + kEnvelopeBytes <= v1::kMaxPacketBytes) return {};
  const std::string message = frame.SerializeAsString();
  if (const auto range = place(std::as_bytes(std::span(message)))) return *range;
  used_ = 0;
  throw Error(grpc::RESOURCE_EXHAUSTED, "frame is " + std::to_string(bytes) +
                                            " bytes besides what is in shared memory, " +
                                            "more than a packet and the memory for one frame hold");
}

bool LocalTransport::send_packet(const v1::LocalRequest& request) {
  packet_.clear();
  request.AppendToString(&packet_);
  if (send_with_file(socket_.get(), packet_, -1)) return true;
  if (errno == EAGAIN || errno == EWOULDBLOCK) {
    is_late_ = true;
    shutdown(socket_.get(), SHUT_RDWR);
  }
  return false;
}

FrameTransport::Arrival LocalTransport::read(v1::StreamFramesResponse& response, Time deadline) {
  if (deadline != kNever && !has_arrived(socket_.get(), deadline)) return Arrival::kNothing;
  const ssize_t size = receive(socket_.get(), incoming_);
  if (size <= 0) return Arrival::kEnd;
  v1::LocalResponse packet;
  if (!packet.ParseFromArray(incoming_.data(), static_cast<int>(size)))
    throw Error(grpc::DATA_LOSS, "the daemon's packet is not a LocalResponse");
  if (packet.has_closed()) {
    closed_ = std::move(*packet.mutable_closed());
    return Arrival::kEnd;
  }
  response = std::move(*packet.mutable_frame());
  return Arrival::kMessage;
}

std::span<const std::byte> LocalTransport::shared(const v1::SharedRange& range) const {
  const auto output = region_.bytes().last(layout_.output_in_file());
  if (range.size() > output.size() || range.offset() > output.size() - range.size())
    throw Error(grpc::DATA_LOSS, "contacts.shared names " + std::to_string(range.size()) + " bytes at offset " +
                                     std::to_string(range.offset()) + "; the output region has " +
                                     std::to_string(output.size()));
  return output.subspan(range.offset(), range.size());
}

void LocalTransport::half_close() { shutdown(socket_.get(), SHUT_WR); }

void LocalTransport::cancel() {
  is_cancelled_ = true;
  shutdown(socket_.get(), SHUT_RDWR);
}

std::optional<Error> LocalTransport::finish() {
  if (closed_ && closed_->code() == grpc::OK) return std::nullopt;
  if (closed_) return Error(closed_->code(), closed_->message(), closed_->field());
  if (is_late_)
    return Error(grpc::DEADLINE_EXCEEDED,
                 "the daemon took no packet within " + std::to_string(deadline_.count()) + " ms (deadline)");
  if (is_cancelled_) return Error(grpc::CANCELLED, "the stream was cancelled");
  return Error(grpc::UNAVAILABLE, "the daemon's local socket was closed");
}

}  // namespace collided::client
