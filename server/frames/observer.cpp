// Turns events of scenes and frames into metrics, log lines and the daemon's state.
#include "server/frames/observer.hpp"

#include <algorithm>
#include <string_view>

#include "server/convert/options.hpp"
#include "server/ops/log.hpp"
#include "server/refusals/status.hpp"

namespace collided::server {
namespace {

constexpr double kSecond = 1000;  // milliseconds
constexpr std::string_view kUpload = "upload", kDownload = "download";

double stage_milliseconds(const FrameResult& result, std::string_view name) {
  double milliseconds = 0;
  for (const auto& stage : result.stages)
    if (stage.stage == name) milliseconds += stage.milliseconds;
  return milliseconds;
}

}  // namespace

void ServiceObserver::answered(const Scene&, const AnsweredFrame& frame) {
  const FrameCost& cost = frame.cost;
  metrics_.observe_phase(Phase::kQueue, cost.queue_milliseconds / kSecond);
  metrics_.observe_phase(Phase::kDecode, cost.decode_milliseconds / kSecond);
  metrics_.observe_phase(Phase::kEncode, cost.encode_milliseconds / kSecond);
  // Not the step's own time, which covers only its last run and no exact arithmetic.
  const double upload = stage_milliseconds(frame.result, kUpload),
               download = stage_milliseconds(frame.result, kDownload);
  metrics_.observe_phase(Phase::kUpload, upload / kSecond);
  metrics_.observe_phase(Phase::kCompute, std::max(0.0, cost.engine_milliseconds - upload - download) / kSecond);
  metrics_.observe_phase(Phase::kDownload, download / kSecond);
  for (const auto& stage : frame.result.stages)
    if (stage.stage != kUpload && stage.stage != kDownload)
      metrics_.observe_stage(stage.stage, stage.milliseconds / kSecond);
  metrics_.count_engine(label_of(frame.result.broad_phase.engine), label_of(frame.result.broad_phase.reason));
  metrics_.count_frame({cost.total_milliseconds / kSecond, count_contacts(frame.result), cost.bytes_in, cost.bytes_out,
                        frame.result.replays});
}

void ServiceObserver::refused(const Scene&, uint64_t, const std::exception_ptr& error) {
  metrics_.count_rejected(code_name(describe(error).code));
}

void ServiceObserver::counted(const Scene&, CounterId id, uint64_t times) { metrics_.count(id, times); }

void ServiceObserver::expired(const Scene& scene) {
  log_event(spdlog::level::info, "scene deleted: its lease ran out",
            {{"scene", scene.id()}, {"lease_seconds", scene.identity().lease_seconds}});
}

void ServiceObserver::device_failed(const Scene& scene, const std::string& why) {
  const auto plan = scene.plan();
  log_event(spdlog::level::err, "device error",
            {{"scene", scene.id()}, {"device", to_string(plan->engine.device)}, {"reason", why}});
  for (const Device& device : devices_of(plan->engine))
    if (!device_works(device)) lifecycle_.fail("a device no longer responds: " + to_string(device) + ": " + why);
}

}  // namespace collided::server
