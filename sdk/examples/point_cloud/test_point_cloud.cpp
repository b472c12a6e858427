#include "catch.h"
#include "point_cloud.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

TEST_CASE("a point cloud is loaded as it was saved, and another file is refused")
{
    const fresco::testing::TemporaryFolder folder;
    const fresco::ArtifactFolder own{folder.path(), {}};
    example::PointCloud cloud;
    cloud.points = {{1, 2, 3}, {4, 5, 6}};
    cloud.save(own);
    CHECK(example::PointCloud::load(own)->points == cloud.points);
    fresco::write_file(folder.path() / "points.npy", "points");
    CHECK_THROWS_AS(example::PointCloud::load(own), fresco::Error);
}
