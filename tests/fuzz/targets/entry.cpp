// What libFuzzer and replay.cpp call, in every target.

#include "tests/fuzz/targets/fuzz.hpp"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  collided::fuzz::run(collided::fuzz::Input(data, size));
  return 0;
}
