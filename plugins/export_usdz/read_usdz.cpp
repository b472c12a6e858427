#include "read_usdz.h"

#include "zip.h"

#include <fresco/error.h>

#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <zlib.h>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
constexpr std::size_t local_bytes = 30;
constexpr std::size_t central_bytes = 46;
constexpr std::size_t end_bytes = 22;

void expect(bool good, const std::string& what)
{
    if (!good)
        throw Error(what);
}

std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t width)
{
    expect(at + width <= bytes.size(), fmt::format("ends before byte {}", at + width));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i)
        value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
    return value;
}

class PackageReader
{
  public:
    explicit PackageReader(std::string_view package) : package_(package) {}

    std::vector<UsdzEntry> read()
    {
        expect(package_.size() >= end_bytes, "too short for a zip archive");
        const std::size_t end = package_.size() - end_bytes;
        expect(package_.substr(end, 4) == "PK\5\6", fmt::format("byte {}: expected the end of the directory", end));
        const std::uint64_t count = number(package_, end + 10, 2);
        std::size_t central = number(package_, end + 16, 4);
        expect(number(package_, end + 8, 2) == count && central + number(package_, end + 12, 4) == end,
               "the directory does not end where the archive says");
        std::vector<UsdzEntry> entries;
        std::size_t next = 0;
        const std::size_t directory = central;
        for (std::uint64_t i = 0; i < count; ++i)
        {
            expect(number(package_, central, 4) == 0x02014b50,
                   fmt::format("byte {}: expected an entry of the directory", central));
            entries.push_back(entry(central, next));
            central += central_bytes + entries.back().name.size() + number(package_, central + 30, 2) +
                       number(package_, central + 32, 2);
        }
        expect(central == end && next == directory, "bytes that belong to no file");
        return entries;
    }

  private:
    UsdzEntry entry(std::size_t central, std::size_t& next) const
    {
        const std::size_t name_bytes = number(package_, central + 28, 2);
        const std::size_t local = number(package_, central + 42, 4);
        expect(local == next && number(package_, local, 4) == 0x04034b50, fmt::format("byte {}: expected a file", next));
        expect(central + central_bytes + name_bytes <= package_.size(), "a name exceeds the archive");
        UsdzEntry result;
        result.name = package_.substr(central + central_bytes, name_bytes);
        const std::string place = result.name + ": ";
        // Version, flags, method, time, checksum and sizes.
        expect(package_.substr(central + 6, 22) == package_.substr(local + 4, 22) &&
                   number(package_, local + 26, 2) == name_bytes &&
                   package_.substr(local + local_bytes, name_bytes) == result.name,
               place + "its header and the directory do not agree");
        expect(number(package_, local + 6, 2) == 0 && number(package_, local + 8, 2) == 0,
               place + "expected stored bytes, not compressed ones");
        const std::size_t data = local + local_bytes + name_bytes + number(package_, local + 28, 2);
        const std::size_t bytes = number(package_, local + 18, 4);
        expect(data % zip_alignment == 0, place + fmt::format("begins at byte {}, not at a multiple of {}", data, zip_alignment));
        expect(bytes == number(package_, local + 22, 4) && data + bytes <= package_.size(), place + "exceeds the archive");
        result.data = package_.substr(data, bytes);
        expect(crc32_z(0, reinterpret_cast<const Bytef*>(result.data.data()), bytes) == number(package_, local + 14, 4),
               place + "the checksum differs");
        next = data + bytes;
        return result;
    }

    std::string_view package_;
};

/// The numbers of a list, whatever brackets are around them.
class Numbers
{
  public:
    Numbers(std::string_view layer, std::string_view declaration)
    {
        const std::string begin = "        " + std::string(declaration) + " = [";
        const std::size_t at = layer.find(begin);
        expect(at != std::string_view::npos, std::string(declaration) + " is missing");
        rest_ = layer.substr(at + begin.size());
        rest_ = rest_.substr(0, rest_.find(']'));
    }

    template <class Number>
    bool is_next(Number meant)
    {
        skip();
        Number found{};
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), found);
        if (error != std::errc() || std::memcmp(&found, &meant, sizeof found) != 0)
            return false;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return true;
    }
    bool is_at_end()
    {
        skip();
        return rest_.empty();
    }

  private:
    void skip() { rest_.remove_prefix(std::min(rest_.find_first_not_of("(), \n"), rest_.size())); }

    std::string_view rest_;
};

template <class Row>
void check_rows(std::string_view layer, std::string_view declaration, const std::vector<Row>& rows, const auto& is_next)
{
    Numbers numbers(layer, declaration);
    for (std::size_t i = 0; i < rows.size(); ++i)
        expect(is_next(numbers, rows[i]),
               fmt::format("the written file differs from what was to be written: {}, {}", declaration, i));
    expect(numbers.is_at_end(), fmt::format("{}: more than the {} that were to be written", declaration, rows.size()));
}
}  // namespace

std::vector<UsdzEntry> read_usdz(std::string_view package, std::string_view source)
{
    try
    {
        return PackageReader(package).read();
    }
    catch (const Error& error)
    {
        throw Error(std::string(source) + ": " + error.what());
    }
}

void check_usda(std::string_view layer, const WeldedMesh& mesh)
{
    check_rows(layer, "int[] faceVertexIndices", mesh.indices,
               [](Numbers& numbers, std::uint32_t index) { return numbers.is_next(index); });
    check_rows(layer, "int[] faceVertexCounts", std::vector<std::uint32_t>(mesh.indices.size() / 3, 3),
               [](Numbers& numbers, std::uint32_t count) { return numbers.is_next(count); });
    check_rows(layer, "point3f[] points", mesh.positions,
               [](Numbers& numbers, Vec3f p) { return numbers.is_next(p.x) && numbers.is_next(p.y) && numbers.is_next(p.z); });
    check_rows(layer, "texCoord2f[] primvars:st", mesh.texcoords,
               [](Numbers& numbers, Vec2f uv) { return numbers.is_next(uv.x) && numbers.is_next(uv.y); });
}
