#pragma once

#include <fresco/artifact.h>
#include <fresco/math.h>

#include <vector>

namespace example
{

/// Points in the world frame, meters. On disk: `points.npy`, float32 N x 3.
struct PointCloud : fresco::Artifact
{
    static constexpr std::string_view artifact_name = "example_point_cloud";
    static constexpr int artifact_version = 1;

    std::vector<fresco::Vec3f> points;

    void save(const fresco::ArtifactFolder& folder) const override;
    static std::shared_ptr<PointCloud> load(const fresco::ArtifactFolder& folder);
};

}  // namespace example
