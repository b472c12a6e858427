#pragma once

#include "scene.h"

#include <vector>

namespace room
{

struct SceneHit
{
    float t = 0;
    int solid = -1;  ///< -1: none.
    int face = 0;
    bool same_face(const SceneHit& other) const { return solid == other.solid && face == other.face; }
};

/// Finds what a ray meets first: a tree of bounding boxes over the furniture, and the room around it. Immutable, any thread. The
/// scene must outlive it.
class Caster
{
  public:
    explicit Caster(const Scene& scene);
    const Scene& scene() const { return *scene_; }
    /// A `guess` (the solid that a ray nearby has met) makes it faster; it decides only between faces that lie in one plane.
    SceneHit cast(const Ray& ray, int guess = -1) const;
    /// Whether something is met before t = `limit`, not counting the solid `ignored` (-1: all count).
    bool blocked(const Ray& ray, float limit, int ignored) const;

  private:
    struct Node
    {
        Vec3f low, high;
        int first = 0;  ///< Leaf: index into order_; else the left child, the right one follows.
        int count = 0;  ///< 0: inner node.
    };
    struct Bounds
    {
        Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    };
    static float surface(const Bounds& box);
    Bounds bounds(std::size_t begin, std::size_t end) const;
    void sort_along(int axis, std::size_t begin, std::size_t end);
    void build(std::size_t node, std::size_t begin, std::size_t end);

    const Scene* scene_;
    std::vector<Node> nodes_;
    std::vector<int> order_;
};

}  // namespace room
