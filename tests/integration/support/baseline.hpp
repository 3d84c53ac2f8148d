#pragma once
// What an idle daemon holds, to compare with what it holds after an attack.

#include <string>
#include <thread>

#include "tests/integration/support/probe.hpp"

namespace collided::test {

class Baseline {
 public:
  explicit Baseline(const Probe& probe) : probe_(probe) {
    for (Gauge& gauge : gauges_) gauge.value = probe_.metric(gauge.name);
    resident_ = resident();
    threads_ = probe_.threads();
  }

  /// Everything taken since has been released; of resident memory, all but `slack` MiB, which an allocator may keep.
  /// The daemon serves.
  void expect_back(double slack = 48) const {
    for (const Gauge& gauge : gauges_)
      eventually(gauge.name + std::string(" goes back to ") + std::to_string(gauge.value),
                 [&] { return probe_.metric(gauge.name) <= gauge.value; });
    // A scene is off the gauges before its memory is freed.
    eventually("resident memory goes back to " + std::to_string(resident_),
               [&] { return resident() - resident_ < memory_limit(slack); });
    // gRPC's pools grow and shrink by a few threads for each processor as calls come and go.
    eventually("threads go back to " + std::to_string(threads_), [&] { return probe_.threads() <= threads_ + pool_; });
    EXPECT_TRUE(probe_.is_ready());
  }

 private:
  struct Gauge {
    const char* name;
    double value = 0;
  };

  const double pool_ = 4 + 2.0 * std::thread::hardware_concurrency();

  double resident() const { return probe_.metric("process_resident_memory_bytes"); }

  const Probe& probe_;
  Gauge gauges_[6] = {{"collided_streams"},       {"collided_scenes"},         {"collided_device_bytes"},
                      {"collided_queued_frames"}, {"collided_outgoing_bytes"}, {"process_open_fds"}};
  double resident_ = 0, threads_ = 0;
};

}  // namespace collided::test
