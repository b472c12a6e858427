#pragma once

#include "catch.h"

#include <fresco/splats/splats.h>

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

/// \file Gaussians whose numbers are known, and files of them that are written number by number.

namespace fresco::splats::samples
{

inline std::vector<std::byte> bytes_of(const std::string& text)
{
    const auto* const data = reinterpret_cast<const std::byte*>(text.data());
    return {data, data + text.size()};
}

template <class T>
std::string raw(T value)
{
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Appends a Gaussian of other splats.
inline void copy(const Splats& from, std::size_t i, Splats& to)
{
    to.centers.push_back(from.centers[i]);
    to.rotations.push_back(from.rotations[i]);
    to.scales.push_back(from.scales[i]);
    to.opacities.push_back(from.opacities[i]);
    to.colors.push_back(from.colors[i]);
}

/// Appends a round Gaussian that lies across `normal`, of unit length.
inline void add_flat(Splats& splats, Vec3d center, Vec3d normal, double size, double thickness, double opacity, Vec3f color)
{
    // The half-way turn from +z to the normal.
    const double w = std::sqrt(std::max(1 + normal.z, 0.0) / 2);
    const bool is_down = w < 1e-3;
    splats.centers.push_back(vec_cast<float>(center));
    splats.rotations.push_back({is_down ? 0 : static_cast<float>(w), is_down ? 1 : static_cast<float>(-normal.y / (2 * w)),
                                is_down ? 0 : static_cast<float>(normal.x / (2 * w)), 0});
    splats.scales.push_back({static_cast<float>(size), static_cast<float>(size), static_cast<float>(thickness)});
    splats.opacities.push_back(static_cast<float>(opacity));
    splats.colors.push_back(color);
}

/// Four Gaussians, among them a flat one, a bright one and one darker than black.
inline Splats four()
{
    Splats splats;
    splats.centers = {{-1, 0, -1}, {0, 0.25F, -1}, {-1, 0, 3.5F}, {0.5F, -2, 0}};
    splats.rotations = {{1, 0, 0, 0}, {0.5F, 0.5F, 0.5F, 0.5F}, {0.5F, -0.5F, 0.5F, -0.5F}, {0, 0, 0, 1}};
    splats.scales = {{0.1F, 0.1F, 0.1F}, {0.2F, 0.1F, 0.001F}, {0.1F, 0.3F, 0.1F}, {0.05F, 0.1F, 0.4F}};
    splats.opacities = {0.9F, 0.2F, 0.5F, 0.99F};
    splats.colors = {{0.25F, 0.5F, 0.75F}, {1.5F, 0.5F, 0}, {-0.16F, 0, 1}, {1, 1, 1}};
    return splats;
}

struct PlyForm
{
    int degree = 0;
    std::string behind{};         ///< Bytes behind the last vertex.
    float quaternion_length = 1;  ///< Some trainers do not normalize.
};

/// As INRIA's trainer writes it; coefficient k of Gaussian i is i + k / 100.
inline std::vector<std::byte> ply(const Splats& splats, const PlyForm& form = {})
{
    std::string header =
        fmt::format("ply\nformat binary_little_endian 1.0\ncomment a sample\nelement vertex {}\n", splats.size());
    std::string names = "x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 ";
    const int rest = 3 * ((form.degree + 1) * (form.degree + 1) - 1);
    for (int k = 0; k < rest; ++k)
        names += fmt::format("f_rest_{} ", k);
    names += "opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 ";
    for (std::size_t begin = 0; begin < names.size(); begin = names.find(' ', begin) + 1)
        header += "property float " + names.substr(begin, names.find(' ', begin) - begin) + "\n";
    std::string body;
    const auto put = [&](double value) { body += raw(static_cast<float>(value)); };
    const auto put_vector = [&](Vec3f v)
    {
        put(v.x);
        put(v.y);
        put(v.z);
    };
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        put_vector(splats.centers[i]);
        put_vector({0, 0, 0});
        put_vector((splats.colors[i] - Vec3f{0.5F, 0.5F, 0.5F}) * (1 / 0.28209479F));
        for (int k = 0; k < rest; ++k)
            put(static_cast<double>(i) + k / 100.0);
        put(-std::log(1 / splats.opacities[i] - 1));
        const Vec3f scale = splats.scales[i];
        put_vector({std::log(scale.x), std::log(scale.y), std::log(scale.z)});
        for (const float each : splats.rotations[i])
            put(each * form.quaternion_length);
    }
    return bytes_of(header + "end_header\n" + body + form.behind);
}

inline void check_near(const Splats& found, const Splats& expected, double tolerance, double color_tolerance)
{
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
    {
        CAPTURE(i);
        CHECK(length(found.centers[i] - expected.centers[i]) <= tolerance);
        double same = 0;  // A rotation has two quaternions.
        for (std::size_t k = 0; k < 4; ++k)
            same += found.rotations[i][k] * expected.rotations[i][k];
        CHECK(std::abs(same) >= 1 - tolerance);
        const Vec3f scale = found.scales[i];
        const Vec3f truth = expected.scales[i];
        CHECK(std::abs(std::log(scale.x / truth.x)) + std::abs(std::log(scale.y / truth.y)) +
                  std::abs(std::log(scale.z / truth.z)) <=
              tolerance * 4);
        CHECK(std::abs(found.opacities[i] - expected.opacities[i]) <= tolerance);
        CHECK(length(found.colors[i] - expected.colors[i]) <= color_tolerance);
    }
}

}  // namespace fresco::splats::samples
