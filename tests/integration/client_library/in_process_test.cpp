// An engine in this process: what it shares with a daemon is tested with it, here is what it has alone.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>

#include "tests/integration/client_library/client_ways.hpp"
#include "tests/integration/client_library/session_calls.hpp"
#include "tests/integration/client_library/session_daemon.hpp"

namespace collided::test {
namespace {

using client::Error;

Session open_session(const Client& client, const SessionOptions& options = {}) {
  return Session::open(client, session_spec(kMode), SessionMeshes().inputs, options);
}

size_t threads_now() {
  using Threads = std::filesystem::directory_iterator;
  return static_cast<size_t>(std::distance(Threads("/proc/self/task"), Threads()));
}

TEST(InProcess, ASessionHasTheContactsOfADaemonsSession) {
  MortalDaemon daemon;
  Session far = Session::open(daemon.address(), session_spec(kMode), SessionMeshes().inputs);
  Session near = open_session(local());  // which keeps the engine
  uint64_t contacts = 0;
  for (uint64_t id = 1; id <= 20; ++id) {
    const FrameOutput output = detect(near, id);
    EXPECT_EQ(digest(output), digest(detect(far, id))) << "frame " << id;
    contacts += output.done.contact_count();
  }
  EXPECT_GT(contacts, 100u);
  EXPECT_EQ(near.reconnects(), 0u);
  EXPECT_NO_THROW(near.close());
}

TEST(InProcess, ACallerMayTrapFloatingPointErrors) {
  std::vector<std::string> digests;
  for (const int trapped : {0, FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW | FE_UNDERFLOW}) {
    if (feenableexcept(trapped) == -1) GTEST_SKIP() << "this processor has no traps";  // as most of arm64
    Session session = open_session(local());
    for (uint64_t id = 1; id <= 3; ++id) digests.push_back(digest(detect(session, id)));
    EXPECT_EQ(fegetexcept(), trapped);
    std::fesetenv(FE_DFL_ENV);
  }
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(digests[i + 3], digests[i]);
}

TEST(InProcess, ARefusalSaysWhatADaemonsSays) {
  LocalDaemon daemon;
  std::vector<Error> errors;
  for (const Way way : kEveryWay) {
    Client client = client_by(way, daemon.process().address());
    FrameStream stream = client.stream(make_layers(client), {.local = {.use = use_of(way)}});
    ask_whole(stream, 1);
    const std::string few = pack_points({{0, 0, 0}}), far = pack_points({{0, 0, INFINITY}}), one = pack<uint32_t>({1}),
                      many = pack<uint32_t>({1u << 30});
    const std::string too_long = layers_at(1) + layers_at(2) + layers_at(3);
    const FrameUpdate bad[] = {{.positions = bytes_of(few)},
                               {.mesh = 7, .positions = bytes_of(few)},
                               {.positions = bytes_of(far), .indices = bytes_of(one)},
                               {.positions = bytes_of(few), .indices = bytes_of(many)},
                               {.positions = bytes_of(too_long)},
                               {.positions = bytes_of(few).first(5)}};
    uint64_t id = 1;
    std::string said;
    for (const FrameUpdate& update : bad) {
      stream.send(++id, {&update, 1});
      const Error error = error_of([&] { stream.receive().check(); });
      EXPECT_NE(error.code(), 0);
      errors.push_back(error);
    }
    errors.push_back(error_of([&] { client.get_scene("nowhere"); }));
    errors.push_back(error_of([&] { client.stream(stream.scene(), {.window = 1000}); }));
    errors.push_back(error_of([&] { client.create_scene({}, {}); }));
    errors.push_back(error_of([&] { stream.input(uint64_t{1} << 40); }));
    EXPECT_GT(ask_whole(stream, ++id).vertex_triangle.count, 0u);
  }
  const size_t count = errors.size() / 3;
  for (size_t i = 0; i + 1 < count; ++i) {
    EXPECT_STREQ(errors[i].what(), errors[2 * count + i].what());
    EXPECT_EQ(errors[i].field(), errors[2 * count + i].field());
  }
  EXPECT_EQ(errors[2 * count - 1].code(), errors[3 * count - 1].code());
}

TEST(InProcess, TwoEnginesKnowNothingOfEachOther) {
  Client one = local({.threads = 1}), other = local({.threads = 2});
  const pb::Scene scene = make_layers(one);
  EXPECT_EQ(error_of([&] { other.get_scene(scene.scene_id()); }).code(), grpc::NOT_FOUND);
  const auto play = [](Client& client) {
    FrameStream stream = client.stream(make_layers(client), {.window = 3});
    std::vector<std::vector<double>> times;
    for (uint64_t id = 1; id <= 12; ++id) times.push_back(ask_whole(stream, id).vertex_triangle.toi);
    return times;
  };
  auto there = std::async(std::launch::async, play, std::ref(other));
  EXPECT_EQ(play(one), there.get());
}

TEST(InProcess, AnEngineEndsWithTheLastThatUsesItAndItsThreadsWithIt) {
  { detect(*std::make_unique<Session>(open_session(local())), 1); }  // what the process keeps: gRPC's threads, TBB's
  const size_t before = threads_now();
  std::optional<Client> client = local();
  std::optional<FrameStream> stream = client->stream(make_layers(*client), {.window = 4});
  ask_whole(*stream, 1);
  std::optional<client::Watcher> watcher = client->watch(stream->scene().scene_id());
  client.reset();
  const std::string positions = layers_at(2);
  const FrameUpdate update{.positions = bytes_of(positions)};
  for (uint64_t id = 2; id <= 5; ++id) stream->send(id, {&update, 1});
  EXPECT_EQ(stream->receive().frame_id, 2u);
  stream.reset();  // with frames in flight
  EXPECT_GT(watcher->receive().frame_id, 0u);
  watcher.reset();
  EXPECT_TRUE(eventually("all threads end", [&] { return threads_now() <= before; }));
}

TEST(InProcess, AClientEndsWhileAnotherThreadStreams) {
  for (int round = 0; round < 3; ++round) {
    std::optional<Client> client = local();
    FrameStream stream = client->stream(make_layers(*client), {.window = 4});
    auto sender = std::async(std::launch::async, [&] {
      for (uint64_t id = 1; id <= 5; ++id) ask_whole(stream, id);
    });
    client.reset();
    EXPECT_NO_THROW(sender.get());
  }
}

TEST(InProcess, OptionsOutOfRangeAreRefused) {
  const auto field_of = [](const LocalEngine& engine) {
    const Error error = error_of([&] { local(engine); });
    EXPECT_EQ(error.code(), grpc::INVALID_ARGUMENT) << error.what();
    return error.field();
  };
  EXPECT_EQ(field_of({.backend = "tpu"}), "engine.backend");
  EXPECT_EQ(field_of({.threads = -1}), "engine.threads");
  EXPECT_EQ(field_of({.concurrent_frames = 5000}), "engine.concurrent_frames");
  EXPECT_EQ(error_of([] { local({}, {.token = "secret"}); }).field(), "token");
  Client small = local({.memory_bytes = 4096});
  const Error full = error_of([&] { make_layers(small); });
  EXPECT_EQ(full.code(), grpc::RESOURCE_EXHAUSTED) << full.what();
  Client client = local();
  const pb::Scene scene = make_layers(client);
  EXPECT_EQ(
      error_of([&] { client.stream(scene, {.local = {.use = client::Local::kOn, .cuda_ipc_handle = "x"}}); }).field(),
      "options.local.cuda_ipc_handle");
}

TEST(InProcess, AFirstFrameMayBeLargerThanADaemonsMessages) {
  constexpr uint32_t kVertices = 6'000'000;  // 72 MB; a daemon takes 64 MiB
  const std::vector<std::array<uint32_t, 3>> corners{{0, 1, 2}};
  const client::MeshInput mesh{.name = "large", .vertex_count = kVertices, .triangles = corners};
  pb::SceneSpec spec;
  spec.set_mode(pb::DETECTION_MODE_DCD);
  spec.set_thickness(0.1);
  Client client = local({.threads = 1});
  FrameStream stream = client.stream(client.create_scene(spec, {&mesh, 1}));
  const std::vector<float> positions(size_t{3} * kVertices, 1.0f);
  const FrameUpdate update{.positions = std::as_bytes(std::span(positions))};
  stream.send(1, {&update, 1});
  EXPECT_EQ(stream.receive().done.metrics().bytes_in(), positions.size() * sizeof(float));
}

TEST(InProcess, TheProcessKeepsItsOutputItsSignalsAndItsThreadsMask) {
  std::vector<struct sigaction> before(NSIG);
  for (int signal = 1; signal < NSIG; ++signal) sigaction(signal, nullptr, &before[static_cast<size_t>(signal)]);
  sigset_t mask_before, mask;
  pthread_sigmask(SIG_SETMASK, nullptr, &mask_before);
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  {
    Session session = open_session(local());
    detect(session, 1);
    session.close();
  }
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  for (int signal = 1; signal < NSIG; ++signal) {
    struct sigaction now;
    sigaction(signal, nullptr, &now);
    EXPECT_EQ(now.sa_handler, before[static_cast<size_t>(signal)].sa_handler) << signal;
  }
  pthread_sigmask(SIG_SETMASK, nullptr, &mask);
  for (int signal = 1; signal < NSIG; ++signal)
    EXPECT_EQ(sigismember(&mask, signal), sigismember(&mask_before, signal)) << signal;
}

TEST(InProcess, TheLogGoesToTheFunctionThatIsSet) {
  std::vector<std::string> lines;
  set_local_log(LogLevel::kInfo, [&](LogLevel, const std::string& line) { lines.push_back(line); });
  {
    Client client = local();
    make_layers(client);
  }
  set_local_log(LogLevel::kInfo, nullptr);
  const auto has = [&](const char* text) {
    return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.find(text) != line.npos; });
  };
  EXPECT_TRUE(has("scene created"));
  const size_t count = lines.size();
  Client client = local();
  make_layers(client);
  EXPECT_EQ(lines.size(), count);
}

}  // namespace
}  // namespace collided::test
