#pragma once
// The frames that 'collidectl bench --end-to-end' sends, and how many bytes they are.

#include <string>
#include <vector>

#include "client/cpp/client.hpp"
#include "client/scenes/scene.hpp"

namespace collided::cli {

/// The scale of a scene at which its positions come closest to `megabytes` (1e6 bytes) a frame. Throws
/// std::invalid_argument as scenes::check_scene does, also if no scale makes the scene that large or small.
double scale_for(const std::string& scene, double megabytes, v1::PositionFormat format);

/// Frame `frame`, counted from 0, has the id after that. In CCD the first one also has positions at its start; later
/// ones start where the previous frame ended.
v1::Frame frame_at(const scenes::Scene& scene, int frame, const v1::SceneSpec& spec);

/// Updates that borrow the frame's positions.
std::vector<client::FrameUpdate> views_of(const v1::Frame& frame);

/// Copies the updates' positions to the memory that the stream shares with the daemon, and borrows them from there.
void move_to_input(client::FrameStream& stream, std::vector<client::FrameUpdate>& updates);

/// Bytes of all positions.
double bytes_of(const std::vector<client::FrameUpdate>& updates);
/// Bytes of all contacts.
double bytes_of(const client::FrameOutput& output);

}  // namespace collided::cli
