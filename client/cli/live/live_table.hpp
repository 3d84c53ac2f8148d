#pragma once
// Frames of a scene as they come, as a table on a terminal.

#include <functional>
#include <optional>

#include "client/cpp/watcher.hpp"

namespace collided::cli {

/// The next frame; nothing after the last one.
using ReceiveFrame = std::function<std::optional<client::WatchedFrame>()>;

/// Shows frames until there are no more, an interrupt or the key q, after which `cancel` makes `receive` throw; then
/// gives the screen back and prints the last table. Throws what `receive` did, unless q ended it, and Interrupted.
void show_live(const v1::Scene& scene, const ReceiveFrame& receive, const std::function<void()>& cancel);

}  // namespace collided::cli
