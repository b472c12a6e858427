#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/images/lab.h>
#include <fresco/numerics/numerics.h>
#include <fresco/regions/regions.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <set>

using namespace fresco;

namespace
{

/// Two walls of 2 x 2 m that face the origin, at z = 2 and at z = -2, in the halves of one atlas.
struct Walls
{
    Mesh mesh = testing::rectangle({-1, -1, 2}, {0, 2, 0}, {2, 0, 0}, 8, 8);
    Texture texture = testing::blank_texture(32, 0.0F);
    Image style;
    testing::TestRun run;
    testing::TemporaryFolder folder;

    Walls()
    {
        testing::append(mesh, testing::rectangle({-1, -1, -2}, {2, 0, 0}, {0, 2, 0}, 8, 8));
        testing::set_texcoords(mesh,
                               [](Vec3f p) {
                                   return Vec2f{(p.x + 1) * 0.2F + (p.z > 0 ? 0.05F : 0.55F), (p.y + 1) * 0.2F + 0.05F};
                               });
        mesh.texture_px = 32;
        texture.atlas = atlas_id(mesh);
        for (std::size_t texel = 0; texel < texture.seen.values.size(); ++texel)
        {
            texture.seen.values[texel] = 1;
            texture.layers[0].values[3 * texel] = texel % 32 < 16 ? 0.25F : 0.75F;
        }
        style = Image(testing::picture(4, 4, [](int x, int, int c) { return c == 0 ? 40 * x : 90; }));
    }

    void cut(const Value::Map& more = {}, testing::Inputs inputs = {})
    {
        Value options{
            Value::Map{{"position_m", Value::List{0, 0, 0}}, {"forward", Value::List{0, 0, 1}}, {"up", Value::List{0, 1, 0}}}};
        for (const auto& [name, value] : more)
            options.set(name, value);
        inputs.emplace("mesh", std::make_shared<Mesh>(mesh));
        inputs.emplace("texture", std::make_shared<Texture>(texture));
        testing::run_stage(FRESCO_PLUGIN_FILE, "mesh.in_view", options, inputs, folder.path(), run);
    }
    template <class T>
    std::shared_ptr<T> result(const char* port) const
    {
        return T::load({folder.path() / port, {}});
    }
    std::string refusal(const Value::Map& options)
    {
        return testing::error_of([&] { cut(options); });
    }
};

}  // namespace

TEST_CASE_METHOD(Walls, "the faces in view and two rings around them are kept, with their texcoords and regions")
{
    std::vector<std::uint32_t> row(mesh.triangles.size());
    for (std::size_t f = 0; f < row.size(); ++f)
        row[f] = static_cast<std::uint32_t>(f / 16 % 2);
    const Regions stripes = regions_from(mesh, {"even", "odd"}, row);
    cut({{"field_deg", 11.4}, {"aspect", 1}}, {{"regions", std::make_shared<Regions>(stripes)}});
    const auto part = result<Mesh>("mesh");
    const auto parts = result<Regions>("regions");
    check_mesh(*part, "the part");
    CHECK(part->texture_px == 32);
    CHECK(texturing::usual_stroke_m(*part, 0.001) == texturing::usual_stroke_m(mesh, 0.001));
    CHECK(parts->atlas == atlas_id(*part));
    // 20 cm to each side are seen at 2 m: the four squares of a quarter meter at the middle. Then two rings of faces follow.
    std::set<std::uint32_t> known;
    const auto touches = [&](const Triangle& t)
    { return std::ranges::any_of(t, [&](auto corner) { return known.contains(corner); }); };
    for (std::size_t v = 0; v < 81; ++v)
        if (std::abs(mesh.positions[v].x) < 0.3F && std::abs(mesh.positions[v].y) < 0.3F)
            known.insert(static_cast<std::uint32_t>(v));
    std::set<std::uint32_t> wider;
    for (const Triangle& t : mesh.triangles)
        if (touches(t))
            wider.insert(t.begin(), t.end());
    known = wider;
    std::size_t next = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const bool kept = next < part->triangles.size() && part->triangles[next] == mesh.triangles[f];
        INFO(f);
        CHECK(kept == touches(mesh.triangles[f]));
        if (!kept)
            continue;
        for (std::size_t corner = 0; corner < 3; ++corner)
            CHECK(part->texcoords[3 * next + corner] == mesh.texcoords[3 * f + corner]);
        CHECK(parts->names[parts->label_of_face[next]] == (row[f] == 0 ? "even" : "odd"));
        ++next;
    }
    CHECK(next == part->triangles.size());
    CHECK(run.reported.at("faces").as_int() == static_cast<std::int64_t>(next));
}

TEST_CASE_METHOD(Walls, "a wide view toward a corner of the wall lies where the eye is, and on its side where up is")
{
    const auto [up, low, high] = GENERATE(std::tuple{Vec3f{0, 1, 0}, Vec3f{-1, -0.5F, 2}, Vec3f{0.5F, 1, 2}},
                                          std::tuple{Vec3f{1, 0, 0}, Vec3f{-1, -0.75F, 2}, Vec3f{0.25F, 1, 2}});
    // 94 x 31 cm are seen at 2 m, and two squares of 25 cm more to each side.
    cut({{"position_m", Value::List{-0.5, 0.25, 0}}, {"up", Value::List{up.x, up.y, up.z}}, {"aspect", 3}, {"field_deg", 9}});
    const auto part = result<Mesh>("mesh");
    numerics::Bounds<float> box;
    for (const Triangle& triangle : part->triangles)
        for (const std::uint32_t corner : triangle)
            box.add(part->positions[corner]);
    CHECK(length(box.low - low) < 1e-5F);
    CHECK(length(box.high - high) < 1e-5F);
}

TEST_CASE_METHOD(Walls, "the view's texels are recolored as the whole texture would be, and the others are not known")
{
    cut({}, {{"style", std::make_shared<Image>(style)}});
    const auto start = result<Texture>("texture");
    CHECK(start->atlas == atlas_id(*result<Mesh>("mesh")));
    ColorMoments from, to;
    for (std::size_t i = 0; i < texture.layers[0].values.size(); i += 3)
        from.add({double{texture.layers[0].values[i]}, 0, 0});
    for (std::size_t i = 0; i < style.pixels.values.size(); i += 3)
        to.add({style.pixels.values[i] / 255.0, 90 / 255.0, 90 / 255.0});
    const Vec3d wanted = monge_kantorovich(from, to)({0.25, 0, 0});
    const auto at = [&](int x, int y, int c) { return start->layers.front().at(x, y, c); };
    CHECK(at(8, 22, 0) == Approx(std::clamp(wanted.x, 0.0, 1.0)).margin(1e-6));
    CHECK(at(8, 22, 1) == Approx(wanted.y).margin(1e-6));
    CHECK(start->seen.at(8, 22) == 1);
    CHECK(start->seen.at(24, 22) == 0);
    CHECK(at(24, 22, 1) == 0);
    cut();
    CHECK(result<Texture>("texture")->layers.front().at(8, 22, 0) == 0.25F);
}

TEST_CASE_METHOD(Walls, "a view of nothing, and invalid directions, are refused")
{
    CHECK_THAT(refusal({{"forward", Value::List{1, 0, 0}}, {"field_deg", 20}}), Catch::Contains("shows nothing"));
    CHECK_THAT(refusal({{"position_m", Value::List{0, 0, 3}}}), Catch::Contains("shows nothing"));  // Backs are not seen.
    CHECK_THAT(refusal({{"up", Value::List{0, 0, 1}}}), Catch::Contains("two directions"));
    CHECK_THAT(refusal({{"up", Value::List{0, 1}}}), Catch::Contains("expected 3"));
}
