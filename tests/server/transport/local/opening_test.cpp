// Refused openings: the client is told why, and nothing is left behind.
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <fstream>

#include "tests/server/transport/local/serving.hpp"

namespace collided::server {
namespace {

constexpr uint64_t kPage = 4096;

class LocalOpening : public testing::Test {
 protected:
  pb::LocalClosed refusal(const pb::LocalRequest& request, const std::vector<int>& files = {}) {
    const RawLocal raw(serving_.path());
    raw.send(request, files);
    return raw.closed();
  }
  pb::LocalRequest good() const { return test::open_request(scene_, kPage, kPage); }
  void TearDown() override {
    EXPECT_TRUE(eventually([&] { return serving_.server().connections() == 0; }));
    EXPECT_EQ(serving_.host().usage().streams(), 0u);
    EXPECT_TRUE(eventually([&] { return open_files() == files_; })) << open_files() << " " << files_;
  }

  Serving serving_;
  std::string scene_ = serving_.make_scene();
  size_t files_ = open_files();
};

TEST_F(LocalOpening, GoodOne) {
  const Memory memory(2 * kPage);
  const RawLocal raw(serving_.path());
  raw.send(good(), {memory.file()});
  const auto response = raw.receive();
  ASSERT_TRUE(response && response->frame().has_opened());
  EXPECT_EQ(response->frame().opened().window(), 2u);
  EXPECT_EQ(response->frame().opened().scene().scene_id(), scene_);
  raw.half_close();
  EXPECT_EQ(raw.closed().code(), 0);
}

TEST_F(LocalOpening, NamesWhatIsWrong) {
  struct Case {
    const char* field;
    int code;
    std::function<void(pb::LocalOpen&)> spoil;
  };
  const Case cases[] = {
      {"open.version", 3, [](auto& open) { open.set_version(2); }},
      {"open.version", 3, [](auto& open) { open.clear_version(); }},
      {"scene_id", 5, [](auto& open) { open.mutable_open()->set_scene_id("none"); }},
      {"open.window", 8, [](auto& open) { open.mutable_open()->set_window(17); }},
      {"open.delivery", 3, [](auto& open) { open.mutable_open()->set_delivery(pb::DeliveryPolicy(9)); }},
      {"open.resume_token", 7, [](auto& open) { open.mutable_open()->set_resume_token("guess"); }},
      {"open.input_bytes", 3, [](auto& open) { open.set_input_bytes(kPage + 1); }},
      {"open.input_bytes", 8, [](auto& open) { open.set_input_bytes(uint64_t{1} << 40); }},
      {"open.input_bytes", 8, [](auto& open) { open.set_input_bytes(~uint64_t{0} / kPage * kPage); }},
      {"open.output_bytes", 3, [](auto& open) { open.set_output_bytes(1); }},
      {"open.output_bytes", 8, [](auto& open) { open.set_output_bytes((uint64_t{1} << 30) + kPage); }},
      {"open.file", 3, [](auto& open) { open.set_input_bytes(2 * kPage); }},
      {"open.cuda_ipc_handle", 9, [](auto& open) { open.set_cuda_ipc_handle(std::string(64, 'h')); }},
      {"open.output_cuda_ipc_handle", 9, [](auto& open) { open.set_output_cuda_ipc_handle(std::string(64, 'h')); }},
  };
  const Memory memory(2 * kPage);
  for (const auto& one : cases) {
    auto request = good();
    one.spoil(*request.mutable_open());
    const auto closed = refusal(request, {memory.file()});
    EXPECT_EQ(closed.code(), one.code) << closed.message();
    EXPECT_TRUE(closed.field().ends_with(one.field)) << closed.field() << " is not " << one.field;
    EXPECT_FALSE(closed.message().empty());
  }
}

// Where the daemon takes device memory; of scenes on CPU cores there is none.
TEST_F(LocalOpening, DeviceMemoryIsRefusedByFieldAndValue) {
  Config config = Serving::cpu_config();
  config.cuda_ipc = true;
  Serving daemon({}, config);
  const std::string scene = daemon.make_scene(), handle(64, 'h');
  struct Case {
    const char* message;
    uint64_t input, output;
    std::string input_handle, output_handle;
    bool has_file;
  };
  const Case cases[] = {
      {"open.cuda_ipc_handle has 63 bytes, but a handle has 64", 0, 0, handle.substr(1), "", false},
      {"open.output_cuda_ipc_handle has 63 bytes, but a handle has 64", 0, 2 * kPage, "", handle.substr(1), false},
      {"open.input_bytes is 4096, but must be 0 with cuda_ipc_handle", kPage, 0, handle, "", true},
      {"open.output_bytes is 4096, but must be 8192 or more with output_cuda_ipc_handle: 4096 for each frame of the "
       "window",
       0, kPage, "", handle, false},
      {"open.output_bytes is 0, but must be 8192 or more with output_cuda_ipc_handle: 4096 for each frame of the "
       "window",
       kPage, 0, "", handle, true},
      {"open.output_bytes is 8200, but must be a multiple of 4096", 0, 2 * kPage + 8, "", handle, false},
      {"open.file was passed 1 times, but must be passed 0 times for these sizes: it is the memfd", 0, 2 * kPage, "",
       handle, true},
      {"open.file was passed 0 times, but must be passed 1 times for these sizes: it is the memfd", kPage, 2 * kPage,
       "", handle, false},
      {"open.cuda_ipc_handle is set, but scene {} is not on a GPU: it lives on cpu:0", 0, 0, handle, "", false},
      {"open.output_cuda_ipc_handle is set, but scene {} is not on a GPU: it lives on cpu:0", 0, 2 * kPage, "", handle,
       false},
      {"open.output_cuda_ipc_handle is set, but scene {} is not on a GPU: it lives on cpu:0", kPage, 2 * kPage, "",
       handle, true},
  };
  const Memory memory(4 * kPage);
  for (const Case& one : cases) {
    auto request = test::open_request(scene, one.input, one.output);
    request.mutable_open()->set_cuda_ipc_handle(one.input_handle);
    request.mutable_open()->set_output_cuda_ipc_handle(one.output_handle);
    const RawLocal raw(daemon.path());
    raw.send(request, one.has_file ? std::vector<int>{memory.file()} : std::vector<int>{});
    const auto closed = raw.closed();
    EXPECT_EQ(closed.message(), fmt::format(fmt::runtime(one.message), scene));
    EXPECT_EQ(closed.field(), std::string(one.message).substr(0, std::string(one.message).find(' ')));
  }
  EXPECT_TRUE(eventually([&] { return daemon.server().connections() == 0; }));
}

TEST_F(LocalOpening, DeviceMemoryIsRefusedForAScenesShards) {
  Config config = Serving::cpu_config();
  config.cuda_ipc = true;
  Serving daemon({}, config);
  auto sharded = test::tip_request();
  sharded.mutable_spec()->add_part_devices("cpu:0");
  sharded.mutable_spec()->add_part_devices("cpu:0");
  const std::string scene = daemon.make_scene(sharded);
  auto request = test::open_request(scene, 0, 0);
  request.mutable_open()->set_cuda_ipc_handle(std::string(64, 'h'));
  const RawLocal raw(daemon.path());
  raw.send(request, {});
  EXPECT_EQ(raw.closed().message(), "open.cuda_ipc_handle is set, but scene " + scene +
                                        " is in parts on several devices (spec.part_devices), whose positions and "
                                        "contacts are in the host's memory");
}

TEST_F(LocalOpening, OneFileOfTheRightKind) {
  const Memory memory(2 * kPage), unsealed(2 * kPage, 0);
  EXPECT_EQ(refusal(good(), {unsealed.file()}).field(), "open.file");
  EXPECT_EQ(refusal(good()).field(), "open.file");
  EXPECT_EQ(refusal(good(), {memory.file(), memory.file()}).field(), "open.file");
  EXPECT_EQ(refusal(good(), {memory.file(), memory.file(), memory.file(), memory.file()}).code(), 3);
  EXPECT_EQ(refusal(good(), std::vector<int>(100, memory.file())).code(), 8);
  EXPECT_EQ(refusal(good(), std::vector<int>(253, memory.file())).code(), 8);
  EXPECT_EQ(refusal(test::open_request(scene_, 0, 0), {memory.file()}).field(), "open.file");
}

TEST_F(LocalOpening, NothingThatIsNoOpening) {
  pb::LocalRequest frame, shared;
  frame.mutable_frame()->set_frame_id(1);
  shared.mutable_shared_frame()->set_size(1 << 20);
  EXPECT_EQ(refusal(frame).code(), 9);
  EXPECT_EQ(refusal(shared).code(), 9);
  const Memory memory(kPage);
  for (const std::string& packet : {std::string("\xff\xff\xff garbage"), std::string(64 << 10, '\x0a')}) {
    const RawLocal raw(serving_.path());
    ASSERT_TRUE(raw.send(packet, {memory.file()}));
    EXPECT_EQ(raw.closed().code(), 3) << packet.size();
  }
  const RawLocal empty(serving_.path());
  ASSERT_TRUE(empty.send(std::string_view()));
  EXPECT_EQ(empty.closed().code(), 3);
  const RawLocal long_one(serving_.path());
  ASSERT_TRUE(long_one.send(std::string((64 << 10) + 1, '\0')));
  EXPECT_EQ(long_one.closed().code(), 8);
}

TEST_F(LocalOpening, AnotherStreamIsTakenOverWithTheTokenAlone) {
  LocalStream first(serving_.path(), scene_);
  ASSERT_TRUE(first.opened());
  const auto request = test::open_request(scene_, 0, 0);
  EXPECT_EQ(refusal(request).code(), 9);
  auto resuming = request;
  resuming.mutable_open()->mutable_open()->set_resume_token(first.opened()->scene().resume_token());
  const RawLocal second(serving_.path());
  second.send(resuming);
  const auto response = second.receive();
  EXPECT_TRUE(response && response->frame().has_opened());
  EXPECT_EQ(first.raw().closed().code(), 10);
}

TEST_F(LocalOpening, TokensAreAskedFor) {
  const Folder folder;
  std::ofstream(folder.file("tokens"))
      << "[[tokens]]\nname = \"robot\"\ntoken = \"0123456789abcdef0123456789abcdef\"\n";
  std::filesystem::permissions(folder.file("tokens"), std::filesystem::perms(0600));
  Config config = Serving::cpu_config();
  config.tokens_file = folder.file("tokens");
  std::unique_ptr<Serving> guarded;
  ASSERT_NO_THROW(guarded = std::make_unique<Serving>(LocalTimeouts{}, config));
  for (const auto& [token, code] : {std::pair("", 16), {"wrong", 16}, {"0123456789abcdef0123456789abcdef", 5}}) {
    auto request = test::open_request("none", 0, 0);
    request.mutable_open()->set_token(token);
    const RawLocal raw(guarded->path());
    raw.send(request);
    EXPECT_EQ(raw.closed().code(), code) << token;
  }
}

TEST_F(LocalOpening, ConnectionsAreLimited) {
  Config config = Serving::cpu_config();
  config.limits.max_streams = 3;
  Serving narrow({}, config);
  std::vector<std::unique_ptr<RawLocal>> waiting;
  for (int i = 0; i < 3; ++i) waiting.push_back(std::make_unique<RawLocal>(narrow.path()));
  ASSERT_TRUE(eventually([&] { return narrow.server().connections() == 3; }));
  LocalStream stream(narrow.path(), narrow.make_scene());  // the first of those that wait gives way
  EXPECT_TRUE(stream.opened());
  EXPECT_EQ(waiting.front()->closed().code(), 8);
  waiting.clear();
  LocalStream second(narrow.path(), narrow.make_scene()), third(narrow.path(), narrow.make_scene());
  EXPECT_TRUE(second.opened() && third.opened());
  EXPECT_EQ(RawLocal(narrow.path()).closed().code(), 8);
}

TEST(LocalTimeoutsTest, ClientsThatNeverOpenAreEnded) {
  Serving serving({.open_seconds = 0.05});
  const RawLocal silent(serving.path());
  const auto closed = silent.closed();
  EXPECT_EQ(closed.code(), 4) << closed.message();
  EXPECT_TRUE(eventually([&] { return serving.server().connections() == 0; }));
}

}  // namespace
}  // namespace collided::server
