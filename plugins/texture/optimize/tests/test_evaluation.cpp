#include "evaluation.h"
#include "fakes.h"
#include "gradients.h"
#include "rendered_part.h"
#include "views.h"

#include "catch.h"

#include <fresco/error.h>

#include <ATen/Parallel.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/conv2d.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/full_like.h>
#include <ATen/ops/index_select.h>
#include <ATen/ops/matmul.h>
#include <ATen/ops/max_pool2d.h>
#include <ATen/ops/rand.h>
#include <ATen/ops/relu.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/where.h>
#include <ATen/ops/zeros_like.h>
#include <torch/csrc/autograd/autograd.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace fakes;
using namespace fresco::optimize;

namespace
{

/// A texture of one texel, shown by every pixel. Keeps the maps that it is asked to show.
class OneTexel final : public TextureRepresentation
{
  public:
    class View final : public TextureView
    {
      public:
        View(const torch::Tensor& value, int width, int height) : value_(value), width_(width), height_(height) {}
        torch::Tensor render() const override { return value_.reshape({3, 1, 1}).expand({3, height_, width_}).contiguous(); }
        std::vector<SparseGradient> gradient(const torch::Tensor& g) const override
        {
            return {{at::zeros({1}, at::kLong), g.sum({1, 2}).reshape({1, 3})}};
        }

      private:
        torch::Tensor value_;
        int width_;
        int height_;
    };
    void allocate(int) override {}
    void set_picture(const RasterF&) override {}
    std::vector<TextureParameter>& parameters() override { return parameters_; }
    std::unique_ptr<TextureView> make_view(const UvMap& map) const override
    {
        maps.push_back(map);
        return std::make_unique<View>(parameters_[0].values, map.valid.width, map.valid.height);
    }
    Texture to_texture() const override { return {}; }
    mutable std::vector<UvMap> maps;

  private:
    std::vector<TextureParameter> parameters_{{"texel", at::full({1, 3}, 0.4), 1}};
};

struct World
{
    testing::TemporaryFolder folder;
    Wall wall{folder.path(), 2, {24, 36}};
    ViewSource source{*wall.maps, wall.frames, nullptr, {}};
    OneTexel texture;
    HalfNetwork network;

    std::unique_ptr<ViewData> view(std::size_t number, const LevelRules& rules = {}) const
    {
        return load_view(source, number, texture, rules);
    }
};

using Losses = std::map<std::string, std::shared_ptr<Loss>>;

struct WithWorld
{
    World world;
};

}  // namespace

TEST_CASE("a grid cell takes the pixel at its center")
{
    Raster8 mask(5, 4);
    mask.at(1, 1) = 1;
    mask.at(3, 3) = 1;
    mask.at(2, 0) = 1;
    mask.at(4, 1) = 1;
    Raster8 fine(5, 4);
    fine.at(3, 3) = 1;
    fine.at(0, 0) = 1;  // Not in the level.
    const auto half = grid_mask(mask, fine, 2, Protocol::paper, torch::kCPU);
    REQUIRE(half.all.sizes() == at::IntArrayRef({2, 2}));
    CHECK(half.index.equal(at::tensor({3, 0}, at::kLong)));
    CHECK(half.fine_count == 1);
    CHECK(half.all.equal(at::tensor({1, 0, 0, 1}, at::kLong).reshape({2, 2}).to(at::kBool)));
    CHECK(half.fine.equal(at::tensor({0, 0, 0, 1}, at::kLong).reshape({2, 2}).to(at::kBool)));
    CHECK(grid_mask(mask, fine, 1, Protocol::paper, torch::kCPU).index.equal(at::tensor({18, 2, 6, 9}, at::kLong)));
    // The released code takes corners: of rows 0 and 2, and of columns 0 and 2 (5 / 2, rounded down).
    CHECK(grid_mask(mask, fine, 2, Protocol::released_scannet, torch::kCPU).index.equal(at::tensor({1}, at::kLong)));
}

TEST_CASE("selected cells and their gradient equal index_select's, for any type, place in memory and threads")
{
    const int before = at::get_num_threads();
    std::vector<int> every_third;
    for (int i = 0; i < 17 * 9; i += 3)
        every_third.push_back(i);
    for (const auto& list : std::vector<std::vector<int>>{{0}, {150, 151, 152}, {5, 70}, every_third, {}})
    {
        Raster8 mask(17, 9);
        Raster8 fine(17, 9);
        for (std::size_t i = 0; i < list.size(); ++i)
        {
            mask.values[static_cast<std::size_t>(list[i])] = 1;
            fine.values[static_cast<std::size_t>(list[i])] = i % 3 == 1 ? 1 : 0;
        }
        const auto grid = grid_mask(mask, fine, 1, Protocol::paper, torch::kCPU);
        for (const int threads : {1, 3})
            for (const auto type : {at::kFloat, at::kDouble})
                for (const bool innermost : {true, false})
                {
                    at::set_num_threads(threads);
                    const auto numbers = at::arange(5 * 9 * 17, type);
                    const auto features =
                        (innermost ? numbers.reshape({9, 17, 5}).permute({2, 0, 1}) : numbers.reshape({5, 9, 17}))
                            .detach()
                            .set_requires_grad(true);
                    const auto each = at::arange(5 * grid.index.numel(), type) + 1;
                    const auto direction = innermost ? each.reshape({-1, 5}).t() : each.reshape({5, -1});
                    const auto fast = selected_cells(features, grid);
                    const auto slow = at::index_select(features.reshape({5, -1}), 1, grid.index);
                    CHECK(at::equal(fast, slow));
                    CHECK(at::equal(torch::autograd::grad({fast}, {features}, {direction})[0],
                                    torch::autograd::grad({slow}, {features}, {direction})[0]));
                }
    }
    at::set_num_threads(before);
}

TEST_CASE_METHOD(WithWorld, "what is encoded is shared by the losses of a step, and the camera's by the steps of a visit")
{
    const auto data = world.view(0);
    REQUIRE(data->levels.size() == 2);
    CHECK(data->numbers == std::vector<int>{0, 1});
    CHECK(data->levels[0].share == Approx(0.5).margin(0.02));
    const Demands demands{{&world.network, {{"half"}, {"half"}, true}}};
    for (int step = 0; step < 3; ++step)
    {
        const auto image = cut(data->texture->render(), data->levels[1].place).contiguous().set_requires_grad(true);
        RenderedPart part({1, step, 0, step, 7}, image, data->levels[1], demands);
        CHECK(part.height_px() == 36);
        CHECK(part.camera().sizes() == image.sizes());
        const auto features = part.features(world.network, "half");
        CHECK(features.requires_grad());
        CHECK(at::equal(features, part.features(world.network, "half")));
        CHECK(part.feature_mask(world.network, "half", Pixels::all).sizes() == features.sizes().slice(1));
        CHECK_FALSE(part.camera_features(world.network, "half").requires_grad());
        CHECK(part.selected(world.network, "half", Pixels::all).size(1) == 18 * 23);
        CHECK(world.network.encoded == 2 + step);
        CHECK_THROWS_AS(part.features(world.network, "same"), std::logic_error);
        CHECK_THROWS_AS(part.features(HalfNetwork(), "half"), std::logic_error);
    }
}

namespace
{

/// Two convolutions with a pooling between them, zeros beyond the border.
class ConvolvedNetwork : public FeatureNetwork
{
  public:
    ConvolvedNetwork()
    {
        at::manual_seed(3);
        first_ = at::rand({4, 3, 3, 3}, at::kDouble) - 0.4;
        second_ = at::rand({5, 4, 3, 3}, at::kDouble) - 0.4;
    }
    void prepare(const PrepareContext&) override {}
    std::vector<FeatureLayer> layers() const override { return {{"fine", 4, 1, 1}, {"deep", 5, 2, 3}}; }
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        pixels += picture.size(1) * picture.size(2);
        const auto fine = at::relu(at::conv2d(picture.unsqueeze(0), first_, {}, 1, 1));
        const auto deep = at::relu(at::conv2d(at::max_pool2d(fine, {2, 2}), second_, {}, 1, 1));
        std::vector<torch::Tensor> result;
        for (const auto& name : names)
            result.push_back((name == "fine" ? fine : deep).squeeze(0));
        return result;
    }
    mutable std::int64_t pixels = 0;

  private:
    torch::Tensor first_;
    torch::Tensor second_;
};

torch::Tensor as_tensor(const Raster8& mask)
{
    return at::tensor(at::ArrayRef<std::uint8_t>(mask.values), at::kByte).reshape({mask.height, mask.width}).to(at::kBool);
}

/// Gives nonsense where nobody reads.
class PartialNetwork final : public ConvolvedNetwork, public PartialFeatures
{
  public:
    std::vector<torch::Tensor> encode_around(const torch::Tensor& picture, const std::vector<std::string>& names,
                                             const ReadPixels& read) const override
    {
        auto result = encode(at::where(as_tensor(read.gradient), picture, picture.detach()), names);
        for (std::size_t i = 0; i < names.size(); ++i)
        {
            const int stride = layer(names[i]).stride;
            const auto cells = at::max_pool2d(as_tensor(read.features).to(at::kFloat).unsqueeze(0), {stride, stride}) > 0;
            result[i] = at::where(cells, result[i], at::full_like(result[i], 1e9));
        }
        return result;
    }
};

}  // namespace

TEST_CASE("crops give the loss and the gradient of the whole frame, and encode less")
{
    at::manual_seed(8);
    const int width = 61;
    const int height = 47;
    // An angle, whose arms see each other, a corner and a spot between them.
    const auto is_in = [](int x, int y)
    { return (x < 40 && y < 5) || (x < 5 && y < 36) || (x > 50 && y > 36) || (std::abs(x - 30) < 3 && std::abs(y - 20) < 4); };
    LevelPixels level_pixels;
    level_pixels.all = testing::picture(
        width, height, [&](int x, int y, int) { return is_in(x, y) ? 1 : 0; }, 1);
    level_pixels.fine = testing::picture(
        width, height, [&](int x, int y, int) { return is_in(x, y) && (x + y) % 3 != 0 ? 1 : 0; }, 1);
    const auto camera = at::rand({3, height, width}, at::kDouble);
    const auto image = at::rand({3, height, width}, at::kDouble).set_requires_grad(true);
    ConvolvedNetwork whole_network;
    PartialNetwork partial_network;
    std::vector<double> values;
    std::vector<torch::Tensor> gradients;
    std::vector<std::int64_t> pixels;
    for (ConvolvedNetwork* const network : {&whole_network, &whole_network, static_cast<ConvolvedNetwork*>(&partial_network)})
    {
        LevelData level;
        level.camera = camera;
        level.pixels = level_pixels;
        const Demands demands{{network, {{"fine", "deep"}, {"fine", "deep"}, values.empty()}}};
        RenderedPart part({}, image, level, demands);
        // Gram matrices and differences to the camera.
        auto sum = at::zeros({}, at::kDouble);
        network->pixels = 0;
        for (const char* layer : {"fine", "deep"})
            for (const auto role : {Pixels::all, Pixels::fine, Pixels::steep})
            {
                const auto seen = part.selected(*network, layer, role);
                const auto difference = seen - part.camera_selected(*network, layer, role);
                sum = sum + at::matmul(seen, seen.t()).pow(2).sum() / 1e3 + difference.pow(2).sum();
            }
        pixels.push_back(network->pixels);
        values.push_back(sum.item<double>());
        gradients.push_back(torch::autograd::grad({sum}, {image})[0]);
        for (const char* layer : {"fine", "deep"})
        {
            const auto all = part.selected(*network, layer, Pixels::all);
            const auto count = part.fine_count(*network, layer);
            CHECK(all.narrow(1, 0, count).equal(part.selected(*network, layer, Pixels::fine)));
            CHECK(all.narrow(1, count, all.size(1) - count).equal(part.selected(*network, layer, Pixels::steep)));
        }
    }
    const auto most = [](const torch::Tensor& x) { return x.abs().max().item<double>(); };
    const auto mask = as_tensor(level_pixels.all);
    CHECK(values[1] == Approx(values[0]).epsilon(1e-12));
    CHECK(values[2] == Approx(values[0]).epsilon(1e-12));
    CHECK(most(gradients[0]) > 0);
    CHECK(most(gradients[1] - gradients[0]) < 1e-11 * most(gradients[0]));
    CHECK(most((gradients[2] - gradients[0]) * mask) < 1e-11 * most(gradients[0]));
    CHECK(most((gradients[2] - gradients[0]) * mask.logical_not()) > 0);
    CHECK(4 * pixels[1] < 3 * pixels[0]);
}

TEST_CASE_METHOD(WithWorld, "the evaluation's gradient is that of the weighted sum over losses and levels")
{
    const Losses losses{{"camera", camera_loss()}};
    LevelRules unscaled;
    unscaled.scaling = GradientScaling::none;
    const auto data = world.view(1, unscaled);
    Evaluator evaluator(losses, ValueSpace(Values::display), torch::kCPU, 1);
    const auto loss = [&] { return evaluator.evaluate(0, {}, *data, "v", 1); };
    const auto evaluation = loss();
    CHECK(evaluator.summands().at("camera") == Approx(evaluation.loss));
    auto& values = world.texture.parameters()[0].values;
    for (int c = 0; c < 3; ++c)
    {
        auto value = values[0][c];
        value.add_(0.01);
        const double above = loss().loss;
        value.sub_(0.02);
        const double below = loss().loss;
        value.add_(0.01);
        CHECK(evaluation.gradients[0].values[0][c].item<float>() == Approx((above - below) / 0.02).epsilon(1e-3).margin(1e-5));
    }
    // With the angle's scaling every pixel's gradient, and so their sum, is 0.8 of it.
    const auto scaled = evaluator.evaluate(0, {}, *world.view(1), "v", 1);
    CHECK(scaled.gradients[0].values[0][0].item<float>() == Approx(0.8 * evaluation.gradients[0].values[0][0].item<float>()));
    CHECK(scaled.loss == Approx(evaluation.loss));
}

TEST_CASE_METHOD(WithWorld, "a level's picture goes on beyond the level, as far as the texture is seen")
{
    const auto data = world.view(0);
    auto& level = data->levels[1];
    level.pixels.all = Raster8(level.pixels.all.width, level.pixels.all.height);
    level.pixels.all.at(20, 20) = 1;
    torch::Tensor seen;
    const auto look = [&](Part& part)
    {
        seen = part.image().detach().clone();
        return ordered_mean(part.image());
    };
    const Losses losses{{"witness", std::make_shared<PictureLoss>(look)}};
    Evaluator(losses, ValueSpace(Values::display), torch::kCPU, 1).evaluate(0, {}, *data, "v", 1);
    CHECK(seen[0][5][30].item<float>() == Approx(0.4));
    CHECK(seen[0][5][0].item<float>() == 0);  // Not on the wall.
}

TEST_CASE_METHOD(WithWorld, "missing heights and frames are named")
{
    CHECK_THROWS_WITH(ViewSource(*world.wall.maps, world.wall.frames, nullptr, {24, 30}),
                      Catch::Contains("30 px") && Catch::Contains("24, 36"));
    CHECK(ViewSource(*world.wall.maps, world.wall.frames, nullptr, {36}).height_px(0) == 36);
    world.wall.frames.frames.pop_back();
    CHECK_THROWS_WITH(ViewSource(*world.wall.maps, world.wall.frames, nullptr, {}), Catch::Contains("walk/frame-1"));
}

TEST_CASE_METHOD(
    WithWorld, "pixels without a surface show the texture's corner where the released code is followed, and pull at it unscaled")
{
    for (const bool by_angle : {false, true})
    {
        LevelRules rules;
        rules.protocol = Protocol::released_scannet;
        rules.scaling = by_angle ? GradientScaling::angle : GradientScaling::none;
        const auto data = world.view(1, rules);
        const LevelData& level = data->levels.back();
        const UvMap& shown = world.texture.maps.back();
        const auto row = level.place.y0 + 3;
        CHECK((shown.uv.at(0, row, 0) == 0 && shown.uv.at(0, row, 1) == 1));
        CHECK_FALSE(data->hidden[row][0].item<bool>());  // shown …
        CHECK(level.pixels.all.at(0, 3) == 0);           // … but not compared, where the largest map has no surface either
        CHECK(data->factor[row][0].item<float>() == (by_angle ? 0 : 1));
        CHECK(data->factor[row][5].item<float>() == Approx(by_angle ? 0.8 : 1));
    }
    CHECK(world.view(1)->hidden[3][0].item<bool>());
}

TEST_CASE_METHOD(WithWorld,
                 "the released code takes the sensor's depth where every frame has it, and then leaves out what was not measured")
{
    const auto numbers = [&](Protocol protocol)
    {
        LevelRules rules;
        rules.by_depth = true;
        rules.protocol = protocol;
        return load_view(ViewSource(*world.wall.maps, world.wall.frames, nullptr, {}), 0, world.texture, rules)->numbers;
    };
    const auto by_mesh = numbers(Protocol::paper);
    CHECK(numbers(Protocol::released_scannet) == by_mesh);
    // The right half is 2 m away, where the larger height is wanted; nothing is known of the left half.
    RasterF depth(40, 30);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        depth.values[i] = i % 40 < 20 ? 0 : 2;
    for (auto& frame : world.wall.frames.frames)
        testing::set_depth_picture(frame, world.folder.path(), depth);
    CHECK(numbers(Protocol::paper) == by_mesh);
    CHECK(numbers(Protocol::released_scannet) == std::vector<int>{1});
    CHECK(numbers(Protocol::released_matterport3d) == std::vector<int>{0, 1});
}

TEST_CASE_METHOD(WithWorld, "camera features are kept for a view's next visit while there is room, and then not encoded again")
{
    const auto& network = world.network;
    const Demands wanted{{&network, {{"half"}, {"half"}, false}}};
    torch::Tensor features;
    /// Loads the view, asks for its camera and says how much was encoded.
    const auto visit = [&](CameraMemory& memory, std::size_t number)
    {
        const auto data = world.view(number);
        memory.give_back(*data);
        const int before = network.encoded;
        auto& level = data->levels.back();
        RenderedPart part({}, at::zeros_like(level.camera), level, wanted);
        features = part.camera_selected(network, "half", Pixels::all);
        memory.keep(*data);
        return network.encoded - before;
    };
    CameraMemory memory(1 << 20);
    CHECK(visit(memory, 0) == 1);
    const auto first = features;
    CHECK(visit(memory, 1) == 1);
    CHECK(visit(memory, 0) == 0);
    CHECK(features.equal(first));
    // Room for one view.
    CameraMemory small(static_cast<std::size_t>(first.numel()) * 4);
    for (const auto& [view, encoded] : {std::pair(0U, 1), {1U, 1}, {0U, 0}, {1U, 1}})
        CHECK(visit(small, view) == encoded);
}

TEST_CASE("camera features of the smallest height are enlarged between the centers of cells")
{
    HalfNetwork network;
    const Demands demands{{&network, {{"half"}, {"half"}, true}}};
    LevelData level;
    // Cells of 0.5 and 2.5 along a row.
    level.smallest =
        std::make_shared<SmallestCamera>(SmallestCamera{at::arange(4, at::kFloat).expand({3, 4, 4}).contiguous(), {}});
    RenderedPart part({}, at::zeros({3, 8, 8}), level, demands);
    const auto row = part.camera_features(network, "half")[0][0];
    REQUIRE(row.numel() == 4);
    const std::vector<float> expected{0.5F, 1.0F, 2.0F, 2.5F};
    for (std::int64_t i = 0; i < 4; ++i)
        CHECK(row[i].item<float>() == Approx(expected[static_cast<std::size_t>(i)]));
}

TEST_CASE("prefetched items come in order and no more than asked ahead, and an exception where its item would be taken")
{
    for (const std::size_t threads : {1U, 3U})
    {
        std::atomic<std::size_t> made{0};
        const auto make = [&](std::size_t i, std::size_t)
        {
            // The first ones wait until every thread is at work; later the first of three takes longest.
            for (++made; made < threads;)
                std::this_thread::yield();
            std::this_thread::sleep_for(std::chrono::milliseconds(i % 3 == 0 ? 3 : 0));
            if (i == 39)
                throw std::runtime_error("no view 39");
            return std::make_unique<std::size_t>(i);
        };
        Prefetch<std::unique_ptr<std::size_t>> loader(3, 40, 1 + threads, threads, make);
        for (std::size_t i = 3; i < 39; ++i)
        {
            CHECK(*loader.next() == i);
            CHECK(made <= i - 3 + 1 + 1 + threads);
        }
        CHECK_THROWS_WITH(loader.next(), "no view 39");
    }
}

namespace
{

/// Compares features with the camera's, or only with the style.
class FeatureLoss final : public Loss
{
  public:
    explicit FeatureLoss(bool sees_camera) : sees_camera_(sees_camera) {}
    LossNeeds needs() const override { return {{{.network = nullptr, .names = {"a"}, .camera = sees_camera_}}, false}; }
    void prepare(const PrepareContext&) override {}
    std::vector<LossTerm> evaluate(Part&) override { return {}; }

  private:
    bool sees_camera_;
};

}  // namespace

TEST_CASE("style over content is reported, and warned about where a run begins empty")
{
    const Losses losses{{"content", std::make_shared<FeatureLoss>(true)},
                        {"picture", camera_loss()},
                        {"style", std::make_shared<FeatureLoss>(false)},
                        {"more_style", std::make_shared<FeatureLoss>(false)}};
    struct Case
    {
        double style;
        bool begins_empty;
        std::size_t warnings;
    };
    for (const Case& c : {Case{15, true, 0}, Case{2.9, true, 1}, Case{81, true, 1}, Case{1000, false, 0}})
    {
        testing::TestRun run;
        report_balance(losses, {{"content", 10}, {"picture", 100}, {"style", c.style - 1}, {"more_style", 1}}, c.begins_empty,
                       run);
        CHECK(run.reported.at("initial_style_over_content").as_double() == Approx(c.style / 10));
        CHECK(run.messages.size() == c.warnings);
    }
    testing::TestRun run;
    report_balance(losses, {{"content", 0}, {"style", 1}}, true, run);
    CHECK(run.reported.find("initial_style_over_content") == nullptr);
}

TEST_CASE("held-out views lie in the middles of equal stretches, and the rest is optimized for")
{
    const std::vector<std::size_t> views{0, 2, 4, 6, 8, 10, 12, 14, 16, 18};
    CHECK(split_views(views, 0).trained == views);
    const auto split = split_views(views, 2);
    CHECK(split.held_out == std::vector<std::size_t>{4, 14});
    CHECK(split.trained == std::vector<std::size_t>{0, 2, 6, 8, 10, 12, 16, 18});
    CHECK(split_views(views, 9).held_out.size() == 9);
    CHECK_THROWS_WITH(split_views(views, 10), Catch::Contains("only 10 views"));
}

TEST_CASE("a run stops when three measurements gain less than asked for")
{
    const auto stops = [](const std::vector<double>& losses, double gain)
    {
        std::vector<HeldOutLoss> history;
        for (const double loss : losses)
            history.push_back({std::ssize(history) * 10, loss, {loss}});
        return has_stopped_falling(history, gain);
    };
    CHECK_FALSE(stops({10, 9.99, 9.98}, 0.01));
    CHECK(stops({10, 9.99, 9.98, 9.97}, 0.01));
    CHECK_FALSE(stops({10, 9.99, 9.98, 9.8}, 0.01));
    CHECK(stops({10, 8, 9, 9, 9}, 0.01));
    CHECK_FALSE(stops({10, 9.99, 9.98, 9.97}, 0));
}

TEST_CASE("the gradient of the displayed picture agrees with finite differences, beyond its range only on the way back")
{
    const auto factor = at::tensor({0.5F, 2.0F}).reshape({1, 2});
    const auto direction = at::tensor({0.3F, -0.2F, 0.7F, 0.1F, -0.4F, 0.6F}).reshape({3, 1, 2});
    const auto stored = at::tensor({0.2F, 0.4F, 0.6F, 0.3F, 0.5F, 0.1F}).reshape({3, 1, 2});
    const auto hidden = at::full({1, 2}, false, at::kBool);
    for (const auto values : {Values::display, Values::network})
    {
        const ValueSpace space(values);
        const auto gradient = values_back(space, displayed_values(space, stored, hidden).beyond, factor, direction).flatten();
        for (std::int64_t i = 0; i < 6; ++i)
        {
            const auto step = (at::arange(6) == i).reshape({3, 1, 2}).to(at::kFloat) * 0.05;
            const auto loss = [&](const torch::Tensor& moved)
            { return (displayed_values(space, moved, hidden).picture * direction * factor).sum().item<double>(); };
            CHECK(gradient[i].item<float>() ==
                  Approx((loss(stored + step) - loss(stored - step)) / 0.1).epsilon(1e-3).margin(1e-5));
        }
    }
    const auto beyond = at::tensor({1.2F, 1.2F, -0.1F}).reshape({3, 1, 1});
    const auto gradient = at::tensor({0.5F, -0.5F, -0.25F}).reshape({3, 1, 1});
    const ValueSpace space(Values::display);
    const auto out = displayed_values(space, beyond, at::full({1, 1}, false, at::kBool)).beyond;
    const auto back = values_back(space, out, at::full({1, 1}, 1.0F), gradient);
    CHECK(back.flatten().equal(at::tensor({0.5F, 0.0F, -0.25F})));
}
