#include "catch.h"

#include <far_device.h>
#include <fresco/layered_texture/layered_texture.h>

#include <ATen/ATen.h>

#include <cmath>

using namespace fresco;

namespace
{

class TwoLayers final : public LayeredTexture
{
  public:
    explicit TwoLayers(TexelGrid grid) : grid_(grid) {}
    void allocate(int size_px) override { allocate_layers({size_px, size_px / 2}, {1, 0}, grid_); }
    void set_picture(const RasterF& picture) override
    {
        RasterF coarse(picture.width / 2, picture.height / 2, 3);
        for (std::size_t i = 0; i < coarse.values.size(); ++i)
            coarse.values[i] = static_cast<float>(std::sin(static_cast<double>(i)));
        set_layers({picture, coarse});
    }

  private:
    TexelGrid grid_;
};

/// uv that crosses the borders and meets texel centers, some pixels invalid.
UvMap swirl(int width, int height)
{
    UvMap map{RasterF(width, height, 2), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            map.uv.at(x, y, 0) = static_cast<float>(0.5 + 0.6 * std::sin(0.11 * x + 0.05 * y));
            map.uv.at(x, y, 1) = x % 5 == 0 ? 0.53125F : static_cast<float>(0.5 + 0.55 * std::cos(0.07 * y - 0.03 * x));
            map.valid.at(x, y) = (x + y) % 4 != 0 ? 1 : 0;
        }
    return map;
}

}  // namespace

TEST_CASE("a view on another device looks up and gathers what it does on the processor, and waits for nothing")
{
    const auto map = swirl(37, 29);
    RasterF picture(32, 32, 3);
    for (std::size_t i = 0; i < picture.values.size(); ++i)
        picture.values[i] = static_cast<float>(std::cos(0.3 * static_cast<double>(i)));
    for (const auto grid : {TexelGrid::centers, TexelGrid::corners})
    {
        TwoLayers near(grid);
        TwoLayers far(grid);
        near.allocate(32);
        far.allocate(32);
        REQUIRE(far.move_to(testing::far_device()));
        near.set_picture(picture);
        far.set_picture(picture);
        const auto near_view = near.make_view(map);
        const auto far_view = far.make_view(map);
        const auto slopes = at::sin(at::arange(3 * 29 * 37, at::kFloat)).view({3, 29, 37});
        const auto far_slopes = slopes.to(testing::far_device());
        testing::forget_far_traffic();
        const auto shown = far_view->render();
        const auto gradients = far_view->gradient(far_slopes);
        CHECK(testing::far_traffic().wait_count() == 0);
        CHECK((shown.cpu() - near_view->render()).abs().max().item<float>() < 1e-6F);
        const auto expected = near_view->gradient(slopes);
        REQUIRE(gradients.size() == 2);
        for (std::size_t i = 0; i < 2; ++i)
        {
            CHECK(gradients[i].texels.cpu().equal(expected[i].texels));
            CHECK(gradients[i].values.cpu().equal(expected[i].values));
        }
        CHECK(far.to_texture().layers[0].values == near.to_texture().layers[0].values);
    }
}
