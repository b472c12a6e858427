#include "base/records.h"
#include "catch.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

using namespace fresco::host;

TEST_CASE("A record is refused at every length but its own, with every byte changed, and with anything added")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "record.json";
    write_record(file, fresco::Value::Map{{"stage", "mesh"}, {"sizes", fresco::Value::List{1, 2.5, true, fresco::Value()}}});
    const std::string whole = fresco::read_text_file(file);
    CHECK(read_record(file).at("stage").as_string() == "mesh");
    const auto refused = [&](const std::string& text)
    {
        fresco::write_file(file, text);
        CHECK_THROWS_AS(read_record(file), fresco::Error);
    };
    for (std::size_t length = 0; length < whole.size(); ++length)
        refused(whole.substr(0, length));
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (const int change : {1, 32, 128, 255})
        {
            std::string text = whole;
            text[at] = static_cast<char>(text[at] ^ change);
            refused(text);
        }
    for (const char* more : {"\n", " ", "}", "\0"})
        refused(whole + (*more == '\0' ? std::string(1, '\0') : more));
    fresco::write_file(file, whole);
    CHECK(read_record(file).at("sizes").as_list().size() == 4);
}
