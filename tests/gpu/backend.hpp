#pragma once
// The backend that this executable tests, and a fixture that skips where it is missing.

#include <gtest/gtest.h>

#include "gpu/detector.hpp"

namespace collided::test {

/// Given by the library that is linked: collided_tests_on_cpu or collided_tests_on_cuda.
extern const Backend kBackend;

template <class Base = ::testing::Test>
class OnBackend : public Base {
 protected:
  void SetUp() override {
    if (kBackend == Backend::kCuda && !cuda_available()) GTEST_SKIP() << "no CUDA device can be used";
  }
};

/// Settings of a scene on the backend under test; meshes are added later.
inline SceneSpec settings(Mode mode, Accuracy accuracy, Scalar scalar = Scalar::kF64, double thickness = 0) {
  SceneSpec spec;
  spec.device.backend = kBackend;
  spec.mode = mode;
  spec.accuracy = accuracy;
  spec.scalar = scalar;
  spec.thickness = thickness;
  return spec;
}

}  // namespace collided::test
