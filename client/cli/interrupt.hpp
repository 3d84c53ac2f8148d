#pragma once
// What an interrupted collidectl (SIGINT, SIGTERM, SIGHUP) still does: stop its daemon and remove its folder.

#include <sys/types.h>

#include <string>

namespace collided::cli {

/// From now on an interrupt ends the daemon and removes the socket and the ready file in `folder`, and `folder`.
void clean_up_on_interrupt(pid_t daemon, const std::string& folder);
/// The daemon has been stopped: an interrupt has nothing to do any more.
void no_clean_up_on_interrupt() noexcept;

}  // namespace collided::cli
