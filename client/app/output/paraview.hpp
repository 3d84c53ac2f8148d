#pragma once
// Contacts for ParaView: a point each, where the first feature touches, with the other fields as its data. Contacts
// whose points are not computed, of triangle pairs and candidates, cannot be written.
//
// Edge-triangle contacts are also joined to contours, if StepPositions has the scene. Common corners of neighbours, at
// which contours may end, are points of kind 0 after all contacts.

#include <string>
#include <vector>

#include "client/app/output/contact_points.hpp"

namespace collided::cli {

/// VTK's PolyData in XML (.vtp), in ASCII: a vertex for each contact, then a poly-line for each contour, whose cells
/// have `contour` (its number; -1 of vertices), `closed` and `meshes` (indices; -1 of vertices). Fields that were not
/// computed are left out, and are 0 of a kind that does not have them. Throws std::runtime_error if the file cannot be
/// written.
void write_vtp(const std::string& file, const client::FrameOutput& output, const StepPositions& positions);

/// PLY in ASCII: fields that were not computed are 0. Contours are edges between the points.
void write_ply(const std::string& file, const client::FrameOutput& output, const StepPositions& positions);

/// A series of files that ParaView plays (.pvd): the name of each, as seen from the series' folder, and its time.
struct TimedFile {
  double time;
  std::string file;
};
void write_pvd(const std::string& file, const std::vector<TimedFile>& files);

}  // namespace collided::cli
