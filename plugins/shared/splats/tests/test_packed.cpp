#include "splat_samples.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <algorithm>
#include <array>

using namespace fresco;
using namespace fresco::splats;

namespace
{

/// Each quaternion has another largest component, and its others differ in size or sign.
Splats turned()
{
    Splats splats = samples::four();
    splats.rotations = {
        {0.8F, 0.4F, -0.2F, 0.4F}, {-0.4F, 0.8F, 0.4F, 0.2F}, {0.4F, 0.2F, 0.8F, -0.4F}, {0.2F, -0.4F, 0.4F, 0.8F}};
    splats.colors = {{0.25F, 0.5F, 0.75F}, {0.9F, 0.5F, 0}, {0.16F, 0, 1}, {1, 1, 1}};
    return splats;
}

/// The step of `count` ones between two values that is nearest to `value`.
std::uint32_t step(double value, double low, double high, int count)
{
    return static_cast<std::uint32_t>(std::lround((value - low) / (high - low) * count));
}

std::size_t largest_of(const std::array<float, 4>& q)
{
    return static_cast<std::size_t>(std::ranges::max_element(q) - q.begin());
}

/// PlayCanvas' compressed PLY, whose first chunk of 256 has copies of Gaussian 0.
std::string compressed_ply(const Splats& splats, bool with_colors)
{
    const std::size_t count = 256 + splats.size();
    std::string header = "ply\nformat binary_little_endian 1.0\nelement chunk 2\n", chunks, rows;
    for (const std::string what : {"", "scale_", "color_"})
        for (const char* const end : {"min_", "max_"})
            for (const char axis : std::string(what == "color_" ? (with_colors ? "rgb" : "") : "xyz"))
                header += fmt::format("property float {}{}{}\n", end, what == "color_" ? "" : what, axis);
    header += fmt::format("element vertex {}\n", count);
    for (const char* name : {"position", "rotation", "scale", "color"})
        header += fmt::format("property uint packed_{}\n", name);
    for (const float shift : {0.F, 1.F})
    {
        const std::array ranges{-4 - shift, -4.F, -4.F,  4.F, 4 + shift, 4.F, -7 - shift, -7.F, -7.F,
                                0.F,        0.F,  shift, 0.F, -shift,    0.F, 1 + shift,  1.F,  1.F};
        for (std::size_t k = 0; k < (with_colors ? 18U : 12U); ++k)
            chunks += samples::raw(ranges[k]);
    }
    for (std::size_t row = 0; row < count; ++row)
    {
        const std::size_t i = row < 256 ? 0 : row - 256;
        const double shift = row < 256 ? 0 : 1, tint = with_colors ? shift : 0;
        const Vec3f c = splats.centers[i], s = splats.scales[i], rgb = splats.colors[i];
        std::uint32_t turn = static_cast<std::uint32_t>(largest_of(splats.rotations[i]));
        for (std::size_t k = 0; k < 4; ++k)
            if (k != largest_of(splats.rotations[i]))
                turn = turn << 10U | step(splats.rotations[i][k], -std::sqrt(0.5), std::sqrt(0.5), 1023);
        rows +=
            samples::raw(step(c.x, -4 - shift, 4, 2047) << 21U | step(c.y, -4, 4 + shift, 1023) << 11U | step(c.z, -4, 4, 2047));
        rows += samples::raw(turn);
        rows += samples::raw(step(std::log(s.x), -7 - shift, 0, 2047) << 21U | step(std::log(s.y), -7, 0, 1023) << 11U |
                             step(std::log(s.z), -7, shift, 2047));
        rows += samples::raw(step(rgb.x, 0, 1 + tint, 255) << 24U | step(rgb.y, -tint, 1, 255) << 16U |
                             step(rgb.z, 0, 1, 255) << 8U | step(splats.opacities[i], 0, 1, 255));
    }
    return header + "end_header\n" + chunks + rows;
}

using Pixel = std::array<std::uint32_t, 4>;

/// A lossless WebP of one row, in which each of 256 values of each channel has a code of 8 bits.
std::string webp(const std::vector<Pixel>& pixels)
{
    std::vector<bool> bits;
    const auto put = [&](std::uint64_t value, int count)
    {
        for (int k = 0; k < count; ++k)
            bits.push_back((value >> k & 1U) != 0);
    };
    put(0x2f, 8);
    put(static_cast<std::uint32_t>(pixels.size() - 1), 14);
    put(0, 14);
    put(1, 4);  // Alpha is used; version 0.
    put(0, 3);  // No transform, no cache of colors, one set of codes.
    for (int channel = 0; channel < 4; ++channel)
    {
        put(8U << 1U, 5);  // Not a simple code. Of the lengths of codes of lengths, 12 follow,
        put(0, 3 * 11);
        put(1, 3);  // of which only the length 8 occurs.
        if (channel == 0)
            put(254U << 4U | 3U << 1U | 1U, 12);  // Green has 256 values with codes; copies have none.
        else
            put(0, 1);
    }
    put(1, 4);  // One distance, 0.
    for (const Pixel& pixel : pixels)
        for (const std::size_t channel : {1U, 0U, 2U, 3U})
            for (int k = 7; k >= 0; --k)
                put(pixel[channel] >> k & 1U, 1);
    std::string data((bits.size() + 15) / 16 * 2, '\0');
    for (std::size_t k = 0; k < bits.size(); ++k)
        data[k / 8] = static_cast<char>(data[k / 8] | (bits[k] ? 1 << k % 8 : 0));
    const auto size = static_cast<std::uint32_t>(data.size());
    return "RIFF" + samples::raw(size + 12) + "WEBPVP8L" + samples::raw(size) + data;
}

}  // namespace

TEST_CASE("A compressed PLY has the numbers that were packed, with colors in chunks and without")
{
    for (const bool with_colors : {false, true})
    {
        CAPTURE(with_colors);
        const std::string file = compressed_ply(turned(), with_colors);
        SplatFile found = parse_splats(std::as_bytes(std::span(file)), "x");
        CHECK(found.format == SplatFormat::compressed_ply);
        REQUIRE(found.splats.size() == 260);
        Splats last;
        for (std::size_t i = 256; i < 260; ++i)
            samples::copy(found.splats, i, last);
        samples::check_near(last, turned(), 0.006, 0.006);
        CHECK(length(found.splats.centers[255] - turned().centers[0]) < 0.006F);
    }
}

TEST_CASE("A SOG has the numbers that were packed")
{
    const Splats truth = turned();
    std::array<std::vector<Pixel>, 5> pictures;
    std::string scales, colors;
    for (int k = 0; k < 256; ++k)
    {
        scales += fmt::format("{}{}", k > 0 ? "," : "", -8 + k / 32.0);
        colors += fmt::format("{}{}", k > 0 ? "," : "", (k / 255.0 - 0.5) / 0.28209479);
    }
    for (std::size_t i = 0; i < truth.size(); ++i)
    {
        const Vec3f c = truth.centers[i], s = truth.scales[i], rgb = truth.colors[i];
        Pixel low{}, high{}, size{}, turn{}, color{};
        for (std::size_t k = 0; k < 3; ++k)
        {
            const double center = std::array{c.x, c.y, c.z}[k];
            const std::uint32_t packed = step(std::copysign(std::log1p(std::abs(center)), center), -2, 2, 65535);
            low[k] = packed % 256;
            high[k] = packed / 256;
            size[k] = step(std::log(std::array{s.x, s.y, s.z}[k]), -8, 0, 256);
            color[k] = step(std::array{rgb.x, rgb.y, rgb.z}[k], 0, 1, 255);
        }
        std::size_t next = 0;
        for (std::size_t k = 0; k < 4; ++k)
            if (k != largest_of(truth.rotations[i]))
                turn[next++] = step(truth.rotations[i][k], -std::sqrt(0.5), std::sqrt(0.5), 255);
        turn[3] = 252 + static_cast<std::uint32_t>(largest_of(truth.rotations[i]));
        color[3] = step(truth.opacities[i], 0, 1, 255);
        for (const auto& [picture, pixel] : {std::pair{0, low}, {1, high}, {2, size}, {3, turn}, {4, color}})
            pictures[static_cast<std::size_t>(picture)].push_back(pixel);
    }
    const testing::TemporaryFolder folder;
    for (std::size_t k = 0; k < 5; ++k)
        write_file(folder.path() / fmt::format("{}.webp", k), webp(pictures[k]));
    write_file(folder.path() / "meta.json",
               fmt::format(R"({{"version": 2, "count": 4, "means": {{"mins": [-2, -2, -2], "maxs": [2, 2, 2], "files": ["0.webp",
                           "1.webp"]}}, "scales": {{"codebook": [{}], "files": ["2.webp"]}}, "quats": {{"files": ["3.webp"]}},
                           "sh0": {{"codebook": [{}], "files": ["4.webp"]}}}})",
                           scales, colors));
    try
    {
        const SplatFile found = read_splats(folder.path());
        CHECK(found.format == SplatFormat::sog);
        samples::check_near(found.splats, truth, 0.016, 0.006);
    }
    catch (const Error& error)
    {
        if (std::string(error.what()).find("SOG needs OpenCV") == std::string::npos)
            throw;
        WARN("skipped: SOG needs OpenCV");
    }
}
