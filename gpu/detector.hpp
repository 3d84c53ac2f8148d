#pragma once
// The engine's public face: a scene is specified once, then fed one frame at a time.
// Everything below this header and types.hpp is the engine's own business.

#include "gpu/types.hpp"

namespace collided {

/// One scene on one device. Not thread-safe: one call at a time; different detectors are independent. On CUDA whoever
/// calls it, or a slot, or releases an answer, has the scene's device as its current one afterwards. The caller's
/// floating-point environment changes nothing.
class Detector {
 public:
  /// Throws InvalidInput for a bad spec, ResourceExhausted past the budget, what the quota throws, DeviceError if the
  /// backend is missing. Host memory that this takes while it works counts in the quota; memory for positions is taken
  /// by the first frame, so that nothing is held for vertices that were only declared. `cancelled`: as FrameInput has
  /// it, asked by the calling thread after about 8 ms of work; Cancelled is thrown if it returns true.
  static std::unique_ptr<Detector> create(SceneSpec spec, std::function<bool()> cancelled = {});
  virtual ~Detector() = default;

  /// Applies one frame and finds its contacts. A throw leaves the scene as it was.
  virtual FrameResult detect(const FrameInput& frame) = 0;

  /// Positions at the end (t = 1) of the last frame applied, packed xyz of the scene's scalar type: to.size() bytes.
  /// Only once a frame has been applied. Throws ResourceExhausted, DeviceError.
  virtual void read_positions(const VertexSample& sample, std::span<std::byte> to) = 0;

  /// From any thread, also while a frame is in work. A slot may outlive its scene, and is of no
  /// use then, nor after an edit. Throws ResourceExhausted.
  virtual std::shared_ptr<FrameSlot> make_slot() = 0;

  virtual std::vector<MemoryPart> memory() const = 0;
  /// That any frame so far needed.
  virtual ListLengths list_lengths() const = 0;
  /// As the last edit left it, without triangles.
  virtual const SceneSpec& spec() const = 0;
  /// Of one world.
  virtual const Topology& topology() const = 0;
  virtual DeviceInfo device() const = 0;
};

/// Bytes that a scene of so many vertices and elements (in each world of a set) holds at the least once it has had a
/// frame, whatever its options: on its backend, and for its topology on the host. Reads no vertex and no element.
uint64_t min_scene_bytes(const SceneSpec& spec, uint64_t vertices, uint64_t triangles);

/// What is known of a scene before it is made.
struct SceneEstimate {
  std::vector<MemoryPart> memory;   ///< at least what Detector::memory() tells after a first frame that finds nothing
  std::vector<std::string> stages;  ///< of such a frame, in order
  PerKind<FieldSet> fields;         ///< that the contacts of an answer have; none of kinds that it does not have
};

/// Of so many vertices and elements (in each world of a set), with the scene's own options for the frame. Allocates
/// nothing on the backend and reads no vertex and no element of the meshes. Throws InvalidInput for a bad spec.
SceneEstimate estimate_scene(const SceneSpec& spec, uint64_t vertices, uint64_t triangles);

/// Throws InvalidInput, naming the option, for options of a scene that cannot be used or do not go together. Reads no
/// mesh.
void check_options(const SceneSpec& spec);
/// The same for those of a frame of a scene whose options passed. Reads no update.
void check_options_of_frame(const SceneSpec& spec, const FrameInput& frame);

/// The same for pairs that are left out: rings of meshes, rest pairs, pairs of meshes. Reads the meshes of the spec,
/// but not their triangles.
void check_exclusions(const SceneSpec& spec);

/// Devices that scenes can live on: the CPU with so many threads (0: all cores), then every usable CUDA device.
std::vector<DeviceInfo> list_devices(int threads = 0);

/// CUDA devices that are missing from list_devices(), with the reasons; none in a build without CUDA.
std::vector<UnusableDevice> unusable_devices();

/// Loads the engine's kernels onto a CUDA device, which takes minutes where the driver has to compile them; does
/// nothing for the CPU. Throws DeviceError if the driver refuses them.
void load_kernels(const Device& device);

/// Throws InvalidInput for an ordinal that this machine does not have, DeviceError where it has no CUDA device at all.
void check_device(const Device& device);

/// Bytes that scenes can still have on a CUDA device, which this makes ready for work; 0 for the CPU, whose memory is
/// the host's. Throws DeviceError.
uint64_t free_device_memory(const Device& device);

/// CUDA loads all kernels when it starts, not each with the frame that needs it first, which takes 30 ms of a scene's
/// first frame. Sets CUDA_MODULE_LOADING unless it is set; to be called before there are threads and devices.
void load_kernels_at_start();

/// Whether a CUDA device can be used now (built in, driver present).
bool cuda_available();

/// Why no CUDA device can be used, to end an error with; empty if one can.
std::string cuda_obstacle();

/// Whether a device still answers. After some failures (DeviceError) it does not until the process is started anew.
bool device_works(const Device& device);

/// Pins memory that is mapped already, for all CUDA devices, by way of one of them; does nothing for the CPU. Throws
/// DeviceError.
std::unique_ptr<SharedMemory> register_host_memory(const Device& device, std::span<std::byte> memory);

/// Puts the calling thread's current CUDA device back when it ends, where what is done with `device` may change it;
/// does nothing for the CPU.
class KeptCudaDevice {
 public:
  explicit KeptCudaDevice(const Device& device);
  ~KeptCudaDevice();
  KeptCudaDevice(const KeptCudaDevice&) = delete;
  KeptCudaDevice& operator=(const KeptCudaDevice&) = delete;

 private:
  std::optional<int> ordinal_;
};

/// Throws InvalidInput, naming `field`, unless the bytes lie in memory of this CUDA device. The driver is asked about
/// the first and the last byte. For the CPU nothing is checked.
void check_device_memory(const Device& device, std::span<const std::byte> memory, const std::string& field);

/// Opens memory that another process has on this device, or on one that it reaches directly, by its cudaIpcMemHandle_t
/// (64 bytes). bytes() are those of the device, and not for the host to read. Throws InvalidInput for a bad handle, one
/// of memory that the device does not reach, or where there is no CUDA, DeviceError.
std::unique_ptr<SharedMemory> open_device_memory(const Device& device, std::span<const std::byte> handle);

}  // namespace collided
