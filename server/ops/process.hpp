#pragma once
// Facts about this process, from the operating system.

namespace collided::server {

/// Since the Unix epoch.
double process_start_seconds();
/// 0 if /proc cannot be read.
double process_resident_bytes();
/// Resident bytes that no other process shares; 0 if /proc cannot be read.
double process_private_bytes();
/// Bytes that the allocator has handed out and not got back: what the daemon holds, whether or not pages of freed
/// memory went back to the system.
double process_heap_bytes();
/// 0 if /proc cannot be read.
double process_open_files();

}  // namespace collided::server
