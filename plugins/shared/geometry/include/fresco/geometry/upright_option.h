#pragma once

#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/stage.h>

#include <string>
#include <string_view>

namespace fresco::geometry
{

/// The axis that x, y, z, -x, -y or -z names.
Vec3d named_axis(std::string_view name);

/// find_up for a stage: the frames' cameras are evidence where `frames` is wired. Reports `up` [x, y, z], which the run's page
/// goes by, `up_from`, `up_plane_deg` and `up_plane_share`.
Upward found_up(const Mesh& mesh, const Input<Frames>& frames, RunContext& run);

/// The option `up` of a stage that writes a mesh for viewers, and the input `frames` that it looks at. Declared in the stage as
/// `UprightOption up{this};`.
class UprightOption
{
  public:
    explicit UprightOption(Configurable* owner);

    const Input<Frames>& frames() const { return frames_; }

    /// The rotation (x, y, z, w) that the mesh is to be turned by so that it stands with `target` up, +Y or +Z; {0, 0, 0, 1} for
    /// none. Says what was found, and reports as found_up.
    std::array<double, 4> turn(const Mesh& mesh, Vec3d target, RunContext& run) const;

    /// A copy of the mesh that is turned so.
    Mesh standing(const Mesh& mesh, Vec3d target, RunContext& run) const;

  private:
    Input<Frames> frames_;
    Option<std::string> up_;
};

}  // namespace fresco::geometry
