// Streams frames whose contacts are known until its input ends, and tells how it went: of a session that is disturbed.
// Usage: routed_session ADDRESS

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <future>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "client/cpp/session.hpp"

using namespace collided;
using namespace collided::client;

namespace {

using Clock = std::chrono::steady_clock;
using Points = std::vector<std::array<double, 3>>;

// The corner of `falling` is at 1 or at -3, so that it passes the floor at a quarter or at three quarters of the way.
Points falling(bool down) {
  const double z = down ? -3 : 1;
  return {{1, 1, z}, {1.25, 1, z + 8}, {1, 1.25, z + 8}};
}

std::future<FrameOutput> submit(Session& session, uint64_t number) {
  const Points floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, tip = falling(number % 2 == 1);
  std::vector<FrameUpdate> updates;
  if (number == 0) updates.push_back({.mesh = 0, .positions = std::as_bytes(std::span(floor))});
  updates.push_back({.mesh = 1, .positions = std::as_bytes(std::span(tip))});
  return session.submit(updates);
}

void check(const FrameOutput& output, uint64_t number) {
  if (number == 0) return;
  const Contacts& found = output.vertex_triangle;
  const double expected = number % 2 == 1 ? 0.25 : 0.75;
  if (found.toi.size() == 1 && std::abs(found.toi[0] - expected) < 1e-3) return;
  throw std::runtime_error("frame " + std::to_string(number) + ": not the contact at " + std::to_string(expected));
}

v1::SceneSpec spec() {
  v1::SceneSpec out;
  out.set_mode(v1::DETECTION_MODE_CCD);
  out.set_position_format(v1::POSITION_FORMAT_F64);
  return out;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: routed_session ADDRESS\n", stderr), 2;
  const std::vector<std::array<uint32_t, 3>> one{{0, 1, 2}};
  const MeshInput meshes[] = {{.name = "floor", .vertex_count = 3, .triangles = one},
                              {.name = "falling", .vertex_count = 3, .triangles = one}};
  SessionOptions options;
  options.stream.window = 3;
  Session session = Session::open(argv[1], spec(), meshes, options);
  std::atomic<bool> is_over = false;
  std::thread reader([&] {
    char byte;
    while (read(STDIN_FILENO, &byte, 1) > 0) {
    }
    is_over = true;
  });
  std::deque<std::future<FrameOutput>> in_flight;
  uint64_t sent = 0, answered = 0;
  auto last = Clock::now();
  Clock::duration longest{};
  while (!is_over || !in_flight.empty()) {
    while (!is_over && in_flight.size() < session.window()) in_flight.push_back(submit(session, sent++));
    if (in_flight.empty()) break;
    check(in_flight.front().get(), answered++);
    const auto now = Clock::now();
    longest = std::max(longest, now - std::exchange(last, now));
    in_flight.pop_front();
    if (answered % 10 == 0) std::printf("%s\n", session.scene().scene_id().c_str()), std::fflush(stdout);
  }
  reader.join();
  std::printf("answered %ju longest wait %.2f s reconnects %ju recreations %ju\n", static_cast<uintmax_t>(answered),
              std::chrono::duration<double>(longest).count(), static_cast<uintmax_t>(session.reconnects()),
              static_cast<uintmax_t>(session.recreations()));
  session.close();
} catch (const std::exception& error) {
  std::fprintf(stderr, "routed_session: %s\n", error.what());
  std::_Exit(1);
}
