#pragma once

#include <fresco/image.h>
#include <fresco/images/lab.h>
#include <fresco/math.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

/// \file A picture level as its description says it, in double precision and with plain loops. Keys on every second pixel: for
/// pictures of less than 12 000 keys.

namespace plain
{

using namespace fresco;

using Numbers = std::vector<double>;

inline double squared_distance(const Numbers& a, const Numbers& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

/// Eigenvectors of a symmetric matrix, those of the largest eigenvalues first (cyclic Jacobi).
inline std::vector<Numbers> eigenvectors(std::vector<Numbers> a)
{
    const std::size_t n = a.size();
    std::vector<Numbers> vectors(n, Numbers(n, 0.0));
    for (std::size_t i = 0; i < n; ++i)
        vectors[i][i] = 1;
    const auto turn = [](double& x, double& y, double c, double s)
    {
        const double before = x;
        x = c * before - s * y;
        y = s * before + c * y;
    };
    for (int sweep = 0; sweep < 15; ++sweep)
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q)
            {
                if (a[p][q] == 0)
                    continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1);
                for (std::size_t k = 0; k < n; ++k)
                    turn(a[k][p], a[k][q], c, t * c);
                for (std::size_t k = 0; k < n; ++k)
                {
                    turn(a[p][k], a[q][k], c, t * c);
                    turn(vectors[p][k], vectors[q][k], c, t * c);
                }
            }
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
    std::vector<Numbers> sorted;
    for (const std::size_t i : order)
        sorted.push_back(vectors[i]);
    return sorted;
}

/// A picture at any place, bilinear, pixel centers at whole numbers, clamped at its border.
template <class Picture>
Vec3d color_of(const Picture& picture, Vec2d at)
{
    const double x = std::clamp(at.x, 0.0, picture.width - 1.0);
    const double y = std::clamp(at.y, 0.0, picture.height - 1.0);
    Vec3d sum;
    for (int j = static_cast<int>(y); j <= y + 1; ++j)
        for (int i = static_cast<int>(x); i <= x + 1; ++i)
        {
            const double share = std::max(0.0, 1 - std::abs(x - i)) * std::max(0.0, 1 - std::abs(y - j));
            const auto value = [&](int c) { return static_cast<double>(picture.at(i, j, c)); };
            if (share > 0)
                sum += Vec3d{value(0), value(1), value(2)} * share;
        }
    return sum;
}

struct Picture
{
    Picture(const Raster8& rgb, double of_scale, int of_side)
        : scale(of_scale), side(of_side), lab(lab_picture(resized(rgb, static_cast<int>(std::lround(rgb.width * scale)),
                                                                  static_cast<int>(std::lround(rgb.height * scale)))))
    {
        for (int y = 0; y + side <= lab.height; y += 2)
            for (int x = 0; x + side <= lab.width; x += 2)
                keys.push_back(Vec2d{x + half(), y + half()});
        find_components();
    }

    double half() const { return side / 2; }

    Numbers values_at(Vec2d at) const
    {
        Numbers values;
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i)
                for (int c = 0; c < 3; ++c)
                    values.push_back(static_cast<double>(lab.at(static_cast<int>(std::lround(at.x) - side / 2) + i,
                                                                static_cast<int>(std::lround(at.y) - side / 2) + j, c)));
        return values;
    }

    /// Mean squared difference from a place.
    double distance(const Numbers& look, Vec2d at) const
    {
        return squared_distance(look, values_at(at)) / static_cast<double>(look.size());
    }

    Numbers projected(const Numbers& values) const
    {
        Numbers result;
        for (const Numbers& component : components)
        {
            double sum = 0;
            for (std::size_t i = 0; i < values.size(); ++i)
                sum += component[i] * (values[i] - mean[i]);
            result.push_back(sum);
        }
        return result;
    }

    Vec2d inside(Vec2d at) const
    {
        return {std::clamp(at.x, half(), lab.width - 1 - half()), std::clamp(at.y, half(), lab.height - 1 - half())};
    }

    /// Of keys that are as near the last.
    std::size_t key_near(Vec2d at) const
    {
        std::size_t near = 0;
        for (std::size_t k = 1; k < keys.size(); ++k)
            if (const Vec2d a = keys[k] - at, b = keys[near] - at; dot(a, a) <= dot(b, b))
                near = k;
        return near;
    }

    double scale;
    int side;
    RasterF lab;
    std::vector<Vec2d> keys;
    std::vector<Numbers> key_features;
    Numbers mean;
    std::vector<Numbers> components;

  private:
    void find_components()
    {
        mean.assign(static_cast<std::size_t>(3 * side * side), 0.0);
        std::vector<Numbers> values;
        for (const Vec2d key : keys)
            values.push_back(values_at(key));
        for (const Numbers& v : values)
            for (std::size_t i = 0; i < mean.size(); ++i)
                mean[i] += v[i] / static_cast<double>(keys.size());
        std::vector<Numbers> products(mean.size(), Numbers(mean.size(), 0.0));
        for (const Numbers& v : values)
            for (std::size_t i = 0; i < mean.size(); ++i)
                for (std::size_t j = 0; j < mean.size(); ++j)
                    products[i][j] += (v[i] - mean[i]) * (v[j] - mean[j]);
        components = eigenvectors(products);
        components.resize(std::min<std::size_t>(mean.size(), 48));
        for (const Numbers& v : values)
            key_features.push_back(projected(v));
    }
};

}  // namespace plain
