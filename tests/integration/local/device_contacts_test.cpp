// Contacts that stay in a client's device memory: those that other clients get on the host, whatever else goes on.
#include <gtest/gtest.h>
#include <spawn.h>

#include <memory>
#include <optional>
#include <thread>

#include "tests/integration/local/device_scene.hpp"
#include "tests/integration/local/local_daemon.hpp"

namespace collided::test {
namespace {

using client::Client;
using client::Contacts;
using client::DeviceContacts;
using client::Error;
using client::FrameOptions;
using client::FrameOutput;
using client::FrameStream;
using client::FrameUpdate;
using client::Local;

constexpr uint64_t kAmple = 4 << 20;

/// As if all of them had come to the host.
Contacts brought(const DeviceMemory& memory, const DeviceContacts& placed, const Contacts& others) {
  const auto join = [&]<class T>(const client::DeviceArray& array, const std::vector<T>& rest) {
    std::vector<T> all = memory.read<T>(array);
    EXPECT_TRUE(all.empty() || all.size() == placed.count);
    all.insert(all.end(), rest.begin(), rest.end());
    return all;
  };
  return {placed.count + others.count,
          join(placed.elements, others.elements),
          join(placed.stencils, others.stencils),
          join(placed.toi, others.toi),
          join(placed.distance, others.distance),
          join(placed.weights, others.weights),
          join(placed.normals, others.normals),
          join(placed.flags, others.flags),
          join(placed.features, others.features),
          join(placed.signed_distances, others.signed_distances),
          {}};
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same_bytes(const Contacts& a, const Contacts& b) {
  return a.count == b.count && same_bytes(a.elements, b.elements) && same_bytes(a.stencils, b.stencils) &&
         same_bytes(a.toi, b.toi) && same_bytes(a.distance, b.distance) && same_bytes(a.weights, b.weights) &&
         same_bytes(a.normals, b.normals) && same_bytes(a.flags, b.flags) && same_bytes(a.features, b.features) &&
         same_bytes(a.signed_distances, b.signed_distances);
}

uint64_t count_placed(const FrameOutput& output) {
  uint64_t count = 0;
  client::for_each_kind([&](pb::ContactKind, const DeviceContacts& placed) { count += placed.count; },
                        output.on_device);
  return count;
}

void expect_same(const FrameOutput& expected, const FrameOutput& output, const DeviceMemory& memory) {
  client::for_each_kind(
      [&](pb::ContactKind kind, const Contacts& all, const Contacts& others, const DeviceContacts& placed) {
        EXPECT_TRUE(same_bytes(all, brought(memory, placed, others)))
            << pb::ContactKind_Name(kind) << ", frame " << output.frame_id;
      },
      expected, output, output.on_device);
  EXPECT_EQ(expected.done.contact_count(), output.done.contact_count());
  EXPECT_EQ(expected.done.earliest_toi(), output.done.earliest_toi());
  EXPECT_EQ(expected.done.any_contact(), output.done.any_contact());
  EXPECT_EQ(expected.done.advanced(), output.done.advanced());
  EXPECT_EQ(expected.done.metrics().bytes_out(), output.done.metrics().bytes_out());
}

FrameOutput ask(FrameStream& stream, uint64_t id, const FrameOptions& options = {}) {
  const std::string positions = device_layers_at(id);
  const FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
  stream.send(id, {&update, 1}, options);
  FrameOutput output = stream.receive();
  output.check();
  return output;
}

/// What a stream may ask of each frame.
std::vector<FrameOptions> all_options() {
  std::vector<FrameOptions> all;
  for (const auto mode : {pb::DETECTION_MODE_CCD, pb::DETECTION_MODE_DCD})
    for (const auto accuracy :
         {pb::ACCURACY_CANDIDATES, pb::ACCURACY_FAST, pb::ACCURACY_GUARDED, pb::ACCURACY_CERTIFIED, pb::ACCURACY_EXACT})
      for (const auto report : {pb::REPORT_ALL, pb::REPORT_EARLIEST_ONLY, pb::REPORT_ANY_HIT}) {
        if (report == pb::REPORT_EARLIEST_ONLY && (mode == pb::DETECTION_MODE_DCD || accuracy < pb::ACCURACY_GUARDED))
          continue;
        if (report == pb::REPORT_ANY_HIT && accuracy < pb::ACCURACY_FAST) continue;
        all.push_back({.mode = mode, .accuracy = accuracy, .report = report});
      }
  all.push_back({.ignore_separating = true});
  all.push_back({.advance = true});
  all.push_back({.trial = true});
  return all;
}

class DeviceContactsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    int devices = 0;
    if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) GTEST_SKIP() << "no CUDA device can be used";
    daemon_.emplace(std::vector<std::string>{"--local-socket", folder_.file("local"), "--cuda-ipc"}, "cuda");
    client_.emplace(Client::connect(daemon_->address()));
  }
  FrameStream open(const pb::Scene& scene, const DeviceMemory& memory, uint64_t output_bytes, uint32_t window = 1) {
    return client_->stream(
        scene, {.window = window,
                .local = {.use = Local::kOn, .output_bytes = output_bytes, .output_cuda_ipc_handle = memory.handle()}});
  }
  FrameStream open_on_host(const pb::Scene& scene) {
    return client_->stream(scene, {.window = 1, .local = {.use = Local::kOff}});
  }
  /// The field that a stream into the memory is refused for.
  std::string refused_field(const client::LocalOptions& options) {
    try {
      client_->stream(make_device_scene(*client_), {.window = 2, .local = options});
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), grpc::INVALID_ARGUMENT) << e.message();
      return e.field();
    }
    return "none";
  }

  OpenFolder folder_;
  std::optional<DaemonProcess> daemon_;
  std::optional<Client> client_;
};

TEST_F(DeviceContactsTest, AreThoseOfTheHost) {
  for (const uint64_t bytes : {kAmple, uint64_t{4096}, uint64_t{100 << 10}}) {
    const DeviceMemory memory(bytes);
    FrameStream stream = open(make_device_scene(*client_), memory, bytes),
                other = open_on_host(make_device_scene(*client_));
    uint64_t id = 1;
    ask(stream, id), ask(other, id);
    for (const FrameOptions& options : all_options()) {
      const FrameOutput expected = ask(other, ++id, options), output = ask(stream, id, options);
      expect_same(expected, output, memory);
      if (bytes == kAmple) {
        EXPECT_EQ(count_placed(output), output.done.contact_count());
      } else if (output.done.contact_count() > 4096) {
        EXPECT_LT(count_placed(output), output.done.contact_count());
      }
      if (expected.done.contact_count() > 0) {
        EXPECT_GT(count_placed(output), 0u);
      }
    }
  }
}

// Frames in flight have parts of their own; positions may be in the same memory.
TEST_F(DeviceContactsTest, FramesOfTwoStreamsAtOnce) {
  constexpr uint32_t kWindow = 3;
  constexpr uint64_t kFrames = 30;
  const auto run = [&] {
    const std::string first = device_layers_at(1);
    const DeviceMemory memory(kWindow * (kAmple + first.size()));
    const std::string handle = memory.handle();
    FrameStream stream = client_->stream(
        make_device_scene(*client_),
        {.window = kWindow,
         .local = {
             .use = Local::kOn, .output_bytes = kAmple, .cuda_ipc_handle = handle, .output_cuda_ipc_handle = handle}});
    FrameStream other = open_on_host(make_device_scene(*client_));
    const auto check_one = [&] {
      const FrameOutput output = stream.receive();
      output.check();
      expect_same(ask(other, output.frame_id), output, memory);
    };
    for (uint64_t id = 1; id <= kFrames; ++id) {
      const uint64_t at = kWindow * kAmple + id % kWindow * first.size();
      memory.write(at, device_layers_at(id));
      pb::Frame frame;
      frame.set_frame_id(id);
      pb::SharedRange& range = *frame.add_updates()->mutable_shared_positions();
      range.set_offset(at);
      range.set_size(first.size());
      stream.send(frame);
      if (id >= kWindow) check_one();
    }
    for (uint32_t i = 1; i < kWindow; ++i) check_one();
    stream.finish();
  };
  std::thread beside([&] { EXPECT_NO_THROW(run()); });
  EXPECT_NO_THROW(run());
  beside.join();
}

TEST_F(DeviceContactsTest, WatchersGetTheFirst) {
  const DeviceMemory memory(kAmple);
  const pb::Scene scene = make_device_scene(*client_);
  FrameStream stream = open(scene, memory, kAmple), other = open_on_host(make_device_scene(*client_));
  ask(stream, 1), ask(other, 1);
  client::Watcher watcher = client_->watch(scene.scene_id(), {.max_contacts_per_kind = 7});
  const FrameOutput output = ask(stream, 2);
  Contacts expected = ask(other, 2).vertex_triangle;
  const client::WatchedFrame watched = watcher.receive();
  ASSERT_EQ(watched.vertex_triangle.count, 7u);
  expected.elements.resize(7), expected.toi.resize(7);
  EXPECT_EQ(watched.vertex_triangle.elements, expected.elements);
  EXPECT_EQ(watched.vertex_triangle.toi, expected.toi);
  EXPECT_EQ(watched.omitted_contacts, output.done.contact_count() - 14);
  EXPECT_EQ(count_placed(output), output.done.contact_count());
}

TEST_F(DeviceContactsTest, ADeadClientTakesNothingWithIt) {
  const DeviceMemory memory(kAmple);
  const pb::Scene bystander = make_device_scene(*client_);
  FrameStream stream = open(bystander, memory, kAmple), other = open_on_host(make_device_scene(*client_));
  uint64_t id = 0;
  for (int round = 0; round < 3; ++round) {
    const pb::Scene scene = make_device_scene(*client_);
    int output[2];
    ASSERT_EQ(pipe2(output, O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    std::string path = setting("COLLIDED_DEVICE_CLIENT", COLLIDED_DEVICE_CLIENT), address = daemon_->address(),
                scene_id = scene.scene_id();
    char* arguments[] = {path.data(), address.data(), scene_id.data(), nullptr};
    pid_t victim = 0;
    ASSERT_EQ(posix_spawn(&victim, path.c_str(), &actions, nullptr, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    close(output[1]);
    char byte = 0;
    EXPECT_EQ(read(output[0], &byte, 1), 1) << "the other client got no answer";
    close(output[0]);
    kill(victim, SIGKILL);
    waitpid(victim, nullptr, 0);
    for (int i = 0; i < 3; ++i) {
      const FrameOutput expected = ask(other, ++id);
      expect_same(expected, ask(stream, id), memory);
    }
    const DeviceMemory next(kAmple);
    FrameStream resumed = client_->resume(
        scene,
        {.window = 1, .local = {.use = Local::kOn, .output_bytes = kAmple, .output_cuda_ipc_handle = next.handle()}});
    const FrameOutput answer = ask(resumed, resumed.scene().last_frame_id() + 1);
    EXPECT_EQ(count_placed(answer), answer.done.contact_count());
    EXPECT_GT(count_placed(answer), 0u);
  }
}

TEST_F(DeviceContactsTest, NamesWhatIsWrong) {
  const DeviceMemory memory(kAmple);
  const std::string handle = memory.handle();
  EXPECT_EQ(refused_field({.use = Local::kOn, .output_bytes = 4096, .output_cuda_ipc_handle = std::string(64, 'x')}),
            "open.output_cuda_ipc_handle");
  EXPECT_EQ(refused_field({.use = Local::kOn, .output_bytes = 4096, .output_cuda_ipc_handle = handle.substr(1)}),
            "open.output_cuda_ipc_handle");
  EXPECT_EQ(refused_field({.use = Local::kOn, .output_bytes = 0, .output_cuda_ipc_handle = handle}),
            "open.output_bytes");
  EXPECT_EQ(refused_field({.use = Local::kOn, .output_bytes = kAmple * 100, .output_cuda_ipc_handle = handle}),
            "open.output_bytes");
  EXPECT_EQ(refused_field({.output_bytes = 4096, .output_cuda_ipc_handle = handle}),
            "options.local.output_cuda_ipc_handle");
}

}  // namespace
}  // namespace collided::test
