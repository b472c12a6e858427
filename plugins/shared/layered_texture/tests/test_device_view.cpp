#include "texture_samples.h"

#include <far_device.h>
#include <fresco/layered_texture/layered_texture.h>

#include <ATen/ATen.h>

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
        set_layers({picture, texture_samples::random_picture(picture.width / 2, picture.height / 2, 3, 3)});
    }

  private:
    TexelGrid grid_;
};

}  // namespace

TEST_CASE("a view on another device looks up and gathers what it does on the processor, and waits for nothing")
{
    const auto map = texture_samples::random_map(37, 29, 1);
    const RasterF picture = texture_samples::random_picture(32, 32, 3, 2);
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
