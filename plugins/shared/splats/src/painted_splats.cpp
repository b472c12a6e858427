#include "formats.h"

#include <fresco/files_io.h>
#include <fresco/splats/painted_splats.h>

#include <algorithm>

namespace fresco::splats
{
namespace
{

double logit(double opacity)
{
    constexpr double least = 1e-6;
    const double p = std::clamp(opacity, least, 1 - least);
    return std::log(p / (1 - p));
}

void put(std::span<std::byte> row, std::size_t at, double value)
{
    const auto number = static_cast<float>(value);
    std::memcpy(row.data() + at, &number, sizeof number);
}

std::byte byte_of(double share)
{
    return static_cast<std::byte>(std::lround(std::clamp(255 * share, 0.0, 255.0)));
}

/// Writes numbers into a row of a PLY, where its layout has them.
class RowWriter
{
  public:
    RowWriter(const PlyRows& vertex, const std::string& source) : offsets_(gaussian_offsets(vertex, source)) {}

    void shape(std::span<std::byte> row, Vec3f center, Vec3f scale, double opacity) const
    {
        vector(row, 0, vec_cast<double>(center));
        put(row, offsets_[6], logit(opacity));
        const Vec3d size = vec_cast<double>(scale);
        vector(row, 7, {std::log(size.x), std::log(size.y), std::log(size.z)});
    }
    void color(std::span<std::byte> row, Vec3f color) const
    {
        vector(row, 3, (vec_cast<double>(color) - Vec3d{0.5, 0.5, 0.5}) * (1 / harmonic_0));
    }
    void rotation(std::span<std::byte> row, const std::array<float, 4>& rotation) const
    {
        for (std::size_t k = 0; k < 4; ++k)
            put(row, offsets_[10 + k], static_cast<double>(rotation[k]));
    }

  private:
    void vector(std::span<std::byte> row, std::size_t first, Vec3d v) const
    {
        put(row, offsets_[first], v.x);
        put(row, offsets_[first + 1], v.y);
        put(row, offsets_[first + 2], v.z);
    }

    std::array<std::size_t, 14> offsets_;
};

std::vector<std::byte> ply_of(const Splats& splats)
{
    std::string text = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", splats.size());
    for (const std::string_view name : gaussian_names)
        text += fmt::format("property float {}\n{}", name,
                            name == "z" ? "property float nx\nproperty float ny\nproperty float nz\n" : "");
    text += "end_header\n";
    constexpr std::size_t row_bytes = 17 * sizeof(float);
    std::vector<std::byte> bytes(text.size() + splats.size() * row_bytes);
    std::memcpy(bytes.data(), text.data(), text.size());
    const RowWriter writer(ply_rows(bytes, "splats")[0], "splats");
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const auto row = std::span(bytes).subspan(text.size() + i * row_bytes, row_bytes);
        writer.shape(row, splats.centers[i], splats.scales[i], double{splats.opacities[i]});
        writer.color(row, splats.colors[i]);
        writer.rotation(row, splats.rotations[i]);
    }
    return bytes;
}

/// The header with another count, and without the properties that are left out.
std::string header_text(const PlyHeader& header, std::size_t count, bool keeps_harmonics)
{
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& comment : header.comments)
        text += comment + "\n";
    for (const PlyElement& element : header.elements)
    {
        const bool is_vertex = element.name == "vertex";
        text += fmt::format("element {} {}\n", element.name, is_vertex ? count : element.count);
        for (const PlyProperty& property : element.properties)
            if (!is_vertex || keeps_harmonics || !property.name.starts_with("f_rest_"))
                text += property.line + "\n";
    }
    return text + "end_header\n";
}

std::vector<std::byte> painted_ply(Bytes bytes, const PaintedSplats& painted, bool keeps_harmonics, const std::string& source)
{
    const auto elements = ply_rows(bytes, source);
    const PlyRows& vertex = *find_rows(elements, "vertex");
    const RowWriter writer(vertex, source);
    std::vector<std::pair<std::size_t, std::size_t>> kept;  // Ranges of a row's bytes.
    std::size_t offset = 0;
    for (const PlyProperty& property : vertex.properties)
    {
        if (keeps_harmonics || !property.name.starts_with("f_rest_"))
            kept.emplace_back(offset, size_of(property.type));
        offset += size_of(property.type);
    }
    const std::string text = header_text(parse_ply_header(bytes, source), painted.parts.size(), keeps_harmonics);
    std::vector<std::byte> result;
    result.reserve(text.size() + painted.parts.size() * vertex.row_bytes);
    const auto append = [&](Bytes more) { result.insert(result.end(), more.begin(), more.end()); };
    append(std::as_bytes(std::span(text)));
    append(bytes.subspan(elements[0].begin, vertex.begin - elements[0].begin));
    std::vector<std::byte> row(vertex.row_bytes);
    for (const PaintedSplats::Part& part : painted.parts)
    {
        std::ranges::copy(bytes.subspan(vertex.begin + part.source * vertex.row_bytes, vertex.row_bytes), row.begin());
        if (part.is_split)
            writer.shape(row, part.center, part.scale, double{part.opacity});
        if (!part.keeps_color)
            writer.color(row, part.color);
        for (const auto& [at, size] : kept)
            append(std::span(row).subspan(at, size));
    }
    append(bytes.subspan(vertex.begin + vertex.count * vertex.row_bytes));
    return result;
}

void put_splat_shape(std::span<std::byte> row, Vec3f center, Vec3f scale, double opacity)
{
    std::size_t at = 0;
    for (const float each : {center.x, center.y, center.z, scale.x, scale.y, scale.z})
    {
        put(row, at, double{each});
        at += sizeof(float);
    }
    row[27] = byte_of(opacity);
}

void put_splat_color(std::span<std::byte> row, Vec3f color)
{
    row[24] = byte_of(double{color.x});
    row[25] = byte_of(double{color.y});
    row[26] = byte_of(double{color.z});
}

std::vector<std::byte> splat_of(const Splats& splats)
{
    std::vector<std::byte> bytes(splats.size() * splat_row_bytes);
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const auto row = std::span(bytes).subspan(i * splat_row_bytes, splat_row_bytes);
        put_splat_shape(row, splats.centers[i], splats.scales[i], double{splats.opacities[i]});
        put_splat_color(row, splats.colors[i]);
        for (std::size_t k = 0; k < 4; ++k)
            row[28 + k] = static_cast<std::byte>(
                std::lround(std::clamp(128 * (static_cast<double>(splats.rotations[i][k]) + 1), 0.0, 255.0)));
    }
    return bytes;
}

std::vector<std::byte> painted_splat(Bytes bytes, const PaintedSplats& painted)
{
    std::vector<std::byte> result(painted.parts.size() * splat_row_bytes);
    for (std::size_t i = 0; i < painted.parts.size(); ++i)
    {
        const PaintedSplats::Part& part = painted.parts[i];
        const auto row = std::span(result).subspan(i * splat_row_bytes, splat_row_bytes);
        std::ranges::copy(bytes.subspan(part.source * splat_row_bytes, splat_row_bytes), row.begin());
        if (part.is_split)
            put_splat_shape(row, part.center, part.scale, double{part.opacity});
        if (!part.keeps_color)
            put_splat_color(row, part.color);
    }
    return result;
}

std::vector<std::byte> painted_spz(const SpzContents& from, const PaintedSplats& painted, bool keeps_harmonics)
{
    SpzContents spz = from;
    if (!keeps_harmonics)
        spz.degree = 0;
    spz.count = painted.parts.size();
    const auto row = spz.row_bytes();
    for (std::size_t k = 0; k < row.size(); ++k)
    {
        spz.streams[k].resize(spz.count * row[k]);
        for (std::size_t i = 0; row[k] > 0 && i < spz.count; ++i)
            std::memcpy(spz.streams[k].data() + i * row[k], from.streams[k].data() + painted.parts[i].source * row[k], row[k]);
    }
    for (std::size_t i = 0; i < spz.count; ++i)
    {
        const PaintedSplats::Part& part = painted.parts[i];
        if (part.is_split)
            spz.put(i, part.center, part.scale, double{part.opacity});
        if (!part.keeps_color)
            spz.put_color(i, part.color);
    }
    return packed_spz(spz);
}

}  // namespace

bool is_written(SplatFormat format)
{
    return format == SplatFormat::ply || format == SplatFormat::splat || format == SplatFormat::spz;
}

std::vector<std::byte> bytes_of(const Splats& splats, SplatFormat format)
{
    return format == SplatFormat::ply     ? ply_of(splats)
           : format == SplatFormat::splat ? splat_of(splats)
                                          : packed_spz(spz_of(splats));
}

std::vector<std::byte> painted_bytes(const std::filesystem::path& path, const SplatFile& file, const PaintedSplats& painted,
                                     SplatFormat format, bool keeps_harmonics)
{
    const bool is_own = format == file.format;
    if (!is_own && format == SplatFormat::spz)
        return painted_spz(spz_of(file.splats), painted, false);
    const std::vector<std::byte> bytes = is_own ? read_file(path) : bytes_of(file.splats, format);
    const std::string source = path.string();
    // Indices are those of the file that was read.
    if (is_own && parse_splats(bytes, source).splats.centers != file.splats.centers)
        throw Error(source + ": has changed since it was read: run again");
    if (format == SplatFormat::ply)
        return painted_ply(bytes, painted, keeps_harmonics || !is_own, source);
    if (format == SplatFormat::splat)
        return painted_splat(bytes, painted);
    return painted_spz(unpacked_spz(bytes, source), painted, keeps_harmonics);
}

}  // namespace fresco::splats
