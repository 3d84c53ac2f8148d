// The memory and processes that a process may have, read from files in the kernel's formats.
#include "server/config/host_limits.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace collided::server {
namespace {

constexpr uint64_t kGigabyte = uint64_t{1} << 30;

class HostMemory : public testing::Test {
 protected:
  HostMemory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "collided-memory-XXXXXX").string();
    root_ = mkdtemp(pattern.data());
    put("/proc/meminfo", "MemTotal:        8388608 kB\nMemFree:         1234 kB\n");
  }
  ~HostMemory() override { std::filesystem::remove_all(root_); }

  void put(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(root_ + path).parent_path());
    std::ofstream(root_ + path) << text;
  }
  uint64_t memory() const { return host_memory(root_); }
  uint64_t processes() const { return cgroup_limit(kCgroupProcesses, root_); }

 private:
  std::string root_;
};

TEST_F(HostMemory, IsTheHostsWhereNothingBoundsIt) {
  EXPECT_EQ(memory(), 8 * kGigabyte);
  put("/proc/self/cgroup", "0::/\n");
  EXPECT_EQ(memory(), 8 * kGigabyte);
  put("/sys/fs/cgroup/memory.max", "max\n");
  EXPECT_EQ(memory(), 8 * kGigabyte);
}

TEST_F(HostMemory, IsTheLeastOfTheGroupsOnTheWay) {
  put("/proc/self/cgroup", "0::/system.slice/collided.service\n");
  put("/sys/fs/cgroup/system.slice/collided.service/memory.max", "max\n");
  put("/sys/fs/cgroup/system.slice/memory.max", "2147483648\n");
  EXPECT_EQ(memory(), 2 * kGigabyte);
  put("/sys/fs/cgroup/system.slice/collided.service/memory.max", "1073741824\n");
  EXPECT_EQ(memory(), kGigabyte);
}

// A container sees only its own cgroup, as the root, though its path is the host's.
TEST_F(HostMemory, IsThatOfTheContainer) {
  put("/proc/self/cgroup", "0::/docker/0123abcd\n");
  put("/sys/fs/cgroup/memory.max", "536870912\n");
  EXPECT_EQ(memory(), kGigabyte / 2);
}

TEST_F(HostMemory, IsThatOfTheOldHierarchy) {
  put("/proc/self/cgroup", "5:cpu,cpuacct:/other\n4:memory:/job/step:one\n1:name=systemd:/x\n");
  put("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(memory(), 8 * kGigabyte);
  put("/sys/fs/cgroup/memory/job/step:one/memory.limit_in_bytes", "3221225472\n");
  EXPECT_EQ(memory(), 3 * kGigabyte);
  put("/sys/fs/cgroup/memory/job/memory.limit_in_bytes", "1073741824\n");
  EXPECT_EQ(memory(), kGigabyte);
}

TEST_F(HostMemory, ProcessesAreLimitedByTheGroupsOnTheWay) {
  EXPECT_EQ(processes(), kNoLimit);
  put("/proc/self/cgroup", "8:pids:/job/one\n0::/\n");
  put("/sys/fs/cgroup/pids/job/one/pids.max", "max\n");
  EXPECT_EQ(processes(), kNoLimit);
  put("/sys/fs/cgroup/pids/job/pids.max", "12\n");
  EXPECT_EQ(processes(), 12u);
  put("/proc/self/cgroup", "0::/system.slice/collided.service\n");
  put("/sys/fs/cgroup/system.slice/collided.service/pids.max", "40\n");
  EXPECT_EQ(processes(), 40u);
}

TEST_F(HostMemory, IsUnknownWhereNothingTells) {
  put("/proc/meminfo", "nonsense\n");
  put("/proc/self/cgroup", "nonsense\n0::\n");
  put("/sys/fs/cgroup/memory.max", "-1\n");
  EXPECT_EQ(memory(), 0u);
}

TEST(RealHostMemory, IsKnown) { EXPECT_GT(host_memory(), uint64_t{64} << 20); }

}  // namespace
}  // namespace collided::server
