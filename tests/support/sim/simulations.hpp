#pragma once
// Bodies to simulate, small enough for a step to take a few milliseconds on two cores.

#include <span>

#include "tests/support/sim/simulator.hpp"

namespace collided::test {

struct Simulation {
  const char* name;
  Bodies (*make)();
};

/// cloth_on_sphere, sheets, soft_boxes, box_stack, knot.
std::span<const Simulation> simulations();
/// Throws std::out_of_range.
const Simulation& simulation(const std::string& name);

}  // namespace collided::test
