#include "formats.h"

#include <fresco/value.h>

#include <algorithm>
#include <numbers>

#ifdef FRESCO_SPLATS_OPENCV
#include <opencv2/imgcodecs.hpp>
#endif

namespace fresco::splats
{
namespace
{

constexpr std::size_t codes = 256;

/// Pixels of a WebP picture of 32 bytes or more as its header states them; 0 if it isn't a lossless one.
std::size_t webp_pixels(Bytes bytes)
{
    const auto is = [&](std::size_t at, const char* name) { return std::memcmp(bytes.data() + at, name, 4) == 0; };
    if (!is(0, "RIFF") || !is(8, "WEBP"))
        return 0;
    const auto side = [](std::uint32_t less) { return std::size_t{less} + 1; };
    if (is(12, "VP8L"))
    {
        const auto sizes = value_at<std::uint32_t>(bytes, 21);
        return side(sizes & 0x3fffU) * side(sizes >> 14U & 0x3fffU);
    }
    if (!is(12, "VP8X"))
        return 0;
    constexpr std::size_t chunk_header = 8;
    std::size_t at = 12;
    while (bytes.size() - at >= chunk_header && !is(at, "VP8L"))
    {
        const std::size_t length = value_at<std::uint32_t>(bytes, at + 4);
        at += std::min(bytes.size() - at, chunk_header + length + length % 2);
    }
    const bool is_lossless = bytes.size() - at >= chunk_header;
    return is_lossless ? side(value_at<std::uint32_t>(bytes, 24) & 0xffffffU) * side(value_at<std::uint32_t>(bytes, 26) >> 8U)
                       : 0;
}

/// The pixels of the Gaussians: red, green, blue, alpha.
std::vector<std::array<std::uint8_t, 4>> pixels_of(const std::vector<std::byte>& bytes, std::size_t count,
                                                   const std::string& place)
{
#ifdef FRESCO_SPLATS_OPENCV
    // OpenCV takes no WebP of less bytes, which a picture of one color may have.
    constexpr std::size_t least_bytes = 64;
    auto padded = bytes;
    padded.resize(std::max(bytes.size(), least_bytes));
    const std::size_t pixels = webp_pixels(padded);
    if (pixels < count || pixels > 2 * count + 65536)
        throw Error(fmt::format("{}: is a picture of {} pixels; expected lossless WebP with one for each of the {} Gaussians",
                                place, pixels, count));
    cv::Mat picture;
    try
    {
        picture = cv::imdecode(cv::Mat(1, static_cast<int>(padded.size()), CV_8U, padded.data()), cv::IMREAD_UNCHANGED);
    }
    catch (const cv::Exception&)
    {
        picture.release();
    }
    if (picture.depth() != CV_8U || picture.channels() < 3 || picture.total() != pixels)
        throw Error(place + ": cannot be decoded: the picture is damaged, or OpenCV was built without WebP");
    std::vector<std::array<std::uint8_t, 4>> result(count);
    for (std::size_t i = 0; i < count; ++i)
    {
        const int row = static_cast<int>(i / static_cast<std::size_t>(picture.cols));
        const int column = static_cast<int>(i % static_cast<std::size_t>(picture.cols));
        const std::uint8_t* const bgr = picture.ptr(row) + static_cast<std::ptrdiff_t>(column) * picture.channels();
        result[i] = {bgr[2], bgr[1], bgr[0], picture.channels() == 4 ? bgr[3] : std::uint8_t{255}};
    }
    return result;
#else
    static_cast<void>(bytes);
    static_cast<void>(count);
    static_cast<void>(webp_pixels);
    throw Error(place + ": SOG needs OpenCV, which fresco was built without; \"splat-transform IN.sog OUT.ply\" writes a PLY");
#endif
}

/// All zeros for a pixel that holds none.
std::array<double, 4> rotation_of(const std::array<std::uint8_t, 4>& pixel)
{
    constexpr std::uint8_t first = 252;
    if (pixel[3] < first)
        return {};
    const auto component = [&](std::size_t k) { return (pixel[k] / 127.5 - 1) * (std::numbers::sqrt2 / 2); };
    return completed({component(0), component(1), component(2)}, pixel[3] - std::size_t{first});
}

}  // namespace

SplatFile parse_sog(std::string_view meta, const SogFile& file, std::size_t total_bytes, const std::string& source)
{
    const Value value = parse_json(meta, source);
    const JsonPlace root(value, source);
    if (value.find("lodLevels") != nullptr || value.find("tree") != nullptr)
        throw Error(source + ": is a streamed SOG; \"splat-transform lod-meta.json OUT.ply\" makes one file of its finest level");
    if (value.find("version") == nullptr && value.find("means") != nullptr)
        throw Error(source + ": is SOG 1; \"splat-transform meta.json OUT.sog\" makes SOG 2 of it");
    if (root["version"].integer() != 2)
        root.fail("version", "expected 2; \"splat-transform IN.sog OUT.ply\" makes a PLY of it");
    // A real one has 10 bytes a Gaussian.
    const auto count = static_cast<std::size_t>(root["count"].integer(1, 1'000'000'000));
    if (count > total_bytes)
        root.fail("count", fmt::format("{} bytes cannot hold {} Gaussians", total_bytes, count));
    const auto pixels = [&](const char* key, std::size_t index)
    {
        const JsonPlace part = root[key];
        const auto names = part["files"].texts();
        if (index >= names.size() || names[index].find_first_of("/\\") != std::string::npos)
            part.fail("files", "expected names of WebP files beside meta.json");
        return pixels_of(file(names[index]), count, source + ": " + names[index]);
    };
    const auto codebook = [&](const char* key) { return root[key]["codebook"].numbers(codes); };
    const auto low = root["means"]["mins"].numbers(3);
    const auto high = root["means"]["maxs"].numbers(3);
    const auto scale_codes = codebook("scales");
    const auto color_codes = codebook("sh0");
    const auto lower = pixels("means", 0);
    const auto upper = pixels("means", 1);
    const auto scales = pixels("scales", 0);
    const auto quaternions = pixels("quats", 0);
    const auto colors = pixels("sh0", 0);

    SplatFile result;
    result.format = SplatFormat::sog;
    resize(result.splats, count);
    for (std::size_t i = 0; i < count; ++i)
    {
        std::array<float, 3> center{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double share = (lower[i][k] + 256 * upper[i][k]) / 65535.0;
            const double packed = low[k] + (high[k] - low[k]) * share;
            center[k] = static_cast<float>(std::copysign(std::expm1(std::abs(packed)), packed));
        }
        const auto coded = [&](const std::vector<double>& book, const auto& pixel) {
            return Vec3d{book[pixel[0]], book[pixel[1]], book[pixel[2]]};
        };
        const Vec3d color = coded(color_codes, colors[i]) * harmonic_0 + Vec3d{0.5, 0.5, 0.5};
        set(result.splats, i, {center[0], center[1], center[2]}, rotation_of(quaternions[i]), coded(scale_codes, scales[i]),
            colors[i][3] / 255.0, vec_cast<float>(color), source);
    }
    return result;
}

}  // namespace fresco::splats
