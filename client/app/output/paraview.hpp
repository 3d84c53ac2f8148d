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

/// Writes VTK's PolyData in XML (.vtp), in ASCII: a vertex for each contact, then a poly-line for each contour. Data of
/// these cells are `contour` (its number), `closed` and `meshes` (their indices); the first and the last are -1 of
/// vertices. Fields that were not computed are left out. A kind that lacks a field has zeros there. Throws
/// std::runtime_error if the file cannot be written.
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
