#include "point_cloud.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>

namespace example
{

void PointCloud::save(const fresco::ArtifactFolder& folder) const
{
    std::vector<float> values;
    for (const fresco::Vec3f& p : points)
        values.insert(values.end(), {p.x, p.y, p.z});
    const std::vector<std::size_t> shape{points.size(), 3};
    const auto bytes = std::as_bytes(std::span(values));
    fresco::write_file(folder.path / "points.npy", fresco::to_npy(fresco::NpyType::float32, shape, bytes));
}

std::shared_ptr<PointCloud> PointCloud::load(const fresco::ArtifactFolder& folder)
{
    const auto file = folder.path / "points.npy";
    const fresco::NpyArray array = fresco::read_npy(file);
    if (array.shape.size() != 2 || array.shape[1] != 3)
        throw fresco::Error(file.string() + ": expected an array N x 3");
    auto cloud = std::make_shared<PointCloud>();
    const auto values = array.as<float>();
    for (std::size_t i = 0; i + 2 < values.size(); i += 3)
        cloud->points.push_back({values[i], values[i + 1], values[i + 2]});
    return cloud;
}

}  // namespace example
