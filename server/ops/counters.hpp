#pragma once
// The counters of Prometheus without labels. Each is a row, and counts from the start of the daemon.

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace collided::server {

enum class CounterId {
  kFrames,
  kContacts,
  kReceivedBytes,
  kSentBytes,
  kSkippedFrames,
  kNotShownFrames,
  kReplays,
  kReconnects,
  kDroppedLogLines,
  kResetFloods,
  kEvictedConnections,
  kEnd  ///< their number
};

struct CounterRow {
  CounterId id;
  const char *name, *help;
};

/// Rows are in the order of CounterId.
inline constexpr CounterRow kCounters[] = {
    {CounterId::kFrames, "collided_frames_total", "Frames that were answered"},
    {CounterId::kContacts, "collided_contacts_total", "Contacts that were reported"},
    {CounterId::kReceivedBytes, "collided_received_bytes_total", "Bytes of positions and indices in frames"},
    {CounterId::kSentBytes, "collided_sent_bytes_total",
     "Bytes of arrays in answers: contacts, pairs of meshes, shortened ways, what limits them"},
    {CounterId::kSkippedFrames, "collided_skipped_frames_total", "Frames skipped by LATEST_WINS"},
    {CounterId::kNotShownFrames, "collided_watch_skipped_frames_total",
     "Frames that were not sent to a watcher, once for each watcher"},
    {CounterId::kReplays, "collided_replays_total", "Runs repeated because a buffer was too small"},
    {CounterId::kReconnects, "collided_reconnects_total", "Streams opened with a resume token"},
    {CounterId::kDroppedLogLines, "collided_dropped_log_lines_total", "Dropped log lines"},
    {CounterId::kResetFloods, "collided_reset_floods_total",
     "Connections ended because their clients reset too many calls"},
    {CounterId::kEvictedConnections, "collided_evicted_connections_total",
     "Connections evicted to make room for new ones, or ended by a limit of a connection"},
};

static_assert(std::size(kCounters) == static_cast<size_t>(CounterId::kEnd), "a counter has no row");
static_assert(std::adjacent_find(std::begin(kCounters), std::end(kCounters),
                                 [](const CounterRow& a, const CounterRow& b) { return a.id >= b.id; }) ==
                  std::end(kCounters),
              "a row is not in the order of CounterId");

}  // namespace collided::server
