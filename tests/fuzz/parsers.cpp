#include "parsers.h"

#include <fresco/testing.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace fresco::fuzz
{
namespace
{

std::vector<Parser>& list()
{
    static std::vector<Parser> parsers;
    return parsers;
}

}  // namespace

const std::vector<Parser>& parsers()
{
    return list();
}

Registered::Registered(std::initializer_list<Parser> parsers)
{
    list().insert(list().end(), parsers);
    std::ranges::sort(list(), {}, &Parser::name);
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
