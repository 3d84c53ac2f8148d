// Median times of stages over several frames.

#include "client/measure/stage_medians.hpp"

#include <map>
#include <string>

#include "client/measure/statistics.hpp"

namespace collided::cli {

Json median_stages(const std::vector<v1::FrameMetrics>& frames) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<double>> times;
  for (const v1::FrameMetrics& frame : frames) {
    Json stages = stages_json(frame);
    stages["total"] = frame.total_milliseconds();
    for (const auto& [name, ms] : stages.items()) {
      if (!times.contains(name)) order.push_back(name);
      times[name].push_back(ms.get<double>());
    }
  }
  Json out = Json::object();
  for (const std::string& name : order) out[name] = median(times[name]);
  return out;
}

}  // namespace collided::cli
