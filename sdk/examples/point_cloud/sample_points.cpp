#include "point_cloud.h"

#include <fresco/mesh.h>
#include <fresco/stage.h>

namespace
{

class SamplePoints final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh"};
    fresco::Output<example::PointCloud> points{this, "points", "The center of every face"};

    void run(fresco::RunContext&) override
    {
        example::PointCloud cloud;
        for (const fresco::Triangle& t : mesh->triangles)
            cloud.points.push_back((mesh->positions[t[0]] + mesh->positions[t[1]] + mesh->positions[t[2]]) * (1.0F / 3));
        points = std::move(cloud);
    }
};

}  // namespace

FRESCO_STAGE("example.sample_points", SamplePoints, "One point per face")
