#pragma once
// What Prometheus scrapes from the daemon.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/ops/counters.hpp"

namespace collided::server {

/// Where the time of a frame goes, from its arrival to its last answer.
enum class Phase { kQueue, kDecode, kUpload, kCompute, kDownload, kEncode };

/// One frame that was answered.
struct FrameTotals {
  double seconds = 0;  ///< from its arrival to its last answer
  uint64_t contacts = 0;
  uint64_t bytes_in = 0;   ///< of its positions and indices
  uint64_t bytes_out = 0;  ///< of its answer's arrays
  uint64_t replays = 0;    ///< runs repeated because a buffer was too small
};

/// One device at the time of a scrape.
struct DeviceGauges {
  std::string device;  ///< its id, such as "cuda:1"
  uint64_t scenes = 0;
  uint64_t held_bytes = 0, max_bytes = 0, free_bytes = 0;
  uint64_t waiting_frames = 0;  ///< for a turn
  double busy_seconds = 0;      ///< of work on frames, since the start
};

/// State at the time of a scrape.
struct Gauges {
  uint64_t scenes = 0;
  uint64_t streams = 0;
  uint64_t watchers = 0;
  uint64_t calls = 0;  ///< open, without frame streams and watches
  uint64_t device_bytes = 0;
  uint64_t queued_frames = 0;
  uint64_t outgoing_bytes = 0;  ///< of answers waiting for their clients
  uint64_t connections = 0;     ///< of gRPC
  uint64_t evicted = 0;         ///< connections ended to make room, since the start
  uint64_t max_scenes = 0;      ///< limits, of all clients together
  uint64_t max_streams = 0;
  uint64_t max_device_bytes = 0;
  bool is_ready = false;  ///< as /readyz tells
  std::vector<DeviceGauges> devices = {};
};

/// Thread-safe. Counting takes no lock that a scrape holds for long, and allocates only for new names.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  void observe_phase(Phase phase, double seconds);
  /// A stage of the engine. At most 64 names are distinguished; the others count as "other".
  void observe_stage(std::string_view stage, double seconds);
  void count_frame(const FrameTotals& frame);
  /// A frame's engine and why it was chosen, names as in FrameMetrics.
  void count_engine(std::string_view engine, std::string_view reason);
  void count(CounterId id, uint64_t times = 1);
  /// A refused frame or call; `reason` is the name of its gRPC code, such as RESOURCE_EXHAUSTED.
  void count_rejected(std::string_view reason);
  /// Changed TLS files: whether they were loaded, or the previous ones kept.
  void count_certificate_reload(bool is_taken);
  /// An ended call: its method without the service, and the name of its gRPC code. Any code but OK and CANCELLED counts
  /// as a rejection, too.
  void count_call(std::string_view method, std::string_view code);

  /// `gauges` is called at each scrape, on its thread; an empty function means no scene and no stream. When this
  /// returns, the previous function is no longer running.
  void set_gauges(std::function<Gauges()> gauges);

  /// Prometheus text format 0.0.4.
  std::string text() const;

 private:
  struct Families;
  const std::unique_ptr<Families> families_;
};

}  // namespace collided::server
