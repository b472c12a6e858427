#include "face_blocks.h"

namespace fresco::face_blocks
{

std::vector<Vec2f> texcoords(std::size_t faces, const Layout& layout)
{
    const double size = layout.size_px;
    const double near = 0.5 + inset_px;
    const double far = layout.block_px - 0.5 - inset_px;
    std::vector<Vec2f> result;
    result.reserve(3 * faces);
    for (std::size_t face = 0; face < faces; ++face)
    {
        const std::size_t column = face % layout.blocks_per_row();
        const std::size_t row = face / layout.blocks_per_row();
        const double left = static_cast<double>(column) * layout.block_px;
        const double lower = static_cast<double>(row) * layout.block_px;
        const auto uv = [&](double x, double y) {
            return Vec2f{static_cast<float>((left + x) / size), static_cast<float>((lower + y) / size)};
        };
        result.push_back(uv(near, near));
        result.push_back(uv(far, near));
        result.push_back(uv(near, far));
    }
    return result;
}

int smallest_size_px(std::size_t faces, int block_px)
{
    Layout layout{.size_px = 1, .block_px = block_px};
    while (layout.blocks_count() < faces)
        layout.size_px *= 2;
    return layout.size_px;
}

}  // namespace fresco::face_blocks
