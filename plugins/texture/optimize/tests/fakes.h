#pragma once

#include "loop.h"
#include "uv_map_samples.h"

#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>
#include <fresco/uv_maps.h>

#include <ATen/ops/avg_pool2d.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// \file A tiny world: cameras that look straight at a square painted wall, one texture unit wide; and losses to optimize it
/// with.

namespace fakes
{

using namespace fresco;

/// Color of the wall at (u, v).
inline Vec3f painting(double u, double v)
{
    return {static_cast<float>(0.5 + 0.3 * std::sin(6 * u)), static_cast<float>(0.3 + 0.5 * v),
            static_cast<float>(0.6 - 0.4 * u * v)};
}

/// View i of a walk along the wall sees a window of 0.5 x 0.5 of it from this uv on; the left two pixel columns look past it.
inline Vec2d window(std::size_t view, std::size_t views)
{
    const double t = static_cast<double>(view) / static_cast<double>(views - 1);
    return {0.5 * t, 0.25 + 0.25 * std::sin(5 * t)};
}

/// Color of a point of a view's picture, in shares of its width and height.
inline Vec3f seen_painting(std::size_t view, std::size_t views, double x, double y)
{
    const Vec2d at = window(view, views);
    return painting(at.x + 0.5 * x, at.y + 0.5 * (1 - y));
}

inline UvMap wall_map(std::size_t view, std::size_t views, int width, int height)
{
    UvMap map{RasterF(width, height, 2), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    const auto at = window(view, views);
    for (int y = 0; y < height; ++y)
        for (int x = 2; x < width; ++x)
        {
            map.uv.at(x, y, 0) = static_cast<float>(at.x + 0.5 * (x + 0.5) / width);
            map.uv.at(x, y, 1) = static_cast<float>(at.y + 0.5 * (1 - (y + 0.5) / height));
            map.depth.at(x, y) = 2;
            map.cosine.at(x, y) = 0.8F;
            map.valid.at(x, y) = 1;
        }
    return map;
}

/// Uv maps and frames of the wall on disk, below `folder`.
struct Wall
{
    Wall(const std::filesystem::path& folder, std::size_t views, const std::vector<int>& heights)
    {
        std::filesystem::create_directories(folder);
        for (std::size_t i = 0; i < views; ++i)
        {
            Frame frame = testing::frame("frame-" + std::to_string(i), testing::camera(40, 30, 30), static_cast<long>(i));
            frame.sequence = "walk";
            const auto color = [&](int x, int y, int c)
            {
                const Vec3f rgb = seen_painting(i, views, (x + 0.5) / 40, (y + 0.5) / 30);
                return 255 * (&rgb.x)[c];
            };
            testing::set_color_picture(frame, folder, testing::picture(40, 30, color));
            frames.frames.push_back(frame);
        }
        maps = written_uv_maps(folder / "maps", frames, heights,
                               [&](std::size_t view, int width, int height) { return wall_map(view, views, width, height); });
    }

    std::shared_ptr<const UvMaps> maps;
    Frames frames;
};

/// A loss on the picture itself, by a function of the part.
class PictureLoss final : public Loss
{
  public:
    using Function = std::function<torch::Tensor(Part&)>;
    explicit PictureLoss(Function value) : value_(std::move(value)) {}
    LossNeeds needs() const override { return {{}, true}; }
    void prepare(const PrepareContext&) override {}
    std::vector<LossTerm> evaluate(Part& part) override { return {{"", value_(part)}}; }

  private:
    Function value_;
};

/// The picture shall be the camera's: mean of squared differences over the mask.
inline std::shared_ptr<Loss> camera_loss()
{
    return std::make_shared<PictureLoss>(
        [](Part& part)
        {
            const auto mask = part.mask(Pixels::all);
            const auto difference = (part.image() - part.camera()) * mask;
            return ordered_sum(difference * difference) / static_cast<double>(3 * mask.sum().item<std::int64_t>());
        });
}

/// Wants the brightest picture, but breaks where one is brighter than 0.9.
inline std::shared_ptr<Loss> fragile_loss()
{
    return std::make_shared<PictureLoss>(
        [](Part& part)
        {
            const auto mean = ordered_mean(part.image());
            return part.image().max().item<double>() > 0.9 ? mean / 0.0 : -mean;
        });
}

/// One network layer of stride 2: means of 2 x 2 pixels, run through a convolution.
class HalfNetwork final : public FeatureNetwork
{
  public:
    void prepare(const PrepareContext&) override { ++prepared; }
    std::vector<FeatureLayer> layers() const override { return {{"half", 3, 2, 0}, {"same", 3, 1, 0}}; }
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        ++encoded;
        ++all_encoded;
        std::vector<torch::Tensor> result;
        for (const auto& name : names)
            result.push_back(name == "half" ? at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0) : picture * 2);
        return result;
    }
    int prepared = 0;
    mutable int encoded = 0;
    static inline int all_encoded = 0;  ///< By all networks of this kind.
};

/// Mean features like the style's, smoothed over the steps: has a state, and a network.
class MeanLoss final : public Loss
{
  public:
    Slot<FeatureNetwork> features{this, "features", "features.half", "Network"};
    LossNeeds needs() const override { return {{{features.get().get(), {"half"}, false, true}}, false}; }
    void prepare(const PrepareContext& context) override
    {
        const auto maps = features->encode(context.style.fine, {"half"});
        target_ = ordered_mean(maps[0].reshape({3, -1}), 1);
        running_ = target_.clone();
    }
    std::vector<LossTerm> evaluate(Part& part) override
    {
        const auto selected = part.selected(*features, "half", Pixels::all);
        const auto mean = ordered_mean(selected, 1);
        running_ = (running_ * 0.9 + mean.detach() * 0.1).detach();
        const auto away = mean * 0.5 + running_ * 0.5 - target_;
        const auto content = selected - part.camera_selected(*features, "half", Pixels::all);
        const auto noise = static_cast<double>(part.seed() % 1000) * 1e-5;
        // Its gradient depends on a sum over everything, to the last bit.
        const auto gray = ordered_mean(selected) - 0.4;
        return {{"half", ordered_sum(away * away) * (1 + noise)},
                {"half", ordered_mean(content * content) * 0.1},
                {"half", gray * gray}};
    }
    TensorMap state() const override { return {{"running", running_}}; }
    void restore(const TensorMap& state) override { running_ = state.at("running").clone(); }

  private:
    torch::Tensor target_;
    torch::Tensor running_;
};

/// Asks whether it shall stop in every evaluation, as losses that take long do, when something has changed in it already; and
/// breaks at its `breaks_at`-th evaluation.
class AskingLoss final : public Loss
{
  public:
    explicit AskingLoss(int breaks_at) : breaks_at_(breaks_at) {}
    LossNeeds needs() const override { return {{}, true}; }
    void prepare(const PrepareContext& context) override
    {
        progress_ = context.progress;
        evaluated_ = at::zeros({1}, at::kDouble);
    }
    std::vector<LossTerm> evaluate(Part& part) override
    {
        evaluated_ += 1;
        progress_->check_canceled();
        if (--breaks_at_ == 0)
            throw Error("broken");
        return {{"", ordered_mean(part.image()) * evaluated_.item<double>()}};
    }
    TensorMap state() const override { return {{"evaluated", evaluated_.clone()}}; }
    void restore(const TensorMap& state) override { evaluated_ = state.at("evaluated").clone(); }

  private:
    int breaks_at_;
    const Progress* progress_ = nullptr;
    at::Tensor evaluated_;
};

}  // namespace fakes

namespace fresco::optimize
{

/// Steps over all views in their whole size, neither measured nor kept, from zeros.
inline LoopOptions short_loop(int size_px, int repeats_count, const torch::Device& device = torch::kCPU)
{
    return {.size_px = size_px,
            .init = Init::zeros,
            .device = device,
            .schedule = {.repeats_count = repeats_count},
            .checkpoint_seconds = 0,
            .preview_seconds = 0};
}

}  // namespace fresco::optimize
