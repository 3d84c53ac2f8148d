#pragma once
// A client of the local socket without the client library, for what the library never does.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collided/v1/local.pb.h"

namespace collided::test {

namespace pb = collided::v1;

constexpr int kGoodSeals = F_SEAL_SHRINK | F_SEAL_GROW;

/// Shared memory of a client, mapped for itself.
class Memory {
 public:
  explicit Memory(size_t bytes, int seals = kGoodSeals) : bytes_(bytes) {
    file_ = memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    EXPECT_EQ(ftruncate(file_, static_cast<off_t>(bytes)), 0);
    start_ = static_cast<std::byte*>(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0));
    EXPECT_NE(start_, MAP_FAILED);
    EXPECT_EQ(fcntl(file_, F_ADD_SEALS, seals), 0);
  }
  ~Memory() {
    munmap(start_, bytes_);
    close(file_);
  }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  int file() const { return file_; }
  std::byte* data() const { return start_; }
  void put(size_t offset, std::string_view bytes) const { std::memcpy(start_ + offset, bytes.data(), bytes.size()); }
  std::string get(const pb::SharedRange& range, size_t base) const {
    return {reinterpret_cast<const char*>(start_) + base + range.offset(), range.size()};
  }

 private:
  size_t bytes_;
  int file_ = -1;
  std::byte* start_ = nullptr;
};

/// A connection to a local socket.
class RawLocal {
 public:
  explicit RawLocal(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  }
  ~RawLocal() { hang_up(); }
  RawLocal(const RawLocal&) = delete;
  RawLocal& operator=(const RawLocal&) = delete;

  bool is_connected() const { return connected_; }
  int socket() const { return socket_; }
  void hang_up() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }
  void half_close() const { shutdown(socket_, SHUT_WR); }
  pid_t daemon() const {
    ucred peer{};
    socklen_t size = sizeof(peer);
    getsockopt(socket_, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    return peer.pid;
  }

  bool send(std::string_view packet, const std::vector<int>& files = {}, int flags = 0) const {
    iovec bytes{const_cast<char*>(packet.data()), packet.size()};
    msghdr message{};
    message.msg_iov = &bytes;
    message.msg_iovlen = 1;
    constexpr size_t kMaxFiles = 253;  // the kernel's limit
    alignas(cmsghdr) char control[CMSG_SPACE(kMaxFiles * sizeof(int))] = {};
    if (!files.empty()) {
      message.msg_control = control;
      message.msg_controllen = CMSG_SPACE(files.size() * sizeof(int));
      cmsghdr* const part = CMSG_FIRSTHDR(&message);
      part->cmsg_level = SOL_SOCKET;
      part->cmsg_type = SCM_RIGHTS;
      part->cmsg_len = CMSG_LEN(files.size() * sizeof(int));
      std::memcpy(CMSG_DATA(part), files.data(), files.size() * sizeof(int));
    }
    return sendmsg(socket_, &message, MSG_NOSIGNAL | flags) >= 0;
  }
  bool send(const pb::LocalRequest& request, const std::vector<int>& files = {}) const {
    return send(request.SerializeAsString(), files);
  }
  bool send(const pb::Frame& frame) const {
    pb::LocalRequest request;
    *request.mutable_frame() = frame;
    return send(request);
  }

  /// The daemon's next packet; nullopt at the end, or after 30 s.
  std::optional<pb::LocalResponse> receive() const {
    constexpr int kPatienceMs = 30'000;
    std::string packet(1 << 20, '\0');
    for (int tries = 0; tries < 2; ++tries) {  // the reset may be reported before the daemon's last packet
      pollfd state{socket_, POLLIN, 0};
      if (poll(&state, 1, kPatienceMs) <= 0) {
        ADD_FAILURE() << "the daemon says nothing";
        return std::nullopt;
      }
      const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
      if (size < 0 && errno == ECONNRESET) continue;
      if (size <= 0) return std::nullopt;
      EXPECT_LE(size, 64 << 10);
      pb::LocalResponse response;
      EXPECT_TRUE(response.ParseFromArray(packet.data(), static_cast<int>(size)));
      return response;
    }
    return std::nullopt;
  }
  /// Why the stream ended; earlier packets are skipped.
  pb::LocalClosed closed() const {
    while (const auto response = receive())
      if (response->has_closed()) {
        EXPECT_FALSE(receive()) << "a packet after the last one";
        return response->closed();
      }
    pb::LocalClosed none;
    none.set_code(-1);
    none.set_message("the daemon closed the stream without a word");
    return none;
  }

 private:
  int socket_;
  bool connected_ = false;
};

inline pb::LocalRequest open_request(const std::string& scene_id, uint64_t input, uint64_t output,
                                     uint32_t window = 0) {
  pb::LocalRequest request;
  request.mutable_open()->set_version(1);
  request.mutable_open()->mutable_open()->set_scene_id(scene_id);
  request.mutable_open()->mutable_open()->set_window(window);
  request.mutable_open()->set_input_bytes(input);
  request.mutable_open()->set_output_bytes(output);
  return request;
}

/// Takes the positions out of a frame's message into memory, from `offset` on.
inline pb::Frame shared_frame(pb::Frame frame, const Memory& memory, size_t offset = 0) {
  const auto share = [&](std::string* own, pb::SharedRange* range) {
    memory.put(offset, *own);
    range->set_offset(offset);
    range->set_size(own->size());
    offset += (own->size() + 7) / 8 * 8;
    own->clear();
  };
  for (auto& update : *frame.mutable_updates()) {
    if (!update.positions().empty()) share(update.mutable_positions(), update.mutable_shared_positions());
    if (!update.start_positions().empty())
      share(update.mutable_start_positions(), update.mutable_shared_start_positions());
  }
  return frame;
}

/// The chunk with its arrays in the message, from memory whose output begins at `base`.
inline pb::ContactChunk own_arrays(pb::ContactChunk chunk, const Memory& memory, size_t base) {
  const pb::SharedArrays shared = chunk.shared();
  if (!chunk.has_shared()) return chunk;
  chunk.clear_shared();
  chunk.set_elements(memory.get(shared.elements(), base));
  chunk.set_stencils(memory.get(shared.stencils(), base));
  chunk.set_toi(memory.get(shared.toi(), base));
  chunk.set_distance(memory.get(shared.distance(), base));
  chunk.set_weights(memory.get(shared.weights(), base));
  chunk.set_normals(memory.get(shared.normals(), base));
  chunk.set_flags(memory.get(shared.flags(), base));
  chunk.set_features(memory.get(shared.features(), base));
  chunk.set_signed_distances(memory.get(shared.signed_distances(), base));
  return chunk;
}

}  // namespace collided::test
