#include "sheet.h"

#include "grid_mask.h"

#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/tensor.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>

namespace fresco::optimize
{
namespace
{

/// A crop of one of the view's levels, and its corner on the sheet.
struct Placed
{
    std::size_t level = 0;
    Crop crop;
    int x = 0;
    int y = 0;

    int width() const { return crop.encoded.x1 - crop.encoded.x0; }
    int height() const { return crop.encoded.y1 - crop.encoded.y0; }
};

/// The sheet's boxes and size. Boxes stand in rows, the highest first, with at least a cell of the largest stride between them.
struct Layout
{
    Layout(const ViewData& data, const CropRules& rules) : align(rules.align)
    {
        for (std::size_t level = 0; level < data.levels.size(); ++level)
        {
            const auto& mask = data.levels[level].pixels.all;
            width = std::max(width, slot(mask.width));
            if (data.levels[level].smallest)
            {
                // Enlarged camera features have no crops, and both must select in one order.
                const PixelBox frame{0, 0, mask.width, mask.height};
                boxes.push_back({level, {frame, frame}});
            }
            else
                for (const auto& crop : covering_crops(mask, rules))
                    boxes.push_back({level, crop});
        }
        std::ranges::stable_sort(boxes, std::greater<>(), &Placed::height);
        std::vector<std::pair<int, int>> rows;  // Their tops, and what is used of their width.
        for (auto& box : boxes)
        {
            auto row = std::ranges::find_if(rows, [&](const auto& r) { return r.second + slot(box.width()) <= width; });
            if (row == rows.end())
            {
                row = rows.insert(rows.end(), {height, 0});
                height += slot(box.height());
            }
            std::tie(box.y, box.x) = *row;
            row->second += slot(box.width());
        }
        // A library gets ready for every new shape, 1.6 ms for each convolution (cuDNN 9): few heights, one width.
        const int step = std::lcm(align, 128);
        height = (height + step - 1) / step * step;
    }

    /// A side with the space after it.
    int slot(int side) const { return (side / align + 1) * align; }

    int align;
    int width = 0;
    int height = 0;
    std::vector<Placed> boxes;
};

torch::Tensor numbers(const std::vector<std::int64_t>& values, const torch::Device& device)
{
    return sent_to(at::tensor(values, at::kLong), device);
}

void place_pixels(const Layout& layout, const ViewData& data, Sheet& sheet, const torch::Device& device)
{
    std::vector<std::int64_t> pixels;
    std::vector<std::int64_t> places;
    for (const auto& box : layout.boxes)
        for (int y = 0; y < box.height(); ++y)
            for (int x = 0; x < box.width(); ++x)
            {
                const std::int64_t row = data.levels[box.level].place.y0 + box.crop.encoded.y0 + y;
                pixels.push_back(row * data.hidden.size(1) + box.crop.encoded.x0 + x);
                places.push_back(std::int64_t{box.y + y} * layout.width + box.x + x);
            }
    sheet.pixels = numbers(pixels, device);
    sheet.places = numbers(places, device);
}

torch::Tensor border_cells(const Layout& layout, int stride, const torch::Device& device)
{
    std::vector<std::int64_t> cells;
    for (const auto& box : layout.boxes)
    {
        const int width = box.width() / stride;
        const int height = box.height() / stride;
        for (int y = -1; y <= height; ++y)
            for (int x = -1; x <= width; x += y < 0 || y == height || x == width ? 1 : width + 1)
            {
                const std::int64_t row = box.y / stride + y;
                const std::int64_t column = box.x / stride + x;
                if (row >= 0 && column >= 0 && row < layout.height / stride && column < layout.width / stride)
                    cells.push_back(row * (layout.width / stride) + column);
            }
    }
    return numbers(cells, device);
}

/// Appends the cells of one level that pass the angle filter, then the others.
LevelColumns add_cells(const Layout& layout, const LevelData& data, std::size_t level, int stride,
                       std::vector<std::int64_t>& cells)
{
    std::vector<std::int64_t> others;
    LevelColumns columns;
    for (const auto& box : layout.boxes)
    {
        if (box.level != level)
            continue;
        const auto& [core, encoded] = box.crop;
        const auto mask = grid_mask(cut(data.pixels.all, core, encoded), cut(data.pixels.fine, core, encoded), stride,
                                    data.protocol, torch::kCPU);
        const auto* cell = mask.index.data_ptr<std::int64_t>();
        const std::int64_t width = box.width() / stride;
        for (std::int64_t i = 0; i < mask.chosen_count(); ++i)
            (i < mask.fine_count ? cells : others)
                .push_back((box.y / stride + cell[i] / width) * (layout.width / stride) + box.x / stride + cell[i] % width);
        columns.count += mask.chosen_count();
        columns.fine_count += mask.fine_count;
    }
    cells.insert(cells.end(), others.begin(), others.end());
    return columns;
}

ViewSheet view_sheet(const ViewData& data, const FeatureNetwork& network, const Demand& demand, const torch::Device& device)
{
    // In pixels: a further box costs the space around it.
    CropRules rules{1, 0, 10'000};
    for (const auto& name : demand.image)
    {
        const auto layer = network.layer(name);
        rules.align = std::lcm(rules.align, layer.stride);
        rules.margin_px = std::max(rules.margin_px, layer.margin_px);
    }
    const Layout layout(data, rules);
    ViewSheet result;
    result.sheet.height = layout.height;
    result.sheet.width = layout.width;
    place_pixels(layout, data, result.sheet, device);
    for (int stride = 1; stride <= rules.align; ++stride)
        if (rules.align % stride == 0)
            result.sheet.borders.emplace(stride, border_cells(layout, stride, device));
    for (const auto& name : demand.image)
    {
        const int stride = network.layer(name).stride;
        if (result.columns.contains(stride))
            continue;
        std::vector<std::int64_t> cells;
        for (std::size_t level = 0; level < data.levels.size(); ++level)
            result.columns[stride].push_back(add_cells(layout, data.levels[level], level, stride, cells));
        result.sheet.cells.emplace(stride, numbers(cells, device));
    }
    return result;
}

std::map<std::string, torch::Tensor> encoded(const FeatureNetwork& network, const torch::Tensor& picture,
                                             const std::vector<std::string>& layers, const Sheet& sheet)
{
    const auto features = dynamic_cast<const SheetFeatures&>(network).encode_sheet(picture, layers, sheet);
    std::map<std::string, torch::Tensor> result;
    for (std::size_t i = 0; i < layers.size(); ++i)
        result.emplace(layers[i], features.at(i));
    return result;
}

}  // namespace

void get_sheets_ready(ViewData& data, const Demands& demands, const torch::Device& device)
{
    for (const auto& [network, demand] : demands)
    {
        const auto* able = dynamic_cast<const SheetFeatures*>(network);
        if (able != nullptr && able->takes_sheets() && !demand.whole && !data.levels.empty())
            data.sheets.emplace(network, view_sheet(data, *network, demand, device));
    }
}

bool SheetLevels::has_all(const LossNeeds& needs) const
{
    return !needs.picture && !needs.features.empty() &&
           std::ranges::all_of(needs.features, [&](const auto& layers) { return has(*layers.network); });
}

const std::vector<LevelColumns>& SheetLevels::counts(const FeatureNetwork& network, const std::string& layer) const
{
    return data_.sheets.at(&network).columns.at(network.layer(layer).stride);
}

torch::Tensor SheetLevels::selected(const FeatureNetwork& network, const std::string& layer)
{
    auto& known = features_[&network];
    if (known.empty())
        known = encoded(network, picture_, demands_.at(&network).image, data_.sheets.at(&network).sheet);
    return known.at(layer);
}

torch::Tensor SheetLevels::camera_selected(const FeatureNetwork& network, const std::string& layer)
{
    const at::NoGradGuard no_gradient;
    auto& known = data_.sheets.at(&network).camera;
    const auto& names = demands_.at(&network).camera;
    if (known.empty() && data_.levels.front().smallest)
        for (const auto& name : names)
        {
            std::vector<torch::Tensor> parts;
            for (auto& level : data_.levels)
                parts.push_back(RenderedPart({}, level.camera, level, demands_).camera_selected(network, name, Pixels::all));
            known.emplace(name, at::cat(parts, 1));
        }
    else if (known.empty())
        known = encoded(network, data_.camera, names, data_.sheets.at(&network).sheet);
    return known.at(layer);
}

std::vector<LevelColumns> SheetLevels::columns(const FeatureNetwork& network, const std::string& layer)
{
    auto result = counts(network, layer);
    for (std::size_t level = 0; level < result.size(); ++level)
        result[level].share = share_(level, {layer, {}, &network});
    return result;
}

const torch::Tensor& SheetLevels::kept(const std::string& name, const std::function<torch::Tensor()>& make)
{
    const auto found = data_.kept.find(name);
    return found != data_.kept.end() ? found->second : data_.kept.emplace(name, make()).first->second;
}

torch::Tensor SheetLevels::of_level(const FeatureNetwork& network, const std::string& layer, std::size_t level, bool camera)
{
    const auto all = camera ? camera_selected(network, layer) : selected(network, layer);
    std::vector<std::int64_t> sizes;
    for (const auto& columns : counts(network, layer))
        sizes.push_back(columns.count);
    if (camera)
        return all.split_with_sizes(sizes, 1)[level];
    // Together, so that the way back joins the levels' gradients once.
    auto& parts = split_[{&network, layer}];
    if (parts.empty())
        parts = all.split_with_sizes(sizes, 1);
    return parts[level];
}

std::int64_t SheetLevels::fine_count(const FeatureNetwork& network, const std::string& layer, std::size_t level) const
{
    return counts(network, layer)[level].fine_count;
}

}  // namespace fresco::optimize
