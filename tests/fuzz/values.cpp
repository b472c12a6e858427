#include "parsers.h"

#include <fresco/npy.h>
#include <fresco/value.h>

namespace fresco::fuzz
{
namespace
{

void read_json(Bytes bytes)
{
    const Value value = parse_json(text_of(bytes), source);
    const std::string text = to_json(value);
    require(to_json(parse_json(text, "its own JSON")) == text, "written and read, the same value");
    require(to_json(parse_json(to_json(value, 1), "its own JSON")) == text, "indented, the same value");
}

void read_npy(Bytes bytes)
{
    const NpyArray array = parse_npy(bytes, source);
    const NpyArray again = parse_npy(to_npy(array.type, array.shape, array.bytes), "its own NPY");
    require(again.type == array.type && again.shape == array.shape && again.bytes == array.bytes,
            "written and read, the same array");
}

const Registered registered{{"json", "sdk/src/(json|value)\\.cpp", read_json}, {"npy", "sdk/src/npy\\.cpp", read_npy}};

}  // namespace
}  // namespace fresco::fuzz
