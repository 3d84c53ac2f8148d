#pragma once
// What an interrupted collidectl (SIGINT, SIGTERM, SIGHUP) still does: stop its daemon and remove its folder, or delete
// its scene on a daemon of others.

#include <sys/types.h>

#include <string>

namespace collided::cli {

/// From now on an interrupt ends the daemon and removes the sockets and the ready file in `folder`, and `folder`.
void clean_up_on_interrupt(pid_t daemon, const std::string& folder);
/// The daemon has been stopped: an interrupt has nothing to do any more.
void no_clean_up_on_interrupt() noexcept;

/// For scenes on a daemon of others: from now on the first interrupt is only noted, so that the scene can be deleted;
/// a second one of its kind ends collidectl at once.
void note_interrupts();
/// Throws Interrupted if an interrupt was noted.
void check_interrupt();

}  // namespace collided::cli
