#include "formats.h"

#include <fresco/files_io.h>

#include <algorithm>

namespace fresco::splats
{

std::string_view name_of(SplatFormat format)
{
    constexpr std::array<std::string_view, 5> names{"PLY", "compressed PLY", "SPLAT", "SPZ", "SOG"};
    return names.at(static_cast<std::size_t>(format));
}

void resize(Splats& splats, std::size_t count)
{
    splats.centers.resize(count);
    splats.rotations.resize(count);
    splats.scales.resize(count);
    splats.opacities.resize(count);
    splats.colors.resize(count);
}

void set(SplatFile& file, std::size_t i, Vec3f center, std::array<double, 4> rotation, Vec3d log_scale, double opacity,
         Vec3f color, const std::string& source)
{
    // Gaussians that are flat on purpose have scales down to 0.
    const auto scale = [](double log) { return static_cast<float>(std::max(std::exp(log), 1e-20)); };
    Splats& splats = file.splats;
    splats.centers[i] = center;
    splats.scales[i] = {scale(log_scale.x), scale(log_scale.y), scale(log_scale.z)};
    splats.opacities[i] = static_cast<float>(opacity);
    splats.colors[i] = color;
    double norm = 0;
    for (const double each : rotation)
        norm += each * each;
    norm = std::sqrt(norm);
    const Vec3f size = splats.scales[i];
    for (const double each : {center.x, center.y, center.z, size.x, size.y, size.z, color.x, color.y, color.z,
                              static_cast<float>(opacity), static_cast<float>(norm)})
        if (!std::isfinite(each))
            throw Error(fmt::format("{}: Gaussian {} has a number that is not finite; \"splat-transform IN.ply --filter-nan "
                                    "OUT.ply\" leaves such ones out",
                                    source, i));
    if (norm > 0)
        for (std::size_t k = 0; k < 4; ++k)
            splats.rotations[i][k] = static_cast<float>(rotation[k] / norm);
    else
    {
        splats.rotations[i] = {1, 0, 0, 0};
        splats.opacities[i] = 0;
        ++file.undirected;
    }
}

SplatFile parse_splats(std::span<const std::byte> bytes, const std::string& source)
{
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("ply"))
        return parse_ply(bytes, source);
    throw Error(source + ": isn't a file of Gaussian splats; expected PLY, SPLAT, SPZ or SOG");
}

SplatFile read_splats(const std::filesystem::path& file)
{
    return parse_splats(read_file(file), file.string());
}

}  // namespace fresco::splats
