// Preloaded into a daemon: breaks its device as soon as the file $COLLIDED_FAIL_DEVICE exists, like a kernel that
// crashes.
#include <pthread.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace {

__global__ void fail_kernel() { __trap(); }

void wait_and_fail(const char* file) {
  while (!std::filesystem::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  fail_kernel<<<1, 1>>>();
  cudaDeviceSynchronize();
}

// The daemon takes its signals in one thread, which must not be this one.
__attribute__((constructor)) void begin() {
  const char* const file = std::getenv("COLLIDED_FAIL_DEVICE");
  if (!file) return;
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  std::thread(wait_and_fail, file).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace
