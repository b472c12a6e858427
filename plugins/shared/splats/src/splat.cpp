#include "formats.h"

#include <algorithm>

/// \file antimatter15's format: center and scales as floats, color and opacity and the quaternion as bytes.

namespace fresco::splats
{

bool is_splat(Bytes bytes)
{
    if (bytes.empty() || bytes.size() % splat_row_bytes != 0)
        return false;
    constexpr std::size_t looked_at = 4096;
    for (std::size_t at = 0; at < std::min(bytes.size(), looked_at * splat_row_bytes); at += splat_row_bytes)
        for (std::size_t k = 0; k < 6; ++k)
        {
            constexpr float far = 1e8F;
            const auto number = value_at<float>(bytes, at + 4 * k);
            if (!(std::abs(number) < far) || (k > 2 && number < 0))
                return false;
        }
    return true;
}

SplatFile parse_splat(Bytes bytes, const std::string& source)
{
    SplatFile file;
    file.format = SplatFormat::splat;
    resize(file.splats, bytes.size() / splat_row_bytes);
    for (std::size_t i = 0; i < file.splats.size(); ++i)
    {
        const Bytes row = bytes.subspan(i * splat_row_bytes, splat_row_bytes);
        const auto number = [&](std::size_t k) { return value_at<float>(row, 4 * k); };
        const auto byte = [&](std::size_t k) { return static_cast<double>(std::to_integer<int>(row[k])); };
        const auto log = [&](std::size_t k) { return std::log(static_cast<double>(number(k))); };
        const Vec3d color = Vec3d{byte(24), byte(25), byte(26)} * (1 / 255.0);
        set(file.splats, i, {number(0), number(1), number(2)}, {byte(28) - 128, byte(29) - 128, byte(30) - 128, byte(31) - 128},
            {log(3), log(4), log(5)}, byte(27) / 255, vec_cast<float>(color), source);
    }
    return file;
}

}  // namespace fresco::splats
