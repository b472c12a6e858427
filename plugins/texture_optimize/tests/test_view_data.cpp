#include "fakes.h"
#include "level_rules.h"
#include "view_data.h"

#include "catch.h"

using namespace fakes;
using namespace fresco::optimize;

namespace
{

/// Keeps the maps that it is asked to show, and shows nothing.
class KeptMaps final : public TextureRepresentation
{
  public:
    void allocate(int) override {}
    void set_picture(const RasterF&) override {}
    std::vector<TextureParameter>& parameters() override { return parameters_; }
    std::unique_ptr<TextureView> make_view(const UvMap& map) const override
    {
        maps.push_back(map);
        return nullptr;
    }
    Texture to_texture() const override { return {}; }
    mutable std::vector<UvMap> maps;

  private:
    std::vector<TextureParameter> parameters_;
};

}  // namespace

TEST_CASE("pixels without a surface show the texture's corner where the released code is followed")
{
    const testing::TemporaryFolder folder;
    const Wall wall(folder.path(), 2, {24, 36});
    const ViewSource source(*wall.maps, wall.frames, nullptr, {});
    const KeptMaps texture;
    for (const bool by_angle : {false, true})
    {
        LevelRules rules = all_pixels;
        rules.fill_with_corner = true;
        rules.scaling = by_angle ? GradientScaling::angle : GradientScaling::none;
        const auto data = load_view(source, 1, texture, rules);
        const UvMap& map = texture.maps.back();
        const LevelData& level = data->levels.back();
        CHECK(map.valid.at(0, 3) == 1);
        CHECK(map.uv.at(0, 3, 0) == 0);
        CHECK(map.uv.at(0, 3, 1) == 1);
        CHECK(map.uv.at(5, 3, 0) == Approx(wall_map(1, 2, map.valid.width, map.valid.height).uv.at(5, 3, 0)).margin(1e-4));
        CHECK(level.valid.at(0, 3) == 1);       // shown …
        CHECK(level.pixels.all.at(0, 3) == 0);  // … but not compared
        CHECK(level.factor.at(0, 3) == (by_angle ? 0 : 1));
        CHECK(level.factor.at(5, 3) == Approx(by_angle ? 0.8 : 1));
    }
    CHECK(load_view(source, 1, texture, all_pixels)->levels.back().valid.at(0, 3) == 0);
    CHECK(texture.maps.back().valid.at(0, 3) == 0);
}
