// A motion that is played to and fro.

#include "client/cli/web/demo.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "client/app/daemon/connection.hpp"
#include "client/app/input/mesh_input.hpp"

namespace collided::cli {

int frame_to_and_fro(uint64_t step, int frames) {
  if (frames == 1) return 0;
  const auto last = static_cast<uint64_t>(frames - 1), at = step % (2 * last);
  return static_cast<int>(at <= last ? at : 2 * last - at);
}

void play_to_and_fro(client::FrameStream& stream, const Motion& motion, const v1::SceneSpec& spec, double rate,
                     const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  const auto interval = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate));
  std::mutex mutex;
  std::condition_variable_any stopped;
  for (uint64_t step = 0; !stop.stop_requested(); ++step) {
    const auto next = Clock::now() + interval;
    const auto positions = motion.positions(frame_to_and_fro(step, motion.frames));
    run_frame(stream, make_frame(motion.meshes, step + 1, spec, positions));
    std::unique_lock lock(mutex);
    stopped.wait_until(lock, stop, next, [] { return false; });
  }
}

}  // namespace collided::cli
