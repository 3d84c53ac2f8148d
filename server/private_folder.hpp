#pragma once
// The temporary folder of a private daemon, which is removed however the daemon ends.

#include <string>

namespace collided::server {

/// Makes a folder that only this user may enter, and forks the process `collided-tidy`, which removes it once this
/// process is gone. That process also ends this one when standard input has closed: with SIGTERM, and with SIGKILL if
/// that takes more than `seconds_to_stop`. If it is killed itself, this one gets SIGTERM, and the folder stays, empty.
/// This process leaves its parent's process group, so that the parent alone gets the terminal's interrupts, unless the
/// terminal is its standard input. Must be called before any thread exists. Throws ConfigError if standard input is
/// nothing that closes, else std::runtime_error.
std::string make_private_folder(double seconds_to_stop);

}  // namespace collided::server
