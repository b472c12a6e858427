#include "formats.h"

#include <fresco/files_io.h>
#include <fresco/numerics/numerics.h>
#include <fresco/wording.h>
#include <fresco/zip.h>

#include <algorithm>

namespace fresco::splats
{

std::string_view name_of(SplatFormat format)
{
    constexpr std::array<std::string_view, 6> names{"PLY", "compressed PLY", "SPLAT", "SPZ", "SOG", "GLB"};
    return names.at(static_cast<std::size_t>(format));
}

bool is_metric(SplatFormat format)
{
    return format == SplatFormat::spz || format == SplatFormat::glb;
}

std::array<Vec3d, 3> axes_of(const Splats& splats, std::size_t i)
{
    const auto& [w, x, y, z] = splats.rotations[i];
    const Mat3 turn = numerics::rotation_of(double{w}, double{x}, double{y}, double{z});
    return {turn * Vec3d{1, 0, 0}, turn * Vec3d{0, 1, 0}, turn * Vec3d{0, 0, 1}};
}

void resize(Splats& splats, std::size_t count)
{
    splats.centers.resize(count);
    splats.rotations.resize(count);
    splats.scales.resize(count);
    splats.opacities.resize(count);
    splats.colors.resize(count);
}

void set(Splats& splats, std::size_t i, Vec3f center, std::array<double, 4> rotation, Vec3d log_scale, double opacity,
         Vec3f color, const std::string& source)
{
    // Gaussians that are flat on purpose have scales down to 0.
    const auto scale = [](double log) { return static_cast<float>(std::max(std::exp(log), 1e-20)); };
    splats.centers[i] = center;
    splats.scales[i] = {scale(log_scale.x), scale(log_scale.y), scale(log_scale.z)};
    splats.opacities[i] = static_cast<float>(opacity);
    splats.colors[i] = color;
    double norm = 0;
    for (const double each : rotation)
        norm += each * each;
    norm = std::sqrt(norm);
    constexpr float far = 1e12F;  // Its square is a float.
    const Vec3f size = splats.scales[i];
    for (const double each : {center.x, center.y, center.z, size.x, size.y, size.z, color.x, color.y, color.z,
                              static_cast<float>(opacity), static_cast<float>(norm)})
        if (!(std::abs(each) < far))
            throw Error(fmt::format(
                "{}: Gaussian {} has a number that is not finite, or too large; \"splat-transform IN.ply --filter-nan "
                "OUT.ply\" leaves such ones out",
                source, i));
    if (norm > 0)
        for (std::size_t k = 0; k < 4; ++k)
            splats.rotations[i][k] = static_cast<float>(rotation[k] / norm);
    else
    {
        splats.rotations[i] = {1, 0, 0, 0};
        splats.opacities[i] = 0;
    }
}

namespace
{

constexpr std::string_view meta_name = "meta.json";

std::string_view text_of(Bytes bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// mkkellogg's format has no magic number, only a version in front of a header of zeros.
bool is_ksplat(Bytes bytes)
{
    constexpr std::size_t header = 4096;
    constexpr std::size_t section = 1024;
    constexpr std::size_t modes = 3;
    return bytes.size() >= header && value_at<std::uint8_t>(bytes, 0) == 0 && value_at<std::uint8_t>(bytes, 1) == 1 &&
           value_at<std::uint32_t>(bytes, 4) <= (bytes.size() - header) / section && value_at<std::uint16_t>(bytes, 20) < modes &&
           value_at<std::uint32_t>(bytes, 16) > 0;
}

/// A SOG whose files lie beside its meta.json.
SplatFile read_sog_folder(const std::filesystem::path& meta)
{
    if (!std::filesystem::exists(meta) && std::filesystem::exists(meta.parent_path() / "lod-meta.json"))
        return read_sog_folder(meta.parent_path() / "lod-meta.json");
    SplatFile file;
    std::vector<std::filesystem::path> files{meta};
    std::size_t total = 0;
    for (const auto& entry : std::filesystem::directory_iterator(meta.parent_path()))
        total += entry.is_regular_file() ? static_cast<std::size_t>(entry.file_size()) : 0;
    const auto read = [&](const std::string& name)
    {
        files.push_back(meta.parent_path() / name);
        return read_file(files.back());
    };
    file = parse_sog(read_text_file(meta), read, total, meta.string());
    file.files = std::move(files);
    return file;
}

}  // namespace

SplatFile parse_splats(std::span<const std::byte> bytes, const std::string& source)
{
    const std::string_view text = text_of(bytes);
    if (text.starts_with("ply"))
        return parse_ply(bytes, source);
    if (is_spz(bytes))
        return parse_spz(bytes, source);
    if (text.starts_with("PK\3\4"))
    {
        const ZipReader zip(bytes, source);
        if (!zip.contains(std::string(meta_name)))
            throw Error(source +
                        ": the archive has no meta.json, so it isn't a SOG; if it holds a file of splats, unpack it first");
        constexpr std::size_t most_meta = std::size_t{1} << 24U;
        // WebP hardly deflates.
        const std::size_t most_picture = 2 * bytes.size() + 65536;
        const auto meta = zip.unpacked(std::string(meta_name), most_meta);
        const auto unpacked = [&](const std::string& name) { return zip.unpacked(name, most_picture); };
        return parse_sog(text_of(meta), unpacked, bytes.size(), source);
    }
    if (is_ksplat(bytes))
        throw Error(source + ": KSPLAT is not supported; convert it: splat-transform IN.ksplat OUT.ply");
    if (text.starts_with("glTF"))
        return parse_glb(bytes, source);
    if (is_splat(bytes))
        return parse_splat(bytes, source);
    throw Error(source + ": isn't a file of Gaussian splats, or is cut short; expected PLY, SPLAT, SPZ, SOG or GLB");
}

SplatFile read_splats(const std::filesystem::path& file)
{
    if (std::filesystem::is_directory(file))
        return read_sog_folder(file / meta_name);
    const auto bytes = read_file(file);
    // A SPLAT file has no mark and may begin with any byte.
    if (text_of(bytes).starts_with("{") && !is_splat(bytes))
    {
        if (lower_extension(file) == ".gltf")
            throw Error(file.string() + ": splats of glTF are read from one file: export it as .glb");
        return read_sog_folder(file);
    }
    SplatFile result = parse_splats(bytes, file.string());
    result.files = {file};
    return result;
}

}  // namespace fresco::splats
