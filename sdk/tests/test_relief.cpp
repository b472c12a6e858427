#include "catch.h"

#include <fresco/error.h>
#include <fresco/relief.h>
#include <fresco/testing.h>

using namespace fresco;

TEST_CASE("stored normals are exact to a hundredth of a degree, and texels outside charts have none")
{
    const testing::TemporaryFolder folder;
    Relief relief;
    relief.atlas = "0123";
    relief.normals = Raster16(2, 2, 3);
    relief.roughness = Raster8(2, 2, 1, 7);
    const Vec3f normal = normalized(Vec3f{-0.3F, 0.5F, -0.9F});
    relief.set_normal(2, normal);
    relief.save({folder.path(), {}});
    const auto loaded = Relief::load({folder.path(), {}});
    CHECK(loaded->atlas == "0123");
    CHECK(loaded->roughness == relief.roughness);
    CHECK(loaded->has_normal(2));
    CHECK_FALSE(loaded->has_normal(1));
    CHECK(length(loaded->normal(2) - normal) < 1e-4F);
    relief.roughness = Raster8(2, 1);
    relief.save({folder.path(), {}});
    CHECK_THROWS_WITH(Relief::load({folder.path(), {}}), Catch::Contains("roughness.npy") && Catch::Contains("normals' size"));
    relief.normals = Raster16(2, 1, 3);
    relief.save({folder.path(), {}});
    CHECK_THROWS_WITH(Relief::load({folder.path(), {}}), Catch::Contains("normals.npy") && Catch::Contains("square"));
}
