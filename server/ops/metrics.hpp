#pragma once
// What Prometheus scrapes from the daemon.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace collided::server {

/// Where the time of a frame goes, from its arrival to its last answer.
enum class Phase { kQueue, kDecode, kUpload, kCompute, kDownload, kEncode };

/// One frame that was answered.
struct FrameTotals {
  double seconds = 0;  ///< from its arrival to its last answer
  uint64_t contacts = 0;
  uint64_t bytes_in = 0;   ///< of its request
  uint64_t bytes_out = 0;  ///< of its answers
  uint64_t replays = 0;    ///< runs again because a buffer was too small
};

/// What is so at the time of a scrape.
struct Gauges {
  uint64_t scenes = 0;
  uint64_t streams = 0;
  uint64_t calls = 0;  ///< in work, frame streams apart
  uint64_t device_bytes = 0;
  uint64_t queued_frames = 0;
  uint64_t outgoing_bytes = 0;  ///< answers that wait for their client
  uint64_t connections = 0;     ///< of gRPC
  uint64_t evicted = 0;         ///< connections that were ended to make room, since the start
};

/// Thread-safe. Counting takes no lock that a scrape holds for long, and allocates only for names not seen before.
class Metrics {
 public:
  Metrics();
  ~Metrics();

  void observe_phase(Phase phase, double seconds);
  /// A stage of the engine. At most 64 names are told apart; the others count as "other".
  void observe_stage(std::string_view stage, double seconds);
  void count_frame(const FrameTotals& frame);
  /// Frames passed over by LATEST_WINS.
  void count_skipped(uint64_t frames = 1);
  /// A refused frame or call; `reason` is the name of its gRPC code, as RESOURCE_EXHAUSTED.
  void count_rejected(std::string_view reason);
  /// A stream that took up a scene where a broken one left it.
  void count_reconnect();
  /// Files for TLS that have changed: whether they were taken, or the ones before stay.
  void count_certificate_reload(bool is_taken);
  /// A connection that was ended because its client reset too many calls.
  void count_reset_flood();
  /// An ended call: its method without the service, and the name of its gRPC code; other than OK and CANCELLED it is
  /// rejected, too.
  void count_call(std::string_view method, std::string_view code);

  /// Called at each scrape, by the thread of the scrape. An empty function: no scene and no stream; once it is set, the
  /// one before is not running any more.
  void set_gauges(std::function<Gauges()> gauges);

  /// Prometheus text format 0.0.4.
  std::string text() const;

 private:
  struct Families;
  const std::unique_ptr<Families> families_;
};

}  // namespace collided::server
