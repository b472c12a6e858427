#include "run/file_origin.h"

#include "base/text_layout.h"
#include <fresco/error.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <ostream>

namespace fresco::host
{
namespace
{

constexpr std::size_t most_json_bytes = std::size_t{1} << 26U;

std::string json_chunk(const std::filesystem::path& file)
{
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        throw MissingInput(file.string() + ": no such file");
    std::ifstream stream(file, std::ios::binary);
    std::array<unsigned char, 20> header{};
    stream.read(reinterpret_cast<char*>(header.data()), header.size());
    const auto word = [&](std::size_t at)
    { return header[at] | header[at + 1] << 8U | header[at + 2] << 16U | std::uint32_t{header[at + 3]} << 24U; };
    if (!stream || word(0) != 0x46546C67 || word(4) != 2 || word(16) != 0x4E4F534A)
        throw Error(file.string() + ": is not a binary glTF 2.0 file; expected a .glb that export.gltf wrote, or a type: "
                                    "'fresco stages' lists them");
    if (word(12) > most_json_bytes)
        throw Error(file.string() + ": its JSON chunk claims more than 64 MiB");
    std::string json(word(12), '\0');
    if (!stream.read(json.data(), static_cast<std::streamsize>(json.size())))
        throw Error(file.string() + ": ends within its JSON chunk");
    return json;
}

std::string value_text(const Value& value)
{
    return value.is_string() ? value.as_string() : to_json(value);
}

/// "waves.jpg (xxh128 0123…)", or the stage.
std::string input_text(const Value& input)
{
    if (const Value* name = input.find("file"))
        return name->as_string() + " (xxh128 " + input.at("xxh128").as_string() + ")";
    return value_text(input);
}

void write_stage(const Value& stage, std::size_t width, std::ostream& out)
{
    using Kind = TextTable::Kind;
    constexpr std::size_t indent = 2;
    out << '\n' << stage.at("stage").as_string() << '\n';
    TextTable table({{"", Kind::figure}, {"", Kind::figure}, {"", Kind::text}}, indent);
    for (const auto& [name, input] : stage.at("inputs").as_map())
        table.add({"input", name, input_text(input)});
    for (const auto& [name, option] : stage.at("options").as_map())
        table.add({"option", name, input_text(option)});
    if (const Value* figures = stage.find("figures"))
        for (const auto& [name, figure] : figures->as_map())
            table.add({"figure", name, value_text(figure)});
    out << table.text(width);
}

}  // namespace

Value file_origin(const std::filesystem::path& file)
{
    const Value document = parse_json(json_chunk(file), file.string());
    const Value* asset = document.find("asset");
    const Value* extras = asset == nullptr ? nullptr : asset->find("extras");
    if (extras == nullptr || extras->find("stages") == nullptr || extras->find("versions") == nullptr)
        throw Error(file.string() + ": does not say how it was made: asset.extras has no stages and versions");
    return *extras;
}

void write_file_origin(const std::filesystem::path& file, bool json, std::size_t width, std::ostream& out)
{
    const Value origin = file_origin(file);
    if (json)
    {
        out << to_json(origin, 2) << '\n';
        return;
    }
    out << file.string() << ": made with";
    const char* separator = " ";
    for (const auto& [library, version] : origin.at("versions").as_map())
    {
        out << separator << library << ' ' << version.as_string();
        separator = ", ";
    }
    out << '\n';
    for (const Value& stage : origin.at("stages").as_list())
        write_stage(stage, width, out);
}

}  // namespace fresco::host
