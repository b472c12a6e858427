#include "catch.h"
#include "model_colors.h"

#include <fresco/testing_scenes.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace fresco;
using namespace from_model;
using fresco::texturing::displayed;

namespace
{

/// Two pixels side by side, and two rows: 10 20 / 30 40, gray.
Raster8 four_pixels()
{
    Raster8 picture(2, 2, 3);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            picture.values[3 * i + c] = static_cast<std::uint8_t>(10 * (i + 1));
    return picture;
}

double gray(const Raster8& picture, double u, double v, Wrap wrap)
{
    return 255 * displayed(sample_wrapped(picture, {u, v}, wrap, wrap).x);
}

Model model_of(Mesh mesh, ModelMaterial material = {})
{
    Model model;
    model.material_of_face.assign(mesh.triangles.size(), 0);
    model.mesh = std::move(mesh);
    model.materials = {std::move(material)};
    return model;
}

}  // namespace

TEST_CASE("pictures are wrapped as their material says", "[texture.from_model]")
{
    const Raster8 picture = four_pixels();
    // The lower row is v = 0.25.
    CHECK(gray(picture, 0.25, 0.25, Wrap::repeat) == Approx(30));
    CHECK(gray(picture, 0.75, 0.75, Wrap::repeat) == Approx(20));
    CHECK(gray(picture, 7.25, -4.75, Wrap::repeat) == Approx(30));
    CHECK(gray(picture, -0.25, 0.25, Wrap::repeat) == Approx(40));
    CHECK(gray(picture, -0.25, 0.25, Wrap::mirror) == Approx(30));
    CHECK(gray(picture, 1.25, 0.25, Wrap::mirror) == Approx(40));
    CHECK(gray(picture, 2.25, 3.75, Wrap::mirror) == Approx(30));
    CHECK(gray(picture, 2.25, 1.25, Wrap::mirror) == Approx(10));
    CHECK(gray(picture, 9, -9, Wrap::clamp) == Approx(40));
    CHECK(gray(picture, -1e30, 1e30, Wrap::clamp) == Approx(10));
    // Half-way between texels, also around the border: the mean light.
    const auto mean = [](std::uint8_t a, std::uint8_t b)
    { return 255 * displayed((texturing::to_linear(a) + texturing::to_linear(b)) / 2); };
    CHECK(gray(picture, 0.5, 0.25, Wrap::repeat) == Approx(mean(30, 40)));
    CHECK(gray(picture, 1, 0.25, Wrap::repeat) == Approx(mean(40, 30)));
    CHECK(gray(picture, 1, 0.25, Wrap::mirror) == Approx(40));
    CHECK(gray(picture, 1, 0.25, Wrap::clamp) == Approx(40));
}

TEST_CASE("halving averages light, and keeps the last row and column of an odd picture", "[texture.from_model]")
{
    Raster8 checker(4, 4, 3);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            for (int c = 0; c < 3; ++c)
                checker.at(x, y, c) = (x + y) % 2 == 0 ? 255 : 0;
    CHECK(halved(checker) == Raster8(2, 2, 3, 188));
    Raster8 row(5, 1, 3, 0);
    for (int c = 0; c < 3; ++c)
        row.at(4, 0, c) = 255;
    const Raster8 small = halved(row);
    CHECK((small.width == 2 && small.height == 1));
    CHECK(small.at(1, 0) == texturing::from_linear(1.0 / 3));
}

TEST_CASE("a model's color is the product of its material, picture and vertices", "[texture.from_model]")
{
    Mesh mesh = testing::box();
    mesh.colors.assign(8, Rgb8{255, 188, 0});
    mesh.texcoords.assign(36, Vec2f{0.25F, 0.25F});
    ModelMaterial material;
    material.color = {0.5F, 1, 1};
    material.picture = 0;
    material.vertex_colors = true;
    Model model = model_of(mesh, material);
    model.pictures = {"a.png"};
    CHECK(color_source(model) == ColorSource::pictures);
    const ModelColors colors(model, {four_pixels()});
    const double light = texturing::to_linear(30);
    const Vec3d found = colors.at(3, {0.2, 0.3, 0.5});
    CHECK(found.x == Approx(0.5 * light));
    CHECK(found.y == Approx(texturing::to_linear(188) * light));
    CHECK(found.z == 0);
    CHECK(colors.pixels_per_meter(3) == 0);

    model.materials[0].picture = ModelMaterial::no_picture;
    CHECK(color_source(model) == ColorSource::shape);
    model.mesh.colors[4] = {1, 2, 3};
    CHECK(color_source(model) == ColorSource::colors);
    model.materials[0].vertex_colors = false;
    CHECK(color_source(model) == ColorSource::shape);
    model.materials.push_back(model.materials[0]);
    model.materials[1].color.x = 0.25F;
    model.material_of_face[7] = 1;
    CHECK(color_source(model) == ColorSource::colors);
}

TEST_CASE("pixels per meter go by the area of a face and of its texcoords", "[texture.from_model]")
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.texcoords = {{0, 0}, {0.5F, 0}, {0, 0.5F}};
    ModelMaterial material;
    material.picture = 0;
    Model model = model_of(mesh, material);
    model.pictures = {"a.png"};
    // Half of 400 pixels on 2 m.
    CHECK(ModelColors(model, {Raster8(400, 400, 3)}).pixels_per_meter(0) == Approx(100));
}

TEST_CASE("a shaded box shows six tones, flat to its edges; a ball is lighter toward the lamp", "[texture.from_model]")
{
    const auto lights = shape_lights(testing::box());
    REQUIRE(lights.size() == 36);
    std::set<int> tones;
    for (std::size_t side = 0; side < 6; ++side)
    {
        double mean = 0;
        for (std::size_t i = 6 * side; i < 6 * side + 6; ++i)
        {
            // L* from 20 to 90.
            CHECK(lights[i] > 0.0299F);
            CHECK(lights[i] < 0.763F);
            mean += displayed(double{lights[i]}) / 6;
        }
        tones.insert(static_cast<int>(std::lround(mean * 20)));
    }
    CHECK(tones.size() >= 5);
    // +x, +y and +z look at the lamp.
    const auto side_light = [&](std::size_t side) { return lights[6 * side]; };
    CHECK(side_light(5) > side_light(4));
    CHECK(side_light(3) > side_light(2));
    CHECK(side_light(1) > side_light(0));
}

TEST_CASE("ridges are lighter and valleys darker than flat surface", "[texture.from_model]")
{
    // A strip that is bent a little, within the crease angle, at x = 1: up or down.
    const auto light_at_bend = [](float height)
    {
        Mesh mesh;
        for (const float y : {0.0F, 1.0F})
            for (const float x : {0.0F, 1.0F, 2.0F})
                mesh.positions.push_back({x, y, x == 1 ? height : 0});
        mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
        return shape_lights(mesh)[1];
    };
    CHECK(light_at_bend(0.1F) > light_at_bend(0));
    CHECK(light_at_bend(-0.1F) < light_at_bend(0));
}
