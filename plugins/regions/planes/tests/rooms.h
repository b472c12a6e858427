#pragma once

#include "room_parts.h"

#include <fresco/geometry/topology.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

/// A mesh whose faces are known to be floor, ceiling, walls or furniture.
struct KnownRoom
{
    fresco::Mesh mesh;
    std::vector<RoomPart> parts;
    double noise_m = 0;
    fresco::Random random{3};

    /// A rectangle from `corner` along x and y, which faces x × y, in squares of about 6 cm.
    void sheet(RoomPart part, fresco::Vec3f corner, fresco::Vec3f x, fresco::Vec3f y)
    {
        const auto squares = [](fresco::Vec3f edge)
        { return std::max(1U, static_cast<std::uint32_t>(std::lround(length(edge) / 0.06F))); };
        fresco::Mesh added = fresco::testing::rectangle(corner, x, y, squares(x), squares(y));
        const fresco::Vec3f normal = normalized(cross(x, y));
        for (fresco::Vec3f& p : added.positions)
            p += normal * static_cast<float>(noise_m * (2 * random.uniform() - 1));
        parts.insert(parts.end(), added.triangles.size(), part);
        fresco::testing::append(mesh, added);
    }

    /// A box seen from outside, without the lower side and the one toward +y, which stands at a wall.
    void block(fresco::Vec3f low, fresco::Vec3f size, RoomPart part = RoomPart::furniture)
    {
        const fresco::Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
        sheet(part, low + z, x, y);
        sheet(part, low, x, z);
        sheet(part, low + x, y, z);
        sheet(part, low + y, -y, z);
    }

    /// The inside of a box from the origin.
    void shell(fresco::Vec3f size, bool with_ceiling = true)
    {
        const fresco::Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
        sheet(RoomPart::floor, {}, x, y);
        if (with_ceiling)
            sheet(RoomPart::ceiling, z, y, x);
        sheet(RoomPart::walls, {}, z, x);
        sheet(RoomPart::walls, x, z, y);
        sheet(RoomPart::walls, x + y, z, -x);
        sheet(RoomPart::walls, y, z, -y);
    }

    /// A table of 75 cm with four legs.
    void table(float x, float y)
    {
        block({x, y, 0.72F}, {1.6F, 0.9F, 0.03F});
        sheet(RoomPart::furniture, {x, y, 0.72F}, {0, 0.9F, 0}, {1.6F, 0, 0});
        for (const float dx : {0.05F, 1.47F})
            for (const float dy : {0.05F, 0.77F})
                block({x + dx, y + dy, 0}, {0.08F, 0.08F, 0.72F});
    }

    /// Intersection over union of a part's area.
    double iou(const std::vector<RoomPart>& found, RoomPart part) const
    {
        double both = 0;
        double either = 0;
        for (std::size_t f = 0; f < parts.size(); ++f)
        {
            const double area = length(fresco::geometry::area_vector(mesh, f));
            both += found[f] == part && parts[f] == part ? area : 0;
            either += found[f] == part || parts[f] == part ? area : 0;
        }
        return either > 0 ? both / either : 1;
    }

    double least_iou(const std::vector<RoomPart>& found) const
    {
        return std::min({iou(found, RoomPart::floor), iou(found, RoomPart::ceiling), iou(found, RoomPart::walls),
                         iou(found, RoomPart::furniture)});
    }
};
