#include <fresco/uv_mapping/sight.h>

namespace fresco
{

Sight sight(bool front, double depth)
{
    if (!front)
        return Sight::back_face;
    return depth < nearest_surface_m ? Sight::too_near : Sight::surface;
}

}  // namespace fresco
