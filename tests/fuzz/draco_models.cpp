#include "parsers.h"

namespace fresco::fuzz
{
namespace
{

const Registered registered_draco{{"gltf_draco", "plugins/shared/gltf/src/with_draco/.*", read_gltf}};

}  // namespace
}  // namespace fresco::fuzz
