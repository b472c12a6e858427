#include "views.h"

#include "released_view.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>
#include <fresco/uv_mapping/view_frames.h>

#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>
#include <c10/core/DeviceGuard.h>
#include <c10/core/StreamGuard.h>
#include <c10/core/impl/VirtualGuardImpl.h>

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <span>
#include <utility>

namespace fresco::optimize
{

ViewSource::ViewSource(const UvMaps& maps, const Frames& frames, const ImageIo* images, const std::vector<int>& heights_px,
                       const Texture* start)
    : maps_(maps), frames_(frames), images_(images), frame_of_(frames_of_views(maps, frames))
{
    for (std::size_t level = 0; level < maps.heights_px.size(); ++level)
        if (heights_px.empty() || std::find(heights_px.begin(), heights_px.end(), maps.heights_px[level]) != heights_px.end())
            levels_.push_back(level);
    for (const int height : heights_px)
        if (std::find(maps.heights_px.begin(), maps.heights_px.end(), height) == maps.heights_px.end())
            throw Error(
                fmt::format("option \"heights_px\": no uv maps of {} px; found {}", height, fmt::join(maps.heights_px, ", ")));
    has_depth_ = std::ranges::none_of(frame_of_, [&](std::size_t i) { return frames.frames[i].depth_picture.empty(); });
    for (std::size_t view = 0; view < maps.views.size() && !start_; ++view)
    {
        if (!frames.frames[frame_of_[view]].color_picture.empty())
            continue;
        if (start == nullptr)
            throw Error(
                "frame " + name(view) +
                " has no color picture: wire 'start' to the texture of photographs (texture.from_frames) that such frames "
                "show");
        start_ = std::make_unique<ShownTexture>(*start);
    }
}

std::vector<std::size_t> ViewSource::seeing_views() const
{
    std::vector<std::size_t> views;
    for (std::size_t view = 0; view < maps_.views.size(); ++view)
    {
        const auto& counts = maps_.views[view].valid_pixels;
        if (std::any_of(levels_.begin(), levels_.end(), [&](std::size_t level) { return counts.at(level) > 0; }))
            views.push_back(view);
    }
    return views;
}

Raster<double> ViewSource::measured_depth(std::size_t view) const
{
    if (!has_depth_)
        return {};
    const Frame& frame = frames_.frames[frame_of_[view]];
    const Raster16 steps = load_depth_steps(frame, images_);
    Raster<double> depth(steps.width, steps.height);
    std::ranges::transform(steps.values, depth.values.begin(), [&](std::uint16_t step) { return step * frame.depth_unit_m; });
    return depth;
}

Raster8 ViewSource::camera(std::size_t view) const
{
    const Frame& frame = frames_.frames[frame_of_[view]];
    if (start_ && frame.color_picture.empty())
        return start_->shown(maps_.load_map(view, levels_.back()));
    return load_color(frame, images_);
}

namespace
{

torch::Tensor bool_tensor(const Raster8& mask)
{
    auto tensor = at::empty({mask.height, mask.width}, at::kBool);
    std::transform(mask.values.begin(), mask.values.end(), tensor.data_ptr<bool>(), [](auto v) { return v != 0; });
    return tensor;
}

/// The map that shows the texture's first texel where there is no surface.
UvMap filled_with_corner(const UvMap& map)
{
    UvMap result = map;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] == 0)
        {
            result.uv.values[2 * i] = 0;
            result.uv.values[2 * i + 1] = 1;
            result.valid.values[i] = 1;
        }
    return result;
}

template <class T>
void paste(const Raster<T>& part, Raster<T>& whole, int row)
{
    const auto length = static_cast<std::ptrdiff_t>(part.width) * part.channels;
    for (int y = 0; y < part.height; ++y)
        std::copy_n(part.values.begin() + y * length, length,
                    whole.values.begin() + static_cast<std::ptrdiff_t>(whole.index(0, row + y)));
}

}  // namespace

std::unique_ptr<ViewData> load_view(const ViewSource& source, std::size_t view, const TextureRepresentation& texture,
                                    const LevelRules& rules)
{
    std::vector<UvMap> maps;
    for (std::size_t level = 0; level < source.level_count(); ++level)
        maps.push_back(source.map(view, level));
    const Raster8 camera = source.camera(view);
    const bool released = is_released(rules.protocol);
    std::shared_ptr<SmallestCamera> smallest;
    Raster<double> depth(maps[0].depth.width, maps[0].depth.height);
    std::ranges::copy(maps[0].depth.values, depth.values.begin());
    if (released)
    {
        ReleasedView seen = released_view(maps, camera, source.measured_depth(view), rules.protocol);
        smallest = std::make_shared<SmallestCamera>(SmallestCamera{to_tensor(seen.picture), {}});
        depth = std::move(seen.depth);
    }
    const auto pixels = levels_of(maps, depth, rules);
    const auto shares = level_shares(pixels);

    auto data = std::make_unique<ViewData>();
    data->view = view;
    data->protocol = rules.protocol;
    int width = 0;
    int height = 0;
    for (std::size_t level = 0; level < maps.size(); ++level)
    {
        if (!(shares[level] > 0))
            continue;
        const auto& valid = maps[level].valid;
        LevelData result;
        result.height_px = source.height_px(level);
        result.protocol = rules.protocol;
        // A row between two levels: neighbors across it are none.
        height += height > 0 ? 1 : 0;
        result.place = {0, height, valid.width, height + valid.height};
        width = std::max(width, valid.width);
        height += valid.height;
        result.share = shares[level];
        result.camera = to_tensor(resized(camera, valid.width, valid.height));
        result.all = bool_tensor(pixels[level].all);
        result.fine = bool_tensor(pixels[level].fine);
        result.pixels = pixels[level];
        result.smallest = smallest;
        data->levels.push_back(std::move(result));
        data->numbers.push_back(static_cast<int>(level));
    }
    if (data->levels.empty())
        return data;
    UvMap shown{RasterF(width, height, 2), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    RasterF factor(width, height);
    for (std::size_t i = 0; i < data->levels.size(); ++i)
    {
        const auto& map = maps[static_cast<std::size_t>(data->numbers[i])];
        const UvMap level = released ? filled_with_corner(map) : map;
        const int row = data->levels[i].place.y0;
        paste(level.uv, shown.uv, row);
        paste(level.depth, shown.depth, row);
        paste(level.cosine, shown.cosine, row);
        paste(level.valid, shown.valid, row);
        paste(gradient_factor(map, data->levels[i].pixels, rules.scaling), factor, row);
    }
    data->texture = texture.make_view(shown);
    data->hidden = bool_tensor(shown.valid).logical_not();
    data->factor = to_tensor(factor).squeeze(0);
    return data;
}

torch::Tensor cut(const torch::Tensor& picture, const PixelBox& box)
{
    const auto rows = picture.slice(-2, box.y0, box.y1);
    return rows.slice(-1, box.x0, box.x1);
}

const GridMask& grid_of(LevelData& level, int stride, const torch::Device& device)
{
    const auto found = level.grids.find(stride);
    if (found != level.grids.end())
        return found->second;
    return level.grids.emplace(stride, grid_mask(level.pixels.all, level.pixels.fine, stride, level.protocol, device))
        .first->second;
}

namespace
{

std::size_t bytes_of(const FeatureMaps& features)
{
    std::size_t bytes = 0;
    for (const auto& [crop, layers] : features)
        for (const auto& [name, values] : layers)
            bytes += values.storage().nbytes();
    return bytes;
}

}  // namespace

void CameraMemory::keep(const ViewData& data)
{
    if (data.levels.empty() || views_.contains(data.view))
        return;
    std::vector<FeatureMaps> features;
    for (const auto& level : data.levels)
        features.push_back(level.camera_features);
    if (const auto& smallest = data.levels.front().smallest)
        features.push_back(smallest->features);
    std::size_t bytes = 0;
    for (const auto& maps : features)
        bytes += bytes_of(maps);
    if (bytes > left_bytes_)
        return;
    left_bytes_ -= bytes;
    views_.emplace(data.view, std::move(features));
}

void CameraMemory::give_back(ViewData& data) const
{
    const auto found = views_.find(data.view);
    if (found == views_.end())
        return;
    for (std::size_t level = 0; level < data.levels.size(); ++level)
        data.levels[level].camera_features = found->second[level];
    if (found->second.size() > data.levels.size())
        data.levels.front().smallest->features = found->second.back();
}

void move_to(ViewData& data, const torch::Device& device, bool texture_too)
{
    if (device.is_cpu() || data.levels.empty())
        return;
    const auto cameras = at::zeros({3, data.hidden.size(0), data.hidden.size(1)}, at::kFloat);
    for (const auto& level : data.levels)
        cut(cameras, level.place).copy_(level.camera);
    data.camera = sent_to(cameras, device);
    for (auto& level : data.levels)
    {
        level.camera = cut(data.camera, level.place);
        level.all = sent_to(level.all, device);
        level.fine = sent_to(level.fine, device);
        if (level.smallest)
            level.smallest->picture = sent_to(level.smallest->picture, device);
    }
    if (!texture_too)
        return;
    data.hidden = sent_to(data.hidden, device);
    data.factor = sent_to(data.factor, device);
}

namespace
{

std::size_t loading_threads(const torch::Device& device)
{
    return device.is_cpu() ? 1 : 4;
}

std::vector<c10::Stream> side_streams(const torch::Device& device)
{
    std::vector<c10::Stream> streams;
    if (!device.is_cpu())
        for (std::size_t i = 0; i < loading_threads(device); ++i)
            streams.push_back(c10::impl::VirtualGuardImpl(device.type()).getStreamFromGlobalPool(device, false));
    return streams;
}

}  // namespace

ViewFeed::ViewFeed(const torch::Device& device, std::size_t first, std::size_t last, const Make& make)
    : device_(device), streams_(side_streams(device)),
      loader_(first, last, 1 + loading_threads(device), loading_threads(device),
              [this, make](std::size_t index, std::size_t thread) { return load(index, thread, make); })
{
}

ViewFeed::~ViewFeed()
{
    try
    {
        let_go();
    }
    catch (const std::exception&)
    {
        // The device has failed, and what it said first is on its way up.
        return;
    }
}

ViewFeed::Loaded ViewFeed::load(std::size_t index, std::size_t thread, const Make& make) const
{
    if (streams_.empty())
        return {make(index), std::nullopt, thread};
    const c10::DeviceGuard on_device(device_);
    const c10::StreamGuard on_stream(streams_[thread]);
    Loaded loaded{make(index), c10::Event(device_.type()), thread};
    loaded.sent->record(streams_[thread]);
    return loaded;
}

void ViewFeed::let_go()
{
    if (present_.data && !streams_.empty())
    {
        // The view's memory belongs to the side stream, which may use it again at once, but work on it may not have ended.
        c10::Event done(device_.type());
        done.record(c10::impl::VirtualGuardImpl(device_.type()).getStream(device_));
        done.block(streams_[present_.thread]);
    }
    present_ = {};
}

ViewData& ViewFeed::next()
{
    auto loaded = loader_.next();
    let_go();
    present_ = std::move(loaded);
    if (present_.sent)
        present_.sent->block(c10::impl::VirtualGuardImpl(device_.type()).getStream(device_));
    return *present_.data;
}

}  // namespace fresco::optimize
