// A process that holds device memory for another: reads a size (8 bytes) and that many bytes from its input, puts them
// on the device, writes the memory's handle (64 bytes), and holds the memory until its input ends.

#include <cuda_runtime.h>

#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
  uint64_t size = 0;
  if (std::fread(&size, sizeof(size), 1, stdin) != 1) return 1;
  std::vector<char> bytes(size);
  if (std::fread(bytes.data(), 1, size, stdin) != size) return 2;
  void* memory = nullptr;
  cudaIpcMemHandle_t handle;
  if (cudaMalloc(&memory, size) != cudaSuccess) return 3;
  if (cudaMemcpy(memory, bytes.data(), size, cudaMemcpyHostToDevice) != cudaSuccess) return 4;
  if (cudaDeviceSynchronize() != cudaSuccess) return 5;
  if (cudaIpcGetMemHandle(&handle, memory) != cudaSuccess) return 6;
  if (std::fwrite(&handle, sizeof(handle), 1, stdout) != 1 || std::fflush(stdout) != 0) return 7;
  std::getchar();
  return cudaFree(memory) == cudaSuccess ? 0 : 8;
}
