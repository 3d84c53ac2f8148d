// Scenes on every device of this machine, from whichever thread.

#include <cstdlib>
#include <thread>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/gpu/refused_field.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// Those of the backend under test; of the CPU, two.
std::vector<Device> devices() {
  if (kBackend == Backend::kCpu) return {{kBackend, 0}, {kBackend, 1}};
  std::vector<Device> found;
  for (const DeviceInfo& info : list_devices())
    if (info.device.backend == kBackend) found.push_back(info.device);
  return found;
}

template <class F>
void in_a_thread(const F& f) {
  std::thread(f).join();
}

class SceneDevices : public OnBackend<> {
 protected:
  const Case case_ = rounded(soup(31, 300, 1, 0.2, 0.1), Scalar::kF32);
  const Frame frame_{case_, Mode::kCcd, Scalar::kF32};

  SceneSpec spec_on(const Device& device) const {
    SceneSpec spec = spec_for(case_, settings(Mode::kCcd, Accuracy::kCertified, Scalar::kF32));
    spec.device = device;
    return spec;
  }
};

TEST(DeviceNames, AreThoseThatUsersWrite) {
  EXPECT_EQ(to_string(Device{Backend::kCuda, 3}), "cuda:3");
  EXPECT_EQ(parse_device("cuda:3"), (Device{Backend::kCuda, 3}));
  EXPECT_EQ(parse_device("cpu"), (Device{Backend::kCpu, 0}));
  EXPECT_EQ(parse_device("cuda"), (Device{Backend::kCuda, 0}));
  for (const char* text : {"", "gpu", "cpu:", "cpu:x", "cuda:-1", "cuda:1x", "cuda:99999999999", "cuda:1:2", "CUDA:1"})
    EXPECT_FALSE(parse_device(text)) << text;
}

TEST_F(SceneDevices, AllGiveTheSameContacts) {
  const FrameResult expected = run_case(case_, spec_on({}));
  for (const Device& device : devices()) {
    const auto detector = Detector::create(spec_on(device));
    EXPECT_EQ(detector->device().device, device);
    EXPECT_TRUE(same_contacts(expected, detector->detect(frame_.input()))) << to_string(device);
  }
}

// A new thread's current device is the first one, whatever its scene's is.
TEST_F(SceneDevices, AnyThreadWorksOnTheScenesOwn) {
  const FrameResult expected = run_case(case_, spec_on({}));
  for (const Device& device : devices()) {
    std::unique_ptr<Detector> detector;
    std::shared_ptr<FrameSlot> slot;
    FrameResult result;
    std::vector<float> positions(3 * case_.end[0].size());
    in_a_thread([&] { detector = Detector::create(spec_on(device)); });
    in_a_thread([&] { slot = detector->make_slot(); });
    in_a_thread([&] { slot->send(frame_.input().updates); });
    in_a_thread([&] { result = detector->detect({.updates = {}, .slot = slot}); });
    in_a_thread([&] {
      detector->read_positions({0, 1, case_.end[0].size()}, std::as_writable_bytes(std::span(positions)));
    });
    EXPECT_TRUE(same_contacts(expected, result)) << to_string(device);
    EXPECT_EQ(positions[1], static_cast<float>(case_.end[0][0][1])) << to_string(device);
    in_a_thread([&] { detector.reset(); });
    in_a_thread([&] { slot.reset(); });
    in_a_thread([&] { result = {}; });
    EXPECT_TRUE(device_works(device)) << to_string(device);
  }
}

TEST_F(SceneDevices, OneThreadWorksOnAllInTurn) {
  std::vector<std::unique_ptr<Detector>> detectors;
  for (const Device& device : devices()) detectors.push_back(Detector::create(spec_on(device)));
  const FrameResult first = detectors.front()->detect(frame_.input());
  for (int round = 0; round < 2; ++round)
    for (const auto& detector : detectors) EXPECT_TRUE(same_contacts(first, detector->detect(frame_.input())));
}

TEST_F(SceneDevices, MemoryOfTheHostIsPinnedForAllOfThem) {
  constexpr uint64_t kPage = 4096;
  const uint64_t bytes = (bytes_in(frame_.input().updates) / kPage + 1) * kPage;
  const std::unique_ptr<std::byte, void (*)(void*)> memory(static_cast<std::byte*>(std::aligned_alloc(kPage, bytes)),
                                                           std::free);
  const auto registered = register_host_memory(devices().front(), {memory.get(), bytes});
  const std::vector<MeshPositions> updates = moved_to(registered->bytes(), frame_.input().updates);
  for (const Device& device : devices()) {
    const auto detector = Detector::create(spec_on(device));
    EXPECT_TRUE(same_contacts(run_case(case_, spec_on({})), detector->detect({.updates = updates})));
  }
}

TEST_F(SceneDevices, OneThatIsNotThereIsRefused) {
  EXPECT_EQ("device", refused_field([&] { Detector::create(spec_on({kBackend, -1})); }));
  if (kBackend == Backend::kCpu) return;
  const auto count = static_cast<int>(devices().size());
  try {
    Detector::create(spec_on({kBackend, count}));
    FAIL() << "a device was made up";
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "device");
    EXPECT_NE(std::string(e.what()).find("this machine has " + std::to_string(count)), std::string::npos) << e.what();
  }
}

TEST_F(SceneDevices, TellHowMuchMemoryIsFree) {
  for (const DeviceInfo& info : list_devices()) {
    const uint64_t free = free_device_memory(info.device);
    EXPECT_LE(free, info.memory_bytes);
    EXPECT_EQ(free > 0, info.device.backend == Backend::kCuda);
    EXPECT_EQ(info.uuid.empty(), info.device.backend == Backend::kCpu);
  }
}

}  // namespace
}  // namespace collided::test
