#pragma once

#include "noise.h"
#include "scene.h"

namespace room
{

/// Puts bodies into a scene. Pieces of furniture stand on the floor at (x, y) and are turned about the vertical by `yaw`.
class Furniture
{
  public:
    Furniture(Scene& scene, std::uint32_t seed) : scene_(scene), seed_(seed) {}

    std::uint16_t material(Material m);
    float random() { return unit(seed_, ++drawn_); }
    float random(float from, float to) { return mix(from, to, random()); }

    /// A frame on the floor in which furniture is built: local x, y, z in meters.
    void stand_at(float x, float y, float yaw, float z = 0);
    /// Box by its center and edges.
    Solid& box(Vec3f center, Vec3f edges, std::uint16_t material, float yaw = 0);
    /// What the boxes from here on are part of.
    void begin(Part part) { part_ = part; }
    /// Round body between z0 and z1.
    Solid& round(float x, float y, float z0, float z1, float bottom_radius, float top_radius, std::uint16_t material);
    Solid& ball(Vec3f center, Vec3f radii, std::uint16_t material);

    void table(std::uint16_t wood);
    void still_life();
    void chair(std::uint16_t wood, std::uint16_t cushion);
    void shelf(float width, float height, std::uint16_t wood);
    void sofa(float width, std::uint16_t cloth, std::uint16_t cushion);
    void sideboard(float width, std::uint16_t front, std::uint16_t top);
    void plant();
    void floor_lamp(std::uint16_t glowing);
    /// Hangs from the ceiling at height `ceiling`.
    void pendant(float ceiling, std::uint16_t glowing);
    /// Center of the picture at height z; the wall is behind, at local y = 0, the picture in front of it.
    void picture(float width, float height, float z, Vec3f sky, Vec3f hills);
    void armchair(std::uint16_t cloth, std::uint16_t cushion);
    void radiator(float width);
    /// `right` and `left` of a window of this width, from z0 to z1.
    void curtains(float width, float z0, float z1, std::uint16_t cloth);

  private:
    void book_row(float x0, float x1, float y, float z, float room_above);

    Scene& scene_;
    std::uint32_t seed_;
    std::uint32_t drawn_ = 0;
    Vec3f origin_;
    float yaw_ = 0;
    Part part_ = Part::furniture;
};

}  // namespace room
