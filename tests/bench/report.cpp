#include "tests/bench/report.hpp"

#include <algorithm>
#include <cstdio>
#include <ostream>
#include <stdexcept>

namespace collided::test {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

std::string hex(uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

void write_counts(std::ostream& out, const FrameCounts& c) {
  out << "{\"tests\": " << c.tests << ", \"pairs\": " << c.pairs
      << ", \"candidates_vt\": " << c.candidates.vertex_triangle << ", \"candidates_ee\": " << c.candidates.edge_edge
      << ", \"contacts_vt\": " << c.contacts.vertex_triangle << ", \"contacts_ee\": " << c.contacts.edge_edge
      << ", \"cells\": " << c.cells << ", \"leaves\": " << c.leaves << ", \"registrations\": " << c.registrations
      << ", \"top_level\": " << c.top_level << ", \"base_level\": " << c.base_level << "}";
}

void write_scene(std::ostream& out, const SceneReport& s) {
  out << "    {\"scene\": " << quoted(s.name) << ", \"triangles\": " << s.triangles << ", \"steps\": " << s.steps
      << ", \"total_ms\": " << s.total_ms << ", \"wall_ms\": " << s.wall_ms << ",\n     \"stage_ms\": {";
  for (size_t i = 0; i < s.stage_ms.size(); ++i)
    out << (i ? ", " : "") << quoted(s.stage_ms[i].first) << ": " << s.stage_ms[i].second;
  out << "},\n     \"counts\": ";
  write_counts(out, s.counts);
  out << ",\n     \"device_bytes\": " << s.device_bytes << ", \"replays\": " << s.replays
      << ", \"digest\": " << quoted(hex(s.digest)) << "}";
}

}  // namespace

std::string device_name(Backend backend, int threads) {
  for (const DeviceInfo& device : list_devices(threads))
    if (device.device.backend == backend) return device.name;
  throw std::runtime_error("no such device");
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void write_json(std::ostream& out, const RunReport& r) {
  out << "{\n  \"date\": " << quoted(r.date) << ", \"commit\": " << quoted(r.commit)
      << ", \"device\": " << quoted(r.device) << ",\n  \"mode\": " << quoted(r.mode)
      << ", \"accuracy\": " << quoted(r.accuracy) << ", \"scalar\": " << quoted(r.scalar)
      << ", \"thickness\": " << r.thickness << ", \"positions\": \"" << r.positions << "\",\n  \"scenes\": [\n";
  for (size_t i = 0; i < r.scenes.size(); ++i) {
    write_scene(out, r.scenes[i]);
    out << (i + 1 < r.scenes.size() ? ",\n" : "\n");
  }
  out << "  ]\n}\n";
}

}  // namespace collided::test
