// What virtual subdivision registers and tests where boxes of triangles are cut, as the engine does, and where the
// triangles themselves are, whose pieces have smaller boxes; and how many pairs of boxes the latter does not find.
// Counts in CCD, of a model on the host; the cells are the engine's.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "gpu/engines/octree/cell_grid.hpp"
#include "gpu/engines/octree/subdivision.hpp"
#include "tests/bench/inputs.hpp"

namespace collided::test {
namespace {

using nlohmann::json;

/// A triangle on its way, or a piece of one.
struct Moving {
  Vec3<double> start[3], end[3];

  static Box<double> bounds(const Vec3<double> (&p)[3]) {
    return join(join(Box<double>{p[0], p[0]}, Box<double>{p[1], p[1]}), Box<double>{p[2], p[2]});
  }
  Box<float> box() const { return outward_float(join(bounds(start), bounds(end))); }
  /// Of the larger of the two that it is at either end: cutting it does not make its way shorter.
  double extent() const {
    return std::max(largest_side(outward_float(bounds(start))), largest_side(outward_float(bounds(end))));
  }
  /// One corner and the middles of the edges there; of three or more, the middles of all edges.
  Moving quarter(int corner) const {
    Moving made;
    for (int k = 0; k < 3; ++k) {
      const int from = corner < 3 ? corner : k, to = corner < 3 ? (corner + k) % 3 : (k + 1) % 3;
      made.start[k] = 0.5 * (start[from] + start[to]);
      made.end[k] = 0.5 * (end[from] + end[to]);
    }
    return made;
  }
};

std::vector<Moving> triangles_of(const Case& c) {
  std::vector<Moving> triangles;
  for (size_t mesh = 0; mesh < c.meshes.size(); ++mesh)
    for (const auto& corners : c.meshes[mesh].triangles) {
      Moving& made = triangles.emplace_back();
      for (int k = 0; k < 3; ++k) {
        const Vec3d &s = c.start[mesh][corners[k]], &e = c.end[mesh][corners[k]];
        made.start[k] = {s[0], s[1], s[2]}, made.end[k] = {e[0], e[1], e[2]};
      }
    }
  return triangles;
}

/// The cells that the engine chooses.
LevelGrid grid_of(std::vector<Box<float>>& boxes) {
  const Span<const Box<float>> all{boxes.data(), boxes.size()};
  Box<float> bounds = boxes[0];
  for (const Box<float>& box : boxes) bounds = join(bounds, box);
  uint64_t extents = 0;
  for (const Box<float>& box : boxes) extents += extent_of(box, bounds);
  const OrdinaryExtentOf extent{{&bounds, &extents, boxes.size()}, all};
  OrdinaryExtents ordinary{};
  for (uint64_t i = 0; i < boxes.size(); ++i) ordinary = AddOrdinaryExtents{}(ordinary, extent(i));
  GridState state{};
  SpanCells<OrdinaryMean>{&bounds, {&bounds, &ordinary}, 1, deepest_base(boxes.size()), &state.grid}(0);
  LevelTotals totals{};
  for (uint64_t i = 0; i < boxes.size(); ++i) totals = AddTotals{}(totals, CoveredPerLevelOf{&state.grid, all}(i));
  ChooseCells{&totals, 0, &state}(0);
  return state.grid;
}

using Cells = std::vector<uint32_t>;  ///< numbers within the level, each once

void add_cells(const LevelGrid& grid, const Box<float>& box, Cells& cells) {
  const CellRange range = grid.range(grid.base, box);
  for (uint32_t z = range.lo.z; z <= range.hi.z; ++z)
    for (uint32_t y = range.lo.y; y <= range.hi.y; ++y)
      for (uint32_t x = range.lo.x; x <= range.hi.x; ++x) cells.push_back(morton({x, y, z}));
}
/// Quarters, and quarters of those, until they are no larger than a cell.
void add_cells_of_pieces(const LevelGrid& grid, const Moving& triangle, int depth, Cells& cells) {
  const double cell = (1u << (kDeepest - grid.base)) / static_cast<double>(grid.cells_per_length);
  if (depth == 0 || triangle.extent() <= cell) return add_cells(grid, triangle.box(), cells);
  for (int corner = 0; corner < 4; ++corner) add_cells_of_pieces(grid, triangle.quarter(corner), depth - 1, cells);
}

struct Counts {
  uint64_t registrations = 0, tests = 0, pairs = 0;
};

/// `tests`: pairs that share a cell, each once.
Counts count(const std::vector<Cells>& cells_of, const std::vector<Box<float>>& boxes, const LevelGrid& grid) {
  std::vector<std::vector<uint32_t>> members(uint64_t{1} << (3 * grid.base));
  for (uint32_t i = 0; i < cells_of.size(); ++i)
    for (const uint32_t cell : cells_of[i]) members[cell].push_back(i);
  Counts counts;
  for (const auto& of_cell : members) counts.registrations += of_cell.size() > 1 ? of_cell.size() : 0;
  std::vector<uint32_t> met_by(cells_of.size(), ~0u);
  for (uint32_t a = 0; a < cells_of.size(); ++a)
    for (const uint32_t cell : cells_of[a])
      for (const uint32_t b : members[cell])
        if (b > a && std::exchange(met_by[b], a) != a) ++counts.tests, counts.pairs += overlap(boxes[a], boxes[b]);
  return counts;
}

struct Both {
  Counts boxes, triangles;
};
Both count(const Case& c) {
  constexpr int kDepth = 8;  // more than the levels of any grid
  const std::vector<Moving> triangles = triangles_of(c);
  std::vector<Box<float>> boxes;
  for (const Moving& triangle : triangles) boxes.push_back(triangle.box());
  const LevelGrid grid = grid_of(boxes);
  std::vector<Cells> of_boxes(boxes.size()), of_pieces(boxes.size());
  for (size_t i = 0; i < boxes.size(); ++i) {
    add_cells(grid, boxes[i], of_boxes[i]);
    add_cells_of_pieces(grid, triangles[i], kDepth, of_pieces[i]);
    std::ranges::sort(of_pieces[i]);
    of_pieces[i].erase(std::ranges::unique(of_pieces[i]).begin(), of_pieces[i].end());
  }
  return {count(of_boxes, boxes, grid), count(of_pieces, boxes, grid)};
}

/// Means over the steps.
json counts_of(const std::vector<Both>& steps, Counts Both::*which) {
  const auto mean = [&](uint64_t Counts::*count) {
    uint64_t sum = 0;
    for (const Both& step : steps) sum += step.*which.*count;
    return (sum + steps.size() / 2) / steps.size();
  };
  return {{"registrations", mean(&Counts::registrations)},
          {"tests", mean(&Counts::tests)},
          {"pairs", mean(&Counts::pairs)}};
}

}  // namespace
}  // namespace collided::test

int main(int argc, char** argv) {
  using namespace collided::test;
  CLI::App app("Counts what virtual subdivision makes where boxes are cut and where triangles are, as JSON");
  std::string scene, date, commit;
  double scale = 1;
  int steps = 10;
  app.add_option("--scene", scene, "One scene; default: all");
  app.add_option("--scale", scale, "Refines the grids")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--steps", steps, "Steps of a scene")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--date", date, "Recorded in the result");
  app.add_option("--commit", commit, "Recorded in the result");
  CLI11_PARSE(app, argc, argv);
  try {
    json result{{"date", date}, {"commit", commit}, {"steps", steps}, {"scenes", json::array()}};
    for (const BenchInput& input : bench_inputs(scene, scale)) {
      std::vector<Both> counts;
      for (int step = 0; step < steps; ++step)
        counts.push_back(count(rounded(input.at(step, steps), collided::Scalar::kF32)));
      result["scenes"].push_back({{"scene", input.name},
                                  {"boxes", counts_of(counts, &Both::boxes)},
                                  {"triangles", counts_of(counts, &Both::triangles)}});
    }
    if (result["scenes"].empty()) throw std::invalid_argument("no scene is called " + scene);
    std::cout << result.dump(2) << "\n";
  } catch (const std::exception& error) {
    std::cerr << "collided_subdivision_bench: " << error.what() << "\n";
    return 1;
  }
}
