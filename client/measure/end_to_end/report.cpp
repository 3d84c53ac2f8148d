// Results of 'collidectl bench --end-to-end' as JSON and as a table.

#include "client/measure/end_to_end/report.hpp"

#include <cstdio>

#include "client/app/report/numbers.hpp"
#include "client/measure/statistics.hpp"

namespace collided::cli {

namespace {

Json times_json(std::vector<double> ms) { return {{"p50", median(ms)}, {"p99", quantile(ms, 0.99)}}; }

template <class Value>
std::vector<double> values(const std::vector<FrameTime>& frames, const Value& value) {
  std::vector<double> out;
  for (const FrameTime& frame : frames) out.push_back(value(frame));
  return out;
}

Json transport_times_json(const TransportTimes& transport, const EndToEndRun& run) {
  const auto of = [&](double FrameTime::*field) {
    return values(transport.frames, [field](const FrameTime& frame) { return frame.*field; });
  };
  const std::vector<double> overhead =
      values(transport.frames, [](const FrameTime& frame) { return frame.latency - frame.engine; });
  return {{"transport", transport.name},
          {"latency_ms", times_json(of(&FrameTime::latency))},
          {"engine_ms", times_json(of(&FrameTime::engine))},
          {"overhead_ms", times_json(overhead)},
          {"overhead_to_bare_tcp", median(overhead) / median(run.bare.tcp)},
          {"overhead_to_held_tcp", median(overhead) / median(run.held.tcp)},
          {"decode_ms", median(of(&FrameTime::decode))},
          {"encode_ms", median(of(&FrameTime::encode))},
          {"queue_ms", median(of(&FrameTime::queue))}};
}

std::string line(const std::vector<std::string>& cells) {
  std::string out;
  for (size_t i = 0; i < cells.size(); ++i) {
    char cell[64];
    std::snprintf(cell, sizeof cell, i == 0 ? "    %-20s" : " %9s", cells[i].c_str());
    out += cell;
  }
  return out + "\n";
}

std::string ms_text(const Json& ms) { return milliseconds_text(ms.get<double>()); }

std::string transport_line(const Json& transport) {
  const Json &latency = transport.at("latency_ms"), &overhead = transport.at("overhead_ms");
  return line({transport.at("transport"), ms_text(latency.at("p50")), ms_text(latency.at("p99")),
               ms_text(transport.at("engine_ms").at("p50")), ms_text(overhead.at("p50")), ms_text(overhead.at("p99")),
               format_double("%.2f", transport.at("overhead_to_bare_tcp")),
               format_double("%.2f", transport.at("overhead_to_held_tcp")), ms_text(transport.at("decode_ms")),
               ms_text(transport.at("encode_ms")), ms_text(transport.at("queue_ms"))});
}

}  // namespace

FrameTime frame_time(double latency, const v1::FrameMetrics& metrics) {
  FrameTime out{.latency = latency,
                .engine = metrics.engine_milliseconds(),
                .decode = metrics.decode_milliseconds(),
                .encode = metrics.encode_milliseconds(),
                .queue = metrics.queue_milliseconds()};
  if (out.engine == 0)
    for (const v1::StageTime& stage : metrics.stages()) out.engine += stage.milliseconds();
  return out;
}

Json end_to_end_json(const EndToEndRun& run) {
  Json out = {{"scene", run.name},
              {"scale", run.scale},
              {"vertices", run.scene.vertex_count()},
              {"triangles", run.scene.triangle_count()},
              {"frames", run.bare.tcp.size()},
              {"bytes_in", median(run.bytes_up)},
              {"bytes_out", median(run.bytes_down)},
              {"bare_ms",
               {{"tcp", times_json(run.bare.tcp)},
                {"tcp, held", times_json(run.held.tcp)},
                {"unix", times_json(run.bare.unix_stream)},
                {"unix, held", times_json(run.held.unix_stream)},
                {"few bytes, held", times_json(run.held_control)}}},
              {"transports", Json::array()}};
  for (const TransportTimes& transport : run.transports)
    out["transports"].push_back(transport_times_json(transport, run));
  return out;
}

Json end_to_end_file(const std::vector<EndToEndRun>& runs, int warm_up) {
  const Json scene = scene_json(runs.front().scene);
  Json settings = {{"warm_up", warm_up}};
  for (const char* name : {"mode", "accuracy", "position_format", "thickness", "delta", "report", "kinds", "engine"})
    settings[name] = scene.at(name);
  Json out = {{"device", runs.front().scene.device()}, {"settings", settings}, {"runs", Json::array()}};
  for (const EndToEndRun& run : runs) out["runs"].push_back(end_to_end_json(run));
  return out;
}

std::string end_to_end_lines(const Json& run) {
  const auto count = [&](const char* name) { return count_text(run.at(name).get<uint64_t>()); };
  std::string out = run.at("scene").get<std::string>() + ", scale " + format_double("%.4g", run.at("scale")) + ": " +
                    count("triangles") + " triangles, " + count("bytes_in") + " bytes up, " + count("bytes_out") +
                    " bytes down, " + count("frames") + " frames\n";
  out += line(
      {"milliseconds", "p50", "p99", "engine", "overhead", "p99", "to bare", "to held", "decode", "encode", "queue"});
  for (const Json& transport : run.at("transports")) out += transport_line(transport);
  for (const auto& [name, ms] : run.at("bare_ms").items())
    out += line({"bare " + name, ms_text(ms.at("p50")), ms_text(ms.at("p99"))});
  return out;
}

}  // namespace collided::cli
