#include "catch.h"
#include "model_colors.h"
#include "model_samples.h"
#include "plugin_under_test.h"

#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace from_model;
using fresco::texturing::displayed;
using model_samples::Box;

namespace
{

/// Two pixels side by side, and two rows: 10 20 / 30 40, gray.
Raster8 four_pixels()
{
    return testing::picture(2, 2, [](int x, int y, int) { return 10 * (2 * y + x + 1); });
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

TEST_CASE("ridges are lighter and valleys darker than flat surface", "[texture.from_model]")
{
    // A strip that is bent a little, within the crease angle, at x = 1: up or down.
    const auto light_at_bend = [](float height)
    {
        Mesh mesh = testing::two_chart_wall();
        mesh.positions[1].z = mesh.positions[4].z = height;
        return shape_lights(mesh)[1];
    };
    CHECK(light_at_bend(0.1F) > light_at_bend(0));
    CHECK(light_at_bend(-0.1F) < light_at_bend(0));
}

namespace
{

/// A square of the atlas for each side of the box, in rows of three.
Vec2f atlas_uv(std::size_t side, float u, float v)
{
    const auto column = static_cast<float>(side % 3);
    const auto row = static_cast<float>(side / 3);
    return {(column + 0.05F + 0.9F * u) / 3, (row + 0.05F + 0.9F * v) / 3};
}

/// The box; `with_texcoords(side, u, v)` says where in the texcoords a corner lies.
template <class F>
Mesh box_mesh(const F& texcoord)
{
    Mesh mesh;
    for (std::uint32_t side = 0; side < Box::sides; ++side)
    {
        for (const Vec3f p : Box::corners(side))
            mesh.positions.push_back(p);
        for (const Triangle& t : {Triangle{0, 1, 2}, Triangle{0, 2, 3}})
        {
            mesh.triangles.push_back({4 * side + t[0], 4 * side + t[1], 4 * side + t[2]});
            for (const std::uint32_t corner : t)
                mesh.texcoords.push_back(
                    texcoord(side, model_samples::corner_uvs[corner][0], model_samples::corner_uvs[corner][1]));
        }
    }
    return mesh;
}

Mesh atlas()
{
    return box_mesh(atlas_uv);
}

Texture textured(const Model& model, const Mesh& mesh, testing::TestRun& run, int size_px = 192)
{
    return *testing::output_of<Texture>("texture.from_model", "texture", Value::Map{{"size_px", size_px}},
                                        {{"model", std::make_shared<Model>(model)}, {"mesh", std::make_shared<Mesh>(mesh)}}, run,
                                        {{"image_io", std::make_shared<stored_png::Codec>()}});
}

/// The box with a picture per side in `folder`.
Model painted_box(const testing::TemporaryFolder& folder)
{
    Model model;
    model.mesh = box_mesh([](std::size_t, float u, float v) { return Vec2f{u + 2, v - 3}; });
    model.loaded_from = folder.path();
    for (std::uint32_t side = 0; side < Box::sides; ++side)
    {
        model.pictures.push_back("picture_" + std::to_string(side) + ".png");
        write_file(folder.path() / model.pictures.back(), stored_png::Codec().encode_png(Box::picture(side)));
        ModelMaterial material;
        material.picture = static_cast<int>(side);
        model.materials.push_back(material);
        model.material_of_face.insert(model.material_of_face.end(), 2, side);
    }
    return model;
}

Rgb8 bytes_at(const Texture& texture, Vec2f uv)
{
    std::array<float, 3> rgb{};
    sample_bilinear(texture.layers.at(0), uv.x, uv.y, rgb.data());
    const auto step = [](float v) { return static_cast<std::uint8_t>(std::lround(v * 255)); };
    return {step(rgb[0]), step(rgb[1]), step(rgb[2])};
}

/// The two sides of a wall without much thickness: white to +z, black to -z.
Mesh wall()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, -0.01F}, {1, 0, -0.01F}, {1, 1, -0.01F}, {0, 1, -0.01F}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    mesh.colors.assign(4, Rgb8{255, 255, 255});
    mesh.colors.resize(8);
    mesh.texcoords = {{0, 0},    {0.4F, 0}, {0.4F, 1}, {0, 0},    {0.4F, 1}, {0, 1},
                      {0.5F, 0}, {1, 1},    {1, 0},    {0.5F, 0}, {0.5F, 1}, {1, 1}};
    return mesh;
}

Model colored(const Mesh& mesh)
{
    ModelMaterial material;
    material.vertex_colors = !mesh.colors.empty();
    return model_of(mesh, material);
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "six pictures come out on their sides, the right way up", "[texture.from_model]")
{
    const Texture texture = textured(painted_box(folder), atlas(), run);
    CHECK(texture.atlas == atlas_id(atlas()));
    for (std::size_t side = 0; side < Box::sides; ++side)
        for (const float u : {0.05F, 0.3F, 0.7F, 0.95F})
            for (const float v : {0.05F, 0.3F, 0.7F, 0.95F})
                CHECK(bytes_at(texture, atlas_uv(side, u, v)) == Box::color(side, u, v));
    CHECK(run.reported.at("colors_from").as_string() == "pictures");
    CHECK(run.reported.at("largest_distance_m").as_double() < 1e-6);
    CHECK(run.messages.empty());
    // The middle of the gutter between the squares is not covered.
    CHECK(texture.seen.at(2, 189) == 0);
    CHECK(texture.seen.at(32, 160) == 1);
}

TEST_CASE_METHOD(testing::StageTest,
                 "pixels count whatever their alpha is, without a warning; a damaged picture is named by its model",
                 "[texture.from_model]")
{
    const Model model = painted_box(folder);
    const Mesh mesh = atlas();
    const Texture opaque = textured(model, mesh, run);
    CHECK(run.messages.empty());
    const Raster8 rgb = Box::picture(0);
    const Raster8 rgba = testing::picture(
        16, 16, [&](int x, int y, int c) { return c == 3 ? 0 : rgb.at(x, y, c); }, 4);
    const auto file = model.loaded_from / model.pictures[0];
    write_file(file, stored_png::Codec().encode_png(rgba));
    CHECK(textured(model, mesh, run).layers[0] == opaque.layers[0]);
    CHECK(run.messages.empty());
    std::filesystem::remove(file);
    CHECK_THROWS_WITH(textured(model, mesh, run), Catch::Contains("picture 0 of the model on port 'model': ") &&
                                                      !Catch::Contains(model.loaded_from.string()));
}

TEST_CASE("where the picture is finer than the texture, a texel takes the mean light below it", "[texture.from_model]")
{
    // Stripes of one pixel, black and white: 5 pixels per texel, and 40, which are made fewer first.
    const testing::TemporaryFolder folder;
    for (const int size : {160, 1280})
    {
        const Model model = painted_box(folder);
        const Raster8 stripes = testing::picture(size, size, [](int x, int, int) { return x % 2 == 0 ? 255 : 0; });
        write_file(model.loaded_from / model.pictures[5], stored_png::Codec().encode_png(stripes));
        testing::TestRun run;
        const Texture texture = textured(model, atlas(), run, 107);
        for (const float u : {0.2F, 0.4F, 0.8F})
            CHECK(std::abs(bytes_at(texture, atlas_uv(5, u, 0.5F))[0] - 188) <= 12);
    }
}

TEST_CASE_METHOD(testing::StageTest, "each side of a thin wall keeps its colors", "[texture.from_model]")
{
    Mesh thin = wall();
    // The atlas's wall lies a little beside the model's: each of its sides is nearer to the other color.
    for (Vec3f& p : thin.positions)
        p.z += p.z == 0 ? -0.008F : 0.008F;
    const Texture texture = textured(colored(wall()), thin, run);
    CHECK(run.reported.at("colors_from").as_string() == "colors");
    CHECK(bytes_at(texture, {0.2F, 0.5F}) == Rgb8{255, 255, 255});
    CHECK(bytes_at(texture, {0.75F, 0.5F}) == Rgb8{0, 0, 0});
    CHECK(run.reported.at("mean_distance_m").as_double() == Approx(0.008).epsilon(1e-3));
    CHECK(run.reported.at("max_distance_m").as_double() == Approx(0.02 * std::sqrt(2.0001)).epsilon(1e-6));
    // Between vertices they run linearly in light.
    Mesh ramp = wall();
    ramp.colors[0] = ramp.colors[3] = {0, 0, 0};
    CHECK(std::abs(bytes_at(textured(colored(ramp), wall(), run), {0.2F, 0.5F})[1] - 188) <= 1);
}

TEST_CASE_METHOD(testing::StageTest, "a bare model is shaded by its shape", "[texture.from_model]")
{
    Mesh bare = atlas();
    const Texture texture = textured(colored(bare), atlas(), run);
    CHECK(run.reported.at("colors_from").as_string() == "shape");
    CHECK(run.reported.at("seen_share").as_double() == 1);
    CHECK_THAT(run.messages.at(0), Contains("shaded by its shape"));
    const auto tone = [&](std::size_t side) { return bytes_at(texture, atlas_uv(side, 0.5F, 0.5F))[0]; };
    // Sides that meet differ by a tenth of the range at least.
    for (std::size_t side = 0; side < Box::sides; ++side)
        for (std::size_t other = 0; other < side; ++other)
            if (side / 2 != other / 2)
                CHECK(std::abs(tone(side) - tone(other)) >= 12);
}

TEST_CASE_METHOD(testing::StageTest,
                 "what is out of reach is not seen and continues the rest; a mesh of another model is refused",
                 "[texture.from_model]")
{
    Mesh far = wall();
    for (std::size_t i = 4; i < 8; ++i)
        far.positions[i].z = -0.5F;
    const Texture texture = textured(colored(wall()), far, run);
    CHECK(bytes_at(texture, {0.2F, 0.5F}) == Rgb8{255, 255, 255});
    CHECK(texture.seen.at(144, 96) == 0);
    CHECK(bytes_at(texture, {0.75F, 0.5F}) == Rgb8{255, 255, 255});
    CHECK(run.reported.at("seen_share").as_double() == Approx(0.4 / 0.9).epsilon(0.02));
    CHECK_THAT(run.messages.at(0), Contains("warning: 55 % of the atlas is farther than 0.028 m from the model"));

    for (Vec3f& p : far.positions)
        p.x += 100;
    CHECK_THROWS_WITH(textured(colored(wall()), far, run), Contains("no part of the mesh on port 'mesh' is within"));
    for (Vec2f& uv : far.texcoords)
        uv.y = 0.5F;
    CHECK_THROWS_WITH(textured(colored(wall()), far, run), Contains("the mesh on port 'mesh' has no room in the atlas"));
    far.texcoords.clear();
    CHECK_THROWS_WITH(textured(colored(wall()), far, run), Contains("has no texcoords: wire an atlas.* stage"));
    Model wrong = colored(wall());
    wrong.material_of_face.pop_back();
    CHECK_THROWS_WITH(textured(wrong, wall(), run), Contains("the model on port 'model': materials of 3 faces"));
}
