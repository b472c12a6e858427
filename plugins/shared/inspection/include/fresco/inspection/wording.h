#pragma once

#include <fresco/inspection/diagnosis.h>
#include <fresco/mesh.h>

#include <string>
#include <vector>

/// \file The texts of findings: a diagnosis appends one per mistake. Each names the mistake and the option or change that
/// corrects it. Separate from the diagnosis, so that all advice reads alike.

namespace fresco::inspect
{

/// No room measures as many meters.
inline constexpr double largest_room = 150;

/// Length of the diagonal of the mesh's box, in its unit.
double mesh_extent(const Mesh& mesh);

/// Appends a finding.
void tell(std::vector<Finding>& findings, const char* cause, std::string text, bool certain = true);

/// One finding for each assumption about poses, mesh and depth. `extent`: see mesh_extent; decides whether the mesh or the depth
/// is probably in meters; 0 without a mesh. `one_camera`: depth and color were given the same camera.
void tell_assumption(const Diagnosis& diagnosis, double extent, bool one_camera, std::vector<Finding>& findings);

/// The color camera's focal length is searched up to this natural logarithm of its factor.
inline constexpr double color_focal_reach = 0.3;

/// The color camera's focal length times `mending` raises the edge response.
void tell_color_focal(double mending, double before, double after, std::vector<Finding>& findings);

/// Appends the agreement with the mistake corrected and as recorded to each finding.
void tell_figures(const Diagnosis& diagnosis, std::vector<Finding>& findings);

void tell_inside_out(std::vector<Finding>& findings);
/// `by_mesh`: the frames were compared with a mesh, not with each other.
void tell_uncovered(bool by_mesh, std::vector<Finding>& findings);
void tell_equal_poses(bool positions, bool rotations, std::vector<Finding>& findings);
void tell_disagreement(const Fit& fit, bool by_mesh, bool certain, std::vector<Finding>& findings);

/// How well mesh and frames agree as recorded, in a line.
std::string summary(const Diagnosis& diagnosis, bool by_mesh);

/// Three significant digits: "0.25", "1000".
std::string number(double value);

}  // namespace fresco::inspect
