#include "catch.h"

#include <fresco/mesh.h>
#include <fresco/relief.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <cmath>

using namespace fresco;

namespace
{
SourceMap small_map()
{
    SourceMap map;
    map.atlas = "0123";
    map.picture_width = 4000;
    map.picture_height = 3000;
    map.pixels_per_texel = 2.5F;
    map.clear(4);
    map.set_place(1, 2, {{3999.5F, 0.5F}, -0.5F});
    map.set_place(3, 3, {{1234.25F, 2999.9F}, 3.0F, 2.0F, {0.1F, -0.49F, 2}});
    return map;
}
}  // namespace

TEST_CASE("places come back to a sixteenth of a pixel, also from disk")
{
    const testing::TemporaryFolder folder;
    small_map().save({folder.path(), {}});
    const auto loaded = SourceMap::load({folder.path(), {}});
    CHECK((loaded->atlas == "0123" && loaded->pixels_per_texel == 2.5F));
    CHECK_FALSE(loaded->place(0, 0).has_value());
    const auto place = loaded->place(1, 2);
    REQUIRE(place.has_value());
    CHECK(length(place->at - Vec2f{3999.5F, 0.5F}) < 1 / 16.0F);
    CHECK(std::abs(std::cos(place->angle) - std::cos(-0.5F)) < 1e-3F);
    CHECK(std::abs(std::sin(place->angle) - std::sin(-0.5F)) < 1e-3F);
    CHECK((place->scale == 1 && length(place->shift) == 0));
    CHECK(loaded->place(3, 3)->scale == 2);
    CHECK(length(loaded->place(3, 3)->shift - Vec3f{0.1F, -0.49F, 0.498F}) < 4e-3F);
}

TEST_CASE("a map that is not square or has no picture is refused by name")
{
    const auto refused = [](const auto& change, const std::string& reason)
    {
        const testing::TemporaryFolder folder;
        SourceMap map = small_map();
        change(map);
        map.save({folder.path(), {}});
        CHECK_THROWS_WITH(SourceMap::load({folder.path(), {}}), Contains(reason));
    };
    refused([](SourceMap& map) { map.places = Raster16(4, 3, 4); }, "places.packed: is 4x3; expected 4 texels a side");
    refused([](SourceMap& map) { map.shifts = Raster8(3, 3, 3); }, "shifts.packed: is 3x3; expected 4 texels a side");
    refused([](SourceMap& map) { map.picture_width = 0; }, "source_map.json: picture_width: ");
}

TEST_CASE("an atlas is known by its triangles and texcoords, and an unknown one passes")
{
    const Mesh mesh = testing::wall();
    const std::string id = atlas_id(mesh);
    CHECK(id.size() == 32);
    Mesh moved = mesh;
    moved.positions[0].z = 1;
    CHECK(atlas_id(moved) == id);
    Mesh other = mesh;
    other.texcoords[0].x = 0.5F;
    CHECK_NOTHROW(check_atlas(id, mesh, "the texture on port 'start'"));
    CHECK_NOTHROW(check_atlas("", other, "the texture on port 'start'"));
    CHECK_THROWS_WITH(check_atlas(id, other, "the texture on port 'start'"), Contains("port 'start' was made for another atlas"));
}

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
    CHECK_THROWS_WITH(Relief::load({folder.path(), {}}), Contains("roughness.packed: is 2x1; expected 2 texels"));
}
