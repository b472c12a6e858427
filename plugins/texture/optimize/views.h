#pragma once

/// \file Views from disk to a step: the recorded pictures and uv maps (ViewSource), one view prepared for the losses
/// (ViewData), and the next ones prepared while a step runs (ViewFeed).

#include "grid_mask.h"
#include "levels.h"
#include "pictures.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/texture_representation.h>
#include <fresco/uv_maps.h>

#include <c10/core/Event.h>
#include <c10/core/Stream.h>
#include <torch/types.h>

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace fresco::optimize
{

/// The uv maps of some heights and the camera pictures that belong to them. References its inputs. Thread-safe.
class ViewSource
{
  public:
    /// `heights_px`: which heights to use, empty = all. `images` may be null where every picture is NPY. `start`: what frames
    /// without a picture show; null: none. Throws Error naming what is missing: a height, the frame of a view, its picture.
    ViewSource(const UvMaps& maps, const Frames& frames, const ImageIo* images, const std::vector<int>& heights_px,
               const Texture* start = nullptr);

    std::size_t view_count() const { return maps_.views.size(); }
    std::size_t level_count() const { return levels_.size(); }
    /// Ascending.
    int height_px(std::size_t level) const { return maps_.heights_px[levels_[level]]; }
    /// "seq-01/frame-000008"
    std::string name(std::size_t view) const { return maps_.views[view].sequence + "/" + maps_.views[view].frame; }
    /// Views that see the mesh at one height at least, in recorded order.
    std::vector<std::size_t> seeing_views() const;

    UvMap map(std::size_t view, std::size_t level) const { return maps_.load_map(view, levels_[level]); }
    /// Measured depth in meters, 0: none; empty if some frame has no depth picture.
    Raster<double> measured_depth(std::size_t view) const;
    /// The camera picture as recorded, RGB; of a frame without one, what the start texture shows it at the largest height.
    Raster8 camera(std::size_t view) const;
    /// Whether some frame has no picture.
    bool shows_start() const { return start_ != nullptr; }

  private:
    const UvMaps& maps_;
    const Frames& frames_;
    const ImageIo* images_;
    std::vector<std::size_t> levels_;      ///< Into maps_.heights_px.
    std::vector<std::size_t> frame_of_;    ///< Per view: into frames_.frames.
    bool has_depth_ = true;                ///< Every frame has a depth picture.
    std::unique_ptr<ShownTexture> start_;  ///< Null where every frame has a picture.
};

/// Features by network and crop (0 for a whole frame), and by layer.
using FeatureMaps = std::map<std::pair<const FeatureNetwork*, std::size_t>, std::map<std::string, torch::Tensor>>;

/// The camera picture at the smallest height, and its features, for all levels of a view.
struct SmallestCamera
{
    torch::Tensor picture;  ///< 3 x H x W, RGB in [0,1].
    FeatureMaps features;
};

/// The parts of a level that a network encodes where losses read only selected features.
struct CroppedLevel
{
    std::vector<Crop> crops;
    std::vector<ReadPixels> pixels;  ///< Per crop, in what is encoded: the level's in its core, and all of the level's.
    std::vector<std::map<int, GridMask>> grids;  ///< Per crop, by stride: its core's cells, in its own grid.
};

/// One height of one view, ready for the consecutive steps on it.
struct LevelData
{
    int height_px = 0;
    Protocol protocol = Protocol::paper;
    PixelBox place;  ///< In the view's picture.
    LevelPixels pixels;
    double share = 0;                          ///< ŵ_l
    torch::Tensor camera;                      ///< 3 x H x W, RGB in [0,1].
    torch::Tensor all;                         ///< H x W, bool.
    torch::Tensor fine;                        ///< H x W, bool.
    std::shared_ptr<SmallestCamera> smallest;  ///< Null: the camera is encoded at this height.

    /// Results of parts that the next step on this view needs again.
    FeatureMaps camera_features;    ///< Features of crops: C x N, with the core's cells.
    std::map<int, GridMask> grids;  ///< By stride.
    std::map<const FeatureNetwork*, CroppedLevel> cropped;
};

/// A view's levels on a sheet, for one network.
struct ViewSheet
{
    Sheet sheet;
    std::map<int, std::vector<LevelColumns>> columns;  ///< By stride; of each level, without its share.
    std::map<std::string, torch::Tensor> camera;       ///< Selected features of the camera pictures; kept by the first step.
};

/// The levels lie in one picture, one below the other, so that the texture is looked up once.
struct ViewData
{
    std::size_t view = 0;
    std::vector<LevelData> levels;  ///< Levels with pixels, smallest height first.
    std::vector<int> numbers;       ///< Index of each level in the render pyramid.
    Protocol protocol = Protocol::paper;
    std::unique_ptr<TextureView> texture;  ///< Null without levels.
    torch::Tensor hidden;  ///< H x W, bool: the texture is not seen here; elsewhere it is, also outside of the level.
    torch::Tensor factor;  ///< H x W: what the picture's gradient is multiplied by.

    // On another device than the CPU:
    torch::Tensor camera;  ///< 3 x H x W: the levels' camera pictures.
    std::map<const FeatureNetwork*, ViewSheet> sheets;
    std::map<std::string, torch::Tensor> kept;  ///< See Levels::kept().
};

/// Reads a view's uv maps and camera picture. On any thread.
std::unique_ptr<ViewData> load_view(const ViewSource& source, std::size_t view, const TextureRepresentation& texture,
                                    const LevelRules& rules);

/// The part of a picture.
torch::Tensor cut(const torch::Tensor& picture, const PixelBox& box);

/// The cells of a grid of `stride` that belong to the level; made when first asked for.
const GridMask& grid_of(LevelData& level, int stride, const torch::Device& device);

/// Keeps the features of camera pictures from one visit of a view to the next, for as many of the first views as fit. Each
/// view's is the same at every visit, so that the memory changes no result. Used by one thread.
class CameraMemory
{
  public:
    explicit CameraMemory(std::size_t most_bytes) : left_bytes_(most_bytes) {}
    /// At the end of a visit.
    void keep(const ViewData& data);
    /// Gives a view that was loaded again what was kept.
    void give_back(ViewData& data) const;

  private:
    std::size_t left_bytes_;
    std::map<std::size_t, std::vector<FeatureMaps>>
        views_;  ///< Features of each level, then of the smallest camera, if there is one.
};

/// Moves what losses see to `device`; with `texture_too` what the lookup needs beside the view as well.
void move_to(ViewData& data, const torch::Device& device, bool texture_too);

/// Makes the items first, first + 1, …, last - 1 on threads of its own, as many at a time as there are threads, and at most
/// `depth` ahead of who takes them, in order. An exception of `make` is rethrown where its item would be taken. The destructor
/// waits for the items under way.
template <class T>
class Prefetch
{
  public:
    /// make(item, thread), with threads counted from 0.
    using Make = std::function<T(std::size_t, std::size_t)>;

    Prefetch(std::size_t first, std::size_t last, std::size_t depth, std::size_t threads, Make make)
        : begun_(first), taken_(first), last_(last), depth_(depth), make_(std::move(make))
    {
        for (std::size_t thread = 0; thread < threads; ++thread)
            threads_.emplace_back([this, thread](const std::stop_token& stop) { work(stop, thread); });
    }

    /// The next item; blocks until it is there. At most last - first calls.
    T next()
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return ready_.contains(taken_); });
        auto item = std::move(ready_.extract(taken_++).mapped());
        changed_.notify_all();
        if (item.failure)
            std::rethrow_exception(item.failure);
        return std::move(*item.value);
    }

  private:
    struct Item
    {
        std::optional<T> value;
        std::exception_ptr failure;
    };

    void work(const std::stop_token& stop, std::size_t thread)
    {
        while (true)
        {
            std::size_t number = 0;
            {
                std::unique_lock lock(mutex_);
                if (!changed_.wait(lock, stop, [this] { return begun_ == last_ || begun_ < taken_ + depth_; }) ||
                    begun_ == last_ || stop.stop_requested())
                    return;
                number = begun_++;
            }
            Item item;
            try
            {
                item.value.emplace(make_(number, thread));
            }
            catch (...)
            {
                item.failure = std::current_exception();
            }
            const std::lock_guard lock(mutex_);
            ready_.emplace(number, std::move(item));
            changed_.notify_all();
        }
    }

    std::size_t begun_;  ///< The first item that nobody has begun.
    std::size_t taken_;  ///< The next one to be taken.
    std::size_t last_;
    std::size_t depth_;
    Make make_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::map<std::size_t, Item> ready_;
    std::vector<std::jthread> threads_;  ///< Last: they are joined before what they use goes.
};

/// The views of a run, one after the other: the next ones are made ready while the present one is worked on. For another device
/// than the CPU several threads do so, as steps there are quick, and send them there, each on a stream of its own, so that
/// neither thread nor device waits for the other. Memory: the present view and those ahead. Used by one thread.
class ViewFeed
{
  public:
    using Make = std::function<std::unique_ptr<ViewData>(std::size_t)>;

    /// make(first), make(first + 1), … make(last - 1), on other threads, several at once where the device is not the CPU.
    ViewFeed(const torch::Device& device, std::size_t first, std::size_t last, const Make& make);
    ~ViewFeed();
    ViewFeed(const ViewFeed&) = delete;
    ViewFeed& operator=(const ViewFeed&) = delete;

    /// Lets go of the present view and goes on to the next. Rethrows what make threw.
    ViewData& next();

  private:
    struct Loaded
    {
        std::unique_ptr<ViewData> data;
        std::optional<c10::Event> sent;
        std::size_t thread = 0;
    };
    Loaded load(std::size_t index, std::size_t thread, const Make& make) const;
    void let_go();

    torch::Device device_;
    std::vector<c10::Stream> streams_;  ///< One for each thread; none on the CPU.
    Loaded present_;
    Prefetch<Loaded> loader_;
};

}  // namespace fresco::optimize
