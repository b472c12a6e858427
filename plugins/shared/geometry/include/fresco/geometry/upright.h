#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>

#include <array>
#include <optional>
#include <string>

/// \file Which way is up in a mesh, how to turn it upright, and the option of the stages that ask.

namespace fresco::geometry
{

/// Evidence for the upward direction.
enum class UpEvidence
{
    cameras_and_plane,  ///< The largest level planes, near the cameras' upward direction.
    cameras,            ///< The cameras: no plane near their direction is large enough.
    shape,              ///< The mesh: its walls stand, its floors lie and its furniture faces along one direction only.
    nothing  ///< The mesh does not clearly say; `direction` is the file's +z or +y, whichever is nearer the best guess.
};

struct Upward
{
    Vec3d direction;         ///< Unit length, world frame.
    UpEvidence from;         ///< Evidence that decided.
    double plane_deg = 0;    ///< Angle between the cameras' direction and the planes'; 0 unless cameras_and_plane.
    double plane_share = 0;  ///< Share of the mesh's area in its largest level plane that faces up, 8 cm thick.
    double shape_share = 0;  ///< Without cameras: of the mesh's area, walls on all sides and level surfaces; 0 with.
    double next_share = 0;   ///< Without cameras: what the next best direction has of the evidence, 0 (sure) to 1.
};

/// Finds the upward direction. `by_cameras`: unit length, as cameras_up finds it; level is then the direction that most of the
/// area within 30 degrees of it faces along, up or down. Without it: the direction that most area is square to or faces along and
/// whose two sides are most unlike. `shape` takes 40 % of the area, walls on more than one side, a next best direction of at most
/// 90 % of the evidence, and smaller surfaces, such as tables or a roof, that face up: a room that lacks a wall looks like one
/// that lies on its side without a ceiling. Up is where more area faces (scans lack ceilings and what buildings stand on), or
/// else away from the end that is flatter. The mesh must have passed check_mesh. The same for any number of threads.
Upward find_up(const Mesh& mesh, const std::optional<Vec3d>& by_cameras);

/// The rotation (x, y, z, w) that turns `up` to `target`, which is +Y or +Z; both of unit length. First the coordinate axis that
/// `up` is nearest to, by the shortest way or half around X, then the rest by the shortest way: small changes of `up` turn
/// nothing around.
std::array<double, 4> upright_turn(Vec3d up, Vec3d target);

/// `v` turned by a unit quaternion (x, y, z, w).
Vec3d turned(const std::array<double, 4>& turn, Vec3d v);

/// The option `up` of a stage that needs to know which way is up.
Option<std::string> up_option(Configurable* owner);

/// Upward direction for that option: the axis named, with a warning where the mesh clearly stands another way, or as find_up
/// finds it, with a warning where nothing clearly shows it. The frames' cameras are evidence where `frames` is wired. Reports
/// `up_from`, `up_plane_deg` and `up_plane_share`; without cameras `up_shape_share` and `up_next_share`. Warns where the mesh
/// clearly hangs upside down by the cameras.
Vec3d shown_up(const std::string& up, const Mesh& mesh, const Input<Frames>& frames, RunContext& run);

/// The option `up` of a stage that writes a mesh for viewers, and the input `frames` that it looks at. Declared in the stage as
/// `UprightOption up{this};`.
class UprightOption
{
  public:
    explicit UprightOption(Configurable* owner);

    const Input<Frames>& frames() const { return frames_; }
    /// Whether the option leaves it to the stage to turn the mesh: `auto` or `keep`.
    bool names_no_axis() const { return *up_ == "auto" || *up_ == "keep"; }

    /// The rotation (x, y, z, w) that the mesh is to be turned by so that it stands with `target` up, +Y or +Z; {0, 0, 0, 1} for
    /// none. Says what was found; reports `up` [x, y, z], which the run's page goes by, and the figures of shown_up.
    std::array<double, 4> turn(const Mesh& mesh, Vec3d target, RunContext& run) const;

    /// A copy of the mesh that is turned so.
    Mesh standing(const Mesh& mesh, Vec3d target, RunContext& run) const;

  private:
    Input<Frames> frames_;
    Option<std::string> up_;
};

}  // namespace fresco::geometry
