#pragma once
// Whether and how a stream shares memory with a daemon on the same host.

#include <cstdint>
#include <string>

namespace collided::client {

enum class Local {
  kAutomatic,  ///< if the daemon is on this host and offers it; else gRPC
  kOff,        ///< gRPC
  kOn,         ///< or the stream is not opened
};

struct LocalOptions {
  Local use = Local::kAutomatic;
  /// Room for each frame's contacts, at most 1 GiB for the window. Contacts beyond it come by the socket, slower.
  /// Memory is provided when it is first touched.
  uint64_t output_bytes = uint64_t{8} << 20;
  /// cudaIpcMemHandle_t (64 bytes) of memory on the scene's GPU: updates then name shared ranges in it. Needs kOn.
  std::string cuda_ipc_handle = "";
  /// User id that the daemon may run as besides root, this process's own user and, with a unix:... address, whoever
  /// listens there. -1: nobody else's socket is used.
  int64_t daemon_user = -1;
};

}  // namespace collided::client
