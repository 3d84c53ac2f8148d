// The exact decisions on facts known by construction.

#include "gpu/exact/exact.hpp"

#include <gtest/gtest.h>

TEST(Exact, Builds) {}
