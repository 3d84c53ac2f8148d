#pragma once
// What a scene in parts should cost, from what it costs on one device.
//
// Every part boxes all triangles and measures the scene; it then goes over all boxes once more, to leave out those that
// are not its own, which reads and writes as much as the measuring did. All that follows is of its own pairs alone. So
//
//   step(n) = boxes + 2 levels + work / n,   work: all other stages
//
// with the stages' times on one device, if shares are even. It knows nothing of triangles that lie in several parts'
// blocks, nor of what a launch costs that has little to do; both make small scenes slower than this. Bytes: all parts
// bring all positions, each through its own link, and each answers with its own contacts.

#include <cstdint>
#include <map>
#include <string>

namespace collided::test {

struct StepCost {
  double boxes = 0, levels = 0, work = 0;  ///< milliseconds

  /// Of the stages of a step; transfers are no part of it.
  static StepCost of(const std::map<std::string, double>& stages) {
    StepCost cost;
    for (const auto& [stage, milliseconds] : stages) {
      if (stage == "upload" || stage == "download") continue;
      (stage == "boxes" ? cost.boxes : stage == "levels" ? cost.levels : cost.work) += milliseconds;
    }
    return cost;
  }
  double in_parts(size_t parts) const { return boxes + 2 * levels + work / static_cast<double>(parts); }
};

}  // namespace collided::test
