#pragma once
// Whether and how a stream shares memory with a daemon on the same host.

#include <cstdint>
#include <string>

namespace collided::client {

/// Whether a stream shares memory with the daemon.
enum class Local {
  kAutomatic,  ///< if the daemon is on this host and offers it; else gRPC
  kOff,        ///< never: gRPC
  kOn,         ///< always: else opening the stream fails
};

/// Memory that a stream shares with a daemon on the same host.
struct LocalOptions {
  Local use = Local::kAutomatic;
  /// Room for each frame's contacts, at most 1 GiB for the whole window. Contacts beyond it come over the socket, which
  /// is slower. Memory is allocated on first touch.
  uint64_t output_bytes = uint64_t{8} << 20;
  /// Room in each frame for an edit's triangles, and for positions of what edits have added, at most 256 MiB for the
  /// whole window.
  uint64_t edit_bytes = 0;
  /// A cudaIpcMemHandle_t (64 bytes) of memory on the scene's GPU, in which updates then name ranges. Needs kOn.
  std::string cuda_ipc_handle = "";
  /// The same for contacts, which then stay there (FrameOutput::on_device): each frame of the window has
  /// `output_bytes`, rounded up to pages of 4096, so that the memory must have the window's times as many. May be the
  /// same memory, with positions after that. Needs kOn.
  std::string output_cuda_ipc_handle = "";
  /// Another user id that the daemon may run as, besides root, this process's own user and whoever listens at a
  /// unix:... address. -1: none.
  int64_t daemon_user = -1;
};

}  // namespace collided::client
