#pragma once
// The counters of Prometheus without labels. Each is a row, and counts from the start of the daemon.

#include <iterator>

namespace collided::server {

enum class Count {
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
};

struct CounterRow {
  Count count;
  const char *name, *help;
};

/// Rows are in the order of Count.
inline constexpr CounterRow kCounters[] = {
    {Count::kFrames, "collided_frames_total", "Frames that were answered"},
    {Count::kContacts, "collided_contacts_total", "Contacts that were reported"},
    {Count::kReceivedBytes, "collided_received_bytes_total", "Bytes of positions and indices in frames"},
    {Count::kSentBytes, "collided_sent_bytes_total", "Bytes of arrays in answers: contacts and shortened ways"},
    {Count::kSkippedFrames, "collided_skipped_frames_total", "Frames skipped by LATEST_WINS"},
    {Count::kNotShownFrames, "collided_watch_skipped_frames_total",
     "Frames that were not sent to a watcher, once for each watcher"},
    {Count::kReplays, "collided_replays_total", "Runs repeated because a buffer was too small"},
    {Count::kReconnects, "collided_reconnects_total", "Streams opened with a resume token"},
    {Count::kDroppedLogLines, "collided_dropped_log_lines_total", "Dropped log lines"},
    {Count::kResetFloods, "collided_reset_floods_total",
     "Connections ended because their clients reset too many calls"},
    {Count::kEvictedConnections, "collided_evicted_connections_total",
     "Connections evicted to make room for new ones, or ended by a limit of a connection"},
};

static_assert(
    [] {
      for (size_t i = 0; i < std::size(kCounters); ++i)
        if (kCounters[i].count != static_cast<Count>(i)) return false;
      return kCounters[std::size(kCounters) - 1].count == Count::kEvictedConnections;
    }(),
    "a row of kCounters is missing, or not in the order of Count");

}  // namespace collided::server
