#include "preview.h"

#include "value_tensors.h"

#include <fresco/files_io.h>
#include <fresco/torch/tensor.h>

#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>

#include <algorithm>

namespace fresco::optimize
{
namespace
{

constexpr int largest_side = 1024;

Raster8 displayed(const torch::Tensor& stored, const Raster8& valid, const ValueSpace& space)
{
    const auto result = at::empty_like(stored);
    space.display(values_of(stored), valid.values, values_of(result));
    return to_raster8(result);
}

/// `rows` of the texture from row `first` on, at size x size points.
UvMap strip(int size, int first, int rows)
{
    UvMap map{RasterF(size, rows, 2), RasterF(size, rows), RasterF(size, rows), Raster8(size, rows, 1, 1)};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < size; ++x)
        {
            map.uv.at(x, y, 0) = (static_cast<float>(x) + 0.5F) / static_cast<float>(size);
            map.uv.at(x, y, 1) = 1 - (static_cast<float>(first + y) + 0.5F) / static_cast<float>(size);
        }
    return map;
}

/// The texture at `size` x `size` points, as 3 planes. In strips: a copy of the layers would take as much memory again.
torch::Tensor looked_up(const TextureRepresentation& texture, int size)
{
    constexpr int rows = 64;
    auto result = at::empty({3, size, size}, at::kFloat);
    for (int first = 0; first < size; first += rows)
    {
        const int count = std::min(rows, size - first);
        result.slice(1, first, first + count).copy_(texture.make_view(strip(size, first, count))->render());
    }
    return result;
}

}  // namespace

void write_preview(const std::filesystem::path& folder, const ImageIo& images, const ValueSpace& space, const TextureView& view,
                   const Raster8& valid, const TextureRepresentation& texture, int size_px)
{
    write_file(folder / "view.png", images.encode_png(displayed(view.render().to(at::kCPU), valid, space)));
    const int size = std::min(largest_side, size_px);
    write_file(folder / "texture.png", images.encode_png(displayed(looked_up(texture, size), Raster8(size, size, 1, 1), space)));
}

}  // namespace fresco::optimize
