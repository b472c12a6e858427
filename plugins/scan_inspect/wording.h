#pragma once

#include "diagnosis.h"

#include <fresco/mesh.h>

#include <string>
#include <vector>

namespace fresco::inspect
{

/// Length of the diagonal of the mesh's box, in its unit.
double mesh_extent(const Mesh& mesh);

/// What is to be said of poses and units, one finding for each mistake. `depth_scale` multiplies depths; `extent` tells which of
/// mesh and depth is likely in meters.
void tell_convention(const Convention& convention, double depth_scale, double extent, std::vector<Finding>& findings);

/// What is to be said of the two cameras. `one_camera`: both were given the same angles of view.
void tell_cameras(const Diagnosis& diagnosis, bool one_camera, std::vector<Finding>& findings);

void tell_inside_out(double front_share, std::vector<Finding>& findings);
void tell_unexplained_depth(const Diagnosis& diagnosis, std::vector<Finding>& findings);
void tell_unexplained_edges(const Diagnosis& diagnosis, std::vector<Finding>& findings);

/// How well mesh and frames agree as recorded, in a line.
std::string summary(const Diagnosis& diagnosis);

/// "95 %".
std::string percent(double share);
/// A number with three digits that count: "0.25", "1000".
std::string number(double value);

}  // namespace fresco::inspect
