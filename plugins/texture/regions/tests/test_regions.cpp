#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/regions/regions.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <span>

using namespace fresco;

namespace
{

constexpr int side = 80;

/// Stripes of a color; without the right chart's right half if `cut`.
Texture striped(Vec3f rgb, bool cut = false)
{
    Texture texture = testing::blank_texture(side, 0.0F);
    testing::see(texture, {0, 0}, {cut ? 0.75F : 1.0F, 1}, rgb);
    for (int x = 0; x < side; x += 3)
        for (int y = 0; y < side; ++y)
            texture.layers.front().at(x, y, 1) += 0.1F;
    texture.atlas = atlas_id(testing::two_chart_wall());
    return texture;
}

/// The wall's left half is the floor, the right one a wall.
Regions halves(const Mesh& mesh = testing::two_chart_wall())
{
    return regions_from(mesh, {"floor", "walls"}, {0, 0, 1, 1});
}

struct Given
{
    Texture photo = striped({0.2F, 0.4F, 0.6F});
    Texture night = striped({0.1F, 0.1F, 0.3F});
    Texture waves = striped({0.5F, 0.6F, 0.7F});
    Regions regions = halves();
    Mesh mesh = testing::two_chart_wall();
};

std::shared_ptr<const Texture> put_together(const Value& rules, testing::TestRun& run, const Given& given = {})
{
    testing::Inputs inputs{{"photo", std::make_shared<Texture>(given.photo)},
                           {"mesh", std::make_shared<Mesh>(given.mesh)},
                           {"regions", std::make_shared<Regions>(given.regions)}};
    for (const auto& [region, rule] : rules.as_map())
    {
        const Value* named = rule.find("texture");
        const std::string name = (named != nullptr ? *named : rule).as_string();
        if (name != "keep")
            inputs[name] = std::make_shared<Texture>(name == "night" ? given.night : given.waves);
    }
    return testing::output_of<Texture>("texture.regions", "texture", Value::Map{{"regions", rules}}, inputs, run);
}

/// Texels of one half of the atlas that differ.
int differing(const Texture& a, const Texture& b, bool right)
{
    int count = 0;
    for (int y = 0; y < side; ++y)
        for (int x = right ? side / 2 : 0; x < (right ? side : side / 2); ++x)
        {
            const auto rgb = [&](const Texture& texture) { return std::span(&texture.layers.front().at(x, y), 3); };
            count += a.seen.at(x, y) != 0 && !std::ranges::equal(rgb(a), rgb(b)) ? 1 : 0;
        }
    return count;
}

struct RegionsTest : testing::StageTest
{
    Given given;
};

}  // namespace

TEST_CASE_METHOD(RegionsTest, "texture.regions: kept regions are the photo bit for bit, others their texture",
                 "[texture.regions]")
{
    const auto result = put_together(Value::Map{{"floor", "keep"}, {"*", "night"}}, run);
    CHECK(result->atlas == atlas_id(given.mesh));
    CHECK(differing(*result, given.photo, false) == 0);
    CHECK(differing(*result, given.night, true) == 0);
    CHECK(differing(*result, given.photo, true) > 100);
    CHECK(run.reported.at("regions").at("floor").at("changed_texels").as_int() == 0);
    CHECK(run.reported.at("regions").at("floor").at("texels").as_int() > 100);
    CHECK(run.reported.at("regions").at("walls").at("changed_texels") == run.reported.at("regions").at("walls").at("texels"));
    // A region without a rule is kept, too.
    CHECK(differing(*put_together(Value::Map{{"walls", "waves"}}, run), given.photo, false) == 0);
}

TEST_CASE_METHOD(RegionsTest, "texture.regions: strength mixes with the photo", "[texture.regions]")
{
    const auto result =
        put_together(Value::Map{{"floor", Value::Map{{"texture", "waves"}, {"strength", 0.25}}}, {"walls", "night"}}, run);
    const auto at = [&](const Texture& texture, int x) { return texture.layers.front().at(x, 3 * side / 4, 2); };
    CHECK(at(*result, side / 4) == Approx(0.6 + 0.25 * 0.1));
    CHECK(at(*result, 3 * side / 4) == at(given.night, 3 * side / 4));
}

TEST_CASE_METHOD(RegionsTest, "texture.regions: what the photo lacks is filled from the photo, not from its neighbors' paint",
                 "[texture.regions]")
{
    given.photo = striped({0.2F, 0.4F, 0.6F}, true);
    given.regions = regions_from(given.mesh, {"floor", "walls"}, {1, 1, 1, 0});
    const auto kept = put_together(Value::Map{{"*", "keep"}}, run, given);
    const auto result = put_together(Value::Map{{"floor", "keep"}, {"walls", "night"}}, run, given);
    CHECK(run.reported.at("regions").at("floor").at("changed_texels").as_int() == 0);
    std::size_t blue = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 3 * side / 4 + 1; x < side; ++x)
            if (result->seen.at(x, y) != 0 && result->layers.front().at(x, y, 2) == kept->layers.front().at(x, y, 2))
                ++blue;
    CHECK(blue > 50);
}

TEST_CASE_METHOD(RegionsTest, "texture.regions: refuses what does not belong together, by name", "[texture.regions]")
{
    const Value rules = Value::Map{{"floor", "keep"}, {"*", "night"}};
    CHECK_THROWS_WITH(put_together(Value::Map{{"flor", "keep"}, {"*", "night"}}, run), Contains("(did you mean 'floor'?)"));
    CHECK_THROWS_WITH(put_together(Value::Map{{"chair", "keep"}}, run), Contains("(there are: floor, walls)"));
    given.night = testing::blank_texture(side / 2, 0);
    CHECK_THROWS_WITH(put_together(rules, run, given), Contains("the one on port 'night' 40"));
    given = {};
    given.night.atlas = "00000000000000000000000000000000";
    CHECK_THROWS_WITH(put_together(rules, run, given), Contains("the texture on port 'night'"));
    given = {};
    given.regions.label_of_face.pop_back();
    CHECK_THROWS_WITH(put_together(rules, run, given),
                      Contains("the regions on port 'regions' are of another mesh: they label 3 faces, the mesh on port "
                               "'mesh' has 4; wire the regions.* stage to the same mesh"));
    given = {};
    given.regions.atlas = "00000000000000000000000000000000";
    CHECK_THROWS_WITH(put_together(rules, run, given), Contains("4 with other vertices or texcoords"));
    given = {};
    given.mesh.texcoords.clear();
    given.regions = halves(given.mesh);
    CHECK_THROWS_WITH(put_together(rules, run, given), Contains("has no texcoords"));
    CHECK_THROWS_WITH(put_together(Value::Map{{"floor", Value::Map{{"texture", "night"}, {"strength", 1.5}}}}, run),
                      Contains("'strength' of 'floor'"));
}

TEST_CASE_METHOD(RegionsTest, "texture.regions: a rule for a region that no face has warns", "[texture.regions]")
{
    given.regions.names.emplace_back("ceiling");
    put_together(Value::Map{{"ceiling", "night"}}, run, given);
    REQUIRE(!run.messages.empty());
    CHECK_THAT(run.messages.back(), Contains("warning: no part of the mesh is 'ceiling' without a closer rule: its rule changes nothing"));
}

TEST_CASE_METHOD(RegionsTest, "texture.regions: of the names in a region's path, the innermost that has a rule counts",
                 "[texture.regions]")
{
    // The left half is a part of the house's furniture, the right one its wall.
    given.regions.names = {"house/furniture/part_1", "house/walls"};
    const auto textures = [&](const Value& rules)
    {
        put_together(rules, run, given);
        std::vector<std::string> names;
        for (const auto& [region, figures] : run.reported.at("regions").as_map())
            names.push_back(figures.at("texture").as_string());
        return names;
    };
    using Names = std::vector<std::string>;
    CHECK(textures(Value::Map{{"part_1", "night"}, {"*", "waves"}}) == Names{"night", "waves"});
    CHECK(textures(Value::Map{{"house", "waves"}, {"furniture", "night"}, {"*", "keep"}}) == Names{"night", "waves"});
    CHECK(textures(Value::Map{{"house/walls", "night"}, {"walls", "waves"}, {"furniture", "waves"}}) == Names{"waves", "night"});
    CHECK_THAT(run.messages.back(), Contains("warning: no part of the mesh is 'walls' without a closer rule: its rule changes nothing"));
    run.messages.clear();
    CHECK(textures(Value::Map{{"furniture", "night"}}) == Names{"night", "keep"});
    CHECK(run.messages.empty());
}
