#include "patches.h"
#include "random_tensor.h"
#include "search.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include "catch.h"

#include <algorithm>
#include <cmath>

using fresco::testing::random_tensor;
namespace pm = patch_match;

namespace
{

}  // namespace

TEST_CASE("A grid holds the patches that fit")
{
    const pm::PatchGrid grid{12, 9, 2};
    CHECK(grid.columns() == 4);
    CHECK(grid.rows() == 2);
    CHECK(grid.x(6) == 4);
    CHECK(grid.y(6) == 2);
    CHECK(grid.x(7) == 5);  // not 6, where it would not fit, but the picture's end is covered
    CHECK(pm::PatchGrid{6, 40, 1}.count() == 0);
    CHECK(pm::PatchGrid{7, 7, 3}.count() == 1);
}

TEST_CASE("Patches are rows in the order channel, y, x")
{
    const auto picture = random_tensor({3, 9, 12}, 1) + 0.5;
    const pm::PatchGrid grid{12, 9, 2};
    const auto rows = pm::extract_patches(picture, grid);
    CHECK(rows.sizes() == at::IntArrayRef({8, 147}));
    CHECK(at::equal(rows[6], picture.narrow(1, 2, 7).narrow(2, 4, 7).flatten()));
}

TEST_CASE("A patch with one invalid pixel takes no part")
{
    const pm::PatchGrid grid{12, 9, 1};
    auto mask = at::ones({9, 12}, at::kBool);
    CHECK(pm::whole_patches(mask, grid).all().item<bool>());
    mask[4][3] = false;
    const auto whole = pm::whole_patches(mask, grid);
    for (std::int64_t i = 0; i < grid.count(); ++i)
        CHECK(whole[i].item<bool>() == (grid.x(i) > 3));  // every row of patches covers y = 4
}

TEST_CASE("Halving takes means, and masks only whole cells")
{
    const auto picture = at::arange(15, at::kFloat).reshape({1, 3, 5});
    CHECK(at::equal(pm::halved(picture), at::tensor({3.0F, 5.0F}).reshape({1, 1, 2})));
    auto mask = at::ones({3, 5}, at::kBool);
    mask[1][3] = false;
    CHECK(at::equal(pm::halved_mask(mask), at::tensor({1, 0}).to(at::kBool).reshape({1, 2})));
    CHECK(pm::halved(at::zeros({3, 1, 8})).numel() == 0);
    CHECK(pm::halved_mask(at::ones({1, 8}, at::kBool)).numel() == 0);
}

TEST_CASE("Style patches: every pixel's, or a coarser grid's, with principal directions")
{
    const auto picture = random_tensor({3, 20, 24}, 1) + 0.5;
    const auto all = pm::make_style_patches(picture, 1000, 147);
    CHECK(all.patches.size(0) == 14 * 18);
    CHECK(pm::make_style_patches(picture, 100, 4).patches.size(0) == 8 * 10);
    CHECK(all.total_variance ==
          Approx((all.patches - all.patches.mean(0)).pow(2).sum().item<double>() / (14 * 18)).epsilon(1e-4));
    // All directions keep lengths; the first is the strongest.
    CHECK(at::allclose(all.keys.pow(2).sum(1), (all.patches - all.mean).pow(2).sum(1), 1e-3, 1e-3));
    const auto strength = all.keys.pow(2).mean(0);
    CHECK((strength.narrow(0, 0, 146) >= strength.narrow(0, 1, 146) - 1e-5).all().item<bool>());
    const auto one_color = pm::make_style_patches(at::full({3, 20, 20}, 0.5F), 1000, 8);
    CHECK(at::isfinite(one_color.keys).all().item<bool>());
}

TEST_CASE("The robust distance agrees with the formula and with finite differences")
{
    const auto picture = random_tensor({3, 9, 9}, 1, at::kDouble) + 0.5;
    const auto style = random_tensor({5, 147}, 2) + 0.5;
    const pm::PatchGrid grid{9, 9, 2};
    REQUIRE(grid.count() == 4);
    const auto nearest = at::tensor({3, -1, 0, 4}, at::kInt);
    const double scale = 3;
    const auto value = [&](const torch::Tensor& p) { return pm::robust_distance(p, grid, nearest, style, scale, 0.8, 2); };

    double expected = 0;
    for (const std::int64_t i : {0, 2, 3})
    {
        const auto patch = picture.narrow(1, grid.y(i), 7).narrow(2, grid.x(i), 7).flatten();
        const double squares = (patch - style[nearest[i].item<std::int64_t>()].to(at::kDouble)).pow(2).sum().item<double>();
        expected += std::pow(squares / scale + 1e-4, 0.4) / 3;
    }
    CHECK(value(picture).item<double>() == Approx(expected));

    auto variable = picture.clone().requires_grad_();
    (value(variable) * 2).backward();
    for (std::int64_t i = 0; i < picture.numel(); i += 7)
    {
        auto up = picture.clone();
        auto down = picture.clone();
        up.view({-1})[i] += 1e-6;
        down.view({-1})[i] -= 1e-6;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / 1e-6;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-5).margin(1e-8));
    }
    CHECK(value(picture.to(at::kFloat)).item<double>() == Approx(expected).epsilon(1e-5));
}

TEST_CASE("Many rows of patches have the derivative that libtorch finds, whatever the number of threads")
{
    const auto picture = random_tensor({3, 41, 33}, 1) + 0.5;
    const auto style = (random_tensor({5, 147}, 2) + 0.5) * 0.5;
    const pm::PatchGrid grid{33, 41, 2};
    auto nearest = at::arange(0, grid.count(), at::kInt).remainder(6) - 1;
    nearest = nearest.to(at::kInt).contiguous();
    const auto gradient = [&](int threads)
    {
        auto variable = picture.clone().requires_grad_();
        pm::robust_distance(variable, grid, nearest, style, 3, 0.8, threads).backward();
        return variable.grad();
    };
    CHECK(at::equal(gradient(1), gradient(3)));

    auto variable = picture.to(at::kDouble).requires_grad_();
    auto sum = at::zeros({}, at::kDouble);
    std::int64_t taking_part = 0;
    for (std::int64_t i = 0; i < grid.count(); ++i)
        if (const auto match = nearest[i].item<std::int64_t>(); match >= 0)
        {
            const auto patch = variable.narrow(1, grid.y(i), 7).narrow(2, grid.x(i), 7).flatten();
            sum = sum + ((patch - style[match].to(at::kDouble)).pow(2).sum() / 3 + 1e-4).pow(0.4);
            ++taking_part;
        }
    (sum / static_cast<double>(taking_part)).backward();
    CHECK(at::allclose(gradient(2).to(at::kDouble), variable.grad(), 1e-4, 1e-7));
}

TEST_CASE("A patch that equals its style patch has a finite gradient; none taking part has no value")
{
    const auto picture = random_tensor({3, 7, 7}, 1) + 0.5;
    const pm::PatchGrid grid{7, 7, 1};
    auto variable = picture.clone().requires_grad_();
    const auto value = pm::robust_distance(variable, grid, at::zeros({1}, at::kInt), picture.reshape({1, 147}), 1, 0.8, 1);
    value.backward();
    CHECK(value.item<double>() == Approx(std::pow(1e-4, 0.4)));
    CHECK(at::equal(variable.grad(), at::zeros_like(picture)));
    CHECK_FALSE(pm::robust_distance(picture, grid, at::full({1}, -1, at::kInt), picture.reshape({1, 147}), 1, 0.8, 1).defined());
}

using fresco::Vec3d;

TEST_CASE("moments of two pixels by hand")
{
    auto picture = at::zeros({3, 1, 2}, at::kFloat);
    picture[0][0][1] = 1;
    const auto moments = patch_match::color_moments(picture);
    CHECK(moments.mean() == (Vec3d{0.5, 0, 0}));
    CHECK(moments.covariance()(0, 0) == 0.25);
}

TEST_CASE("recolored applies the map pixel by pixel and clamps")
{
    const auto picture = at::arange(60, at::kDouble).reshape({3, 4, 5}) / 60;
    const fresco::ColorMap map{fresco::Mat3{{2, 0, 0, 0, 1, 0.5, 0, 0.25, 1}}, {-0.5, 0.1, 0}};
    const auto result = patch_match::recolored(picture, map);
    REQUIRE(result.sizes() == picture.sizes());
    const auto in = picture.accessor<double, 3>();
    const auto out = result.accessor<double, 3>();
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x)
        {
            const auto expected = map(Vec3d{in[0][y][x], in[1][y][x], in[2][y][x]});
            CHECK(out[0][y][x] == Approx(std::clamp(expected.x, 0.0, 1.0)).margin(1e-12));
            CHECK(out[1][y][x] == Approx(std::clamp(expected.y, 0.0, 1.0)).margin(1e-12));
            CHECK(out[2][y][x] == Approx(std::clamp(expected.z, 0.0, 1.0)).margin(1e-12));
        }
}
