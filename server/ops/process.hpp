#pragma once
// Facts about this process, from the operating system.

namespace collided::server {

/// Since the Unix epoch.
double process_start_seconds();
/// 0 if /proc cannot be read.
double process_resident_bytes();
/// Resident bytes that no other process shares; 0 if /proc cannot be read.
double process_private_bytes();
/// 0 if /proc cannot be read.
double process_open_files();

}  // namespace collided::server
