#pragma once
// What a refusal of bad input names.

#include <gtest/gtest.h>

#include <string>

#include "gpu/detector.hpp"

namespace collided::test {

/// The path that InvalidInput names; "" if nothing was thrown.
template <class Action>
std::string refused_field(Action&& action) {
  try {
    action();
  } catch (const InvalidInput& e) {
    EXPECT_STRNE("", e.what());
    EXPECT_FALSE(e.field().empty());
    return e.field();
  }
  return "";
}

}  // namespace collided::test
