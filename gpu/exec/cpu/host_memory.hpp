#pragma once
// Memory of the host as the memory of a backend.

#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include "gpu/exec/memory_ledger.hpp"

namespace collided {

/// Aligned to 64 bytes and booked in a scene's ledger. From any thread.
class HostMemory {
 public:
  explicit HostMemory(std::shared_ptr<MemoryLedger> ledger) : ledger_(std::move(ledger)) {}

  void* allocate(const std::string& part, uint64_t bytes) {
    constexpr uint64_t kAlignment = 64;
    ledger_->take(part, bytes);
    void* memory = std::aligned_alloc(kAlignment, (bytes + kAlignment - 1) / kAlignment * kAlignment);
    if (memory == nullptr) {
      ledger_->give_back(part, bytes);
      throw ResourceExhausted(part + ": the host has no " + std::to_string(bytes) + " bytes left");
    }
    return memory;
  }
  void deallocate(const std::string& part, void* memory, uint64_t bytes) {
    std::free(memory);
    ledger_->give_back(part, bytes);
  }
  const std::shared_ptr<MemoryLedger>& ledger() const { return ledger_; }

 private:
  std::shared_ptr<MemoryLedger> ledger_;
};

}  // namespace collided
