// Shared memory that is not what its client claims, which the daemon survives.
#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {
namespace {

constexpr uint64_t kPage = 4096;

/// The tip's end positions at any range of the input.
pb::Frame ranged_frame(uint64_t id, uint64_t offset, uint64_t size) {
  pb::Frame frame;
  frame.set_frame_id(id);
  auto* const tip = frame.add_updates();
  tip->set_mesh(1);
  tip->mutable_shared_positions()->set_offset(offset);
  tip->mutable_shared_positions()->set_size(size);
  return frame;
}

class HostileMemory : public testing::Test {
 protected:
  static pb::CreateSceneRequest leased_tip() {
    auto request = tip_request();
    request.set_lease_seconds(1);
    return request;
  }
  void SetUp() override {
    daemon_.expect_good_streams();
    before_.emplace(daemon_.probe());
    scene_ = daemon_.make_scene(leased_tip());
  }
  void TearDown() override {
    daemon_.expect_good_streams();
    if (before_) before_->expect_back();
  }
  pb::LocalClosed refusal(const pb::LocalRequest& request, const std::vector<int>& files) const {
    const RawLocal raw(daemon_.path());
    raw.send(request, files);
    return raw.closed();
  }
  void expect_refused_file(const char* what, int file) {
    const auto closed = refusal(open_request(scene_, kPage, kPage), {file});
    EXPECT_EQ(closed.code(), grpc::INVALID_ARGUMENT) << what << ": " << closed.message();
    EXPECT_EQ(closed.field(), "open.file") << what << ": " << closed.message();
  }

  LocalDaemon daemon_;
  std::string scene_;
  std::optional<Baseline> before_;
};

// The seal forbids it. Pages can be released, and are then zero.
TEST_F(HostileMemory, IsNotTakenAwayUnderTheDaemon) {
  LocalStream stream(daemon_.path(), scene_);
  expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  const int file = stream.memory().file();
  for (const off_t bytes : {0, 1, 4096}) {
    EXPECT_EQ(ftruncate(file, bytes), -1);
    EXPECT_EQ(errno, EPERM);
  }
  expect_tip_contact(stream.ask_shared(tip_frame(2, 3)), 3);
  ASSERT_EQ(fallocate(file, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 320 << 10), 0);
  const Answer zeros = stream.ask(ranged_frame(3, 0, 36));
  EXPECT_TRUE(zeros.done) << (zeros.error ? zeros.error->message() : "the stream ended");
  // A GPU has pinned the previous pages: from now on the client shares different ones with it.
  LocalStream next(daemon_.path(), daemon_.make_scene(leased_tip()));
  expect_tip_contact(next.ask_shared(first_frame(4)), 4);
}

TEST_F(HostileMemory, IsRefusedUnlessItIsASealedMemfdOfThatSize) {
  constexpr size_t kWanted = 2 * kPage;
  expect_refused_file("unsealed", Memory(kWanted, 0).file());
  expect_refused_file("sealed against growth alone", Memory(kWanted, F_SEAL_GROW).file());
  expect_refused_file("sealed against writing", Memory(kWanted, kGoodSeals | F_SEAL_FUTURE_WRITE).file());
  expect_refused_file("too small", Memory(kWanted - 1).file());
  const OpenFolder folder;
  for (const std::string& path :
       {folder.file("disk"), std::string("/dev/shm/collided-test-") + std::to_string(getpid())}) {
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(ftruncate(file, kWanted), 0);
    expect_refused_file(path.c_str(), file);
    close(file);
    std::filesystem::remove(path);
  }
  int pipe_ends[2];
  ASSERT_EQ(pipe2(pipe_ends, O_CLOEXEC), 0);
  for (const int end : pipe_ends) {
    expect_refused_file("pipe", end);
    close(end);
  }
}

TEST_F(HostileMemory, SizesThatAreLiesAreRefused) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max() / kPage * kPage;
  struct Case {
    uint64_t input, output;
    int code;
    const char* field;
  };
  const Memory memory(2 * kPage);
  for (const auto& [input, output, code, field] : {Case{kPage, 2 * kPage, grpc::INVALID_ARGUMENT, "open.file"},
                                                   Case{kPage, uint64_t{1} << 30, grpc::INVALID_ARGUMENT, "open.file"},
                                                   Case{kPage + 1, kPage, grpc::INVALID_ARGUMENT, "open.input_bytes"},
                                                   Case{kPage, kPage - 1, grpc::INVALID_ARGUMENT, "open.output_bytes"},
                                                   Case{kMost, kPage, grpc::RESOURCE_EXHAUSTED, "open.input_bytes"},
                                                   Case{kMost, kMost, grpc::RESOURCE_EXHAUSTED, "open.input_bytes"},
                                                   Case{kPage, kMost, grpc::RESOURCE_EXHAUSTED, "open.output_bytes"}}) {
    const auto closed = refusal(open_request(scene_, input, output), {memory.file()});
    EXPECT_EQ(closed.code(), code) << closed.message();
    EXPECT_EQ(closed.field(), field) << closed.message();
  }
}

// Including sums of offset and size that wrap around. The stream continues.
TEST_F(HostileMemory, RangesThatAreLiesAreRefused) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  LocalStream stream(daemon_.path(), scene_);
  expect_tip_contact(stream.ask_shared(first_frame(2)), 2);
  const uint64_t input = LocalSizes().input;
  uint64_t id = 2;
  for (const auto& [offset, size] : std::vector<std::pair<uint64_t, uint64_t>>{
           {input, 36}, {input - 32, 36}, {kMost - 35, 36}, {kMost - 7, 8}, {0, kMost}, {0, input + 8}, {4, 36}}) {
    const Answer answer = stream.ask(ranged_frame(id++, offset, size));
    ASSERT_TRUE(answer.error) << offset << " " << size;
    EXPECT_EQ(answer.error->code(), grpc::INVALID_ARGUMENT) << answer.error->message();
    EXPECT_TRUE(answer.error->field().starts_with("frame.updates[0].shared_positions")) << answer.error->field();
  }
  expect_tip_contact(stream.ask_shared(tip_frame(id, 3)), 3);
}

}  // namespace
}  // namespace collided::test
