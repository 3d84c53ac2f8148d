#pragma once
// A sink that records the answers of a frame stream, in order.

#include <mutex>
#include <string>
#include <vector>

#include "server/errors.hpp"
#include "server/frames/session.hpp"
#include "tests/server/wait_until.hpp"

namespace collided::server {

/// The class of an exception that ends streams.
inline std::string kind_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const TakenOver&) {
    return "TakenOver";
  } catch (const NotFound&) {
    return "NotFound";
  } catch (const LimitExceeded&) {
    return "LimitExceeded";
  } catch (const DeviceError&) {
    return "DeviceError";
  } catch (const Stopping&) {
    return "Stopping";
  } catch (...) {
    return "another error";
  }
}

class RecordingSink final : public FrameSink {
 public:
  using Events = std::vector<std::string>;

  void opened(const Scene& scene) override { add("opened after " + std::to_string(scene.snapshot().last_frame_id)); }
  void answered(const Scene&, const std::shared_ptr<AnsweredFrame>& frame) override {
    add("answered " + std::to_string(frame->frame_id));
  }
  void refused(uint64_t frame_id, const Failure& failure) override {
    add("refused " + std::to_string(frame_id) + ": " + code_name(failure.code));
  }
  void skipped(uint64_t frame_id) override { add("skipped " + std::to_string(frame_id)); }
  void draining(double seconds) override { add("draining " + std::to_string(seconds).substr(0, 3)); }
  void ended(const std::exception_ptr& why) override { add("ended: " + kind_of(why)); }

  Events events() const {
    const std::lock_guard lock(mutex_);
    return events_;
  }
  /// The events recorded once there are `count`, or after 30 s.
  Events wait_for(size_t count) const {
    wait_until([&] { return events().size() >= count; });
    return events();
  }

 private:
  void add(std::string event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
  }

  mutable std::mutex mutex_;
  Events events_;
};

}  // namespace collided::server
