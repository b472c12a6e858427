#include "catch.h"

#include <fresco/html.h>

namespace
{
std::string encoded(std::string_view text)
{
    return fresco::base64(std::as_bytes(std::span(text)));
}
}  // namespace

TEST_CASE("base64 gives the test vectors of RFC 4648")
{
    CHECK(encoded("").empty());
    CHECK(encoded("f") == "Zg==");
    CHECK(encoded("fo") == "Zm8=");
    CHECK(encoded("foo") == "Zm9v");
    CHECK(encoded("foob") == "Zm9vYg==");
    CHECK(encoded("fooba") == "Zm9vYmE=");
    CHECK(encoded("foobar") == "Zm9vYmFy");
    CHECK(encoded("\xfb\xff\xfe") == "+//+");
    CHECK(fresco::data_uri("text/plain", std::as_bytes(std::span("foo", 3))) == "data:text/plain;base64,Zm9v");
}

TEST_CASE("JSON cannot leave the script that it is put in")
{
    const fresco::Value value = fresco::Value::Map{{"x", "</script><!--"}};
    const std::string text = fresco::script_json(value);
    CHECK(text.find('<') == std::string::npos);
    CHECK(fresco::parse_json(text) == value);
}
