#include "point_cloud.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>

#include <algorithm>

namespace
{

class PointBounds final : public fresco::Stage
{
    fresco::Input<example::PointCloud> points{this, "points", "Points"};
    fresco::Output<fresco::Files> bounds{this, "bounds", "Their bounding box as JSON"};
    fresco::Option<fresco::OutputName> path{this, "path", {"bounds.json"}, "Name below the output folder"};

    void run(fresco::RunContext&) override
    {
        if (points->points.empty())
            throw fresco::Error("there are no points; give a mesh that has faces");
        fresco::Vec3f low = points->points.front();
        fresco::Vec3f high = low;
        for (const fresco::Vec3f& p : points->points)
        {
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        const auto list = [](fresco::Vec3f p) { return fresco::Value::List{double{p.x}, double{p.y}, double{p.z}}; };
        const auto file = bounds.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        fresco::write_file(file, fresco::to_json(fresco::Value::Map{{"min", list(low)}, {"max", list(high)}}));
        fresco::Files files;
        files.names = {path->path};
        bounds = std::move(files);
    }
};

}  // namespace

FRESCO_STAGE("example.point_bounds", PointBounds, "Bounding box of points")
