// Facts about this process, from the operating system.
#include "server/ops/process.hpp"

#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace collided::server {

double process_start_seconds() {
  static const double start =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  return start;
}

namespace {

struct Pages {
  double total = 0, resident = 0, shared = 0;
};

Pages process_pages() {
  Pages pages;
  std::ifstream("/proc/self/statm") >> pages.total >> pages.resident >> pages.shared;
  return pages;
}

double bytes_of(double pages) { return pages * static_cast<double>(sysconf(_SC_PAGESIZE)); }

}  // namespace

double process_resident_bytes() { return bytes_of(process_pages().resident); }

double process_private_bytes() {
  const Pages pages = process_pages();
  return bytes_of(pages.resident - pages.shared);
}

double process_heap_bytes() {
  const auto heap = mallinfo2();
  return static_cast<double>(heap.uordblks + heap.hblkhd);
}

double process_open_files() {
  std::error_code error;
  const std::filesystem::directory_iterator files("/proc/self/fd", error);
  return error ? 0 : static_cast<double>(std::distance(begin(files), end(files)));
}

}  // namespace collided::server
