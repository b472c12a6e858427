#include "parsers.h"

#include <fresco/error.h>
#include <fresco/weights/state_dict.h>
#include <fresco/weights/vgg19.h>

#include <zlib.h>

#include <cstring>

namespace fresco::fuzz
{
namespace
{

void check(const weights::StateDict& contents)
{
    for (const auto& tensor : contents.tensors)
    {
        std::size_t count = 1;
        for (const std::size_t extent : tensor.shape)
            count *= extent;
        require(tensor.count() == count, "a tensor has the bytes of its shape");
        require(weights::shape_text(tensor.shape).empty() == false, "a shape in words");
        refused([&] { weights::to_float32(tensor, source); });
    }
    refused(
        [&]
        {
            const auto vgg19 = weights::recognize_vgg19(contents, source);
            const auto metadata = weights::vgg19_metadata(vgg19);
            require(metadata.at("padding") == weights::padding_text(vgg19.input.padding), "metadata that say the same");
        });
}

/// With the length of the header that its braces give, where another is stated: else each change of the header ends there.
std::vector<std::byte> with_length(Bytes bytes)
{
    std::vector<std::byte> file(bytes.begin(), bytes.end());
    int depth = 0;
    for (std::size_t at = 8; at < file.size(); ++at)
    {
        depth += file[at] == std::byte{'{'} ? 1 : file[at] == std::byte{'}'} ? -1 : 0;
        if (depth > 0)
            continue;
        const std::uint64_t length = at - 7;
        std::memcpy(file.data(), &length, sizeof length);
        break;
    }
    return file;
}

void read_safetensors(Bytes given)
{
    const bool whole = !refused([&] { weights::parse_state_dict(given, source); });
    const auto mended = whole ? std::vector<std::byte>() : with_length(given);
    const Bytes bytes = whole ? given : Bytes(mended);
    const auto contents = weights::parse_state_dict(bytes, source);
    require(weights::name_of(contents.form) != "", "a form");
    if (contents.form != weights::Form::safetensors)
        return;
    const auto again = weights::to_safetensors(contents.tensors, contents.metadata);
    require(weights::parse_safetensors(again, "its own file").tensors.size() == contents.tensors.size(),
            "written and read, the same");
    check(contents);
}

void read_pickle(Bytes bytes)
{
    check(weights::parse_legacy_pickle(bytes, source));
}

/// An archive whose checksums are right, as far as it is one: else nothing behind them would be reached.
std::vector<std::byte> sealed(Bytes bytes)
{
    std::vector<std::byte> archive(bytes.begin(), bytes.end());
    const auto number = [&](std::size_t at, std::size_t count)
    {
        std::uint64_t value = 0;
        std::memcpy(&value, archive.data() + at, count);
        return static_cast<std::size_t>(value);
    };
    const auto is = [&](std::size_t at, const char* mark, std::size_t size)
    { return at + size <= archive.size() && std::memcmp(archive.data() + at, mark, 4) == 0; };
    for (std::size_t at = 0; at + 46 <= archive.size(); ++at)
    {
        if (!is(at, "PK\1\2", 46))
            continue;
        const std::size_t header = number(at + 42, 4);
        if (!is(header, "PK\3\4", 30))
            continue;
        const std::size_t data = header + 30 + number(header + 26, 2) + number(header + 28, 2);
        const std::size_t size = number(at + 24, 4);
        if (data > archive.size() || size > archive.size() - data)
            continue;
        const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(archive.data() + data), size));
        std::memcpy(archive.data() + at + 16, &sum, 4);
        std::memcpy(archive.data() + header + 14, &sum, 4);
    }
    return archive;
}

void read_zip(Bytes bytes)
{
    const auto archive = sealed(bytes);
    check(weights::parse_zip_pickle(archive, source));
}

const Registered registered{{"safetensors", "sdk/weights/src/(safetensors|state_dict|vgg19)\\.cpp", read_safetensors},
                            {"torch_pickle", "sdk/weights/src/pickle\\.cpp", read_pickle},
                            {"torch_zip", "sdk/weights/src/torch_file\\.cpp", read_zip}};

}  // namespace
}  // namespace fresco::fuzz
