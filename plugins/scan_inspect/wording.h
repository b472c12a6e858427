#pragma once

#include "diagnosis.h"

#include <fresco/mesh.h>

#include <string>
#include <vector>

namespace fresco::inspect
{

/// Length of the diagonal of the mesh's box, in its unit.
double mesh_extent(const Mesh& mesh);

/// One finding for each mistake in what is assumed of poses, mesh and depth. `extent` decides which of mesh and depth is likely
/// in meters; `one_camera`: depth and color were given the same camera.
void tell_assumption(const Diagnosis& diagnosis, double extent, bool one_camera, std::vector<Finding>& findings);

/// One finding for each mistake in what is assumed of the color camera.
void tell_color(const Diagnosis& diagnosis, bool one_camera, std::vector<Finding>& findings);

void tell_channels(std::vector<Finding>& findings);

/// Appends what agrees with the mistake corrected, and what agrees as recorded; the first `by_depth` findings were judged by
/// depth.
void tell_figures(const Diagnosis& diagnosis, std::size_t by_depth, std::vector<Finding>& findings);

void tell_inside_out(std::vector<Finding>& findings);
void tell_uncovered(std::vector<Finding>& findings);
void tell_disagreement(const Fit& fit, bool certain, std::vector<Finding>& findings);
void tell_no_edges(std::vector<Finding>& findings);

/// How well mesh and frames agree as recorded, in a line.
std::string summary(const Diagnosis& diagnosis);

/// "95 %".
std::string percent(double share);
/// A number with three digits that count: "0.25", "1000".
std::string number(double value);
/// With so many digits behind the point.
std::string fixed(double value, int digits);

}  // namespace fresco::inspect
