// Positions that are on the device already: of this process, and of another one.

#include <cuda_runtime.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "tests/gpu/backend.hpp"
#include "tests/gpu/positions/owned_updates.hpp"
#include "tests/support/adversarial.hpp"
#include "tests/support/digest.hpp"

namespace collided::test {
namespace {

/// Another process that holds a copy of some bytes on the device (device_memory_holder.cpp, beside this program).
class Holder {
 public:
  explicit Holder(const std::vector<std::byte>& bytes) {
    int input[2], output[2];
    if (pipe2(input, O_CLOEXEC) != 0 || pipe2(output, O_CLOEXEC) != 0) throw std::runtime_error("pipe2 failed");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    std::string path = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "device_memory_holder";
    char* arguments[] = {path.data(), nullptr};
    const int error = posix_spawn(&process_, path.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(input[0]);
    close(output[1]);
    input_ = input[1], output_ = output[0];
    if (error != 0) throw std::runtime_error(path + " cannot be started");
    const uint64_t size = bytes.size();
    std::FILE* to = fdopen(dup(input_), "w");
    std::fwrite(&size, sizeof(size), 1, to);
    std::fwrite(bytes.data(), 1, size, to);
    std::fclose(to);
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;
  ~Holder() {
    end();
    close(output_);
  }

  std::vector<std::byte> handle() const {
    std::vector<std::byte> handle(sizeof(cudaIpcMemHandle_t));
    for (size_t done = 0; done < handle.size();) {
      const ssize_t n = read(output_, handle.data() + done, handle.size() - done);
      if (n <= 0) throw std::runtime_error("the other process has no device memory");
      done += static_cast<size_t>(n);
    }
    return handle;
  }

  /// The process gives its memory back and ends.
  void end() {
    if (process_ <= 0) return;
    close(input_);
    int status = 0;
    waitpid(process_, &status, 0);
    EXPECT_EQ(status, 0);
    process_ = 0;
  }

 private:
  pid_t process_ = 0;
  int input_ = -1, output_ = -1;
};

const Device kDevice{Backend::kCuda};

class DeviceMemoryInput : public OnBackend<> {
 protected:
  const Case case_ = rounded(soup(95, 400, 1, 0.2, 0.1), Scalar::kF32);
  const SceneSpec spec_ = spec_for(case_, settings(Mode::kCcd, Accuracy::kFast, Scalar::kF32));
  const Frame frame_{case_, Mode::kCcd, Scalar::kF32};

  /// The bytes of the updates in turn.
  static std::vector<std::byte> packed(const std::vector<MeshPositions>& updates) {
    std::vector<std::byte> bytes(bytes_in(updates));
    moved_to(bytes, updates);
    return bytes;
  }
  /// The updates with their bytes at `memory`, which holds what packed() returns.
  static std::vector<MeshPositions> placed_at(std::span<const std::byte> memory, std::vector<MeshPositions> updates) {
    uint64_t offset = 0;
    for (MeshPositions& u : updates)
      for (std::span<const std::byte>* bytes : {&u.indices, &u.start, &u.end}) {
        *bytes = memory.subspan(offset, bytes->size());
        offset += bytes->size();
      }
    return updates;
  }
};

TEST_F(DeviceMemoryInput, OfThisProcess) {
  const std::vector<MeshPositions> updates = frame_.input().updates;
  const std::vector<std::byte> bytes = packed(updates);
  void* memory = nullptr;
  ASSERT_EQ(cudaMalloc(&memory, bytes.size()), cudaSuccess);
  ASSERT_EQ(cudaMemcpy(memory, bytes.data(), bytes.size(), cudaMemcpyHostToDevice), cudaSuccess);
  ASSERT_EQ(cudaDeviceSynchronize(), cudaSuccess);
  FrameInput input;
  input.updates = placed_at({static_cast<std::byte*>(memory), bytes.size()}, updates);
  auto detector = Detector::create(spec_);
  const FrameResult expected = run_case(case_, spec_);
  EXPECT_TRUE(same_contacts(expected, detector->detect(input)));
  input.slot = detector->make_slot();
  input.slot->send(std::exchange(input.updates, {}));
  EXPECT_TRUE(same_contacts(expected, detector->detect(input)));
  EXPECT_EQ(cudaFree(memory), cudaSuccess);
}

TEST_F(DeviceMemoryInput, OfAnotherProcess) {
  const std::vector<MeshPositions> updates = frame_.input().updates;
  const std::vector<std::byte> bytes = packed(updates);
  Holder holder(bytes);
  const std::vector<std::byte> handle = holder.handle();
  const auto opened = open_device_memory(kDevice, handle);
  ASSERT_GE(opened->bytes().size(), bytes.size());
  EXPECT_EQ(open_device_memory(kDevice, handle)->bytes().size(), opened->bytes().size())
      << "opened once more, and closed";
  auto detector = Detector::create(spec_);
  FrameInput input;
  input.slot = detector->make_slot();
  input.slot->send(placed_at(opened->bytes(), updates));
  holder.end();  // what is open stays
  EXPECT_TRUE(same_contacts(run_case(case_, spec_), detector->detect(input)));
}

TEST_F(DeviceMemoryInput, OfAnotherDeviceIsReadFromThere) {
  if (list_devices().size() < 3) GTEST_SKIP() << "there is one GPU alone";
  const std::vector<MeshPositions> updates = frame_.input().updates;
  Holder holder(packed(updates));
  SceneSpec spec = spec_;
  spec.device.ordinal = 1;
  const auto opened = open_device_memory(spec.device, holder.handle());
  auto detector = Detector::create(spec);
  FrameInput input;
  input.updates = placed_at(opened->bytes(), updates);
  EXPECT_TRUE(same_contacts(run_case(case_, spec_), detector->detect(input)));
}

TEST_F(DeviceMemoryInput, ABadCoordinateIsNamed) {
  Case broken = case_;
  broken.end[0][13][2] = std::nan("");
  const Frame bad(broken, Mode::kCcd, Scalar::kF32);
  Holder holder(packed(bad.input().updates));
  const auto opened = open_device_memory(kDevice, holder.handle());
  auto detector = Detector::create(spec_);
  FrameInput input;
  input.updates = placed_at(opened->bytes(), bad.input().updates);
  try {
    detector->detect(input);
    ADD_FAILURE() << "NaN was taken";
  } catch (const InvalidInput& e) {
    EXPECT_EQ(e.field(), "updates[0].end");
    EXPECT_NE(std::string(e.what()).find("mesh 0, vertex 13, coordinate z is "), std::string::npos) << e.what();
  }
  EXPECT_TRUE(same_contacts(run_case(case_, spec_), detector->detect(frame_.input())));
}

}  // namespace
}  // namespace collided::test
