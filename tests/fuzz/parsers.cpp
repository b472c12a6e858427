#include "parsers.h"

#include <fresco/testing.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace fresco::fuzz
{

std::vector<Parser>& parsers()
{
    static std::vector<Parser> parsers;
    return parsers;
}

Registered::Registered(std::initializer_list<Parser> more)
{
    parsers().insert(parsers().end(), more);
    std::ranges::sort(parsers(), {}, &Parser::name);
}

void require(bool holds, const std::string& what)
{
    if (!holds)
        throw std::logic_error("does not hold: " + what);
}

std::filesystem::path file_with(Bytes bytes, const std::string& name)
{
    static const testing::TemporaryFolder folder;
    auto file = folder.path() / name;
    std::ofstream stream(file, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!stream.flush())
        throw std::runtime_error(file.string() + ": cannot be written");
    return file;
}

}  // namespace fresco::fuzz
