// The memory that a client may share, and the ranges that a frame may name.
#include "server/transport/local/shared_region.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "server/errors.hpp"
#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kPage = 4096;

auto map(int file, uint64_t input, uint64_t output = 0) {
  return SharedRegion::map(Fd(dup(file)), {input, output}, {Backend::kCpu});
}

std::string refusal(int file, uint64_t input) try {
  map(file, input);
  return "";
} catch (const InvalidInput& e) {
  EXPECT_EQ(e.field(), "open.file");
  return e.what();
}

TEST(SharedRegion, IsInputThenOutput) {
  const Memory memory(3 * kPage);
  const auto region = map(memory.file(), 2 * kPage, kPage);
  memory.put(kPage, "position");
  region->output()[0] = std::byte{'c'};
  EXPECT_EQ(std::memcmp(region->input(kPage, 8, "range").data(), "position", 8), 0);
  EXPECT_EQ(memory.data()[2 * kPage], std::byte{'c'});
  EXPECT_EQ(region->output().size(), kPage);
}

TEST(SharedRegion, NeedsTheSealAndCannotBeCutThen) {
  const Memory unsealed(kPage, 0), grow_only(kPage, F_SEAL_GROW), sealed(kPage, F_SEAL_SHRINK);
  EXPECT_NE(refusal(unsealed.file(), kPage).find("F_SEAL_SHRINK"), std::string::npos);
  EXPECT_NE(refusal(grow_only.file(), kPage).find("F_SEAL_SHRINK"), std::string::npos);
  const auto region = map(sealed.file(), kPage);
  EXPECT_NE(ftruncate(sealed.file(), 0), 0);
  EXPECT_EQ(region->input(0, kPage, "range").back(), std::byte{0});
}

TEST(SharedRegion, StaysWhenPagesAreGivenBack) {
  const Memory memory(2 * kPage);
  const auto region = map(memory.file(), kPage, kPage);
  memory.put(0, "position");
  ASSERT_EQ(fallocate(memory.file(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 2 * kPage), 0);
  EXPECT_EQ(region->input(0, kPage, "range").front(), std::byte{0});
  region->output()[0] = std::byte{1};
}

TEST(SharedRegion, IsAMemfdThatTheDaemonCanWriteTo) {
  const Folder folder;
  const Fd plain(open(folder.file("plain").c_str(), O_RDWR | O_CREAT, 0600));
  const Fd tmpfs(open("/dev/shm", O_TMPFILE | O_RDWR, 0600));
  int pipes[2];
  ASSERT_EQ(pipe(pipes), 0);
  const Fd reader(pipes[0]), writer(pipes[1]);
  for (const int file : {plain.get(), tmpfs.get(), reader.get(), -1}) {
    if (file == plain.get() || file == tmpfs.get()) (void)!ftruncate(file, kPage);
    EXPECT_FALSE(refusal(file, kPage).empty()) << file;
  }
  const Fd frozen(memfd_create("frozen", MFD_ALLOW_SEALING));
  ASSERT_EQ(ftruncate(frozen.get(), kPage), 0);
  ASSERT_EQ(fcntl(frozen.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_WRITE), 0);
  EXPECT_NE(refusal(frozen.get(), kPage).find("writing"), std::string::npos);
}

TEST(SharedRegion, HasTheBytesThatItSays) {
  const Memory memory(2 * kPage);
  EXPECT_NE(refusal(memory.file(), 3 * kPage).find("8192"), std::string::npos);
  EXPECT_EQ(refusal(memory.file(), 2 * kPage), "");
}

TEST(SharedRegion, RangesLieInTheInput) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  const Memory memory(2 * kPage);
  const auto region = map(memory.file(), kPage, kPage);
  const std::pair<uint64_t, uint64_t> bad[] = {{0, kPage + 1}, {kPage, 1},     {kPage + 8, 0}, {8, kPage},
                                               {kMost, 1},     {1, kMost},     {kMost, kMost}, {kMost - 7, 16},
                                               {8, kMost - 7}, {kMost - 7, 0}, {4, 8}};
  for (const auto& [offset, size] : bad)
    EXPECT_THROW(region->input(offset, size, "range"), InvalidInput) << offset << " " << size;
  EXPECT_EQ(region->input(0, kPage, "range").size(), kPage);
  EXPECT_EQ(region->input(kPage, 0, "range").size(), 0u);
  EXPECT_EQ(region->input(kPage - 8, 8, "range").size(), 8u);
}

}  // namespace
}  // namespace collided::server
