// Refuses to start where the system's limits leave too few threads or too little memory.
#include "server/start_limits.hpp"

#include <pthread.h>
#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "server/config/host_limits.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kMegabyte = uint64_t{1} << 20;

// With two cores a daemon has 17 threads when it starts and 25 with its first clients. Of these gRPC's pools grow with
// the cores, up to a size.
constexpr size_t kFixedThreads = 22;
constexpr unsigned kMostCoresOfPools = 16;

// Beside stacks: gRPC, a small scene and its frames; and for malloc two arenas, each of which reserves twice its 64 MiB
// for a moment.
constexpr uint64_t kWorkingBytes = 64 * kMegabyte, kReservedBytes = 192 * kMegabyte;

// Of new threads, as glibc has it.
uint64_t stack_bytes() {
  pthread_attr_t attributes;
  size_t bytes = 0;
  if (pthread_attr_init(&attributes) != 0) return 8 * kMegabyte;
  pthread_attr_getstacksize(&attributes, &bytes);
  pthread_attr_destroy(&attributes);
  return bytes;
}

struct Mapped {
  uint64_t all = 0, data = 0;  ///< bytes
};

// Fields of /proc/self/statm, in pages: size, resident, shared, text, 0, data.
Mapped mapped() {
  std::ifstream file("/proc/self/statm");
  uint64_t size = 0, skipped = 0, data = 0;
  file >> size >> skipped >> skipped >> skipped >> skipped >> data;
  const auto page = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return {size * page, data * page};
}

void check_memory(const char* name, uint64_t limit, uint64_t need, const char* what, const StartNeeds& needs) {
  if (limit >= need) return;
  throw std::runtime_error(
      fmt::format("{} is {} MiB, but the daemon needs {} MiB of {} to start (of which {} threads' stacks)", name,
                  limit / kMegabyte, (need + kMegabyte - 1) / kMegabyte, what, needs.threads));
}

/// Threads that wait until all of them are to end.
class Trial {
 public:
  Trial() { gate_.lock(); }
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  ~Trial() {
    gate_.unlock();
    for (std::thread& thread : threads_) thread.join();
  }

  /// Returns how many threads could be started.
  size_t start(size_t count) try {
    threads_.reserve(count);
    while (threads_.size() < count) threads_.emplace_back([this] { const std::lock_guard wait(gate_); });
    return threads_.size();
  } catch (const std::system_error&) {
    return threads_.size();
  } catch (const std::bad_alloc&) {
    return threads_.size();
  }

 private:
  std::mutex gate_;
  std::vector<std::thread> threads_;
};

std::string thread_limits() {
  std::string limits;
  const auto add = [&](const std::string& name, uint64_t limit) {
    if (limit != kNoLimit) limits += fmt::format("{}{} is {}", limits.empty() ? "" : ", ", name, limit);
  };
  add("pids.max of its cgroup", cgroup_limit(kCgroupProcesses));
  if (geteuid() != 0) add("RLIMIT_NPROC, for all processes of the user,", soft_limit(RLIMIT_NPROC));
  return limits.empty() ? "the system has no more" : limits;
}

}  // namespace

StartNeeds start_needs(const Config& config, unsigned cores, uint64_t stack_bytes) {
  const size_t engine = config.threads > 0 ? static_cast<size_t>(config.threads) : cores;
  const size_t threads = kFixedThreads + 4 * size_t{std::min(cores, kMostCoresOfPools)} + engine;
  const uint64_t data = threads * stack_bytes + kWorkingBytes;
  return {threads, data + kReservedBytes, data};
}

void check_start_limits(const Config& config) {
  const StartNeeds needs = start_needs(config, std::max(1u, std::thread::hardware_concurrency()), stack_bytes());
  const Mapped now = mapped();
  check_memory("RLIMIT_AS", soft_limit(RLIMIT_AS), now.all + needs.address_space, "address space", needs);
  check_memory("RLIMIT_DATA", soft_limit(RLIMIT_DATA), now.data + needs.data, "data", needs);
  Trial trial;
  if (const size_t started = trial.start(needs.threads); started < needs.threads)
    throw std::runtime_error(fmt::format("the daemon needs {} threads to start, but only {} could be started: {}",
                                         needs.threads, started, thread_limits()));
}

}  // namespace collided::server
