#include "parsers.h"

#include <fresco/npy.h>
#include <fresco/value.h>

namespace fresco::fuzz
{
namespace
{

/// A value is read as what it is, and as nothing else.
void check(const Value& value)
{
    const auto reads = [&](auto as) { return !refused([&] { (value.*as)(); }); };
    if (value.is_list())
        for (const Value& item : value.as_list())
            check(item);
    else if (value.is_map())
        for (const auto& [key, item] : value.as_map())
        {
            require(&value.at(key) == &item, "a key leads to its value");
            check(item);
        }
    else
    {
        require(reads(&Value::as_bool) == value.is_bool() && reads(&Value::as_int) == value.is_int() &&
                    reads(&Value::as_double) == value.is_number() && reads(&Value::as_string) == value.is_string(),
                "a " + std::string(value.kind_name()));
        const auto list = static_cast<const Value::List& (Value::*)() const>(&Value::as_list);
        const auto map = static_cast<const Value::Map& (Value::*)() const>(&Value::as_map);
        require(!reads(list) && !reads(map) && refused([&] { (void)value.at("key"); }), "neither a list nor a map");
    }
}

void read_json(Bytes bytes)
{
    const Value value = parse_json(text_of(bytes), source);
    check(value);
    const std::string text = to_json(value);
    require(to_json(parse_json(text, "its own JSON")) == text, "written and read, the same value");
    require(to_json(parse_json(to_json(value, 1), "its own JSON")) == text, "indented, the same value");
}

void read_npy(Bytes bytes)
{
    const NpyArray array = parse_npy(bytes, source);
    const auto reads = [&]<class T>(T)
    { return refused([&] { require(array.as<T>().size() == array.count(), "its values"); }) ? 0 : 1; };
    require(reads(std::uint8_t{}) + reads(std::uint16_t{}) + reads(std::uint32_t{}) + reads(std::int32_t{}) +
                    reads(std::int64_t{}) + reads(float{}) + reads(double{}) ==
                1,
            "an array of one type");
    require(fresco::read_npy(file_with(bytes, "array.npy")).shape == array.shape, "the same from a file");
    const NpyArray again = parse_npy(to_npy(array.type, array.shape, array.bytes), "its own NPY");
    require(again.type == array.type && again.shape == array.shape && again.bytes == array.bytes,
            "written and read, the same array");
}

const Registered registered{{"json", "sdk/src/value\\.cpp", read_json}, {"npy", "sdk/src/npy\\.cpp", read_npy}};

}  // namespace
}  // namespace fresco::fuzz
