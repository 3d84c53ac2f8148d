// What Prometheus scrapes from the daemon.
#include "server/ops/metrics.hpp"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <shared_mutex>

#include "server/ops/log.hpp"
#include "server/ops/process.hpp"

namespace collided::server {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;
using prometheus::Labels;
using prometheus::Registry;

constexpr size_t kMaxStages = 64, kMaxReasons = 32, kMaxCalls = 512, kMaxEngines = 64;
constexpr const char* kOther = "other";
constexpr std::array<const char*, 6> kPhases = {"queue", "decode", "upload", "compute", "download", "encode"};

Histogram::BucketBoundaries buckets() {
  return {50e-6, 100e-6, 250e-6, 500e-6, 1e-3, 2.5e-3, 5e-3, 10e-3, 25e-3, 50e-3, 100e-3, 250e-3, 500e-3, 1};
}

Family<Counter>& counters(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

std::vector<Counter*> unlabelled(Registry& registry) {
  std::vector<Counter*> out;
  for (const CounterRow& row : kCounters) out.push_back(&counters(registry, row.name, row.help).Add({}));
  return out;
}

/// Counts what is counted elsewhere, whose total may only grow.
void raise_to(Counter& counter, double total) {
  if (const double more = total - counter.Value(); more > 0) counter.Increment(more);
}

Family<Histogram>& histograms(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

Family<Gauge>& gauges_of(Registry& registry, const char* name, const char* help) {
  return prometheus::BuildGauge().Name(name).Help(help).Register(registry);
}

Gauge& gauge(Registry& registry, const char* name, const char* help, const Labels& labels = {}) {
  return gauges_of(registry, name, help).Add(labels);
}

/// The values of a metric's labels; the second is empty where there is one label.
using LabelValues = std::pair<std::string, std::string>;
using LabelViews = std::pair<std::string_view, std::string_view>;

struct LabelOrder {
  using is_transparent = void;
  template <class A, class B>
  bool operator()(const A& a, const B& b) const {
    return LabelViews(a) < LabelViews(b);
  }
};

// Metrics of one family by label values. Past `max` of them all others share one, so that callers cannot create an
// unbounded number. What is known is found without an allocation, as each frame is.
template <class Metric>
class ByLabels {
 public:
  using Make = std::function<Metric&(const LabelValues&)>;
  ByLabels(size_t max, LabelValues shared, Make make) : max_(max), shared_(std::move(shared)), make_(std::move(make)) {}

  Metric& at(std::string_view first, std::string_view second = {}) {
    const LabelViews key(first, second);
    {
      std::shared_lock lock(mutex_);
      if (const auto found = metrics_.find(key); found != metrics_.end()) return *found->second;
    }
    std::unique_lock lock(mutex_);
    if (const auto known = metrics_.find(key); known != metrics_.end()) return *known->second;
    return add(metrics_.size() < max_ ? LabelValues(key) : shared_);
  }

 private:
  Metric& add(const LabelValues& key) {
    const auto [at, is_new] = metrics_.try_emplace(key, nullptr);
    if (is_new) at->second = &make_(key);
    return *at->second;
  }

  const size_t max_;
  const LabelValues shared_;
  const Make make_;
  std::shared_mutex mutex_;
  std::map<LabelValues, Metric*, LabelOrder> metrics_;  // guarded by mutex_
};

template <class Metric>
ByLabels<Metric> by_label(size_t max, typename ByLabels<Metric>::Make make) {
  return {max, {kOther, ""}, std::move(make)};
}

ByLabels<Counter> by_pair(size_t max, Family<Counter>& family, const char* first, const char* second) {
  return {max, {kOther, kOther}, [&family, first, second](const LabelValues& values) -> Counter& {
            return family.Add({{first, values.first}, {second, values.second}});
          }};
}

}  // namespace

struct Metrics::Families {
  Families();

  void set_gauges_now() const;
  void set_gauges_of(const DeviceGauges& device) const;
  Counter& of(CounterId id) const { return *counts[static_cast<size_t>(id)]; }
  void raise(CounterId id, double total) const { raise_to(of(id), total); }

  Registry registry;
  const std::vector<Counter*> counts;  ///< by CounterId
  Histogram& frame_seconds;
  Gauge &scenes, &streams, &watchers, &calls_in_work, &device_bytes, &queued_frames, &outgoing_bytes, &connections;
  Gauge &max_scenes, &max_streams, &max_device_bytes, &ready;
  Gauge &heap_bytes, &resident_bytes, &open_files;
  Family<Gauge>&device_scenes, &device_held_bytes, &device_max_bytes, &device_free_bytes, &device_waiting_frames;
  Family<Counter>& device_busy_seconds;
  Family<Histogram>& phase_family;
  Family<Histogram>& stage_family;
  Family<Counter>& rejected_family;
  Family<Counter>& call_family;
  Family<Counter>& engine_family;
  Family<Counter>& certificate_family;
  Counter &certificates_taken, &certificates_refused;  // both from the start, so that the first is seen to increase
  std::vector<Histogram*> phases;
  ByLabels<Histogram> stages;
  ByLabels<Counter> rejected, calls, engines;
  mutable std::mutex gauges_mutex;
  std::function<Gauges()> gauges;  // guarded by gauges_mutex
};

Metrics::Families::Families()
    : counts(unlabelled(registry)),
      frame_seconds(
          histograms(registry, "collided_frame_seconds", "Time of a frame from its arrival to its last answer")
              .Add({}, buckets())),
      scenes(gauge(registry, "collided_scenes", "Resident scenes")),
      streams(gauge(registry, "collided_streams", "Open streams")),
      watchers(gauge(registry, "collided_watchers", "Open calls of WatchScene")),
      calls_in_work(gauge(registry, "collided_calls_in_work", "Open calls, without frame streams and watches")),
      device_bytes(
          gauge(registry, "collided_device_bytes", "Bytes that all scenes hold, on their backends and on the host")),
      queued_frames(gauge(registry, "collided_queued_frames", "Frames waiting for their turn")),
      outgoing_bytes(gauge(registry, "collided_outgoing_bytes", "Bytes of answers waiting for their clients")),
      connections(gauge(registry, "collided_connections", "Connections of gRPC")),
      max_scenes(gauge(registry, "collided_max_scenes", "Limit of resident scenes")),
      max_streams(gauge(registry, "collided_max_streams", "Limit of open streams")),
      max_device_bytes(gauge(registry, "collided_max_device_bytes", "Limit of the bytes that all scenes hold")),
      ready(gauge(registry, "collided_ready", "1 while /readyz is 200, else 0")),
      heap_bytes(gauge(registry, "collided_heap_bytes", "Bytes that the daemon holds of the memory of its process")),
      resident_bytes(gauge(registry, "process_resident_memory_bytes", "Resident memory size in bytes")),
      open_files(gauge(registry, "process_open_fds", "Number of open file descriptors")),
      device_scenes(gauges_of(registry, "collided_device_scenes", "Scenes that live on the device")),
      device_held_bytes(gauges_of(registry, "collided_device_held_bytes", "Bytes that the scenes of the device hold")),
      device_max_bytes(
          gauges_of(registry, "collided_device_max_bytes", "Limit of the bytes that the scenes of the device hold")),
      device_free_bytes(gauges_of(registry, "collided_device_free_bytes",
                                  "Bytes that a new scene may have on the device, by its limit and its memory")),
      device_waiting_frames(
          gauges_of(registry, "collided_device_waiting_frames", "Frames waiting for a turn on the device")),
      device_busy_seconds(counters(registry, "collided_device_busy_seconds_total",
                                   "Seconds of work on frames on the device, of all that run at once")),
      phase_family(histograms(registry, "collided_phase_seconds",
                              "Time of a frame in each phase from its arrival to its last answer")),
      stage_family(
          histograms(registry, "collided_stage_seconds",
                     "Time of a frame in each stage of the engine, once for each run, all within the phase compute")),
      rejected_family(
          counters(registry, "collided_rejected_total", "Refused frames and calls, by the name of the gRPC code")),
      call_family(counters(registry, "collided_calls_total", "Ended calls, by method and name of the gRPC code")),
      engine_family(counters(registry, "collided_broad_phase_frames_total",
                             "Answered frames, by what found their pairs, and why it was chosen")),
      certificate_family(
          counters(registry, "collided_certificate_reloads_total", "Changed TLS files, by result: taken or refused")),
      certificates_taken(certificate_family.Add({{"result", "taken"}})),
      certificates_refused(certificate_family.Add({{"result", "refused"}})),
      stages(by_label<Histogram>(kMaxStages,
                                 [this](const LabelValues& values) -> Histogram& {
                                   return stage_family.Add({{"stage", values.first}}, buckets());
                                 })),
      rejected(by_label<Counter>(kMaxReasons,
                                 [this](const LabelValues& values) -> Counter& {
                                   return rejected_family.Add({{"reason", values.first}});
                                 })),
      calls(by_pair(kMaxCalls, call_family, "method", "code")),
      engines(by_pair(kMaxEngines, engine_family, "engine", "reason")) {
  for (const auto* phase : kPhases) phases.push_back(&phase_family.Add({{"phase", phase}}, buckets()));
  gauge(registry, "collided_build_info", "1, labelled with the version", {{"version", COLLIDED_VERSION}}).Set(1);
  gauge(registry, "process_start_time_seconds", "Start time of the process since the Unix epoch in seconds")
      .Set(process_start_seconds());
}

void Metrics::Families::set_gauges_now() const {
  std::lock_guard lock(gauges_mutex);
  const auto now = gauges ? gauges() : Gauges();
  scenes.Set(static_cast<double>(now.scenes));
  streams.Set(static_cast<double>(now.streams));
  watchers.Set(static_cast<double>(now.watchers));
  calls_in_work.Set(static_cast<double>(now.calls));
  device_bytes.Set(static_cast<double>(now.device_bytes));
  queued_frames.Set(static_cast<double>(now.queued_frames));
  outgoing_bytes.Set(static_cast<double>(now.outgoing_bytes));
  connections.Set(static_cast<double>(now.connections));
  max_scenes.Set(static_cast<double>(now.max_scenes));
  max_streams.Set(static_cast<double>(now.max_streams));
  max_device_bytes.Set(static_cast<double>(now.max_device_bytes));
  ready.Set(now.is_ready ? 1 : 0);
  for (const DeviceGauges& device : now.devices) set_gauges_of(device);
  raise(CounterId::kEvictedConnections, static_cast<double>(now.evicted));
  heap_bytes.Set(process_heap_bytes());
  resident_bytes.Set(process_resident_bytes());
  open_files.Set(process_open_files());
  raise(CounterId::kDroppedLogLines, static_cast<double>(dropped_log_lines()));
}

void Metrics::Families::set_gauges_of(const DeviceGauges& device) const {
  const Labels labels{{"device", device.device}};
  device_scenes.Add(labels).Set(static_cast<double>(device.scenes));
  device_held_bytes.Add(labels).Set(static_cast<double>(device.held_bytes));
  device_max_bytes.Add(labels).Set(static_cast<double>(device.max_bytes));
  device_free_bytes.Add(labels).Set(static_cast<double>(device.free_bytes));
  device_waiting_frames.Add(labels).Set(static_cast<double>(device.waiting_frames));
  raise_to(device_busy_seconds.Add(labels), device.busy_seconds);
}

Metrics::Metrics() : families_(std::make_unique<Families>()) {}
Metrics::~Metrics() = default;

void Metrics::observe_phase(Phase phase, double seconds) {
  families_->phases[static_cast<size_t>(phase)]->Observe(seconds);
}

void Metrics::observe_stage(std::string_view stage, double seconds) { families_->stages.at(stage).Observe(seconds); }

void Metrics::count_frame(const FrameTotals& frame) {
  families_->frame_seconds.Observe(frame.seconds);
  count(CounterId::kFrames);
  count(CounterId::kContacts, frame.contacts);
  count(CounterId::kReceivedBytes, frame.bytes_in);
  count(CounterId::kSentBytes, frame.bytes_out);
  count(CounterId::kReplays, frame.replays);
}

void Metrics::count_engine(std::string_view engine, std::string_view reason) {
  families_->engines.at(engine, reason).Increment();
}
void Metrics::count(CounterId id, uint64_t times) { families_->of(id).Increment(static_cast<double>(times)); }
void Metrics::count_rejected(std::string_view reason) { families_->rejected.at(reason).Increment(); }

void Metrics::count_certificate_reload(bool is_taken) {
  (is_taken ? families_->certificates_taken : families_->certificates_refused).Increment();
}

void Metrics::count_call(std::string_view method, std::string_view code) {
  families_->calls.at(method, code).Increment();
  if (code != "OK" && code != "CANCELLED") count_rejected(code);
}

void Metrics::set_gauges(std::function<Gauges()> gauges) {
  std::lock_guard lock(families_->gauges_mutex);
  families_->gauges = std::move(gauges);
}

std::string Metrics::text() const {
  families_->set_gauges_now();
  return prometheus::TextSerializer().Serialize(families_->registry.Collect());
}

}  // namespace collided::server
