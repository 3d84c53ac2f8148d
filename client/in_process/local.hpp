#pragma once
// The engine in this process, for a program that wants no daemon: the same calls, the same bytes of contacts, the same
// errors. Link collided::local.

#include <cstdint>
#include <functional>
#include <string>

#include "client/cpp/client.hpp"

namespace collided {

/// What an engine in this process may use.
struct LocalEngine {
  std::string backend = "auto";  ///< "cpu", "cuda", or "auto": a GPU where there is one
  int threads = 0;               ///< CPU threads of a scene, up to 4096; 0: all cores
  int concurrent_frames =
      0;  ///< frames computed at once, of different scenes, up to 4096; 0: 4 to 12 with a GPU, else 2
  uint64_t memory_bytes = 0;  ///< of all scenes; 0: half of the host's memory, or 9/10 of the device's if that is less
};

/// Starts an engine, and returns a client of it. Streams, sessions (Session::open(client, ...)) and watchers are made
/// as of a daemon; the engine ends, and its threads with it, with the last of these and of the client. Each call
/// starts an engine of its own. Nothing else in the process is touched: no signal handler, logger, environment,
/// standard stream or socket. The threads that it starts block all signals but those of faults. Throws
/// client::Error: INVALID_ARGUMENT for options out of range, with their field(), FAILED_PRECONDITION for "cuda" where
/// no device can be used.
client::Client local(const LocalEngine& engine = {}, const client::ConnectOptions& options = {});

/// Of a line of the log, from what only developers need on.
enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// From now on all engines of the process pass their log lines, of `level` and above and without line ends, to `take`:
/// from any thread, one at a time. It must not call the library. Null, as at the start: there is no log. Once this has
/// returned, the function that was set before is not running.
void set_local_log(LogLevel level, std::function<void(LogLevel level, const std::string& line)> take);

}  // namespace collided
