#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <filesystem>
#include <string>
#include <vector>

namespace bench
{

/// A progress that allows so many threads.
class Threads final : public fresco::Progress
{
  public:
    explicit Threads(int count) : count_(count) {}
    int threads() const override { return count_; }

  private:
    int count_;
};

/// What the suite runs over.
struct GeometryInput
{
    std::string name;
    fresco::Mesh mesh;
    std::vector<fresco::Camera> cameras;  ///< 640 x 480, inside the scanned room.
};

/// The room of scan.synthetic_room with seed 1, 4.5 x 3.6 x 2.6 m, 3 mm of noise, as `views` depth pictures show it: about
/// 240 000 faces for edges of 3 cm.
GeometryInput synthetic_room(double edge_m, int views, fresco::Progress& progress);

/// Any mesh; the cameras stand in the middle of its box and look around. Throws as read_mesh.
GeometryInput mesh_file(const std::filesystem::path& file, int views);

/// A recording in the layout of 7-Scenes: its mesh.ply, and `views` of the poses in seq-01, evenly spread. Throws as read_mesh
/// and read_rigid_transform.
GeometryInput scan_folder(const std::filesystem::path& folder, int views);

}  // namespace bench
