#include "view_data.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ops/empty.h>

#include <algorithm>

namespace fresco::optimize
{
namespace
{

torch::Tensor bool_tensor(const Raster8& mask)
{
    auto tensor = at::empty({mask.height, mask.width}, at::kBool);
    std::transform(mask.values.begin(), mask.values.end(), tensor.data_ptr<bool>(), [](auto v) { return v != 0; });
    return tensor;
}

}  // namespace

std::unique_ptr<ViewData> load_view(const ViewSource& source, std::size_t view, const TextureRepresentation& texture,
                                    bool scale_by_angle)
{
    std::vector<UvMap> maps;
    for (std::size_t level = 0; level < source.level_count(); ++level)
        maps.push_back(source.map(view, level));
    const auto pixels = level_pixels(maps);
    const auto shares = level_shares(pixels);
    const Raster8 camera = source.camera(view);

    auto data = std::make_unique<ViewData>();
    data->view = view;
    for (std::size_t level = 0; level < maps.size(); ++level)
    {
        if (!(shares[level] > 0))
            continue;
        const auto& map = maps[level];
        LevelData result;
        result.height_px = source.height_px(level);
        result.view = texture.make_view(map);
        result.factor = gradient_factor(map, pixels[level], scale_by_angle);
        result.share = shares[level];
        result.camera = to_tensor(resized(camera, map.valid.width, map.valid.height));
        result.all = bool_tensor(pixels[level].all);
        result.fine = bool_tensor(pixels[level].fine);
        result.pixels = pixels[level];
        data->levels.push_back(std::move(result));
        data->numbers.push_back(static_cast<int>(level));
    }
    if (data->levels.empty())
        throw Error("view " + source.name(view) +
                    ": its uv maps have no valid pixel, though their index says so; make them again");
    return data;
}

void move_to(ViewData& data, const torch::Device& device)
{
    for (auto& level : data.levels)
    {
        level.camera = level.camera.to(device);
        level.all = level.all.to(device);
        level.fine = level.fine.to(device);
    }
}

}  // namespace fresco::optimize
