#pragma once
// Which failpoint of a daemon fails, and when: memory that the test and its daemon share through a file.

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>

namespace collided::test {

constexpr const char* kControlVariable = "COLLIDED_FAULT_CONTROL";  ///< names the file

struct FaultControl {
  std::atomic<int> calls_left;  ///< the failpoint fails at the last of them; 0: none does
  std::atomic<bool> lasts;      ///< whether it also fails at all later calls
  std::atomic<int> failed;      ///< calls
  int error;                    ///< errno, or the error of the CUDA runtime
  char symbol[96];              ///< written while calls_left is 0, as the error is
};

/// Null if the file cannot be mapped.
inline FaultControl* map_control(const char* file) {
  const int fd = open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0 || ftruncate(fd, sizeof(FaultControl)) != 0) return nullptr;
  void* const memory = mmap(nullptr, sizeof(FaultControl), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  return memory == MAP_FAILED ? nullptr : static_cast<FaultControl*>(memory);
}

}  // namespace collided::test
